//! Whether plans know how far they may be off: stated corridors against recorded motion.

use inhand_model::{CorridorCoverage, Finger};
use maud::{Markup, html};

use super::session::name;
use super::table::{Group, Line, grouped, numbers, words};
use super::{Body, Method};
use crate::figure::dot_plot::{self, DotPlot, Row};
use crate::figure::palette::finger_class;
use crate::figure::{Figure, FigureColumn, FigureData, Key};
use crate::learned::stated_percent;
use crate::number::{NARROW_SPACE, NONE, count, decimals, percent};

/// Methods with a corridor of one stated share.
struct Width<'a, 'b> {
    share_stated: f64,
    methods: Vec<(&'a Method<'b>, &'b CorridorCoverage)>,
}

/// The section's content; `None` where no method plans a corridor.
pub(super) fn section(methods: &[Method<'_>]) -> Option<Body> {
    let widths = widths(methods);
    if widths.is_empty() {
        return None;
    }
    let mut body = Body::from(html! {
        p {
            "A corridor says, for each fingertip and instant, how far from the plan the recorded fingertip may be when both do the same task. \
             It is honest where it holds the stated share of the recorded motion: a smaller share means that plans claim to know more than \
             they do, a larger one that they know more than they claim."
        }
    });
    body.figure(figure(&widths)).prose(html! {
        (share_table(&widths))
        p.note {
            "n: recorded fingertip positions judged, of all fingers. Filled: those among them that rest on an interpolated sample. Left out: a gap, a \
             plan that failed, or one without a corridor. Width: as a Mahalanobis distance, in standard deviations of the corridor's own \
             three-dimensional covariance. Neighbouring instants are not independent, so a share is less certain than n suggests."
        }
    });
    Some(body)
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

/// `None` where nothing was judged.
fn figure(widths: &[Width<'_, '_>]) -> Option<Figure> {
    let drawn: Vec<(&Width<'_, '_>, Vec<Row<'_>>)> = widths
        .iter()
        .map(|width| (width, rows(width)))
        .filter(|(_, rows)| !rows.is_empty())
        .collect();
    if drawn.is_empty() {
        return None;
    }
    let data = data(&drawn);
    let panels = drawn.into_iter().map(|(width, rows)| {
        dot_plot::draw(&DotPlot {
            title: &format!("{} % corridors", stated_percent(width.share_stated)),
            axis_name: "recorded positions inside (%)",
            stated: width.share_stated,
            rows,
        })
    });
    Some(Figure {
        id: "corridor-coverage",
        title: "Share of the recorded motion inside the corridors.".to_owned(),
        caption: "One dot a finger; upright line: all fingers, also as a number at the right; dotted: the share \
            stated. The axes differ and do not start at zero."
            .to_owned(),
        data,
        legend: Finger::ALL
            .map(|finger| Key::area(finger.name(), finger_class(finger)))
            .into(),
        panels: panels.collect(),
    })
}

fn data(drawn: &[(&Width<'_, '_>, Vec<Row<'_>>)]) -> FigureData {
    // Stated share, method, finger, share found.
    let points: Vec<(f64, &str, &str, f64)> = drawn
        .iter()
        .flat_map(|(width, rows)| rows.iter().map(|row| (width.share_stated, row)))
        .flat_map(|(stated, row)| {
            let fingers = row
                .by_finger
                .iter()
                .map(|(finger, &share)| (finger.name(), share));
            std::iter::once(("all", row.pooled))
                .chain(fingers)
                .map(move |(finger, share)| (stated, row.label, finger, share))
        })
        .collect();
    FigureData::new([
        FigureColumn::words("motion", points.iter().map(|point| point.1)),
        FigureColumn::words("finger", points.iter().map(|point| point.2)),
        FigureColumn::numbers("stated_percent", points.iter().map(|point| 100.0 * point.0)),
        FigureColumn::numbers("inside_percent", points.iter().map(|point| 100.0 * point.3)),
    ])
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
            pooled: coverage.share_inside.all,
            by_finger: &coverage.share_inside.by_finger,
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
            share(coverage.share_inside.all),
        ])
        .chain(coverage.share_inside.by_finger.as_array().map(share))
        .collect()
}
