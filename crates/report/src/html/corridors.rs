//! Whether plans know how far they may be off: stated corridors against recorded motion.

use inhand_model::{CorridorCoverage, Finger};
use maud::{Markup, html};

use super::Method;
use super::session::name;
use super::table::{Group, Line, grouped, numbers, words};
use crate::figure::dot_plot::{self, DotPlot, Row};
use crate::figure::palette::finger_class;
use crate::learned::stated_percent;
use crate::number::{NARROW_SPACE, NONE, count, decimals, percent};

/// Methods with a corridor of one stated share.
struct Width<'a, 'b> {
    share_stated: f64,
    methods: Vec<(&'a Method<'b>, &'b CorridorCoverage)>,
}

/// The section's content; `None` where no method plans a corridor.
pub(super) fn section(methods: &[Method<'_>]) -> Option<Markup> {
    let widths = widths(methods);
    if widths.is_empty() {
        return None;
    }
    Some(html! {
        p {
            "A corridor says, for each fingertip and instant, how far from the plan the recorded fingertip may be when both do the same task. \
             It is honest where it holds the stated share of the recorded motion: a smaller share means that plans claim to know more than \
             they do, a larger one that they know more than they claim."
        }
        (figure(&widths))
        (share_table(&widths))
        p.note {
            "n: recorded fingertip positions judged, of all fingers. Filled: those among them that rest on an interpolated sample. Left out: a gap, a \
             plan that failed, or one without a corridor. Width: as a Mahalanobis distance, in standard deviations of the corridor's own \
             three-dimensional covariance. Neighbouring instants are not independent, so a share is less certain than n suggests."
        }
    })
}

/// Stated shares in rising order, each with the methods that state it.
fn widths<'a, 'b>(methods: &'a [Method<'b>]) -> Vec<Width<'a, 'b>> {
    let mut widths: Vec<Width<'a, 'b>> = Vec::new();
    for method in methods {
        for coverage in &method.evaluation.corridors {
            let same = |width: &&mut Width<'_, '_>| width.share_stated == coverage.share_stated;
            match widths.iter_mut().find(same) {
                Some(width) => width.methods.push((method, coverage)),
                None => widths.push(Width {
                    share_stated: coverage.share_stated,
                    methods: vec![(method, coverage)],
                }),
            }
        }
    }
    widths.sort_by(|a, b| a.share_stated.total_cmp(&b.share_stated));
    widths
}

fn figure(widths: &[Width<'_, '_>]) -> Markup {
    let drawn: Vec<(&Width<'_, '_>, Vec<Row<'_>>)> = widths
        .iter()
        .map(|width| (width, rows(width)))
        .filter(|(_, rows)| !rows.is_empty())
        .collect();
    html! {
        @if !drawn.is_empty() {
            figure.panels {
                @for (width, rows) in drawn {
                    (dot_plot::draw(&DotPlot {
                        title: &format!("{} % corridors", stated_percent(width.share_stated)),
                        axis_name: "recorded positions inside (%)",
                        stated: width.share_stated,
                        rows,
                    }))
                }
                figcaption {
                    b { "Share of the recorded motion inside the corridors." }
                    " One dot a finger ("
                    @for (place, finger) in Finger::ALL.into_iter().enumerate() {
                        @if place > 0 { ", " }
                        span.together { span.swatch.(finger_class(finger)) {} (finger.name()) }
                    }
                    "); upright line: all fingers, also as a number at the right; dotted: the share stated. The axes differ and do not start \
                     at zero."
                }
            }
        }
    }
}

/// Methods of which anything was judged.
fn rows<'a>(width: &Width<'a, 'a>) -> Vec<Row<'a>> {
    width
        .methods
        .iter()
        .filter(|(_, coverage)| coverage.n > 0 && width.share_stated.is_finite())
        .map(|(method, coverage)| Row {
            label: &method.evaluation.name,
            class: &method.class,
            stressed: method.default,
            pooled: coverage.share_inside,
            by_finger: &coverage.share_inside_by_finger,
        })
        .collect()
}

fn share_table(widths: &[Width<'_, '_>]) -> Markup {
    let mut columns = vec![
        words("method"),
        numbers("n", "positions"),
        numbers("filled", ""),
        numbers("left out", ""),
        numbers("width", "std. dev."),
        numbers("all fingers", "% inside"),
    ];
    columns.extend(Finger::ALL.map(|finger| numbers(finger.name(), "%")));
    let groups: Vec<Group> = widths
        .iter()
        .map(|width| Group {
            head: Some(html! { "stated: " (stated_percent(width.share_stated)) " %" }),
            lines: width
                .methods
                .iter()
                .map(|(method, coverage)| Line {
                    head: name(method),
                    cells: cells(coverage),
                    best: Vec::new(),
                    stressed: method.default,
                })
                .collect(),
        })
        .collect();
    grouped(
        "Share of recorded fingertip positions inside the stated corridor, on the test segments",
        &columns,
        &groups,
    )
}

fn cells(coverage: &CorridorCoverage) -> Vec<String> {
    let share = |value: f64| match coverage.n {
        0 => NONE.to_owned(),
        _ => percent(value),
    };
    let counts = [coverage.n, coverage.n_filled, coverage.n_left_out];
    counts
        .map(|n| count(n, NARROW_SPACE))
        .into_iter()
        .chain([
            decimals(coverage.mahalanobis, 2),
            share(coverage.share_inside),
        ])
        .chain(coverage.share_inside_by_finger.as_array().map(share))
        .collect()
}
