//! Recorded and planned paths in space.

use inhand_model::{Finger, Path, PathExample};
use maud::html;

use super::{Body, Method, default};
use crate::figure::projection::{self, Drawn, Shape};
use crate::figure::{Figure, FigureData, Key, PLAIN_CLASS, finger_class, finger_keys};
use crate::words::{decimals, to_mm};

/// The examples; a sentence where there are none.
pub(super) fn part(examples: &[PathExample], methods: &[Method<'_>]) -> Body {
    if examples.is_empty() {
        return html! { p { "No segment was planned, so no path is shown." } }.into();
    }
    let figures = examples.iter().map(|example| figure(example, methods));
    figures.fold(Body::default(), Body::figure)
}

/// The best baseline by its third quartile, besides the default method.
fn best_baseline<'a>(methods: &[Method<'a>]) -> Option<&'a str> {
    let p75 = |method: &Method<'_>| method.evaluation.error.all.p75;
    let others = methods
        .iter()
        .filter(|m| m.evaluation.baseline && !m.default);
    let best = others.filter(|method| p75(method).is_finite());
    let best = best.min_by(|a, b| p75(a).total_cmp(&p75(b)));
    best.map(|method| method.name)
}

fn figure(example: &PathExample, methods: &[Method<'_>]) -> Option<Figure> {
    let default = default(methods).map(|method| method.name);
    let path_of = |name: Option<&str>| {
        let mut paths = example
            .methods
            .iter()
            .map(|(method, path)| (&**method, path));
        paths.find(|(method, _)| Some(*method) == name)
    };
    // The recorded motion last, on top.
    let motions = [
        path_of(best_baseline(methods))
            .map(|(name, path)| (name, " dotted thin", Drawn::Path, path)),
        path_of(default).map(|(name, path)| (name, " dashed thin", Drawn::Path, path)),
        Some(("recorded", " thin", Drawn::Started, &example.recorded_m)),
    ];
    let shapes: Vec<Shape> = (motions.iter().flatten())
        .flat_map(|&(name, style, drawn, path)| {
            Finger::ALL.map(|finger| Shape {
                label: format!("{finger}, {name}"),
                class: format!("{}{style}", finger_class(finger)),
                drawn,
                points_mm: path[finger].iter().map(|point| point.map(to_mm)).collect(),
            })
        })
        .collect();
    let mut panels = projection::panels("All fingers", &shapes);
    if panels.is_empty() {
        return None;
    }
    // What is a millimetre apart is not seen beside a hand: the finger farthest off once more, alone.
    if let Some(finger) = path_of(default).and_then(|(_, path)| farthest(&example.recorded_m, path))
    {
        let alone = |shape: &Shape| shape.label.starts_with(&format!("{finger},"));
        let shapes: Vec<Shape> = shapes.into_iter().filter(alone).collect();
        panels.extend(projection::panels(&capitalised(finger), &shapes));
    }
    let mut legend = finger_keys(Key::area);
    let styles = motions.iter().rev().flatten();
    legend
        .extend(styles.map(|&(name, style, ..)| Key::line(name, format!("{PLAIN_CLASS}{style}"))));
    let (id, which, place) = match example.why {
        "median" => ("path-median", "The median segment", "median"),
        _ => ("path-worst", "The worst segment", "largest"),
    };
    Some(Figure {
        id,
        title: format!("{which}, recorded and planned."),
        caption: format!(
            "Paths of the fingertips in the hand's frame, seen along its three axes: segment {} of the \
             test takes, {} from {} s on. Of all segments its mean error over fingers and instants is the {place}. Above all \
             fingers at one scale, below the one that is farthest off, larger. Dots: where the recorded motion starts. Methods that are not drawn are in the data.",
            example.segment,
            example.take,
            decimals(example.start_s, 2),
        ),
        data: data(example),
        legend,
        panels,
    })
}

/// The finger that comes farthest away from where it was recorded.
fn farthest(recorded: &Path, planned: &Path) -> Option<Finger> {
    let apart_m = |finger: Finger| {
        let pairs = recorded[finger].iter().zip(&planned[finger]);
        pairs
            .map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt())
            .fold(0.0, f64::max)
    };
    Finger::ALL
        .into_iter()
        .max_by(|&a, &b| apart_m(a).total_cmp(&apart_m(b)))
}

fn capitalised(finger: Finger) -> String {
    let name = finger.name();
    name[..1].to_uppercase() + &name[1..]
}

fn data(example: &PathExample) -> FigureData {
    let mut rows: Vec<(&str, Finger, f64, [f64; 3])> = Vec::new();
    let methods = example.methods.iter().map(|(name, path)| (&**name, path));
    for (name, path) in std::iter::once(("recorded", &example.recorded_m)).chain(methods) {
        for (finger, points) in path.iter() {
            rows.extend(points.iter().enumerate().map(|(t, point)| {
                let time_s = example.start_s + t as f64 / example.rate_hz;
                (name, finger, time_s, point.map(to_mm))
            }));
        }
    }
    FigureData::about(&rows)
        .words("motion", |row| row.0)
        .words("finger", |row| row.1.name())
        .numbers("time_s", |row| row.2)
        .points(|row| row.3)
        .done()
}
