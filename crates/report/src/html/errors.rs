//! Distance between planned and recorded fingertips.

use inhand_model::{Finger, PerFinger, Statistics};
use maud::html;

use super::{
    Body, Method, contacts::tau_m, ecdf, intervals, over_time, segment_errors, statistics,
};
use crate::figure::box_plot::{self, BoxPlot, Row, cut_off, shared_end_mm};
use crate::figure::palette::finger_class;
use crate::figure::{Figure, Panel};
use crate::number::{NARROW_SPACE, count, plain};
use crate::report::Report;

const AXIS_NAME: &str = "distance to recorded fingertip (mm)";
/// What is meant by the parts of a box, stated under every figure of them.
pub(super) const BOX_WORDS: &str = "Box: first to third quartile; line: median; whiskers: farthest value within 1.5 \
    interquartile ranges of the box; dot: 95 % quantile. Values beyond the whiskers are not drawn one by one, the largest is the number at the right. \
    Quantiles interpolate linearly (type 7).";

/// The section's content.
pub(super) fn section(report: &Report<'_>, methods: &[Method<'_>]) -> Body {
    let evaluation = report.evaluation;
    let mut body = Body::from(html! {
        p {
            "Distance between the planned and the recorded fingertip, both in the hand's frame, at every sample of every test segment."
        }
    });
    body.figure(overview(methods))
        .figure(by_finger(methods))
        .figure(report.rows.and_then(|rows| ecdf::figure(rows, methods)))
        .append(over_time::part(evaluation, methods))
        .figure(
            (report.rows).and_then(|rows| segment_errors::figure(rows, methods, tau_m(methods))),
        )
        .append(intervals::part(evaluation, methods).unwrap_or_default())
        .prose(statistics::error_table(methods));
    body
}

/// All fingers together by method, and the default method by finger.
fn overview(methods: &[Method<'_>]) -> Figure {
    let pooled = methods.iter().map(|method| &method.evaluation.error.all);
    let end_mm = shared_end_mm(pooled.clone());
    let mut panels = vec![box_plot::draw(&BoxPlot {
        title: "All fingers, by method",
        swatch: None,
        axis_name: AXIS_NAME,
        end_mm,
        rows: methods
            .iter()
            .map(|method| row(method, &method.evaluation.error.all))
            .collect(),
    })];
    let default = methods.iter().find(|method| method.default);
    panels.extend(default.map(default_by_finger));
    let sizes = sizes(methods.iter().map(|method| {
        let evaluation = method.evaluation;
        (evaluation.name.as_str(), &evaluation.error.all)
    }));
    let all = methods.iter().map(|method| {
        let evaluation = method.evaluation;
        ("all", evaluation.name.as_str(), &evaluation.error.all)
    });
    let fingers = default
        .into_iter()
        .flat_map(|method| finger_boxes(method, &method.evaluation.error.by_finger));
    Figure {
        id: "error-by-method",
        title: "Error of each method, and of the default method by finger.".to_owned(),
        caption: format!(
            "{BOX_WORDS} {sizes} The two axes differ. {}",
            cut_words(cut_off(pooled, end_mm), end_mm)
        ),
        data: box_plot::data(all.chain(fingers)),
        legend: Vec::new(),
        panels,
    }
}

fn default_by_finger(method: &Method<'_>) -> Panel {
    let fingers = &method.evaluation.error.by_finger;
    box_plot::draw(&BoxPlot {
        title: &format!("{}, by finger", method.evaluation.name),
        swatch: None,
        axis_name: AXIS_NAME,
        end_mm: shared_end_mm(fingers.as_array()),
        rows: Finger::ALL
            .map(|finger| Row {
                label: finger.name(),
                class: finger_class(finger),
                stressed: false,
                statistics: &fingers[finger],
            })
            .into(),
    })
}

/// Rows of the table behind boxes of one method.
pub(super) fn finger_boxes<'a>(
    method: &Method<'a>,
    fingers: &'a PerFinger<Statistics>,
) -> impl Iterator<Item = (&'a str, &'a str, &'a Statistics)> {
    let name = method.evaluation.name.as_str();
    fingers
        .iter()
        .map(move |(finger, s)| (finger.name(), name, s))
}

fn by_finger(methods: &[Method<'_>]) -> Figure {
    let all = || {
        methods
            .iter()
            .flat_map(|m| m.evaluation.error.by_finger.as_array())
    };
    let end_mm = shared_end_mm(all());
    let panel = |finger: Finger| {
        box_plot::draw(&BoxPlot {
            title: finger.name(),
            swatch: Some(finger_class(finger)),
            axis_name: AXIS_NAME,
            end_mm,
            rows: methods
                .iter()
                .map(|method| row(method, &method.evaluation.error.by_finger[finger]))
                .collect(),
        })
    };
    Figure {
        id: "error-by-finger",
        title: "Error by finger and method, one axis for all five.".to_owned(),
        caption: format!(
            "{BOX_WORDS} {} {}",
            finger_sizes(
                methods
                    .iter()
                    .map(|method| method.evaluation.error.by_finger.as_array())
            ),
            cut_words(cut_off(all(), end_mm), end_mm)
        ),
        data: box_plot::data(
            methods
                .iter()
                .flat_map(|method| finger_boxes(method, &method.evaluation.error.by_finger)),
        ),
        legend: Vec::new(),
        panels: Finger::ALL.map(panel).into(),
    }
}

/// A row of a figure with methods as rows.
pub(super) fn row<'a>(method: &'a Method<'_>, statistics: &'a Statistics) -> Row<'a> {
    Row {
        label: &method.evaluation.name,
        class: &method.class,
        stressed: method.default,
        statistics,
    }
}

/// How many values stand behind each box: once where all are the same, else each.
fn sizes<'a>(distributions: impl Iterator<Item = (&'a str, &'a Statistics)>) -> String {
    let each: Vec<(&str, usize)> = distributions.map(|(name, s)| (name, s.n)).collect();
    match each.as_slice() {
        [] => String::new(),
        [(_, first), rest @ ..] if rest.iter().all(|(_, n)| n == first) => {
            format!(
                "n = {} for each method over all fingers.",
                count(*first, NARROW_SPACE)
            )
        }
        _ => {
            let words: Vec<String> = each
                .iter()
                .map(|(name, n)| format!("{name} {}", count(*n, NARROW_SPACE)))
                .collect();
            format!("n over all fingers: {}.", words.join(", "))
        }
    }
}

/// How many values stand behind each box of a figure with five panels.
pub(super) fn finger_sizes<'a>(
    methods: impl Iterator<Item = &'a [Statistics; Finger::COUNT]>,
) -> String {
    let sizes: Vec<usize> = methods.flatten().map(|s| s.n).collect();
    match (sizes.iter().min(), sizes.iter().max()) {
        (Some(low), Some(high)) if low == high => {
            format!("n = {} for each box.", count(*low, NARROW_SPACE))
        }
        (Some(low), Some(high)) => format!(
            "n = {} to {}, different for different boxes: point at a box, or see the statistics.",
            count(*low, NARROW_SPACE),
            count(*high, NARROW_SPACE)
        ),
        _ => String::new(),
    }
}

/// Whether a box reaches past the axis.
pub(super) fn cut_words(cut: usize, end_mm: f64) -> String {
    match cut {
        0 => "No box, whisker or dot is cut off.".to_owned(),
        1 => format!(
            "One row reaches past the axis, which ends at {} mm; ▸ marks it.",
            plain(end_mm)
        ),
        n => format!(
            "{n} rows reach past the axis, which ends at {} mm; ▸ marks them.",
            plain(end_mm)
        ),
    }
}
