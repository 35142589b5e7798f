//! Whether planned motion satisfies its constraints: reach, collisions, velocities, optimality.

use inhand_model::{Collision, PerFinger, PlanFacts};
use maud::{Markup, html};

use super::errors::finger_table;
use super::{Body, Method, default, method_table, plans, recorded};
use crate::table::{Head, Table, known};
use crate::words::{
    NONE, count, decimals, millimetres, part_of, percent, plain, scientific, to_mm,
};

/// The section's content.
pub(super) fn section(methods: &[Method<'_>]) -> Body {
    let distances: Vec<_> = (methods.iter())
        .map(|method| (method, &method.evaluation.reachability.distance))
        .collect();
    let caption = "Signed distance to the hull, negative inside";
    Body::from(overview(methods))
        .prose(reach_table(methods))
        .folded(
            "Signed distance to the surface of the hull",
            Body::default().prose(finger_table(caption, &distances)),
        )
        .prose(collision_table(methods))
        .append(plans::section(methods))
}

fn overview(methods: &[Method<'_>]) -> Markup {
    let limit = methods
        .first()
        .map(|method| method.evaluation.collision.limit_m);
    let plan = |m: &&Method<'_>, text: fn(&PlanFacts) -> String| {
        known(m.evaluation.plan.as_ref().map(text))
    };
    let caption = "Constraints, checked on the result and not taken from the solver";
    let table = method_table(caption, methods, |method| method)
        .numbers("inside the hull", "%", |m| {
            let reach = &m.evaluation.reachability;
            evaluated(reach.n, percent(reach.inside.mean()))
        })
        .numbers("farthest outside", "mm", |m| {
            let reach = &m.evaluation.reachability;
            evaluated(reach.n, millimetres(farthest(&reach.worst_outside_m)))
        })
        .numbers("colliding", "instants", |m| {
            let collision = &m.evaluation.collision;
            evaluated(collision.n, part_of(collision.instants, collision.n))
        })
        .numbers("nearest pair", "mm", |m| {
            let collision = &m.evaluation.collision;
            evaluated(collision.n, millimetres(collision.nearest_m))
        })
        .numbers("velocity outside", "steps", |m| {
            let velocity = &m.evaluation.velocity;
            evaluated(velocity.n, part_of(velocity.outside, velocity.n))
        })
        .numbers("worst ratio", "to bound", |m| {
            let velocity = &m.evaluation.velocity;
            evaluated(velocity.n, decimals(velocity.worst_ratio, 3))
        })
        .numbers("infeasible", "plans", move |m| {
            plan(m, |plan| {
                part_of(plan.infeasible, plan.solved + plan.infeasible + plan.failed)
            })
        })
        .numbers("KKT residual", "worst", move |m| {
            plan(m, |plan| scientific(plan.worst_kkt_residual))
        });
    html! {
        (table)
        p.note {
            "Inside: share of fingertip positions inside the convex hull of the training takes. "
            @if let Some(limit) = limit {
                "Colliding: instants at which two fingertips are nearer than " (plain(to_mm(limit))) " mm. "
            }
            "Velocity: steps between neighbouring samples, per finger and axis, outside the bounds by more than a millionth; the ratio is the \
             largest velocity over its bound, so that 1 is just allowed. KKT residual: largest violation of the optimality conditions over all \
             plans and all rows of the full problem, recomputed independently of the solver. Baselines solve no optimisation and have no bounds: \
             their lines show which constraints a smooth curve breaks on its own."
        }
    }
}

/// A dash where nothing was evaluated.
fn evaluated(n: usize, text: String) -> String {
    if n == 0 { NONE.to_owned() } else { text }
}

/// A value that is not a number wins, so that it shows.
fn farthest(values: &PerFinger<f64>) -> f64 {
    let values = values.as_array().iter().copied();
    values.fold(0.0, |a, b| if b.is_nan() || b > a { b } else { a })
}

/// A motion of a table: a method, or the recorded motion at the instants of the default method.
type Motion<'m, 'a> = (&'m Method<'a>, bool);

fn motion_table<'m>(caption: &str, methods: &'m [Method<'m>]) -> Table<'m, Motion<'m, 'm>> {
    let reference = default(methods)
        .or(methods.first())
        .map(|method| (method, true));
    let motions = reference
        .into_iter()
        .chain(methods.iter().map(|method| (method, false)));
    let head = |(method, is_recorded): &Motion<'_, '_>| -> Head {
        if *is_recorded {
            recorded()
        } else {
            method.head()
        }
    };
    Table::new(caption, motions, "motion", head)
        .stressed(|(method, is_recorded)| method.default && !is_recorded)
}

fn reach_table<'m>(methods: &'m [Method<'m>]) -> Table<'m, Motion<'m, 'm>> {
    let caption = "Reachability: share of instants inside the training hull (%), and farthest distance outside it (mm), by finger";
    motion_table(caption, methods)
        .counts("n", "a finger", |(method, _)| {
            method.evaluation.reachability.n
        })
        .fingers("%", |(method, is_recorded), finger| {
            let reach = &method.evaluation.reachability;
            let shares = if *is_recorded {
                &reach.recorded_inside
            } else {
                &reach.inside
            };
            evaluated(reach.n, percent(shares[finger]))
        })
        .fingers("mm out", |(method, is_recorded), finger| {
            let reach = &method.evaluation.reachability;
            let outside = evaluated(reach.n, millimetres(reach.worst_outside_m[finger]));
            if *is_recorded { String::new() } else { outside }
        })
}

fn collision_table<'m>(methods: &'m [Method<'m>]) -> Table<'m, Motion<'m, 'm>> {
    // What is not known of the recorded motion is left blank.
    let planned = |(method, is_recorded): &Motion<'_, '_>, text: fn(&Collision) -> String| {
        if *is_recorded {
            String::new()
        } else {
            text(&method.evaluation.collision)
        }
    };
    motion_table("Collisions of fingertips", methods)
        .counts("n", "instants", |(method, _)| method.evaluation.collision.n)
        .numbers("colliding", "instants", |(method, is_recorded)| {
            let collision = &method.evaluation.collision;
            let instants = match is_recorded {
                true => collision.recorded_instants,
                false => collision.instants,
            };
            evaluated(collision.n, count(instants))
        })
        .numbers("with a collision", "trajectories", move |row| {
            planned(row, |collision| {
                evaluated(collision.n, count(collision.trajectories))
            })
        })
        .numbers("nearest pair", "mm", |(method, is_recorded)| {
            let collision = &method.evaluation.collision;
            let nearest_m = match is_recorded {
                true => collision.recorded_nearest_m,
                false => collision.nearest_m,
            };
            evaluated(collision.n, millimetres(nearest_m))
        })
        .words("which pair", move |row| {
            planned(row, |collision| {
                known(collision.nearest_pair.map(|(a, b)| format!("{a}, {b}")))
            })
        })
}
