//! States of contact as a graph: a circle for each set of fingers, an arrow for each change.

use std::f64::consts::{FRAC_PI_2, TAU};

use inhand_model::{Finger, FingerSet};
use maud::{Markup, html};

use super::palette::{PLAIN_CLASS, finger_class};
use super::{Panel, Px};
use crate::number::percent;
use crate::words::shortened;

/// A state.
pub(crate) struct Node {
    /// The fingers that hold.
    pub(crate) fingers: FingerSet,
    /// Share of the time, 0 to 1.
    pub(crate) share: f64,
}

/// A change from one state to another, by their places among the nodes.
pub(crate) struct Edge {
    pub(crate) from: usize,
    pub(crate) to: usize,
    pub(crate) count: usize,
}

/// States and changes of a take.
pub(crate) struct StateGraph<'a> {
    /// The take, above the figure.
    pub(crate) take: &'a str,
    /// States, the most frequent one first.
    pub(crate) nodes: Vec<Node>,
    /// Changes between them.
    pub(crate) edges: Vec<Edge>,
}

const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 420.0;
const CENTRE: [f64; 2] = [0.5 * WIDTH, 226.0];
const RADIUS: f64 = 148.0;
/// Radius of a state that is never left, and least radius.
const LARGEST: f64 = 42.0;
const SMALLEST: f64 = 20.0;
/// How far an arrow bends aside, as a share of its length, so that the way back is another line.
const BEND: f64 = 0.14;
const HEAD: f64 = 8.0;
const DOT_STEP: f64 = 6.4;
/// Radius from which the share stands inside.
const ROOMY: f64 = 30.0;
/// Sine of the angle from which a label stands beside its circle rather than above or below it.
const ASIDE: f64 = 0.3;

/// Draws the figure.
pub(crate) fn draw(graph: &StateGraph<'_>) -> Panel {
    let count = graph.nodes.len().max(1) as f64;
    let places: Vec<[f64; 2]> = (0..graph.nodes.len())
        .map(|place| {
            if graph.nodes.len() == 1 {
                return CENTRE;
            }
            let angle = TAU * place as f64 / count - FRAC_PI_2;
            [
                CENTRE[0] + RADIUS * angle.cos(),
                CENTRE[1] + RADIUS * angle.sin(),
            ]
        })
        .collect();
    let most = graph.edges.iter().map(|edge| edge.count).max().unwrap_or(1);
    let shapes = html! {
        text.title x="0" y="12.5" { (shortened(graph.take, 60)) }
        @for edge in &graph.edges { (arrow(graph, edge, &places, most)) }
        @for (node, place) in graph.nodes.iter().zip(&places) { (circle(node, *place)) }
    };
    Panel {
        width: WIDTH,
        height: HEIGHT,
        summary: summary(graph),
        shapes,
    }
}

/// Areas are as the times.
fn radius(node: &Node) -> f64 {
    (LARGEST * node.share.max(0.0).sqrt()).max(SMALLEST)
}

fn circle(node: &Node, [x, y]: [f64; 2]) -> Markup {
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
fn share(node: &Node, [x, y]: [f64; 2]) -> Markup {
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

/// A bent line from one circle's edge to the other's, thicker the more often it was taken.
fn arrow(graph: &StateGraph<'_>, edge: &Edge, places: &[[f64; 2]], most: usize) -> Markup {
    let (from, to) = (&graph.nodes[edge.from], &graph.nodes[edge.to]);
    let ([x0, y0], [x1, y1]) = (places[edge.from], places[edge.to]);
    let bent = [
        0.5 * (x0 + x1) - BEND * (y1 - y0),
        0.5 * (y0 + y1) + BEND * (x1 - x0),
    ];
    let start = towards([x0, y0], bent, radius(from) + 1.0);
    let tip = towards([x1, y1], bent, radius(to) + 2.0);
    let end = towards(tip, bent, HEAD);
    let [ux, uy] = [(tip[0] - end[0]) / HEAD, (tip[1] - end[1]) / HEAD];
    let side = 0.45 * HEAD;
    let head = format!(
        "M{} {}L{} {}L{} {}z",
        Px(tip[0]),
        Px(tip[1]),
        Px(end[0] - side * uy),
        Px(end[1] + side * ux),
        Px(end[0] + side * uy),
        Px(end[1] - side * ux)
    );
    let way = format!(
        "M{} {}Q{} {} {} {}",
        Px(start[0]),
        Px(start[1]),
        Px(bent[0]),
        Px(bent[1]),
        Px(end[0]),
        Px(end[1])
    );
    let width = 0.8 + 3.2 * (edge.count as f64 / most.max(1) as f64).sqrt();
    html! {
        g.faded {
            title { (from.fingers) " to " (to.fingers) ": " (edge.count) }
            path.edge d=(way) stroke-width=(Px(width)) {}
            path.area d=(head) {}
        }
    }
}

/// The point so far from one towards another.
fn towards([x, y]: [f64; 2], [tx, ty]: [f64; 2], far: f64) -> [f64; 2] {
    let length = (tx - x).hypot(ty - y).max(f64::MIN_POSITIVE);
    [x + (tx - x) * far / length, y + (ty - y) * far / length]
}

/// What the figure says, for those who do not see it.
fn summary(graph: &StateGraph<'_>) -> String {
    let states: Vec<String> = (graph.nodes.iter())
        .map(|node| format!("{} {} %", node.fingers, percent(node.share)))
        .collect();
    let changes: usize = graph.edges.iter().map(|edge| edge.count).sum();
    format!(
        "{}: {}; {changes} changes between them",
        graph.take,
        states.join(", ")
    )
}
