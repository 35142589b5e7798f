//! States of contact as a graph: a circle for each set of fingers, an arrow for each change.

use std::f64::consts::{FRAC_PI_2, TAU};

use inhand_model::{Finger, StateFacts, TakeContacts, Transition};
use maud::{Markup, html};

use super::{PLAIN_CLASS, Panel, Px, finger_class};
use crate::words::percent;

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 400.0;
const CENTRE: [f64; 2] = [0.5 * WIDTH, 206.0];
const RADIUS: f64 = 148.0;
/// Radius of a state that is never left, and least radius.
const LARGEST: f64 = 42.0;
const SMALLEST: f64 = 20.0;
/// Bend of an arrow, as a share of its length, so that the way back is another line.
const BEND: f64 = 0.14;
const HEAD: f64 = 8.0;
const DOT_STEP: f64 = 6.4;
/// Radius from which the share is inside.
const ROOMY: f64 = 30.0;
/// Sine of the angle from which a label is beside its circle rather than above or below it.
const ASIDE: f64 = 0.3;

/// States that are drawn: the most frequent ones.
pub(crate) const STATES: usize = 10;

/// A state at its place.
type Placed<'a> = (&'a StateFacts, [f64; 2]);

/// Draws the figure.
pub(crate) fn draw(take: &TakeContacts) -> Panel {
    let states = &take.states[..take.states.len().min(STATES)];
    let place = |place: usize| {
        if states.len() == 1 {
            return CENTRE;
        }
        let angle = TAU * place as f64 / states.len() as f64 - FRAC_PI_2;
        let (sine, cosine) = angle.sin_cos();
        [CENTRE[0] + RADIUS * cosine, CENTRE[1] + RADIUS * sine]
    };
    let placed: Vec<Placed<'_>> = (states.iter().enumerate())
        .map(|(k, state)| (state, place(k)))
        .collect();
    let at = |fingers| placed.iter().find(|(state, _)| state.fingers == fingers);
    let changes: Vec<(&Transition, &Placed<'_>, &Placed<'_>)> = (take.transitions.iter())
        .filter_map(|change| Some((change, at(change.from)?, at(change.to)?)))
        .collect();
    let most = changes.iter().map(|(change, ..)| change.count).max();
    let shapes = html! {
        @for (change, from, to) in &changes { (arrow(change.count, from, to, most.unwrap_or(1))) }
        @for (state, place) in &placed { (circle(state, *place)) }
    };
    let said: Vec<String> = (states.iter())
        .map(|state| format!("{} {} %", state.fingers, percent(state.share)))
        .collect();
    let total: usize = changes.iter().map(|(change, ..)| change.count).sum();
    Panel {
        title: take.take.as_str().into(),
        width: WIDTH,
        height: HEIGHT,
        summary: format!(
            "{}: {}; {total} changes between them",
            take.take,
            said.join(", ")
        ),
        shapes,
    }
}

/// Areas are as the times.
fn radius(node: &StateFacts) -> f64 {
    (LARGEST * node.share.max(0.0).sqrt()).max(SMALLEST)
}

fn circle(node: &StateFacts, [x, y]: [f64; 2]) -> Markup {
    let dot = |finger: Finger| x + DOT_STEP * (finger.index() as f64 - 2.0);
    html! {
        g.(PLAIN_CLASS) {
            title { (node.fingers) ": " (percent(node.share)) " % of the time" }
            circle.paper cx=(Px(x)) cy=(Px(y)) r=(Px(radius(node))) {}
            circle.node cx=(Px(x)) cy=(Px(y)) r=(Px(radius(node))) {}
            @for finger in Finger::ALL {
                g.(finger_class(finger)) {
                    @if node.fingers.contains(finger) {
                        circle.point cx=(Px(dot(finger))) cy=(Px(y)) r="2.9" {}
                    } @else {
                        circle.dot cx=(Px(dot(finger))) cy=(Px(y)) r="1.3" {}
                    }
                }
            }
        }
        (share(node, [x, y]))
    }
}

/// The share: inside a large circle, else beside it on the side that no arrow comes from.
fn share(node: &StateFacts, [x, y]: [f64; 2]) -> Markup {
    let own = radius(node);
    let out = [x - CENTRE[0], y - CENTRE[1]];
    let length = out[0].hypot(out[1]);
    let (at, anchor) = if own >= ROOMY || length == 0.0 {
        ([x, y + 20.0], "middle")
    } else {
        let [ux, uy] = out.map(|part| part / length);
        let anchor = if ux > ASIDE {
            "start"
        } else if ux < -ASIDE {
            "end"
        } else {
            "middle"
        };
        ([x + ux * (own + 5.0), y + uy * (own + 12.0) + 4.0], anchor)
    };
    html! {
        text.tick x=(Px(at[0])) y=(Px(at[1])) text-anchor=(anchor) { (percent(node.share)) " %" }
    }
}

/// A bent line from one circle's edge to the other's, thicker the more frequent.
fn arrow(
    count: usize,
    (from, [x0, y0]): &Placed<'_>,
    (to, [x1, y1]): &Placed<'_>,
    most: usize,
) -> Markup {
    let bent = [
        0.5 * (x0 + x1) - BEND * (y1 - y0),
        0.5 * (y0 + y1) + BEND * (x1 - x0),
    ];
    let start = towards([*x0, *y0], bent, radius(from) + 1.0);
    let tip = towards([*x1, *y1], bent, radius(to) + 2.0);
    let end = towards(tip, bent, HEAD);
    let [ux, uy] = [(tip[0] - end[0]) / HEAD, (tip[1] - end[1]) / HEAD];
    let side = 0.45 * HEAD;
    let head = format!(
        "M{}L{}L{}z",
        point(tip),
        point([end[0] - side * uy, end[1] + side * ux]),
        point([end[0] + side * uy, end[1] - side * ux])
    );
    let way = format!("M{}Q{} {}", point(start), point(bent), point(end));
    let width = 0.8 + 3.2 * (count as f64 / most.max(1) as f64).sqrt();
    html! {
        g.faded {
            title { (from.fingers) " to " (to.fingers) ": " (count) }
            path.edge d=(way) stroke-width=(Px(width)) {}
            path.area d=(head) {}
        }
    }
}

/// Coordinates in a path.
fn point(at: [f64; 2]) -> String {
    let [x, y] = at.map(Px);
    format!("{x} {y}")
}

/// The point so far from one towards another.
fn towards([x, y]: [f64; 2], [tx, ty]: [f64; 2], far: f64) -> [f64; 2] {
    let length = (tx - x).hypot(ty - y).max(f64::MIN_POSITIVE);
    [x + (tx - x) * far / length, y + (ty - y) * far / length]
}
