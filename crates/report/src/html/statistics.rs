//! Distributions as tables.

use inhand_model::{Finger, Statistics};
use maud::{Markup, html};

use super::Method;
use super::session::name;
use super::table::{Column, Group, Line, grouped, numbers, smallest, words};
use crate::figure::palette::finger_class;
use crate::number::{NARROW_SPACE, NONE, count, millimetres};

/// Columns of a table of distributions of lengths.
pub(super) const COLUMNS: [Column<'static>; 12] = [
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
/// Cells of a line before its lengths: n, filled, left out.
const COUNTS: usize = 3;

/// Errors of all methods: pooled, at the ends, and of each finger.
pub(super) fn error_table(methods: &[Method<'_>]) -> Markup {
    let of = |choose: fn(&Method<'_>) -> Statistics| -> Vec<Statistics> {
        methods.iter().map(choose).collect()
    };
    let mut groups = vec![
        group(
            html! { "all fingers" },
            methods,
            &of(|m| m.evaluation.error.all),
            true,
        ),
        group(
            html! { "all fingers, first sample" },
            methods,
            &of(|m| m.evaluation.error_at_start),
            true,
        ),
        group(
            html! { "all fingers, last sample" },
            methods,
            &of(|m| m.evaluation.error_at_goal),
            true,
        ),
    ];
    groups.extend(Finger::ALL.map(|finger| {
        let statistics: Vec<Statistics> = methods
            .iter()
            .map(|method| method.evaluation.error.by_finger[finger])
            .collect();
        group(finger_head(finger), methods, &statistics, true)
    }));
    html! {
        (grouped("Error statistics", &COLUMNS, &groups))
        p.note {
            "n: fingertip positions compared. Filled: those among them that rest on an interpolated sample. Left out: those that test takes \
             without gaps, and plans without failures, would have given in addition. Bold: smallest of its column among the methods."
        }
    }
}

/// Distributions of several methods by finger. `smaller_is_better` marks the smallest.
pub(super) fn finger_table(
    caption: &str,
    methods: &[Method<'_>],
    distributions: &[&[Statistics; Finger::COUNT]],
    smaller_is_better: bool,
) -> Markup {
    let groups = Finger::ALL.map(|finger| {
        let statistics: Vec<Statistics> = distributions
            .iter()
            .map(|fingers| fingers[finger.index()])
            .collect();
        group(finger_head(finger), methods, &statistics, smaller_is_better)
    });
    grouped(caption, &COLUMNS, &groups)
}

fn finger_head(finger: Finger) -> Markup {
    html! { span.swatch.(finger_class(finger)) {} (finger.name()) }
}

fn group(
    head: Markup,
    methods: &[Method<'_>],
    statistics: &[Statistics],
    smaller_is_better: bool,
) -> Group {
    let lengths: Vec<[f64; COLUMNS.len() - 1 - COUNTS]> = statistics.iter().map(lengths).collect();
    let best = if smaller_is_better {
        smallest(&lengths, |_, length| printed(length))
    } else {
        vec![Vec::new(); lengths.len()]
    };
    let lines = methods
        .iter()
        .zip(statistics)
        .zip(best)
        .map(|((method, s), best)| Line {
            head: name(method),
            cells: cells(s),
            best: best.into_iter().map(|c| c + COUNTS).collect(),
            stressed: method.default,
        })
        .collect();
    Group {
        head: Some(head),
        lines,
    }
}

/// Cells under [`COLUMNS`], but for the name.
pub(super) fn cells(s: &Statistics) -> Vec<String> {
    let counts = [s.n, s.n_filled, s.n_left_out].map(|n| count(n, NARROW_SPACE));
    counts.into_iter().chain(lengths(s).map(printed)).collect()
}

fn printed(length: f64) -> String {
    if length.is_finite() {
        millimetres(length)
    } else {
        NONE.to_owned()
    }
}

fn lengths(statistics: &Statistics) -> [f64; COLUMNS.len() - 1 - COUNTS] {
    let s = statistics;
    let all = [s.mean, s.rmse, s.p5, s.p25, s.p50, s.p75, s.p95, s.max];
    if s.n == 0 { all.map(|_| f64::NAN) } else { all }
}
