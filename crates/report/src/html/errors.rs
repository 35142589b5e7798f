//! Distance between planned and recorded fingertips.

use inhand_model::{Evaluation, Finger, Statistics};
use maud::{Markup, html};

use super::session::name;
use super::table::{Column, Group, Line, grouped, numbers, words};
use super::{Method, legend};
use crate::figure::box_plot::{self, BoxPlot, Row, cut_off, shared_end_mm};
use crate::figure::line_chart::{self, AxisSpec, LineChart, Series};
use crate::figure::palette::finger_class;
use crate::figure::scale::nice_end;
use crate::number::{NARROW_SPACE, NONE, count, millimetres, plain, to_mm};

const AXIS_NAME: &str = "distance to recorded fingertip (mm)";
/// What is meant by the parts of a box, stated under every figure of them.
pub(super) const BOX_WORDS: &str = "Box: first to third quartile; line: median; whiskers: farthest value within 1.5 \
    interquartile ranges of the box; dot: 95 % quantile. Values beyond the whiskers are not drawn one by one, the largest is the number at the right. \
    Quantiles interpolate linearly (type 7).";

/// The section's content.
pub(super) fn section(evaluation: &Evaluation, methods: &[Method<'_>]) -> Markup {
    html! {
        p {
            "Distance between the planned and the recorded fingertip, both in the hand's frame, at every sample of every test segment."
        }
        (overview(methods))
        (by_finger(methods))
        (over_time(evaluation, methods))
        (statistics_table(methods))
    }
}

/// All fingers together by method, and the default method by finger.
fn overview(methods: &[Method<'_>]) -> Markup {
    let pooled = methods.iter().map(|method| &method.evaluation.error);
    let end_mm = shared_end_mm(pooled.clone());
    let default = methods.iter().find(|method| method.default);
    let default_end_mm = default.map_or(1.0, |method| {
        shared_end_mm(method.evaluation.error_by_finger.as_array())
    });
    html! {
        figure.panels {
            (box_plot::draw(&BoxPlot {
                title: "All fingers, by method",
                swatch: None,
                axis_name: AXIS_NAME,
                end_mm,
                rows: methods.iter().map(|method| row(method, &method.evaluation.error)).collect(),
            }))
            @if let Some(method) = default {
                (box_plot::draw(&BoxPlot {
                    title: &format!("{}, by finger", method.evaluation.name),
                    swatch: None,
                    axis_name: AXIS_NAME,
                    end_mm: default_end_mm,
                    rows: Finger::ALL.map(|finger| Row {
                        label: finger.name(),
                        class: finger_class(finger),
                        stressed: false,
                        statistics: &method.evaluation.error_by_finger[finger],
                    }).into(),
                }))
            }
            figcaption {
                b { "Error of each method, and of the default method by finger." }
                " " (BOX_WORDS) " "
                (sizes(methods.iter().map(|method| (method.evaluation.name.as_str(), &method.evaluation.error))))
                " The two axes differ. "
                (cut_words(cut_off(pooled, end_mm), end_mm))
            }
        }
    }
}

fn by_finger(methods: &[Method<'_>]) -> Markup {
    let all = || {
        methods
            .iter()
            .flat_map(|m| m.evaluation.error_by_finger.as_array())
    };
    let end_mm = shared_end_mm(all());
    html! {
        figure.panels {
            @for finger in Finger::ALL {
                (box_plot::draw(&BoxPlot {
                    title: finger.name(),
                    swatch: Some(finger_class(finger)),
                    axis_name: AXIS_NAME,
                    end_mm,
                    rows: methods
                        .iter()
                        .map(|method| row(method, &method.evaluation.error_by_finger[finger]))
                        .collect(),
                }))
            }
            figcaption {
                b { "Error by finger and method, one axis for all five." }
                " " (BOX_WORDS) " "
                (finger_sizes(methods.iter().map(|method| method.evaluation.error_by_finger.as_array())))
                " " (cut_words(cut_off(all(), end_mm), end_mm))
            }
        }
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

/// The lowest curves are enlarged where the highest is this many times as high.
const ENLARGE_FROM: f64 = 2.5;

fn over_time(evaluation: &Evaluation, methods: &[Method<'_>]) -> Markup {
    let rate_hz = evaluation.session.rate_hz;
    let curves: Vec<(&Method<'_>, f64)> = methods
        .iter()
        .map(|method| {
            let peak = method
                .evaluation
                .median_error_by_sample_m
                .iter()
                .copied()
                .filter(|v| v.is_finite())
                .fold(0.0, f64::max);
            (method, to_mm(peak))
        })
        .filter(|(method, _)| !method.evaluation.median_error_by_sample_m.is_empty())
        .collect();
    let highest = curves.iter().map(|(_, peak)| *peak).fold(0.0, f64::max);
    let default = curves
        .iter()
        .find(|(method, _)| method.default)
        .map_or(0.0, |(_, peak)| *peak);
    let enlarged = nice_end(1.5 * default, 6);
    let entries: Vec<(&str, &str)> = curves
        .iter()
        .map(|(method, _)| (method.class.as_str(), method.evaluation.name.as_str()))
        .collect();
    let chart = |title: &str, high: f64| {
        line_chart::draw(&LineChart {
            title,
            x: AxisSpec {
                name: "time in the segment (s)",
                low: 0.0,
                high: evaluation.session.segment_samples.saturating_sub(1) as f64 / rate_hz,
                log: false,
            },
            y: AxisSpec {
                name: "median error (mm)",
                low: 0.0,
                high,
                log: false,
            },
            // The default method is drawn last, on top.
            series: curves
                .iter()
                .filter(|(method, _)| !method.default)
                .chain(curves.iter().filter(|(method, _)| method.default))
                .map(|(method, _)| Series {
                    label: method.evaluation.name.clone(),
                    class: method.class.clone(),
                    points: method
                        .evaluation
                        .median_error_by_sample_m
                        .iter()
                        .enumerate()
                        .map(|(sample, &m)| (sample as f64 / rate_hz, to_mm(m)))
                        .collect(),
                })
                .collect(),
            dots: false,
            marked_x: None,
        })
    };
    let enlarge = default > 0.0 && highest > ENLARGE_FROM * default;
    html! {
        @if curves.is_empty() {
            p { "No method has errors over the time within a segment." }
        } @else {
            figure.panels.wide {
                (chart("Over the time within a segment", nice_end(highest, 6)))
                @if enlarge { (chart("The same, lower part enlarged", enlarged)) }
                figcaption {
                    (legend(&entries))
                    b { "Median error against time within the segment." }
                    " Median over test segments of the error of all fingers at each sample. Methods that are given both ends are right there and \
                     farthest off between them."
                    @if enlarge {
                        " The second axis ends at " (plain(enlarged)) " mm; lines that leave it at the top are cut."
                    }
                }
            }
        }
    }
}

const COLUMNS: [Column<'static>; 12] = [
    words("method"),
    numbers("n", ""),
    numbers("filled", ""),
    numbers("left out", ""),
    numbers("mean", "mm"),
    numbers("RMSE", "mm"),
    numbers("5 %", "mm"),
    numbers("25 %", "mm"),
    numbers("median", "mm"),
    numbers("75 %", "mm"),
    numbers("95 %", "mm"),
    numbers("max", "mm"),
];

fn statistics_table(methods: &[Method<'_>]) -> Markup {
    let group = |head: Markup, of: &dyn Fn(&Method<'_>) -> Statistics| Group {
        head: Some(head),
        lines: methods
            .iter()
            .map(|method| line(method, &of(method)))
            .collect(),
    };
    let mut groups = vec![group(html! { "all fingers" }, &|method| {
        method.evaluation.error
    })];
    groups.extend(Finger::ALL.map(|finger| {
        let head = html! { span.swatch.(finger_class(finger)) {} (finger.name()) };
        group(head, &|method| method.evaluation.error_by_finger[finger])
    }));
    html! {
        (grouped("Error statistics", &COLUMNS, &groups))
        p.note {
            "n: fingertip positions compared. Filled: those among them that rest on an interpolated sample. Left out: those that a test take \
             without gaps would have given in addition."
        }
    }
}

/// A method's distribution as a line of a table with [`COLUMNS`].
fn line(method: &Method<'_>, statistics: &Statistics) -> Line {
    let s = statistics;
    let value = |metres: f64| {
        if s.n == 0 {
            NONE.to_owned()
        } else {
            millimetres(metres)
        }
    };
    Line {
        head: name(method),
        cells: [s.n, s.n_filled, s.n_left_out]
            .map(|n| count(n, NARROW_SPACE))
            .into_iter()
            .chain([s.mean, s.rmse, s.p5, s.p25, s.p50, s.p75, s.p95, s.max].map(value))
            .collect(),
        stressed: method.default,
    }
}

/// Distributions of several methods by finger as a table with the same columns.
pub(super) fn finger_table<'a>(
    caption: &str,
    methods: &[(&'a Method<'a>, &'a [Statistics; Finger::COUNT])],
) -> Markup {
    let groups = Finger::ALL.map(|finger| Group {
        head: Some(html! { span.swatch.(finger_class(finger)) {} (finger.name()) }),
        lines: methods
            .iter()
            .map(|(method, fingers)| line(method, &fingers[finger.index()]))
            .collect(),
    });
    grouped(caption, &COLUMNS, &groups)
}
