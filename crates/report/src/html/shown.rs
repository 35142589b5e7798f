//! Training data: fingertip hulls, primitives, explained variance.

use inhand_model::{DictionaryKind, ExplainedVariance, Finger, Hull, PerFinger, PrimitivePath};
use maud::html;

use super::Body;
use crate::figure::line_chart::{self, AxisSpec, LineChart, Series};
use crate::figure::palette::{PLAIN_CLASS, finger_class};
use crate::figure::projection::{self, Drawn, Shape};
use crate::figure::scale::nice_end;
use crate::figure::{Figure, FigureColumn, FigureData, Key};
use crate::number::{NARROW_SPACE, count, percent, to_mm};
use crate::words::tied;

const LEARNED_CLASS: &str = "l0";

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
        data: FigureData::new([
            FigureColumn::words("finger", corners.iter().map(|corner| corner.0.name())),
            FigureColumn::numbers("x_mm", corners.iter().map(|corner| corner.1[0])),
            FigureColumn::numbers("y_mm", corners.iter().map(|corner| corner.1[1])),
            FigureColumn::numbers("z_mm", corners.iter().map(|corner| corner.1[2])),
        ]),
        legend: finger_keys(Key::area),
        panels,
    })
}

fn finger_keys(key: fn(&'static str, &'static str) -> Key) -> Vec<Key> {
    Finger::ALL
        .map(|finger| key(finger.name(), finger_class(finger)))
        .into()
}

/// Primitives, and the variance they explain.
pub(super) fn dictionary(
    kind: DictionaryKind,
    primitives: &[PrimitivePath],
    explained: Option<&ExplainedVariance>,
    rate_hz: f64,
) -> Body {
    let mut body = Body::default();
    match explained.and_then(variance) {
        Some(figure) => body.figure(figure),
        None => body
            .prose(html! { p { "Every training segment misses something: no variance is told." } }),
    };
    if primitives.is_empty() {
        body.prose(html! { p { "No training segment uses any primitive." } });
    } else {
        body.figure(used_most(kind, primitives, rate_hz));
    }
    body
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
        let series: Vec<Series> = Finger::ALL
            .map(|finger| Series {
                label: finger.name().to_owned(),
                class: finger_class(finger).to_owned(),
                points: (primitive.path_m[finger].iter().enumerate())
                    .map(|(t, point)| (t as f64 / rate_hz, length_mm(point)))
                    .collect(),
            })
            .into();
        let samples = primitive.path_m[Finger::Thumb].len();
        line_chart::draw(&LineChart {
            title: &format!(
                "Primitive {}, {} %",
                primitive.index,
                percent(primitive.share)
            ),
            x: AxisSpec::linear(
                "time in the segment (s)",
                0.0,
                samples.saturating_sub(1) as f64 / rate_hz,
            ),
            y: AxisSpec::linear("displacement (mm)", 0.0, high),
            series,
            dots: false,
            marked_x: None,
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
            rows.extend(
                path.iter()
                    .enumerate()
                    .map(|(t, point)| (primitive, finger, t, point)),
            );
        }
    }
    FigureData::new([
        FigureColumn::counts("primitive", rows.iter().map(|row| row.0.index)),
        FigureColumn::numbers("share_percent", rows.iter().map(|row| 100.0 * row.0.share)),
        FigureColumn::words("finger", rows.iter().map(|row| row.1.name())),
        FigureColumn::numbers("time_s", rows.iter().map(|row| row.2 as f64 / rate_hz)),
        FigureColumn::numbers("x_mm", rows.iter().map(|row| to_mm(row.3[0]))),
        FigureColumn::numbers("y_mm", rows.iter().map(|row| to_mm(row.3[1]))),
        FigureColumn::numbers("z_mm", rows.iter().map(|row| to_mm(row.3[2]))),
        FigureColumn::numbers("length_mm", rows.iter().map(|row| length_mm(row.3))),
    ])
}

/// Share of the variance against rank.
fn variance(explained: &ExplainedVariance) -> Option<Figure> {
    let percents = |points: &[(usize, f64)]| -> Vec<(f64, f64)> {
        points
            .iter()
            .map(|(rank, share)| (*rank as f64, 100.0 * share))
            .collect()
    };
    let principal = percents(&explained.principal);
    let highest = principal.last()?.0;
    let learned = percents(&[explained.learned]);
    let (rank, share) = explained.learned;
    let lowest = principal
        .iter()
        .chain(&learned)
        .map(|point| point.1)
        .fold(100.0, f64::min);
    let series = vec![
        Series {
            label: "principal components".to_owned(),
            class: PLAIN_CLASS.to_owned(),
            points: principal,
        },
        Series {
            label: "the learned dictionary".to_owned(),
            class: LEARNED_CLASS.to_owned(),
            points: learned,
        },
    ];
    Some(Figure {
        id: "explained-variance",
        title: "Explained variance against rank.".to_owned(),
        caption: tied(&format!(
            "Share of the variance of {} training segments about their mean that a dictionary of so many primitives can \
             explain at best (principal components). The learned dictionary explains {} % with {} primitives.",
            count(explained.segments, NARROW_SPACE),
            percent(share),
            count(rank, NARROW_SPACE),
        )),
        data: line_chart::data("rank", "explained_percent", &series),
        legend: vec![
            Key::line("principal components", PLAIN_CLASS),
            Key::area("the learned dictionary", LEARNED_CLASS),
        ],
        panels: vec![line_chart::draw(&LineChart {
            title: "Explained variance",
            x: AxisSpec::log("primitives (logarithmic)", 1.0, highest.max(rank as f64)),
            y: AxisSpec {
                name: "explained (%)",
                // Multiples of ten.
                low: (lowest.max(0.0) / 10.0).floor() * 10.0,
                high: 100.0,
                log: false,
            },
            series,
            dots: true,
            marked_x: None,
        })],
    })
}
