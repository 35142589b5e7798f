//! Bars side by side: a group for each thing counted, a bar for each motion.

use maud::html;

use super::scale::Scale;
use super::{Frame, Panel, Px, axes};
use crate::number::percent;

/// Bars of one motion.
pub(crate) struct BarSeries<'a> {
    /// Name, in the tooltip.
    pub(crate) label: &'a str,
    /// Class of its colour.
    pub(crate) class: &'a str,
    /// Share of each group, 0 to 1.
    pub(crate) shares: Vec<f64>,
}

/// A figure of shares by group.
pub(crate) struct Bars<'a> {
    /// Title, above the figure.
    pub(crate) title: &'a str,
    /// Name of the horizontal axis.
    pub(crate) x_name: &'a str,
    /// Name of the vertical axis.
    pub(crate) y_name: &'a str,
    /// Names of the groups from left to right.
    pub(crate) groups: Vec<String>,
    /// Bars within each group from left to right.
    pub(crate) series: Vec<BarSeries<'a>>,
}

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 286.0;
const FRAME: Frame = Frame {
    left: 42.0,
    top: 44.0,
    right: WIDTH - 8.0,
    bottom: HEIGHT - axes::BOTTOM_ROOM,
};
const WANTED_TICKS: usize = 5;
/// Of a group's width, what is left free.
const GAP_SHARE: f64 = 0.22;
/// Least height of a bar above zero: rare is not never.
const LEAST: f64 = 1.0;

/// Draws the figure.
pub(crate) fn draw(bars: &Bars<'_>) -> Panel {
    let y = Scale::linear(0.0, 100.0, FRAME.bottom, FRAME.top);
    let group_width = FRAME.width() / bars.groups.len().max(1) as f64;
    let bar_width = group_width * (1.0 - GAP_SHARE) / bars.series.len().max(1) as f64;
    let shapes = html! {
        text.title x="0" y="12.5" { (bars.title) }
        (axes::left(&FRAME, &y, WANTED_TICKS, bars.y_name))
        line.axis x1=(Px(FRAME.left)) y1=(Px(FRAME.bottom)) x2=(Px(FRAME.right)) y2=(Px(FRAME.bottom)) {}
        text.name x=(Px(0.5 * (FRAME.left + FRAME.right))) y=(Px(HEIGHT - 5.0)) text-anchor="middle" { (bars.x_name) }
        @for (place, name) in bars.groups.iter().enumerate() {
            @let left = FRAME.left + group_width * (place as f64 + 0.5 * GAP_SHARE);
            text.tick x=(Px(FRAME.left + group_width * (place as f64 + 0.5))) y=(Px(FRAME.bottom + 18.0)) text-anchor="middle" { (name) }
            @for (number, series) in bars.series.iter().enumerate() {
                @let share = series.shares.get(place).copied().unwrap_or(f64::NAN);
                @if share > 0.0 {
                    @let top = y.at(100.0 * share).min(FRAME.bottom - LEAST);
                    g.(series.class) {
                        rect.area x=(Px(left + bar_width * number as f64)) y=(Px(top)) width=(Px(0.86 * bar_width)) height=(Px(FRAME.bottom - top)) {
                            title { (series.label) ", " (name) ": " (percent(share)) " %" }
                        }
                    }
                }
            }
        }
    };
    Panel {
        width: WIDTH,
        height: HEIGHT,
        summary: summary(bars),
        shapes,
    }
}

fn summary(bars: &Bars<'_>) -> String {
    let series: Vec<String> = (bars.series.iter())
        .map(|series| {
            let shares: Vec<String> = series.shares.iter().map(|&share| percent(share)).collect();
            format!("{} {} %", series.label, shares.join(", "))
        })
        .collect();
    format!(
        "{}: share of {}; {}",
        bars.title,
        bars.groups.join(", "),
        series.join("; ")
    )
}
