//! Differences with their intervals: one row each, and a line at no difference.

use maud::{Markup, html};

use super::scale::{Scale, nice_step};
use super::{Frame, Panel, Px, axes};
use crate::words::shortened;

/// One difference.
pub(crate) struct ForestRow<'a> {
    /// Name at the left.
    pub(crate) label: &'a str,
    /// Class of its colour.
    pub(crate) class: &'a str,
    /// Whether the name is stressed.
    pub(crate) stressed: bool,
    /// The difference, percent.
    pub(crate) value: f64,
    /// Its interval, percent.
    pub(crate) interval: Option<[f64; 2]>,
}

/// A figure of differences.
pub(crate) struct Forest<'a> {
    /// What is shown, above the figure.
    pub(crate) title: &'a str,
    /// Name of the axis with its unit.
    pub(crate) axis_name: &'a str,
    /// Ends of the axis, percent; [`axis_ends`] chooses them.
    pub(crate) ends: [f64; 2],
    /// Differences from top to bottom.
    pub(crate) rows: Vec<ForestRow<'a>>,
}

const WIDTH: f64 = 380.0;
const LABEL_LETTERS: usize = 18;
const LETTER_WIDTH: f64 = 7.2;
const LABEL_GAP: f64 = 8.0;
const NUMBERS_WIDTH: f64 = 62.0;
const TOP: f64 = 38.0;
const ROW_HEIGHT: f64 = 24.0;
const WANTED_TICKS: usize = 4;
/// Twice as large is as far as an axis reaches: what is farther is told by its number.
const REACH: f64 = 100.0;
/// Shortest axis, percentage points: less would make a drama of rounding.
const SHORTEST: f64 = 10.0;

/// Ends on whole steps that hold no difference, and every interval up to twice as large.
pub(crate) fn axis_ends<'a>(rows: impl IntoIterator<Item = &'a ForestRow<'a>>) -> [f64; 2] {
    let values = (rows.into_iter())
        .flat_map(|row| {
            [
                Some(row.value),
                row.interval.map(|i| i[0]),
                row.interval.map(|i| i[1]),
            ]
        })
        .flatten()
        .filter(|value| value.is_finite());
    let (low, high) = values.fold((0.0_f64, 0.0_f64), |(low, high), value| {
        (low.min(value.max(-REACH)), high.max(value.min(REACH)))
    });
    let missing = 0.5 * (SHORTEST - (high - low)).max(0.0);
    let step = nice_step(high - low + 2.0 * missing, WANTED_TICKS);
    [
        ((low - missing) / step).floor() * step,
        ((high + missing) / step).ceil() * step,
    ]
}

/// Draws the figure.
pub(crate) fn draw(forest: &Forest<'_>) -> Panel {
    let bottom = TOP + ROW_HEIGHT * forest.rows.len() as f64;
    let longest = (forest.rows.iter())
        .map(|row| row.label.chars().count())
        .max();
    let frame = Frame {
        left: LABEL_GAP + LETTER_WIDTH * longest.unwrap_or(0).min(LABEL_LETTERS) as f64,
        top: TOP,
        right: WIDTH - NUMBERS_WIDTH,
        bottom,
    };
    let [low, high] = forest.ends;
    let scale = Scale::linear(low, high, frame.left, frame.right);
    let zero = Px(scale.at(0.0));
    let shapes = html! {
        text.title x="0" y="12.5" { (forest.title) }
        text.tick x=(zero) y=(Px(TOP - 6.0)) text-anchor="middle" { "equal" }
        (axes::bottom(&frame, &scale, WANTED_TICKS, forest.axis_name))
        line.mark x1=(zero) y1=(Px(frame.top)) x2=(zero) y2=(Px(frame.bottom)) {}
        @for (place, row) in forest.rows.iter().enumerate() {
            @let y = TOP + ROW_HEIGHT * (place as f64 + 0.5);
            g.row {
                title { (tooltip(row)) }
                rect.hover x="0" y=(Px(y - 0.5 * ROW_HEIGHT)) width=(Px(WIDTH)) height=(Px(ROW_HEIGHT)) {}
                text.label.stressed[row.stressed] x=(Px(frame.left - LABEL_GAP)) y=(Px(y + 4.0)) text-anchor="end" { (shortened(row.label, LABEL_LETTERS)) }
                (glyph(row, &frame, &scale, [low, high], y))
                text.value x=(Px(WIDTH - 1.0)) y=(Px(y + 4.0)) text-anchor="end" { (signed(row.value)) }
            }
        }
    };
    Panel {
        width: WIDTH,
        height: bottom + axes::BOTTOM_ROOM,
        summary: summary(forest),
        shapes,
    }
}

fn glyph(
    row: &ForestRow<'_>,
    frame: &Frame,
    scale: &Scale,
    [low, high]: [f64; 2],
    y: f64,
) -> Markup {
    let x = |value: f64| scale.at(value.clamp(low, high));
    let inside = |value: f64| (low..=high).contains(&value);
    html! {
        g.(row.class) {
            @if let Some([from, to]) = row.interval.filter(|i| i.iter().all(|v| v.is_finite()) && i[0] <= high) {
                line.bar x1=(Px(x(from))) y1=(Px(y)) x2=(Px(x(to))) y2=(Px(y)) {}
            }
            @if inside(row.value) {
                circle.point cx=(Px(x(row.value))) cy=(Px(y)) r="3.6" {}
            } @else if row.value > high {
                path.past d={ "M" (Px(frame.right - 1.0)) " " (Px(y - 4.0)) "l6 4l-6 4z" } {}
            }
        }
    }
}

/// A difference with its sign, whole percent where it is large.
pub(crate) fn signed(value: f64) -> String {
    if !value.is_finite() {
        return crate::number::NONE.to_owned();
    }
    let digits = usize::from(value.abs() < 99.95);
    let text = format!("{:.digits$}", value.abs());
    if text.bytes().all(|b| matches!(b, b'0' | b'.')) {
        return format!("{text} %");
    }
    format!("{}{text} %", if value < 0.0 { '−' } else { '+' })
}

fn tooltip(row: &ForestRow<'_>) -> String {
    match row.interval {
        Some([from, to]) => format!(
            "{}: {} ({} to {})",
            row.label,
            signed(row.value),
            signed(from),
            signed(to)
        ),
        None => format!("{}: {}, no interval", row.label, signed(row.value)),
    }
}

fn summary(forest: &Forest<'_>) -> String {
    let rows: Vec<String> = forest.rows.iter().map(tooltip).collect();
    format!("{}: {}", forest.title, rows.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_intervals_and_no_difference() {
        let row = |value, interval| ForestRow {
            label: "",
            class: "",
            stressed: false,
            value,
            interval,
        };
        let ends = |rows: &[ForestRow<'static>]| axis_ends(rows);
        assert_eq!(ends(&[row(-12.0, Some([-18.0, -6.0]))]), [-20.0, 0.0]);
        assert_eq!(ends(&[row(340.0, Some([300.0, 380.0]))]), [0.0, 100.0]);
        let [low, high] = ends(&[row(0.1, None)]);
        assert!(low <= -4.0 && high >= 4.0);
        assert!(ends(&[row(f64::NAN, None)])[0] < 0.0);
    }

    #[test]
    fn differences_have_signs() {
        for (value, text) in [
            (-12.34, "−12.3 %"),
            (5.0, "+5.0 %"),
            (0.01, "0.0 %"),
            (340.4, "+340 %"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(signed(value), text);
        }
    }
}
