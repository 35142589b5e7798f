//! Whether planned motion keeps what it had to keep: reach, collisions, velocities, optimality.

use inhand_model::{Finger, MethodEvaluation, PerFinger, Reachability, Statistics};
use maud::{Markup, html};

use super::session::name;
use super::statistics::finger_table;
use super::table::{Column, Line, numbers, table, words};
use super::{Body, Method, plan_status, plans};
use crate::number::{
    NARROW_SPACE, NONE, count, decimals, millimetres, percent, plain, scientific, to_mm,
};

/// The section's content.
pub(super) fn section(methods: &[Method<'_>]) -> Body {
    let mut body = Body::from(html! {
        (overview(methods))
        (reach_table(methods))
        (collision_table(methods))
    });
    body.figure(plan_status::figure(methods))
        .prose(plans::tables(methods));
    body
}

const OVERVIEW: [Column<'static>; 9] = [
    words("method"),
    numbers("inside the hull", "%"),
    numbers("farthest outside", "mm"),
    numbers("colliding", "instants"),
    numbers("nearest pair", "mm"),
    numbers("velocity outside", "steps"),
    numbers("worst ratio", "to bound"),
    numbers("infeasible", "plans"),
    numbers("KKT residual", "worst"),
];

fn overview(methods: &[Method<'_>]) -> Markup {
    let limit = methods
        .first()
        .map(|method| method.evaluation.collision.limit_m);
    let lines = methods
        .iter()
        .map(|method| Line {
            head: name(method),
            cells: overview_cells(method.evaluation),
            best: Vec::new(),
            stressed: method.default,
        })
        .collect();
    html! {
        (table("Constraints, checked on the result and not taken from the solver", &OVERVIEW, lines))
        p.note {
            "Inside: share of fingertip positions inside the convex hull of the training takes. "
            @if let Some(limit) = limit {
                "Colliding: instants at which two fingertips are nearer than " (plain(to_mm(limit))) " mm. "
            }
            "Velocity: steps between neighbouring samples, per finger and axis, outside the bounds by more than a millionth; the ratio is the \
             largest velocity over its bound, so that 1 is just allowed. KKT residual: largest violation of the optimality conditions over all \
             plans and all rows of the full problem, recomputed apart from the solver. Baselines solve no optimisation and know no bounds: \
             their lines show which constraints a smooth curve breaks on its own."
        }
    }
}

fn overview_cells(method: &MethodEvaluation) -> Vec<String> {
    let (reach, collision, velocity) = (&method.reachability, &method.collision, &method.velocity);
    vec![
        judged(reach.n, percent(reach.inside.mean())),
        judged(reach.n, millimetres(farthest(&reach.worst_outside_m))),
        judged(collision.n, part_of(collision.instants, collision.n)),
        judged(collision.n, millimetres(collision.nearest_m)),
        judged(velocity.n, part_of(velocity.outside, velocity.n)),
        judged(velocity.n, decimals(velocity.worst_ratio, 3)),
        method.plan.as_ref().map_or_else(
            || NONE.to_owned(),
            |plan| part_of(plan.infeasible, plan.solved + plan.infeasible + plan.failed),
        ),
        method.plan.as_ref().map_or_else(
            || NONE.to_owned(),
            |plan| scientific(plan.worst_kkt_residual),
        ),
    ]
}

fn judged(n: usize, text: String) -> String {
    if n == 0 { NONE.to_owned() } else { text }
}

pub(super) fn part_of(part: usize, n: usize) -> String {
    format!(
        "{} of {}",
        count(part, NARROW_SPACE),
        count(n, NARROW_SPACE)
    )
}

/// A value that is not a number wins, so that it shows.
fn farthest(values: &PerFinger<f64>) -> f64 {
    values
        .as_array()
        .iter()
        .copied()
        .fold(0.0, |a, b| if b.is_nan() || b > a { b } else { a })
}

fn recorded() -> Markup {
    html! { span.swatch.recorded {} "recorded" }
}

/// The method whose recorded instants stand for the recorded motion.
fn reference<'a, 'b>(methods: &'a [Method<'b>]) -> Option<&'a Method<'b>> {
    methods
        .iter()
        .find(|method| method.default)
        .or(methods.first())
}

fn reach_table(methods: &[Method<'_>]) -> Markup {
    let mut columns = vec![words("motion"), numbers("n", "a finger")];
    columns.extend(Finger::ALL.map(|finger| numbers(finger.name(), "%")));
    columns.extend(Finger::ALL.map(|finger| numbers(finger.name(), "mm out")));
    let shares = |reach: &Reachability, shares: &PerFinger<f64>| -> Vec<String> {
        std::iter::once(count(reach.n, NARROW_SPACE))
            .chain(
                shares
                    .as_array()
                    .map(|share| judged(reach.n, percent(share))),
            )
            .collect()
    };
    let mut lines = Vec::new();
    if let Some(method) = reference(methods) {
        let reach = &method.evaluation.reachability;
        let mut cells = shares(reach, &reach.recorded_inside);
        cells.extend(std::iter::repeat_n(String::new(), Finger::COUNT));
        lines.push(Line {
            head: recorded(),
            cells,
            best: Vec::new(),
            stressed: false,
        });
    }
    for method in methods {
        let reach = &method.evaluation.reachability;
        let mut cells = shares(reach, &reach.inside);
        let outside = reach.worst_outside_m.as_array();
        cells.extend(outside.map(|metres| judged(reach.n, millimetres(metres))));
        lines.push(Line {
            head: name(method),
            cells,
            best: Vec::new(),
            stressed: method.default,
        });
    }
    let distances: Vec<&[Statistics; Finger::COUNT]> = methods
        .iter()
        .map(|method| method.evaluation.reachability.distance.as_array())
        .collect();
    html! {
        (table(
            "Reachability: share of instants inside the training hull (%), and farthest distance outside it (mm), by finger",
            &columns,
            lines,
        ))
        details {
            summary { "Signed distance to the surface of the hull" }
            (finger_table("Signed distance to the hull, negative inside", methods, &distances, false))
        }
    }
}

fn collision_table(methods: &[Method<'_>]) -> Markup {
    let columns = [
        words("motion"),
        numbers("n", "instants"),
        numbers("colliding", "instants"),
        numbers("with a collision", "trajectories"),
        numbers("nearest pair", "mm"),
        words("which pair"),
    ];
    let mut lines = Vec::new();
    if let Some(method) = reference(methods) {
        let collision = &method.evaluation.collision;
        lines.push(Line {
            head: recorded(),
            cells: vec![
                count(collision.n, NARROW_SPACE),
                judged(
                    collision.n,
                    count(collision.recorded_instants, NARROW_SPACE),
                ),
                String::new(),
                judged(collision.n, millimetres(collision.recorded_nearest_m)),
                String::new(),
            ],
            best: Vec::new(),
            stressed: false,
        });
    }
    lines.extend(methods.iter().map(|method| {
        let collision = &method.evaluation.collision;
        Line {
            head: name(method),
            cells: vec![
                count(collision.n, NARROW_SPACE),
                judged(collision.n, count(collision.instants, NARROW_SPACE)),
                judged(collision.n, count(collision.trajectories, NARROW_SPACE)),
                judged(collision.n, millimetres(collision.nearest_m)),
                collision
                    .nearest_pair
                    .map_or_else(|| NONE.to_owned(), |(a, b)| format!("{a}, {b}")),
            ],
            best: Vec::new(),
            stressed: method.default,
        }
    }));
    table("Collisions of fingertips", &columns, lines)
}
