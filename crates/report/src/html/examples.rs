//! Examples: recorded and planned paths in space, and the worst errors with where to look at them.

use inhand_model::{Finger, Path, PathExample, WorstCase};
use maud::{Markup, html};

use super::{Body, Method, default};
use crate::figure::projection::{self, Drawn, Shape};
use crate::figure::scale::{Scale, nice_end};
use crate::figure::{
    Figure, FigureData, Frame, Key, PLAIN_CLASS, Panel, Px, axes, finger_class, finger_keys,
    line_chart,
};
use crate::table::Table;
use crate::words::{decimals, millimetres, plain, to_mm};

/// The examples; a sentence where there are none.
pub(super) fn paths(examples: &[PathExample], methods: &[Method<'_>]) -> Body {
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
        title: format!("{which}, recorded and planned, published protocol."),
        caption: format!(
            "Paths of the fingertips in the hand's frame, seen along its three axes: segment {} of the \
             test takes, {} from {} s on. Of all segments its mean error over fingers and instants is the {place}. Above all \
             fingers at one scale, below the one that is farthest off, larger. Dots: where the recorded motion starts. Methods that are not drawn are in the data.",
            example.segment,
            example.take,
            decimals(example.start_s, 2),
        ),
        data: path_data(example),
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

fn path_data(example: &PathExample) -> FigureData {
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

const WIDTH: f64 = 380.0;
const FRAME: Frame = Frame::new([34.0, WIDTH - 12.0], [8.0, 78.0]);
const HEIGHT: f64 = 82.0 + axes::BOTTOM_ROOM;
/// Time before and after the worst instant in a cut, seconds.
const AROUND_S: f64 = 2.0;

/// The gallery and its table; a sentence where nothing was planned.
pub(super) fn worst(cases: &[WorstCase], rate_hz: f64) -> Body {
    let Some(first) = cases.first() else {
        return html! { p { "No segment was planned, so there is no worst error." } }.into();
    };
    let (n, method) = (cases.len(), &first.method);
    let highest = cases
        .iter()
        .map(|case| to_mm(case.error_m))
        .fold(0.0, f64::max);
    let end_mm = nice_end(highest, 4);
    let mut fingers: Vec<Finger> = cases.iter().map(|case| case.finger).collect();
    fingers.sort_unstable();
    fingers.dedup();
    let keys = fingers
        .into_iter()
        .map(|finger| Key::line(finger.name(), finger_class(finger)));
    let panels =
        (cases.iter().enumerate()).map(|(place, case)| panel(place + 1, case, rate_hz, end_mm));
    let figure = Figure {
        id: "worst-errors",
        title: format!("The {n} segments with the largest errors of {method}, published protocol."),
        caption: "Error of the finger that is farthest off over the segment, one a segment, largest first; the dot is \
            the worst instant. All axes end at the same height."
            .to_owned(),
        data: worst_data(cases, rate_hz),
        legend: keys.collect(),
        panels: panels.collect(),
    };
    Body::default().figure(figure).prose(where_to_look(cases))
}

fn panel(place: usize, case: &WorstCase, rate_hz: f64, end_mm: f64) -> Panel {
    let last_s = case.errors_m.len().saturating_sub(1) as f64 / rate_hz;
    let x = Scale::linear(0.0, last_s).over(FRAME.left, FRAME.right);
    let y = Scale::linear(0.0, end_mm).over(FRAME.bottom, FRAME.top);
    let points: Vec<(f64, f64)> = (case.errors_m.iter().enumerate())
        .filter(|(_, error_m)| error_m.is_finite())
        .map(|(t, error_m)| (x.at(t as f64 / rate_hz), y.at(to_mm(*error_m))))
        .collect();
    let highest_point = points.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
    let line = line_chart::path(points.iter().copied());
    let title = format!(
        "{place}. {} mm, {}, {} at {} s",
        millimetres(case.error_m),
        case.finger,
        case.take,
        decimals(case.time_s, 2)
    );
    Panel {
        title: title.as_str().into(),
        width: WIDTH,
        height: HEIGHT,
        summary: title.clone(),
        shapes: html! {
            @for tick in y.ticks(3) {
                @let at = y.at(tick.value);
                line.grid x1=(Px(FRAME.left)) y1=(Px(at)) x2=(Px(FRAME.right)) y2=(Px(at)) {}
                text.tick x=(Px(FRAME.left - 6.0)) y=(Px(at + 4.0)) text-anchor="end" { (tick.label) }
            }
            (axes::bottom(&FRAME, &x, 5, "time in the segment (s); error in mm"))
            g.(finger_class(case.finger)) {
                title { (title) }
                path.line d=(line) {}
                @if let Some((x, y)) = highest_point { circle.point cx=(Px(x)) cy=(Px(y)) r="3.5" {} }
            }
        },
    }
}

fn worst_data(cases: &[WorstCase], rate_hz: f64) -> FigureData {
    let rows: Vec<(usize, &WorstCase, usize)> = (cases.iter().enumerate())
        .flat_map(|(place, case)| (0..case.errors_m.len()).map(move |t| (place + 1, case, t)))
        .collect();
    FigureData::about(&rows)
        .counts("place", |row| row.0)
        .words("method", |row| &*row.1.method)
        .words("take", |row| &*row.1.take)
        .words("file", |row| &*row.1.file)
        .words("topic", |row| &*row.1.topic)
        .counts("segment", |row| row.1.segment)
        .words("finger", |row| row.1.finger.name())
        .numbers("worst_time_s", |row| row.1.time_s)
        .numbers("time_in_segment_s", |row| row.2 as f64 / rate_hz)
        .numbers("error_mm", |row| to_mm(row.1.errors_m[row.2]))
        .done()
}

fn where_to_look(cases: &[WorstCase]) -> Markup {
    let rows = cases.iter().enumerate();
    let caption = "Where the worst errors are, published protocol";
    let table = Table::new(caption, rows, "place", |(place, _)| (place + 1).to_string())
        .lengths("error", |(_, case)| case.error_m)
        .words("finger", |(_, case)| case.finger.name().to_owned())
        .words("file", |(_, case)| case.file.clone())
        .decimals("time", "s", 2, |(_, case)| case.time_s)
        .numbers("segment", "", |(_, case)| case.segment.to_string())
        .words("topic", |(_, case)| case.topic.clone());
    html! {
        (table)
        p.note {
            "Files are beside this report; times count from the take's first sample, segments over all test takes from 0. \
             A few seconds around each, to open in a viewer:"
        }
        details {
            summary { "Commands" }
            pre { @for (place, case) in cases.iter().enumerate() { (command(place + 1, case)) "\n" } }
        }
    }
}

fn command(place: usize, case: &WorstCase) -> String {
    let start_s = (case.time_s - AROUND_S).max(0.0);
    let hundredths = |seconds: f64| plain((seconds * 100.0).round() / 100.0);
    format!(
        "inhand cut {} --from {} --to {} -o worst-{place}.mcap",
        shell_word(&case.file),
        hundredths(start_s),
        hundredths(case.time_s + AROUND_S),
    )
}

/// A name as a shell reads it back.
fn shell_word(name: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./".contains(c);
    if !name.is_empty() && name.chars().all(plain) && !name.starts_with('-') {
        name.to_owned()
    } else {
        format!("'./{}'", name.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_survive_a_shell() {
        assert_eq!(shell_word("cube_test_01.mcap"), "cube_test_01.mcap");
        assert_eq!(shell_word("my take.mcap"), "'./my take.mcap'");
        assert_eq!(shell_word("it's.mcap"), "'./it'\\''s.mcap'");
        assert_eq!(shell_word("-o.mcap"), "'./-o.mcap'");
    }
}
