//! Training data: fingertip hulls, primitives, explained variance.

use inhand_model::{
    DictionaryKind, ExplainedVariance, Finger, Hull, Illustrations, PerFinger, PrimitivePath,
};
use maud::html;

use super::Body;
use crate::figure::line_chart::{self, LineChart, Series};
use crate::figure::projection::{self, Drawn, Shape};
use crate::figure::scale::{Scale, nice_end};
use crate::figure::{Figure, FigureData, Key, PLAIN_CLASS, finger_class, finger_keys};
use crate::words::{count, percent, tied, to_mm};

/// Explained variance, or why it is not known.
pub(super) fn variance_part(all: &Illustrations) -> Body {
    match all.explained.as_ref().and_then(variance) {
        Some(figure) => Body::default().figure(figure),
        None => html! { p { "Every training segment has missing samples; explained variance is not available." } }.into(),
    }
}

/// Where fingertips have been in training, and the primitives used most.
pub(super) fn hulls_and_primitives(
    all: &Illustrations,
    kind: DictionaryKind,
    rate_hz: f64,
) -> Body {
    let body = Body::default().figure(all.hulls.as_ref().and_then(hulls));
    match all.primitives.is_empty() {
        true => body.prose(html! { p { "No training segment uses any primitive." } }),
        false => body.figure(used_most(kind, &all.primitives, rate_hz)),
    }
}

/// Hulls in three projections.
pub(super) fn hulls(hulls: &PerFinger<Hull>) -> Option<Figure> {
    let shapes = Finger::ALL.map(|finger| Shape {
        label: finger.name().to_owned(),
        class: format!("{} thin", finger_class(finger)),
        drawn: Drawn::Outline,
        points_mm: (hulls[finger].vertices_m.iter())
            .map(|corner| corner.map(to_mm))
            .collect(),
    });
    let panels = projection::panels("All fingers", &shapes);
    if panels.is_empty() {
        return None;
    }
    let corners: Vec<(Finger, [f64; 3])> = (hulls.iter())
        .flat_map(|(finger, hull)| hull.vertices_m.iter().map(move |v| (finger, v.map(to_mm))))
        .collect();
    Some(Figure {
        id: "hulls",
        title: "Where each fingertip has been in training.".to_owned(),
        caption: "Convex hulls of all positions in the training takes, in the hand's frame: their outlines seen along \
            its three axes, at one scale."
            .to_owned(),
        data: FigureData::about(&corners)
            .words("finger", |corner| corner.0.name())
            .points(|corner| corner.1)
            .done(),
        legend: finger_keys(Key::area),
        panels,
    })
}

fn length_mm(point: &[f64; 3]) -> f64 {
    to_mm(point.iter().map(|v| v * v).sum::<f64>().sqrt())
}

fn used_most(kind: DictionaryKind, primitives: &[PrimitivePath], rate_hz: f64) -> Figure {
    let lengths = primitives.iter().flat_map(|primitive| {
        let paths = primitive.path_m.as_array().iter();
        paths.flat_map(|path| path.iter().map(length_mm))
    });
    let high = nice_end(lengths.fold(0.0, f64::max), 6);
    let panels = primitives.iter().map(|primitive| {
        let series = Finger::ALL.map(|finger| {
            let path = primitive.path_m[finger].iter().enumerate();
            let points = path.map(|(t, point)| (t as f64 / rate_hz, length_mm(point)));
            Series::new(finger.name(), finger_class(finger), points)
        });
        let samples = primitive.path_m[Finger::Thumb].len();
        let last_s = samples.saturating_sub(1) as f64 / rate_hz;
        let share = percent(primitive.share);
        line_chart::draw(&LineChart {
            title: &format!("Primitive {}, {share} %", primitive.index),
            x: ("time in the segment (s)", Scale::linear(0.0, last_s)),
            y: ("displacement (mm)", Scale::linear(0.0, high)),
            series: &series,
            ..LineChart::default()
        })
    });
    let (use_of, size) = match kind {
        DictionaryKind::Nmf => ("all activations in training", "mean activation"),
        DictionaryKind::Pca => (
            "the activations' variance in training",
            "standard deviation",
        ),
    };
    Figure {
        id: "primitives",
        title: "The primitives used most, by finger.".to_owned(),
        caption: format!(
            "How far each primitive moves each fingertip over a segment, at its {size}: the length of the \
             displacement, whose three coordinates are in the data. Primitives count from 0; percentages: share of {use_of}."
        ),
        panels: panels.collect(),
        data: primitive_data(primitives, rate_hz),
        legend: finger_keys(Key::line),
    }
}

fn primitive_data(primitives: &[PrimitivePath], rate_hz: f64) -> FigureData {
    let mut rows: Vec<(&PrimitivePath, Finger, usize, &[f64; 3])> = Vec::new();
    for primitive in primitives {
        for (finger, path) in primitive.path_m.iter() {
            let points = path.iter().enumerate();
            rows.extend(points.map(|(t, point)| (primitive, finger, t, point)));
        }
    }
    FigureData::about(&rows)
        .counts("primitive", |row| row.0.index)
        .numbers("share_percent", |row| 100.0 * row.0.share)
        .words("finger", |row| row.1.name())
        .numbers("time_s", |row| row.2 as f64 / rate_hz)
        .points(|row| row.3.map(to_mm))
        .numbers("length_mm", |row| length_mm(row.3))
        .done()
}

/// Share of the variance against rank.
fn variance(explained: &ExplainedVariance) -> Option<Figure> {
    let percents = |points: &[(usize, f64)]| -> Vec<(f64, f64)> {
        let points = points.iter();
        points
            .map(|(rank, share)| (*rank as f64, 100.0 * share))
            .collect()
    };
    let (rank, share) = explained.learned;
    let highest = explained.principal.last()?.0.max(rank);
    let names = ["principal components", "the learned dictionary"];
    let series = [
        Series::new(names[0], PLAIN_CLASS, percents(&explained.principal)),
        Series::new(names[1], "l0", percents(&[explained.learned])),
    ];
    // Multiples of ten.
    let lowest = line_chart::heights(&series).fold(100.0, f64::min).max(0.0);
    let low = (lowest / 10.0).floor() * 10.0;
    Some(Figure {
        id: "explained-variance",
        title: "Explained variance against rank.".to_owned(),
        caption: tied(&format!(
            "Share of the variance of {} training segments about their mean that a dictionary of so many primitives can \
             explain at best (principal components). The learned dictionary explains {} % with {} primitives.",
            count(explained.segments),
            percent(share),
            count(rank),
        )),
        data: line_chart::data("rank", "explained_percent", &series),
        legend: vec![Key::line(names[0], PLAIN_CLASS), Key::area(names[1], "l0")],
        panels: vec![line_chart::draw(&LineChart {
            x: ("primitives", Scale::log(1.0, highest as f64)),
            y: ("explained (%)", Scale::linear(low, 100.0)),
            series: &series,
            dots: true,
            ..LineChart::default()
        })],
    })
}
