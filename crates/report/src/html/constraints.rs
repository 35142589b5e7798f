//! Whether planned motion keeps what it had to keep: reach, collisions, velocities, optimality.

use inhand_model::{Finger, MethodEvaluation, PerFinger, Reachability};
use maud::{Markup, html};

use super::Method;
use super::session::name;
use super::table::{Column, Line, numbers, table, words};
use crate::json::mean;
use crate::number::{
    NARROW_SPACE, NONE, count, decimals, millimetres, percent, plain, scientific, to_mm,
};

/// The section's content.
pub(super) fn section(methods: &[Method<'_>]) -> Markup {
    let limit = methods
        .first()
        .map(|method| method.evaluation.collision.limit_m);
    html! {
        (table(
            "Constraints, checked on the result and not taken from the solver",
            &COLUMNS,
            methods
                .iter()
                .map(|method| Line {
                    head: name(method),
                    cells: cells(method.evaluation),
                    stressed: method.default,
                })
                .collect(),
        ))
        p.note {
            "Inside: share of fingertip positions inside the convex hull of the training takes. "
            @if let Some(limit) = limit {
                "Colliding: instants at which two fingertips are nearer than " (plain(to_mm(limit))) " mm. "
            }
            "Velocity: steps between neighbouring samples, per finger and axis, outside the bounds by more than a millionth; the ratio is the \
             largest velocity over its bound, so that 1 is just allowed. KKT residual: largest violation of the optimality conditions over all \
             plans and all rows of the full problem, recomputed apart from the solver. Baselines are not planned: they show what bounds \
             they would break."
        }
        (reach_table(methods))
        (plan_table(methods))
    }
}

const COLUMNS: [Column<'static>; 9] = [
    words("method"),
    numbers("inside", "%"),
    numbers("farthest outside", "mm"),
    numbers("colliding", "instants"),
    numbers("recorded", "instants"),
    numbers("nearest pair", "mm"),
    numbers("velocity outside", "steps"),
    numbers("worst ratio", "to bound"),
    numbers("KKT residual", "worst"),
];

fn cells(method: &MethodEvaluation) -> Vec<String> {
    let (reach, collision, velocity) = (&method.reachability, &method.collision, &method.velocity);
    let judged = |n: usize, text: String| if n == 0 { NONE.to_owned() } else { text };
    let of = |part: usize, n: usize| {
        judged(
            n,
            format!(
                "{} of {}",
                count(part, NARROW_SPACE),
                count(n, NARROW_SPACE)
            ),
        )
    };
    vec![
        judged(reach.n, percent(mean(&reach.inside))),
        judged(reach.n, millimetres(farthest(&reach.worst_outside_m))),
        of(collision.instants, collision.n),
        judged(
            collision.n,
            count(collision.recorded_instants, NARROW_SPACE),
        ),
        judged(collision.n, millimetres(collision.nearest_m)),
        of(velocity.outside, velocity.n),
        judged(velocity.n, decimals(velocity.worst_ratio, 3)),
        method.plan.map_or_else(
            || NONE.to_owned(),
            |plan| scientific(plan.worst_kkt_residual),
        ),
    ]
}

/// A value that is not a number wins, so that it shows.
fn farthest(values: &PerFinger<f64>) -> f64 {
    values
        .as_array()
        .iter()
        .copied()
        .fold(0.0, |a, b| if b.is_nan() || b > a { b } else { a })
}

fn reach_table(methods: &[Method<'_>]) -> Markup {
    let mut columns = vec![words("motion"), numbers("n", "a finger")];
    for finger in Finger::ALL {
        columns.push(numbers(finger.name(), "%"));
    }
    for finger in Finger::ALL {
        columns.push(numbers(finger.name(), "mm out"));
    }
    let share = |reach: &Reachability, shares: &PerFinger<f64>| -> Vec<String> {
        shares
            .as_array()
            .map(|value| {
                if reach.n == 0 {
                    NONE.to_owned()
                } else {
                    percent(value)
                }
            })
            .into()
    };
    let mut lines: Vec<Line> = methods
        .iter()
        .map(|method| {
            let reach = &method.evaluation.reachability;
            let mut cells = vec![count(reach.n, NARROW_SPACE)];
            cells.extend(share(reach, &reach.inside));
            cells.extend(reach.worst_outside_m.as_array().map(|metres| {
                if reach.n == 0 {
                    NONE.to_owned()
                } else {
                    millimetres(metres)
                }
            }));
            Line {
                head: name(method),
                cells,
                stressed: method.default,
            }
        })
        .collect();
    if let Some(method) = methods.iter().find(|m| m.default).or(methods.first()) {
        let reach = &method.evaluation.reachability;
        let mut cells = vec![count(reach.n, NARROW_SPACE)];
        cells.extend(share(reach, &reach.recorded_inside));
        cells.extend(vec![String::new(); Finger::COUNT]);
        let head = html! { span.swatch.recorded {} "recorded" };
        lines.insert(
            0,
            Line {
                head,
                cells,
                stressed: false,
            },
        );
    }
    html! {
        (table("Inside the training hull by finger, and farthest distance outside it", &columns, lines))
    }
}

fn plan_table(methods: &[Method<'_>]) -> Markup {
    let lines: Vec<Line> = methods
        .iter()
        .filter_map(|method| {
            let plan = method.evaluation.plan?;
            let n = |n: usize| count(n, NARROW_SPACE);
            Some(Line {
                head: name(method),
                cells: vec![
                    n(plan.solved),
                    n(plan.infeasible),
                    n(plan.failed),
                    n(plan.velocity_bound_active),
                    n(method.evaluation.velocity.trajectories_outside),
                    n(method.evaluation.collision.trajectories),
                    scientific(plan.worst_kkt_residual),
                ],
                stressed: method.default,
            })
        })
        .collect();
    html! {
        @if lines.is_empty() {
            p { "No method solved an optimisation." }
        } @else {
            (table(
                "Plans",
                &[
                    words("method"),
                    numbers("solved", ""),
                    numbers("infeasible", ""),
                    numbers("failed", ""),
                    numbers("velocity bound active", "plans"),
                    numbers("velocity outside", "plans"),
                    numbers("with a collision", "plans"),
                    numbers("KKT residual", "worst"),
                ],
                lines,
            ))
            p.note { "Infeasible: shown to have no solution. Failed: the solver ended with neither a solution nor such a proof. Neither has a trajectory, so neither is in the statistics above." }
        }
    }
}
