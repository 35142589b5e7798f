//! Axes: a line, ticks with labels, faint grid lines, a name with its unit.

use maud::{Markup, html};

use super::scale::Scale;
use super::{Frame, Px};

/// From the baseline of the lowest frame edge to the tick labels' baseline.
const TICK_LABEL_DROP: f64 = 18.0;
/// From there to the axis name's baseline.
const NAME_DROP: f64 = 18.0;
/// From the top of the frame up to the baseline of a vertical axis' name.
const NAME_RISE: f64 = 13.0;
/// Room that a bottom axis needs below the frame.
pub(crate) const BOTTOM_ROOM: f64 = TICK_LABEL_DROP + NAME_DROP + 5.0;

/// A horizontal axis along the bottom of the frame, with grid lines upwards.
pub(crate) fn bottom(frame: &Frame, scale: &Scale, wanted_ticks: usize, name: &str) -> Markup {
    let name_y = frame.bottom + TICK_LABEL_DROP + NAME_DROP;
    html! {
        @for tick in scale.ticks(wanted_ticks) {
            @let x = Px(scale.at(tick.value));
            line.grid x1=(x) y1=(Px(frame.top)) x2=(x) y2=(Px(frame.bottom)) {}
            @if !tick.label.is_empty() {
                text.tick x=(x) y=(Px(frame.bottom + TICK_LABEL_DROP)) text-anchor="middle" { (tick.label) }
            }
        }
        line.axis x1=(Px(frame.left)) y1=(Px(frame.bottom)) x2=(Px(frame.right)) y2=(Px(frame.bottom)) {}
        text.name x=(Px(0.5 * (frame.left + frame.right))) y=(Px(name_y)) text-anchor="middle" { (scale.name(name)) }
    }
}

/// A vertical axis along the left of the frame, with grid lines to the right. Its name stands
/// above it, upright: turned text is hard to read on a phone.
pub(crate) fn left(frame: &Frame, scale: &Scale, wanted_ticks: usize, name: &str) -> Markup {
    html! {
        @for tick in scale.ticks(wanted_ticks) {
            @let y = scale.at(tick.value);
            line.grid x1=(Px(frame.left)) y1=(Px(y)) x2=(Px(frame.right)) y2=(Px(y)) {}
            @if !tick.label.is_empty() {
                text.tick x=(Px(frame.left - 6.0)) y=(Px(y + 4.0)) text-anchor="end" { (tick.label) }
            }
        }
        line.axis x1=(Px(frame.left)) y1=(Px(frame.top)) x2=(Px(frame.left)) y2=(Px(frame.bottom)) {}
        text.name x="0" y=(Px(frame.top - NAME_RISE)) { (scale.name(name)) }
    }
}
