//! A measure by motion and finger: a row a motion, five lines from quartile to quartile with the median on each.

use inhand_model::{Finger, PerFinger, Statistics};
use maud::html;

use super::palette::finger_class;
use super::scale::{Scale, nice_step};
use super::{Frame, Panel, Px, axes};
use crate::number::{NONE, plain};
use crate::words::shortened;

/// One motion.
pub(crate) struct FingerRow<'a> {
    /// Name at the left.
    pub(crate) label: &'a str,
    /// Whether the name is stressed.
    pub(crate) stressed: bool,
    /// Its values.
    pub(crate) by_finger: PerFinger<Statistics>,
}

/// A figure of several motions on one axis.
pub(crate) struct FingerRows<'a> {
    /// What is measured, above the figure.
    pub(crate) title: &'a str,
    /// Name of the axis with its unit.
    pub(crate) axis_name: &'a str,
    /// From the unit of the statistics to that of the axis.
    pub(crate) scale: f64,
    /// Motions from top to bottom.
    pub(crate) rows: Vec<FingerRow<'a>>,
}

const WIDTH: f64 = 380.0;
const LETTERS: usize = 14;
/// Width of a letter at the figure's text size, generous enough for bold and for most fonts.
const LETTER_WIDTH: f64 = 7.2;
const LABEL_GAP: f64 = 10.0;
const TOP: f64 = 30.0;
const ROW_HEIGHT: f64 = 36.0;
/// From one finger's line down to the next one's.
const FINGER_STEP: f64 = 5.6;
const WANTED_TICKS: usize = 4;

/// Draws the figure.
pub(crate) fn draw(plot: &FingerRows<'_>) -> Panel {
    let longest = plot.rows.iter().map(|row| row.label.chars().count()).max();
    let frame = Frame {
        left: LABEL_GAP + LETTER_WIDTH * longest.unwrap_or(0).min(LETTERS) as f64,
        top: TOP,
        right: WIDTH - 12.0,
        bottom: TOP + ROW_HEIGHT * plot.rows.len() as f64,
    };
    let (low, high) = range(plot);
    let x = Scale::linear(low, high, frame.left, frame.right);
    let at = |value: f64| Px(x.at(plot.scale * value));
    let shapes = html! {
        text.title x="0" y="12.5" { (plot.title) }
        (axes::bottom(&frame, &x, WANTED_TICKS, plot.axis_name))
        @for (place, row) in plot.rows.iter().enumerate() {
            @let middle = TOP + ROW_HEIGHT * (place as f64 + 0.5);
            @if place > 0 {
                @let y = Px(middle - 0.5 * ROW_HEIGHT);
                line.grid x1="0" y1=(y) x2=(Px(frame.right)) y2=(y) {}
            }
            text.label.stressed[row.stressed] x=(Px(frame.left - LABEL_GAP)) y=(Px(middle + 4.0)) text-anchor="end" { (shortened(row.label, LETTERS)) }
            @for (finger, s) in row.by_finger.iter() {
                @let y = Px(middle + FINGER_STEP * (finger.index() as f64 - 2.0));
                @if s.n == 0 {
                    @if finger == Finger::Middle {
                        text.tick x=(Px(frame.left + 6.0)) y=(Px(middle + 4.0)) { (NONE) }
                    }
                } @else {
                    g.(finger_class(finger)) {
                        title { (tooltip(plot, row.label, finger, s)) }
                        line.bar x1=(at(s.p25)) y1=(y) x2=(at(s.p75)) y2=(y) {}
                        circle.point cx=(at(s.p50)) cy=(y) r="3" {}
                    }
                }
            }
        }
    };
    Panel {
        width: WIDTH,
        height: frame.bottom + axes::BOTTOM_ROOM,
        summary: summary(plot),
        shapes,
    }
}

/// An axis on whole steps around all quartiles.
fn range(plot: &FingerRows<'_>) -> (f64, f64) {
    let all = plot.rows.iter().flat_map(|row| row.by_finger.as_array());
    let ends = all.filter(|s| s.n > 0).flat_map(|s| [s.p25, s.p75]);
    let (low, high) = ends
        .map(|value| plot.scale * value)
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if low > high {
        return (0.0, 1.0);
    }
    // What cannot be negative starts at 0.
    let low = if low >= 0.0 { 0.0 } else { low };
    let span = if high > low { high - low } else { 1.0 };
    let step = nice_step(span, WANTED_TICKS);
    ((low / step).floor() * step, (high / step).ceil() * step)
}

fn tooltip(plot: &FingerRows<'_>, label: &str, finger: Finger, s: &Statistics) -> String {
    let [p25, p50, p75] = [s.p25, s.p50, s.p75].map(|value| rounded(plot.scale * value));
    format!(
        "{label}, {finger}: median {p50}, quartiles {p25} and {p75} (n = {})",
        s.n
    )
}

/// Three digits after the point at most.
fn rounded(value: f64) -> String {
    plain((value * 1e3).round() / 1e3)
}

/// What the figure says, for those who do not see it.
fn summary(plot: &FingerRows<'_>) -> String {
    let rows: Vec<String> = (plot.rows.iter())
        .map(|row| {
            let medians = row.by_finger.map(|s| match s.n {
                0 => NONE.to_owned(),
                _ => rounded(plot.scale * s.p50),
            });
            format!("{} {}", row.label, medians.as_array().join(", "))
        })
        .collect();
    format!(
        "{} ({}), medians of thumb to little finger: {}",
        plot.title,
        plot.axis_name,
        rows.join("; ")
    )
}
