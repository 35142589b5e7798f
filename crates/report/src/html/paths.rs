//! Recorded and planned paths in space.

use inhand_model::{Finger, Path, PathExample};
use maud::html;

use super::{Body, Method};
use crate::figure::palette::{PLAIN_CLASS, finger_class};
use crate::figure::projection::{self, Drawn, Shape};
use crate::figure::{Figure, FigureColumn, FigureData, Key};
use crate::number::{decimals, to_mm};

/// The examples; a sentence where there are none.
pub(super) fn part(examples: &[PathExample], methods: &[Method<'_>]) -> Body {
    if examples.is_empty() {
        return html! { p { "No segment was planned, so no path is shown." } }.into();
    }
    let mut body = Body::default();
    for example in examples {
        body.figure(figure(example, methods));
    }
    body
}

/// The default method, and the best of those that learn nothing by their third quartile.
fn drawn<'a>(methods: &[Method<'a>]) -> (Option<&'a str>, Option<&'a str>) {
    let name = |method: &Method<'a>| method.evaluation.name.as_str();
    let default = methods.iter().find(|method| method.default);
    let rivals = methods
        .iter()
        .filter(|method| method.evaluation.baseline && !method.default);
    let rivals = rivals.filter(|method| method.evaluation.error.all.p75.is_finite());
    let best = rivals.min_by(|a, b| {
        a.evaluation
            .error
            .all
            .p75
            .total_cmp(&b.evaluation.error.all.p75)
    });
    (default.map(name), best.map(name))
}

fn figure(example: &PathExample, methods: &[Method<'_>]) -> Option<Figure> {
    let (default, baseline) = drawn(methods);
    let path_of = |name: Option<&str>| {
        let path = example
            .methods
            .iter()
            .find(|(method, _)| Some(method.as_str()) == name);
        path.map(|(name, path)| (name.as_str(), path))
    };
    // The recorded motion last, on top.
    let motions = [
        path_of(baseline).map(|(name, path)| (name, " dotted thin", Drawn::Path, path)),
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
    let mut legend: Vec<Key> = Finger::ALL
        .map(|finger| Key::area(finger.name(), finger_class(finger)))
        .into();
    legend.extend(
        motions
            .iter()
            .rev()
            .flatten()
            .map(|&(name, style, ..)| Key::line(name, format!("{PLAIN_CLASS}{style}"))),
    );
    let (id, which) = match example.why {
        "median" => ("path-median", "A usual segment"),
        _ => ("path-worst", "The worst segment"),
    };
    Some(Figure {
        id,
        title: format!("{which}, recorded and planned."),
        caption: format!(
            "Paths of the fingertips in the hand's frame, seen along its three axes: segment {} of the \
             test takes, {} from {} s on. Of all segments its mean error over fingers and instants is the {}. Above all \
             fingers at one scale, below the one that is farthest off, larger. Dots: where the recorded motion starts. Methods that are not drawn are in the data.",
            example.segment,
            example.take,
            decimals(example.start_s, 2),
            match example.why {
                "median" => "median",
                _ => "largest",
            },
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
    let recorded = std::iter::once(("recorded", &example.recorded_m));
    let methods = example
        .methods
        .iter()
        .map(|(name, path)| (name.as_str(), path));
    let all: Vec<(&str, &Path)> = recorded.chain(methods).collect();
    for (name, path) in all {
        for finger in Finger::ALL {
            rows.extend(path[finger].iter().enumerate().map(|(t, point)| {
                let time_s = example.start_s + t as f64 / example.rate_hz;
                (name, finger, time_s, point.map(to_mm))
            }));
        }
    }
    FigureData::new([
        FigureColumn::words("motion", rows.iter().map(|row| row.0)),
        FigureColumn::words("finger", rows.iter().map(|row| row.1.name())),
        FigureColumn::numbers("time_s", rows.iter().map(|row| row.2)),
        FigureColumn::numbers("x_mm", rows.iter().map(|row| row.3[0])),
        FigureColumn::numbers("y_mm", rows.iter().map(|row| row.3[1])),
        FigureColumn::numbers("z_mm", rows.iter().map(|row| row.3[2])),
    ])
}
