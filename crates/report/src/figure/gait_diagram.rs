//! Which finger touches when, and the phases that makes: the gait diagram of a hand.

use inhand_model::{Finger, PhaseKind, TakeContacts};
use maud::{Markup, html};

use super::scale::Scale;
use super::{Frame, Panel, Px, axes, finger_class};
use crate::words::{plain, short, shortened};

/// Phases, in the order of tables, with their words and the class of their colour.
pub(crate) const PHASES: [(PhaseKind, &str, &str); 4] = [
    (PhaseKind::InGrasp, "in grasp", "phase-grasp"),
    (PhaseKind::FingerGaiting, "finger gaiting", "phase-gaiting"),
    (PhaseKind::Regrasp, "regrasp", "phase-regrasp"),
    (PhaseKind::NoGrasp, "no grasp", "phase-none"),
];

const WIDTH: f64 = 940.0;
const LEFT: f64 = 62.0;
const TITLE_HEIGHT: f64 = 26.0;
const LANE_HEIGHT: f64 = 15.0;
const BAR_HEIGHT: f64 = 11.0;
const PHASE_HEIGHT: f64 = 9.0;
/// Lanes of five fingers, and of the phases beneath.
const BLOCK_HEIGHT: f64 = LANE_HEIGHT * (Finger::COUNT as f64) + 18.0;
/// From the end of a row's lanes to the next row's: tick labels.
const BLOCK_GAP: f64 = 30.0;
const WANTED_TICKS: usize = 12;
/// Least width of an interval that is there at all: short is not never.
const LEAST: f64 = 0.6;

/// The longest interval in a row of a diagram, seconds.
pub(crate) const ROW_S: f64 = 60.0;
/// Rows of a diagram; what comes later is not drawn.
pub(crate) const ROWS: usize = 4;

/// Time of a take that is drawn, seconds.
pub(crate) fn shown_s(duration_s: f64) -> f64 {
    duration_s.min(ROW_S * ROWS as f64)
}

/// Draws the figure: rows of equal length below each other.
pub(crate) fn draw(take: &TakeContacts) -> Panel {
    let shown_s = shown_s(take.duration_s);
    let rows = ((shown_s / ROW_S).ceil() as usize).clamp(1, ROWS);
    let row_s = shown_s / rows as f64;
    let top = |row: usize| TITLE_HEIGHT + (BLOCK_HEIGHT + BLOCK_GAP) * row as f64;
    let shapes = html! {
        text.title x="0" y="12.5" { (shortened(&take.take, 80)) }
        @for row in 0..rows {
            (block(take, [row_s * row as f64, row_s * (row + 1) as f64], top(row), row + 1 == rows))
        }
    };
    Panel {
        width: WIDTH,
        height: top(rows - 1) + BLOCK_HEIGHT + axes::BOTTOM_ROOM,
        summary: summary(take),
        shapes,
    }
}

/// One row: a lane for each finger, phases beneath, an axis.
fn block(take: &TakeContacts, span_s: [f64; 2], top: f64, is_last: bool) -> Markup {
    let frame = Frame::new([LEFT, WIDTH - 8.0], [top, top + BLOCK_HEIGHT]);
    let x = Scale::linear(span_s[0], span_s[1]).over(frame.left, frame.right);
    let name = if is_last { "time in the take (s)" } else { "" };
    let phases_top = top + LANE_HEIGHT * Finger::COUNT as f64 + 3.0;
    html! {
        (axes::bottom(&frame, &x, WANTED_TICKS, name))
        @for finger in Finger::ALL {
            @let y = top + LANE_HEIGHT * finger.index() as f64;
            text.label x=(Px(LEFT - 8.0)) y=(Px(y + 10.5)) text-anchor="end" { (finger.name()) }
            g.(finger_class(finger)) {
                (bars(&x, &take.contacts_s[finger], [y + 1.0, BAR_HEIGHT], &format!("{finger} touches")))
            }
            g.missing {
                (bars(&x, &take.unknown_s[finger], [y + 0.5 * LANE_HEIGHT - 1.0, 1.5], &format!("{finger}: not known")))
            }
        }
        text.label x=(Px(LEFT - 8.0)) y=(Px(phases_top + 9.0)) text-anchor="end" { "phase" }
        @for (kind, name, class) in PHASES {
            g.(class) {
                @for phase in take.phases.iter().filter(|phase| phase.kind == kind) {
                    (bars(&x, &[phase.span_s], [phases_top, PHASE_HEIGHT], name))
                }
            }
        }
    }
}

/// Bars over those parts of intervals that are on the axis.
fn bars(x: &Scale, intervals_s: &[[f64; 2]], [top, height]: [f64; 2], name: &str) -> Markup {
    let [low, high] = x.ends();
    html! {
        @for [start, end] in intervals_s.iter().filter(|[start, end]| *start < high && *end > low) {
            @let (left, right) = (x.at(start.max(low)), x.at(end.min(high)));
            rect.area x=(Px(left)) y=(Px(top)) width=(Px((right - left).max(LEAST))) height=(Px(height)) {
                title { (name) ", " (short(*start)) " to " (short(*end)) " s" }
            }
        }
    }
}

/// Description for readers who do not see it.
fn summary(take: &TakeContacts) -> String {
    let contacts = (take.contacts_s.each_ref()).map(|contacts| contacts.len().to_string());
    format!(
        "{}: contacts of thumb to little finger over {} s: {}; {} phases",
        take.take,
        plain(take.duration_s),
        contacts.as_array().join(", "),
        take.phases.len()
    )
}
