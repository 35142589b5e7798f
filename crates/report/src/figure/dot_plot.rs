//! Shares by finger beside a stated share: one row a method, one dot a finger, a tick for all
//! fingers together, and a line where all of them should be.

use inhand_model::{Finger, PerFinger};
use maud::html;

use super::palette::finger_class;
use super::scale::{Scale, nice_step};
use super::{Frame, Panel, Px, axes};
use crate::learned::stated_percent;
use crate::number::{NONE, percent};
use crate::words::shortened;

/// One method.
pub(crate) struct Row<'a> {
    /// Name at the left.
    pub(crate) label: &'a str,
    /// Class that colours the tick.
    pub(crate) class: &'a str,
    /// Whether the name is stressed.
    pub(crate) stressed: bool,
    /// Share over all fingers, 0 to 1.
    pub(crate) pooled: f64,
    /// Share of each finger.
    pub(crate) by_finger: &'a PerFinger<f64>,
}

/// A figure of several methods on one axis.
pub(crate) struct DotPlot<'a> {
    /// What is shown, above the figure.
    pub(crate) title: &'a str,
    /// Name of the axis with its unit.
    pub(crate) axis_name: &'a str,
    /// The share that was stated, 0 to 1.
    pub(crate) stated: f64,
    /// Methods from top to bottom.
    pub(crate) rows: Vec<Row<'a>>,
}

const WIDTH: f64 = 380.0;
const LABEL_LETTERS: usize = 20;
/// Width of a letter at the figure's text size, generous enough for bold and for most fonts.
const LETTER_WIDTH: f64 = 7.2;
const LABEL_GAP: f64 = 8.0;
const NUMBERS_WIDTH: f64 = 56.0;
const TOP: f64 = 38.0;
const ROW_HEIGHT: f64 = 34.0;
/// From one finger's dot down to the next one's, so that equal shares do not hide one another.
const FINGER_STEP: f64 = 5.0;
const WANTED_TICKS: usize = 5;
/// Shortest axis, percentage points: less would make a drama of rounding.
const SHORTEST: f64 = 10.0;

/// Draws the figure.
pub(crate) fn draw(plot: &DotPlot<'_>) -> Panel {
    let bottom = TOP + ROW_HEIGHT * plot.rows.len() as f64;
    let longest = plot.rows.iter().map(|row| row.label.chars().count()).max();
    let frame = Frame {
        left: LABEL_GAP + LETTER_WIDTH * longest.unwrap_or(0).min(LABEL_LETTERS) as f64,
        top: TOP,
        right: WIDTH - NUMBERS_WIDTH,
        bottom,
    };
    let (low, high) = range(plot);
    let scale = Scale::linear(low, high, frame.left, frame.right);
    let stated = scale.at(100.0 * plot.stated);
    let shapes = html! {
            text.title x="0" y="12.5" { (plot.title) }
            text.tick x=(Px(stated)) y=(Px(TOP - 6.0)) text-anchor="middle" { "stated" }
            text.tick x=(Px(WIDTH - 1.0)) y=(Px(TOP - 6.0)) text-anchor="end" { "all" }
            (axes::bottom(&frame, &scale, WANTED_TICKS, plot.axis_name))
            (frame.mark(stated))
            @for (place, row) in plot.rows.iter().enumerate() {
                @let y = TOP + ROW_HEIGHT * (place as f64 + 0.5);
                g.row {
                    title { (tooltip(row)) }
                    rect.hover x="0" y=(Px(y - 0.5 * ROW_HEIGHT)) width=(Px(WIDTH)) height=(Px(ROW_HEIGHT)) {}
                    text.label.stressed[row.stressed] x=(Px(frame.left - LABEL_GAP)) y=(Px(y + 4.0)) text-anchor="end" { (shortened(row.label, LABEL_LETTERS)) }
                    @if row.pooled.is_finite() {
                        @let x = Px(scale.at(100.0 * row.pooled));
                        g.(row.class) { line.pooled x1=(x) y1=(Px(y - 13.0)) x2=(x) y2=(Px(y + 13.0)) {} }
                    }
                    @for (finger, share) in row.by_finger.iter().filter(|(_, share)| share.is_finite()) {
                        g.(finger_class(finger)) {
                            circle.point cx=(Px(scale.at(100.0 * share))) cy=(Px(y + FINGER_STEP * (finger.index() as f64 - 2.0))) r="3" {}
                        }
                    }
                    text.value x=(Px(WIDTH - 1.0)) y=(Px(y + 4.0)) text-anchor="end" { (percent(row.pooled)) }
                }
            }
    };
    Panel {
        width: WIDTH,
        height: bottom + axes::BOTTOM_ROOM,
        summary: summary(plot),
        shapes,
    }
}

/// An axis on whole steps around what was stated and all that is shown, percent.
fn range(plot: &DotPlot<'_>) -> (f64, f64) {
    let shares = plot
        .rows
        .iter()
        .flat_map(|row| std::iter::once(&row.pooled).chain(row.by_finger.as_array()))
        .chain([&plot.stated])
        .filter(|share| share.is_finite());
    let (low, high) = shares.fold((100.0_f64, 0.0_f64), |(low, high), share| {
        (low.min(100.0 * share), high.max(100.0 * share))
    });
    let missing = 0.5 * (SHORTEST - (high - low)).max(0.0);
    let (low, high) = (low - missing, high + missing);
    let step = nice_step(high - low, WANTED_TICKS);
    (
        ((low / step).floor() * step).max(0.0),
        ((high / step).ceil() * step).min(100.0),
    )
}

fn tooltip(row: &Row<'_>) -> String {
    let fingers: Vec<String> = Finger::ALL
        .map(|finger| format!("{finger} {}", with_sign(row.by_finger[finger])))
        .into();
    format!(
        "{}: all fingers {}; {}",
        row.label,
        with_sign(row.pooled),
        fingers.join(", ")
    )
}

fn with_sign(share: f64) -> String {
    if share.is_finite() {
        format!("{} %", percent(share))
    } else {
        NONE.to_owned()
    }
}

/// What the figure says, for those who do not see it.
fn summary(plot: &DotPlot<'_>) -> String {
    let rows: Vec<String> = plot
        .rows
        .iter()
        .map(|row| format!("{} {}", row.label, with_sign(row.pooled)))
        .collect();
    format!(
        "{}: stated {} %, {}",
        plot.title,
        stated_percent(plot.stated),
        rows.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(stated: f64, shares: [f64; Finger::COUNT]) -> (f64, f64) {
        let by_finger = PerFinger::new(shares);
        range(&DotPlot {
            title: "",
            axis_name: "",
            stated,
            rows: vec![Row {
                label: "",
                class: "",
                stressed: false,
                pooled: shares[0],
                by_finger: &by_finger,
            }],
        })
    }

    #[test]
    fn the_axis_holds_what_was_stated_and_what_was_found() {
        assert_eq!(ends(0.5, [0.52, 0.44, 0.61, 0.5, 0.5]), (40.0, 65.0));
        // Short axes are made longer, and none leaves 0 to 100 %.
        assert_eq!(ends(0.95, [0.95; 5]), (90.0, 100.0));
        assert_eq!(ends(0.99, [1.0; 5]), (94.0, 100.0));
        assert_eq!(ends(0.5, [0.0, 1.0, f64::NAN, 0.5, 0.5]), (0.0, 100.0));
    }
}
