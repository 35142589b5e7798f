//! Distance between planned and recorded fingertips, and poses of the object.

use inhand_model::{
    Evaluation, EvaluationRows, Finger, HandAndFingers, PerFinger, Protocol, Statistics,
};
use maud::{Render, html};

use super::{
    Body, Method, default, examples, intervals, known_of, method_table, paper, segment_errors,
    session,
};
use crate::Report;
use crate::figure::box_plot::{self, BOX_WORDS, MILLIMETRES, axis_words, finger_row};
use crate::figure::line_chart::{self, LineChart, Series};
use crate::figure::scale::Scale;
use crate::figure::{Figure, Panel};
use crate::table::{self, Head, SPREAD, Table, UPPER, evaluated};
use crate::verdict::{
    comparison_sentence, default_method, definition, headline, protocols, without_held_out,
};
use crate::words::{NONE, count_range, counted, decimals, millimetres, plain, tied, to_mm};

/// Name of the axis of errors.
pub(super) const AXIS_NAME: &str = "distance to recorded fingertip (mm)";

/// The section's content: errors by method and finger under the first protocol; everything else is folded away.
pub(super) fn section(report: &Report<'_>, published: &[Method<'_>]) -> Body {
    let evaluation = report.evaluation;
    let first = headline(evaluation);
    let own = &super::methods(evaluation, first);
    let title = first.title();
    let body = Body::from(html! {
        p {
            "Distance between the planned and the recorded fingertip, both in the hand's frame, at every sample of every test segment."
        }
        @if let Some(words) = without_held_out(evaluation) { p { (words) } }
        @for protocol in protocols(evaluation) { p.note { (tied(&definition(protocol, evaluation))) } }
    });
    let body = body
        .figure(named(
            overview(own, first),
            first,
            "held-out-error-by-method",
        ))
        .prose(finger_medians(
            &format!("Error by finger, {title}: median (95 % quantile)"),
            own,
        ))
        .folded(
            "Methods, and which was chosen",
            session::methods(evaluation, published),
        );
    let body = protocols(evaluation).fold(body, |body, protocol| {
        let summary = match protocol {
            Protocol::HeldOut => "Held out: intervals, differences, statistics",
            Protocol::Published => "Published: by finger, distribution, statistics",
        };
        body.folded(summary, protocol_part(report, protocol))
    });
    body.folded(
        "Published values of the paper beside this run",
        paper::body(report),
    )
    .folded("Object pose", object(published))
}

/// A figure under the name that it has of the held-out protocol.
fn named(figure: Figure, protocol: Protocol, held_out: &'static str) -> Figure {
    match protocol {
        Protocol::HeldOut => Figure {
            id: held_out,
            ..figure
        },
        Protocol::Published => figure,
    }
}

/// Everything under a protocol but what the section shows of the first one.
fn protocol_part(report: &Report<'_>, protocol: Protocol) -> Body {
    let evaluation = report.evaluation;
    let methods = &super::methods(evaluation, protocol);
    let published = protocol == Protocol::Published;
    let rows = report.rows.filter(|_| published);
    let second = (headline(evaluation) != protocol).then(|| {
        let compared = default_method(evaluation, protocol);
        let sentence = compared.map(|method| comparison_sentence(method, evaluation, protocol));
        Body::from(html! { p { (tied(&sentence.unwrap_or_default())) } })
            .figure(overview(methods, protocol))
            .append(over_time(evaluation, protocol))
    });
    let id = match protocol {
        Protocol::HeldOut => "held-out-differences-from-baseline",
        Protocol::Published => intervals::DIFFERENCES,
    };
    let intervals = evaluation.intervals(protocol);
    let caption = format!("Error statistics, {}", protocol.title());
    let held_out = evaluation.held_out.as_ref().filter(|_| !published);
    Body::default()
        .append(second)
        .figure(published.then(|| by_finger(methods)))
        .figure(rows.and_then(|rows| distribution(rows, methods)))
        .append(intervals.map(|own| intervals::body(own, methods, id)))
        .prose(error_table(&caption, methods))
        .prose(html! {
            p.note {
                @if let Some(own) = held_out {
                    (counted(own.segments, "test segment")) ", " (own.left_out) " left out: of the " (own.ends_samples)
                    " samples of a line on either side half have to be measured. "
                }
                "n: fingertip positions compared. Filled: those among them that rest on an interpolated sample. Left out: those that test takes \
                 without gaps, and plans without failures, would have given in addition. Bold: smallest of its column among the methods."
            }
        })
}

/// Content of the section on errors over time: the median under the first protocol; single segments are folded away.
pub(super) fn time_section(report: &Report<'_>, methods: &[Method<'_>]) -> Body {
    let evaluation = report.evaluation;
    let segments = report
        .rows
        .and_then(|rows| segment_errors::figure(rows, methods));
    let shown = report.illustrations;
    let paths = shown.map(|all| examples::paths(&all.paths, methods));
    let worst = shown.map(|all| examples::worst(&all.worst, evaluation.session.rate_hz));
    over_time(evaluation, headline(evaluation))
        .folded("The worst errors, and where to look", worst)
        .folded(
            "The median and the worst segment over time",
            Body::default().figure(segments),
        )
        .folded("The median and the worst segment in space", paths)
}

/// Median and 95 % quantile of each method and finger, millimetres.
fn finger_medians<'m>(caption: &str, methods: &'m [Method<'m>]) -> Table<&'m Method<'m>> {
    let both = |s: &Statistics| {
        evaluated(
            s.n,
            format!("{} ({})", millimetres(s.p50), millimetres(s.p95)),
        )
    };
    method_table(caption, methods, |method| method)
        .numbers("all fingers", "mm", |m| both(&m.evaluation.error.all))
        .fingers("mm", |m, finger| {
            both(&m.evaluation.error.by_finger[finger])
        })
        .words("what it does", |m| m.evaluation.description.clone())
}

/// Rows of the table behind boxes of one method by finger.
fn finger_boxes<'a>(
    name: &'a str,
    fingers: &'a PerFinger<Statistics>,
) -> impl Iterator<Item = (&'a str, &'a str, &'a Statistics)> {
    (fingers.iter()).map(move |(finger, statistics)| (finger.name(), name, statistics))
}

/// A panel with all fingers together by method and one with the default method by finger, and their caption.
pub(super) fn overview_panels<T>(
    methods: &[Method<'_, T>],
    error: fn(&T) -> &HandAndFingers<Statistics>,
    sizes: &str,
) -> (Vec<Panel>, String) {
    let pooled = methods.iter().map(|m| &error(m.evaluation).all);
    let pooled: Vec<&Statistics> = pooled.collect();
    let axis = (AXIS_NAME, MILLIMETRES.axis(&pooled));
    let rows = methods.iter().map(Method::row).zip(pooled.iter().copied());
    let mut panels = vec![MILLIMETRES.boxes("All fingers, by method", None, axis, rows)];
    let mut scales = vec![axis.1];
    panels.extend(default(methods).map(|method| {
        let fingers = &error(method.evaluation).by_finger;
        let title = format!("{}, by finger", method.name);
        let scale = MILLIMETRES.axis(&fingers.as_array().each_ref());
        scales.push(scale);
        let rows = fingers.iter().map(|(finger, s)| (finger_row(finger), s));
        MILLIMETRES.boxes(&title, None, (AXIS_NAME, scale), rows)
    }));
    let words = axis_words(&scales);
    (
        panels,
        format!("{BOX_WORDS} {sizes}The two axes differ.{words}"),
    )
}

/// All fingers together by method, and the default method by finger.
fn overview(methods: &[Method<'_>], protocol: Protocol) -> Figure {
    let pooled = || methods.iter().map(|m| (m.name, &m.evaluation.error.all));
    let n: Vec<usize> = pooled().map(|(_, error)| error.n).collect();
    let mut sizes = format!("n = {} for each method", count_range(&n));
    let mut boxes: Vec<_> = pooled().map(|(name, error)| ("all", name, error)).collect();
    if let Some(method) = default(methods) {
        let fingers = &method.evaluation.error.by_finger;
        let n = fingers.as_array().each_ref().map(|own| own.n);
        sizes += &format!(", {} for each finger of {}", count_range(&n), method.name);
        boxes.extend(finger_boxes(method.name, fingers));
    }
    let (panels, caption) = overview_panels(methods, |method| &method.error, &(sizes + ". "));
    Figure {
        id: "error-by-method",
        title: format!(
            "Error of each method, and of the default method by finger, {}.",
            protocol.title()
        ),
        caption,
        data: box_plot::data(&boxes),
        legend: Vec::new(),
        panels,
    }
}

fn by_finger(methods: &[Method<'_>]) -> Figure {
    let rows = methods
        .iter()
        .map(|method| (method, &method.evaluation.error.by_finger));
    Figure {
        id: "error-by-finger",
        title: "Error by finger and method, published, one axis for all five.".to_owned(),
        ..finger_figure(&rows.collect::<Vec<_>>(), "", AXIS_NAME)
    }
}

/// A panel a finger with boxes by method on one axis. The caption begins with `lead`.
pub(super) fn finger_figure(
    rows: &[(&Method<'_>, &PerFinger<Statistics>)],
    lead: &str,
    axis_name: &str,
) -> Figure {
    let all = rows.iter().flat_map(|(_, fingers)| fingers.as_array());
    let all: Vec<&Statistics> = all.collect();
    let axis = (axis_name, MILLIMETRES.axis(&all));
    let panel = |finger: Finger| {
        let rows = rows.iter().map(|(m, fingers)| (m.row(), &fingers[finger]));
        MILLIMETRES.boxes(finger.name(), Some(finger), axis, rows)
    };
    let sizes: Vec<usize> = all.iter().map(|s| s.n).collect();
    let differ = match sizes.iter().all(|n| *n == sizes[0]) {
        true => " for each box",
        false => ", different for different boxes: point at a box, or see the statistics",
    };
    let boxes = rows
        .iter()
        .flat_map(|(method, fingers)| finger_boxes(method.name, fingers));
    Figure {
        id: "",
        title: String::new(),
        caption: format!(
            "{lead}{BOX_WORDS} n = {}{differ}.{}",
            count_range(&sizes),
            axis_words(&[axis.1])
        ),
        data: box_plot::data(&boxes.collect::<Vec<_>>()),
        legend: Vec::new(),
        panels: Finger::ALL.map(panel).into(),
    }
}

/// Points that are drawn of a distribution. All of them are exact; between them a reader sees no difference.
const POINTS: usize = 300;
/// Start of its axis, mm: smaller errors are below what any camera resolves.
const LEAST_MM: f64 = 0.01;

/// The distribution of errors, one curve a method; `None` without rows of any method.
fn distribution(rows: &EvaluationRows, methods: &[Method<'_>]) -> Option<Figure> {
    let mut sizes = Vec::new();
    let mut series: Vec<Series> = Vec::new();
    for method in methods {
        let Some(own) = rows.methods.iter().find(|own| own.name == method.name) else {
            continue;
        };
        let errors = own.error_m.iter().flat_map(|fingers| *fingers.as_array());
        let (n, points) = exact_points(errors, POINTS);
        sizes.push(n);
        if n > 0 {
            let points = points
                .into_iter()
                .map(|(m, share)| (to_mm(m), 100.0 * share));
            series.push(method.line(points));
        }
    }
    if series.is_empty() {
        return None;
    }
    let ends = series.iter().filter_map(|line| line.points.last());
    let largest = ends.map(|point| point.0).fold(LEAST_MM, f64::max);
    Some(Figure {
        id: "error-ecdf",
        title: "Share of errors up to a size, published.".to_owned(),
        caption: format!(
            "Empirical distribution of the errors of all fingers at all instants, n = {}; \
             {POINTS} points of each curve are drawn, all exact. Of two curves the one farther left has the smaller errors. Errors \
             below {LEAST_MM} mm are left of the axis.",
            count_range(&sizes)
        ),
        data: line_chart::data("error_mm", "share_percent", &series),
        legend: line_chart::keys(&series),
        panels: vec![line_chart::draw(&LineChart {
            x: ("error (mm)", Scale::log(LEAST_MM, largest)),
            y: ("share of errors up to it (%)", Scale::linear(0.0, 100.0)),
            series: &series,
            ..LineChart::default()
        })],
    })
}

/// Number of the values that are finite, and at most `wanted` points of their empirical distribution: the smallest, the
/// largest, and others at even shares. Each is a value with the share of values up to it.
fn exact_points(values: impl Iterator<Item = f64>, wanted: usize) -> (usize, Vec<(f64, f64)>) {
    let mut sorted: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let (n, drawn) = (sorted.len(), sorted.len().min(wanted));
    let places = (0..drawn).map(|k| k * (n - 1) / drawn.saturating_sub(1).max(1));
    let points = places.map(|place| {
        // Of equal values the last one says how many are up to it.
        let up_to = sorted.partition_point(|value| *value <= sorted[place]);
        (sorted[place], up_to as f64 / n as f64)
    });
    (n, points.collect())
}

/// Median error over the time within a segment.
fn over_time(evaluation: &Evaluation, protocol: Protocol) -> Body {
    let methods = super::methods(evaluation, protocol);
    let rate_hz = evaluation.session.rate_hz;
    let known = methods
        .iter()
        .map(|m| (m, &m.evaluation.median_error_by_sample_m));
    let series: Vec<Series> = (known.filter(|(_, errors_m)| !errors_m.is_empty()))
        .map(|(method, errors_m)| {
            let errors = errors_m.iter().enumerate();
            method.line(errors.map(|(sample, &m)| (sample as f64 / rate_hz, to_mm(m))))
        })
        .collect();
    if series.is_empty() {
        return html! { p { "No method has errors over the time within a segment." } }.into();
    }
    let last_s = evaluation.session.segment_samples.saturating_sub(1) as f64 / rate_hz;
    let positions = methods.iter().map(|own| own.evaluation.error_at_start.n);
    let positions: Vec<usize> = positions.collect();
    let y = line_chart::comparing(&series);
    let [low, _] = y.ends();
    let below = match line_chart::heights(&series).any(|error| error < low) {
        true => format!(" Errors below {} mm are not drawn.", plain(low)),
        false => String::new(),
    };
    let figure = Figure {
        id: "error-within-segment",
        title: format!(
            "Median error against time within the segment, {}.",
            protocol.title()
        ),
        caption: format!(
            "Median of the error of all fingers at each sample over the test segments, n = {} fingertip positions at \
             each sample.{below}",
            count_range(&positions)
        ),
        data: line_chart::data("time_s", "median_error_mm", &series),
        legend: line_chart::keys(&series),
        panels: vec![line_chart::draw(&LineChart {
            x: ("time in the segment (s)", Scale::linear(0.0, last_s)),
            y: ("median error (mm)", y),
            series: &series,
            ..LineChart::default()
        })],
    };
    Body::default().figure(named(figure, protocol, "held-out-error-within-segment"))
}

/// A distribution of a method.
type Distribution<'m, 'a> = (&'m Method<'a>, Statistics);

/// Errors of all methods: pooled, at the ends, and of each finger.
fn error_table(caption: &str, methods: &[Method<'_>]) -> impl Render {
    let of = |choose: &dyn Fn(&Method<'_>) -> Statistics| -> Vec<Distribution<'_, '_>> {
        methods
            .iter()
            .map(|method| (method, choose(method)))
            .collect()
    };
    let mut groups: Vec<(Head, _)> = vec![
        ("all fingers".into(), of(&|m| m.evaluation.error.all)),
        (
            "all fingers, first sample".into(),
            of(&|m| m.evaluation.error_at_start),
        ),
        (
            "all fingers, last sample".into(),
            of(&|m| m.evaluation.error_at_goal),
        ),
    ];
    groups.extend(
        Finger::ALL.map(|finger| (finger.into(), of(&|m| m.evaluation.error.by_finger[finger]))),
    );
    distribution_table(caption, groups).smallest_marked()
}

/// Distributions of methods by finger.
pub(super) fn finger_table<'m>(
    caption: &str,
    rows: &[(&'m Method<'m>, &PerFinger<Statistics>)],
) -> Table<Distribution<'m, 'm>> {
    let groups = Finger::ALL.map(|finger| {
        let rows = rows
            .iter()
            .map(|(method, fingers)| (*method, fingers[finger]));
        (finger.into(), rows.collect())
    });
    distribution_table(caption, groups)
}

fn distribution_table<'m>(
    caption: &str,
    groups: impl IntoIterator<Item = (Head, Vec<Distribution<'m, 'm>>)>,
) -> Table<Distribution<'m, 'm>> {
    spread_columns(
        Table::grouped(caption, groups, "method", |row| row.0.head()).stressed(|row| row.0.default),
        |row| row.1,
    )
}

/// Object error of methods that plan the object too; `None` where no method does.
fn object(methods: &[Method<'_>]) -> Option<Body> {
    let planned = known_of(methods, |own| own.object_error);
    let caption =
        "Object: distance between the origins (mm), and angle between the orientations (°)";
    let degrees = |angle: f64| decimals(angle.to_degrees(), 2);
    let table = method_table(caption, planned, |row| row.0)
        .statistics(&UPPER, "mm", millimetres, |(_, error)| error.position)
        .statistics(&UPPER, "°", degrees, |(_, error)| error.angle)
        .smallest_marked()
        .sizes(|(_, error)| table::sizes(&error.position));
    (!table.is_empty()).then(|| {
        Body::from(html! {
            p {
                "Planned against recorded pose of the object in the hand's frame, at every sample of every test segment where both are known."
            }
        })
        .prose(table)
        .prose(html! {
            p.note {
                "n: instants compared. Filled: those among them at which the object rests on an interpolated sample. Left out: object not tracked, \
                 a gap, or a plan that failed. Angle: of the one rotation from the recorded to the planned orientation, 0 to 180°. Bold: smallest of \
                 its column among the methods. " (NONE) ": nothing to evaluate."
            }
        })
    })
}

/// Sizes and statistics of errors.
pub(super) fn spread_columns<R>(table: Table<R>, of: fn(&R) -> Statistics) -> Table<R> {
    table
        .statistics(&SPREAD, "mm", millimetres, of)
        .sizes(|row| table::sizes(&of(row)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_those_of_the_distribution() {
        // Of 1, 2, .. 1000 a share of k / 1000 is up to k.
        let (n, points) = exact_points((1..=1000).rev().map(f64::from), 37);
        assert_eq!((n, points.len()), (1000, 37));
        assert_eq!((points[0], points[36]), ((1.0, 0.001), (1000.0, 1.0)));
        assert!(points.iter().all(|&(value, share)| share == value / 1000.0));
        assert!(points.windows(2).all(|pair| pair[0].0 < pair[1].0));
    }

    #[test]
    fn few_equal_and_missing_values_have_their_points_too() {
        let values = [2.0, f64::NAN, 1.0, 2.0, f64::INFINITY];
        assert_eq!(
            exact_points(values.into_iter(), 10),
            (3, vec![(1.0, 1.0 / 3.0), (2.0, 1.0), (2.0, 1.0)])
        );
        assert_eq!(exact_points([3.0].into_iter(), 10).1, [(3.0, 1.0)]);
        assert_eq!(exact_points([f64::NAN].into_iter(), 10), (0, vec![]));
    }
}
