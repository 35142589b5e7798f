//! Prediction regions of plans compared with recorded motion.

use inhand_model::{CorridorCoverage, Finger};
use maud::html;

use super::{Body, Method};
use crate::figure::row_plot::{self, Mark, MarkShape, PlotRow, RowPlot, WANTED_TICKS};
use crate::figure::scale::{Scale, whole_steps};
use crate::figure::{Figure, FigureData, Key, finger_keys};
use crate::table::{Table, evaluated};
use crate::words::{NONE, count_range, percent, stated_percent};

/// A prediction region of a method.
type Region<'m, 'a> = (&'m Method<'a>, &'a CorridorCoverage);

/// The section's content; `None` where no method plans a prediction region.
pub(super) fn section(methods: &[Method<'_>]) -> Option<Body> {
    let mut all: Vec<Region<'_, '_>> = (methods.iter())
        .flat_map(|method| {
            method
                .evaluation
                .corridors
                .iter()
                .map(move |own| (method, own))
        })
        .collect();
    if all.is_empty() {
        return None;
    }
    // Stable: those of one stated share stay in the order of the methods.
    all.sort_by(|a, b| a.1.share_stated.total_cmp(&b.1.share_stated));
    let regions: Vec<&[Region<'_, '_>]> =
        (all.chunk_by(|a, b| a.1.share_stated == b.1.share_stated)).collect();
    let body = Body::from(html! {
        p {
            "A prediction region states, for each fingertip and instant, how far from the plan the recorded fingertip may be when both do the same task. \
             It is calibrated where it contains the stated share of the recorded motion: too narrow below, too wide above."
        }
    });
    let groups = regions.iter().map(|region| {
        let head = format!("stated: {} %", stated_percent(region[0].1.share_stated));
        (head, region.to_vec())
    });
    let share = |own: &CorridorCoverage, share: f64| evaluated(own.n, percent(share));
    let caption =
        "Share of recorded fingertip positions inside the prediction region, on the test segments";
    let table = Table::grouped(caption, groups, "method", |(method, _)| method.head())
        .stressed(|(method, _)| method.default)
        .decimals("width", "std. dev.", 2, |(_, own)| own.mahalanobis)
        .numbers("all fingers", "% inside", |(_, own)| {
            share(own, own.share_inside.all)
        })
        .fingers("%", |(_, own), finger| {
            share(own, own.share_inside.by_finger[finger])
        })
        .counts("n", "positions", |(_, own)| own.n)
        .counts("filled", "", |(_, own)| own.n_filled)
        .counts("left out", "", |(_, own)| own.n_left_out);
    let table = Body::default().prose(table).prose(html! {
        p.note {
            "n: recorded fingertip positions evaluated, of all fingers. Filled: those among them that rest on an interpolated sample. Left out: a gap, a \
             plan that failed, or one without a prediction region. Width: as a Mahalanobis distance, in standard deviations of the region's own \
             three-dimensional covariance. Neighbouring instants are not independent, so a share is less certain than n suggests."
        }
    });
    Some(
        body.figure(figure(&regions))
            .folded("Shares by finger, and widths", table),
    )
}

/// Shortest axis, percentage points: less would make a drama of rounding.
const SHORTEST: f64 = 10.0;

/// `None` where nothing was evaluated.
fn figure(regions: &[&[Region<'_, '_>]]) -> Option<Figure> {
    // Method, finger, stated and found percentages.
    let mut cells: Vec<(&str, &str, f64, f64)> = Vec::new();
    let mut panels = Vec::new();
    let sizes = regions.iter().flat_map(|region| region.iter());
    let sizes: Vec<usize> = sizes.map(|(_, own)| own.n).filter(|n| *n > 0).collect();
    for region in regions {
        let share_stated = region[0].1.share_stated;
        let known = region.iter();
        let known = known.filter(|(_, own)| own.n > 0 && share_stated.is_finite());
        let rows: Vec<PlotRow<'_>> = known
            .clone()
            .map(|(method, own)| row(method, own))
            .collect();
        if rows.is_empty() {
            continue;
        }
        let stated = 100.0 * share_stated;
        let first = cells.len();
        for (method, own) in known {
            let shares = &own.share_inside;
            let cell = |finger, share: f64| (method.name, finger, stated, 100.0 * share);
            cells.push(cell("all", shares.all));
            cells.extend(
                shares
                    .by_finger
                    .iter()
                    .map(|(f, &share)| cell(f.name(), share)),
            );
        }
        let shown = cells[first..].iter().map(|cell| cell.3).chain([stated]);
        let [low, high] = whole_steps(shown, SHORTEST, WANTED_TICKS);
        panels.push(row_plot::draw(&RowPlot {
            title: &format!("{} % prediction regions", stated_percent(share_stated)),
            axis: (
                "recorded positions inside (%)",
                Scale::linear(low.max(0.0), high.min(100.0)),
            ),
            marked: Some((stated, "stated")),
            numbers: &["all"],
            rows,
            ..RowPlot::default()
        }));
    }
    (!panels.is_empty()).then(|| Figure {
        id: "corridor-coverage",
        title: "Share of the recorded motion inside the prediction regions.".to_owned(),
        caption: format!(
            "Dot: a finger; upright line: all fingers, also as a number at the right; dotted: the share stated; n = {} recorded \
             positions. The axes differ and do not start at zero.",
            count_range(&sizes)
        ),
        data: FigureData::about(&cells)
            .words("motion", |cell| cell.0)
            .words("finger", |cell| cell.1)
            .numbers("stated_percent", |cell| cell.2)
            .numbers("inside_percent", |cell| cell.3)
            .done(),
        legend: finger_keys(Key::area),
        panels,
    })
}

/// A mark for all fingers together, then one for each.
fn row<'m>(method: &'m Method<'_>, coverage: &CorridorCoverage) -> PlotRow<'m> {
    let shares = &coverage.share_inside;
    let with_sign = |share: f64| match share.is_finite() {
        true => format!("{} %", percent(share)),
        false => NONE.to_owned(),
    };
    let mut marks = vec![Mark::at(MarkShape::Across, 100.0 * shares.all)];
    marks.extend(Finger::ALL.map(|finger| {
        let mark = Mark::at(MarkShape::Dot, 100.0 * shares.by_finger[finger]);
        mark.of_finger(finger, String::new())
    }));
    let fingers = Finger::ALL.map(|f| format!("{f} {}", with_sign(shares.by_finger[f])));
    let all = with_sign(shares.all);
    PlotRow {
        tooltip: format!("{}: all fingers {all}; {}", method.name, fingers.join(", ")),
        marks,
        numbers: vec![percent(shares.all)],
        ..method.row()
    }
}
