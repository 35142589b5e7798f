//! Constraints that planned motion satisfies or violates: reach, collisions, velocities, optimality; how plans ended, and how long they took.

use inhand_model::{Collision, ConstraintFamily, FamilyFacts, PerFinger, PlanFacts};
use maud::{Markup, html};

use super::errors::finger_table;
use super::{Body, Method, default, known_of, method_table, named, recorded};
use crate::figure::row_plot::{self, Mark, MarkShape, PlotRow, RowPlot};
use crate::figure::scale::Scale;
use crate::figure::{Figure, FigureData, PLAIN_CLASS};
use crate::table::{Table, evaluated, known};
use crate::words::{
    NONE, count, count_range, decimals, millimetres, part_of, percent, plain, scientific, to_mm,
};
use crate::{PlanTimes, Report};

/// The section's content: constraints at a glance, and how plans ended where not all were solved.
pub(super) fn section(report: &Report<'_>, methods: &[Method<'_>]) -> Body {
    let distances: Vec<_> = (methods.iter())
        .map(|method| (method, &method.evaluation.reachability.distance))
        .collect();
    let caption = "Signed distance to the hull, negative inside";
    let reach = Body::default()
        .prose(reach_table(methods))
        .prose(finger_table(caption, &distances));
    let planned = known_of(methods, |own| own.plan.as_ref());
    let unsolved = planned
        .iter()
        .any(|(_, plan)| plan.infeasible + plan.failed > 0);
    let plans = plans(&planned);
    let (shown, folded) = match unsolved {
        true => (plans, Body::default()),
        false => (Body::default(), plans),
    };
    let times = times(report.plan_times, methods);
    Body::default()
        .append(shown)
        .prose(overview(methods))
        .folded(
            "Definitions of the columns",
            Body::from(overview_note(methods)),
        )
        .folded("Reach of each finger", reach)
        .folded(
            "Collisions",
            Body::default().prose(collision_table(methods)),
        )
        .folded("Plans and their certificates", folded)
        .folded("Times of single plans", times)
}

fn overview<'m>(methods: &'m [Method<'m>]) -> Table<&'m Method<'m>> {
    let plan = |m: &&Method<'_>, text: fn(&PlanFacts) -> String| {
        known(m.evaluation.plan.as_ref().map(text))
    };
    let caption = "Constraints, checked on the result and not taken from the solver";
    method_table(caption, methods, |method| method)
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
        .numbers("infeasible", "plans", |m| {
            plan(m, |plan| {
                part_of(plan.infeasible, plan.solved + plan.infeasible + plan.failed)
            })
        })
        .numbers("KKT residual", "worst", |m| {
            plan(m, |plan| scientific(plan.worst_kkt_residual))
        })
}

fn overview_note(methods: &[Method<'_>]) -> Markup {
    let mut limits = methods.iter().map(|m| m.evaluation.collision.limit_m);
    html! {
        p.note {
            "Inside: share of fingertip positions inside the convex hull of the training takes. "
            @if let Some(limit) = limits.next() {
                "Colliding: instants at which two fingertips are nearer than " (plain(to_mm(limit))) " mm. "
            }
            "Velocity: steps between neighbouring samples, per finger and axis, outside the bounds by more than a millionth; the ratio is the \
             largest velocity over its bound, so that 1 is just allowed. KKT residual: largest violation of the optimality conditions over all \
             plans and all rows of the full problem, recomputed independently of the solver. Baselines solve no optimisation and have no bounds: \
             their lines show which constraints a smooth curve breaks on its own."
        }
    }
}

/// A value that is not a number wins, so that it shows.
fn farthest(values: &PerFinger<f64>) -> f64 {
    let values = values.as_array().iter().copied();
    values.fold(0.0, |a, b| if b.is_nan() || b > a { b } else { a })
}

/// A motion of a table: a method, or the recorded motion at the instants of the default method.
type Motion<'m, 'a> = (&'m Method<'a>, bool);

fn motion_table<'m>(caption: &str, methods: &'m [Method<'m>]) -> Table<Motion<'m, 'm>> {
    let reference = default(methods)
        .or(methods.first())
        .map(|method| (method, true));
    let motions = reference
        .into_iter()
        .chain(methods.iter().map(|method| (method, false)));
    let head = |(method, is_recorded): &Motion<'_, '_>| match is_recorded {
        true => recorded(),
        false => method.head(),
    };
    Table::new(caption, motions, "motion", head)
        .stressed(|(method, is_recorded)| method.default && !is_recorded)
}

fn reach_table<'m>(methods: &'m [Method<'m>]) -> Table<Motion<'m, 'm>> {
    let caption = "Reachability: share of instants inside the training hull (%), and farthest distance outside it (mm), by finger";
    motion_table(caption, methods)
        .fingers("%", |(method, is_recorded), finger| {
            let reach = &method.evaluation.reachability;
            let shares = match is_recorded {
                true => &reach.recorded_inside,
                false => &reach.inside,
            };
            evaluated(reach.n, percent(shares[finger]))
        })
        .fingers("mm out", |(method, is_recorded), finger| {
            let reach = &method.evaluation.reachability;
            let outside = evaluated(reach.n, millimetres(reach.worst_outside_m[finger]));
            if *is_recorded { String::new() } else { outside }
        })
        .counts("n", "a finger", |(method, _)| {
            method.evaluation.reachability.n
        })
}

fn collision_table<'m>(methods: &'m [Method<'m>]) -> Table<Motion<'m, 'm>> {
    // What is not known of the recorded motion is left blank.
    let planned = |(method, is_recorded): &Motion<'_, '_>, text: fn(&Collision) -> String| {
        match is_recorded {
            true => String::new(),
            false => text(&method.evaluation.collision),
        }
    };
    motion_table("Collisions of fingertips", methods)
        .numbers("colliding", "instants", |(method, is_recorded)| {
            let collision = &method.evaluation.collision;
            let instants = match is_recorded {
                true => collision.recorded_instants,
                false => collision.instants,
            };
            evaluated(collision.n, count(instants))
        })
        .numbers("with a collision", "trajectories", |row| {
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
        .words("which pair", |row| {
            planned(row, |collision| {
                known(collision.nearest_pair.map(|(a, b)| format!("{a}, {b}")))
            })
        })
        .counts("n", "instants", |(method, _)| method.evaluation.collision.n)
}

/// A method with what is known of its plans.
type Planned<'m, 'a> = (&'m Method<'a>, &'a PlanFacts);

/// Certificates by method, then families of constraints by method.
fn plans(planned: &[Planned<'_, '_>]) -> Body {
    if planned.is_empty() {
        return html! { p { "No method solved an optimisation." } }.into();
    }
    certificates(planned).append(families(planned))
}

fn certificates(planned: &[Planned<'_, '_>]) -> Body {
    let with_hull = planned.iter().any(|(_, plan)| plan.outside_hull.is_some());
    let planned = planned.iter();
    let mut table = method_table("Plans and their certificates", planned, |row| row.0)
        .counts("solved", "plans", |(_, plan)| plan.solved)
        .counts("infeasible", "plans", |(_, plan)| plan.infeasible)
        .counts("failed", "plans", |(_, plan)| plan.failed)
        .counts("velocity bound active", "plans", |(_, plan)| {
            plan.velocity_bound_active
        })
        .counts("velocity outside", "plans", |(method, _)| {
            method.evaluation.velocity.trajectories_outside
        })
        .numbers("KKT residual", "worst", |(_, plan)| {
            scientific(plan.worst_kkt_residual)
        });
    if with_hull {
        table = table.numbers("outside the hull", "plans", |(_, plan)| {
            let outside = plan.outside_hull.filter(|_| plan.solved > 0);
            known(outside.map(|outside| part_of(outside, plan.solved)))
        });
    }
    Body::default().prose(table).prose(html! {
        p.note {
            "Infeasible: shown to have no solution. Failed: the solver ended with neither a solution nor such a proof. Neither has a \
             trajectory, so neither is in the statistics above."
            @if with_hull {
                " Outside the hull: solved plans with a fingertip outside its training hull at some instant. That is a finding and no error \
                 unless reachability was asked for: recorded motion leaves the hull of the training takes as well, and a plan starts and \
                 ends at its targets."
            }
        }
    })
}

fn families(planned: &[Planned<'_, '_>]) -> Option<Body> {
    // Where every plan has a solution nothing has to be relaxed.
    let any_infeasible = planned.iter().any(|(_, plan)| plan.infeasible > 0);
    let groups = planned.iter().map(|(method, plan)| {
        let rows = plan.families.iter().map(|facts| (*plan, facts));
        (method.head(), rows.collect())
    });
    let caption = "Activity of each family of constraints, by method";
    let mut table = Table::grouped(caption, groups, "constraint", |(_, facts)| {
        family_words(facts.family)
    })
    .numbers("active", "plans", |(plan, facts)| {
        part_of(facts.active, plan.solved)
    })
    .words("worst violation", |(plan, facts)| {
        violation_words(facts, plan.solved)
    });
    if table.is_empty() {
        return None;
    }
    if any_infeasible {
        table = table
            .numbers(
                "would mend",
                "infeasible plans",
                |(plan, facts)| match plan.infeasible {
                    0 => NONE.to_owned(),
                    infeasible => part_of(facts.would_mend, infeasible),
                },
            )
            .numbers(
                "largest relaxation",
                "needed for that",
                |(_, facts)| match facts.would_mend {
                    0 => NONE.to_owned(),
                    _ => amount(facts.largest_relaxation, facts.family),
                },
            );
    }
    Some(Body::default().prose(table).prose(html! {
        p.note {
            "Families that were off are not listed. Active: solved plans with at least one active bound. Worst violation: over \
             all bounds of all solved plans, recomputed from the motion; one far below what cameras resolve is the solver's rounding. "
            @if any_infeasible {
                "Would mend: infeasible plans that would have a solution if this family alone were relaxed, all its bounds moving outwards by at \
                 most the largest relaxation."
            } @else {
                "No plan was infeasible, so no constraint had to be relaxed."
            }
        }
    }))
}

fn violation_words(facts: &FamilyFacts, solved: usize) -> String {
    let violation = facts.worst_violation;
    if solved == 0 || !violation.is_finite() {
        NONE.to_owned()
    } else if violation < 0.0 {
        format!("satisfied (margin {})", amount(-violation, facts.family))
    } else if violation == 0.0 {
        "satisfied exactly".to_owned()
    } else {
        amount(violation, facts.family)
    }
}

/// A number in the family's unit, with the metre turned into millimetres as everywhere in reports.
/// Small ones keep their order of magnitude, which distinguishes rounding from a bound that was broken.
fn amount(value: f64, family: ConstraintFamily) -> String {
    let value = to_mm(value);
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let digits = match value < 0.01 {
        true => scientific(value),
        false => decimals(value, 2),
    };
    format!("{digits} m{}", family.unit())
}

const fn family_words(family: ConstraintFamily) -> &'static str {
    match family {
        ConstraintFamily::Targets => "target positions met",
        ConstraintFamily::TargetVelocities => "target velocities met",
        ConstraintFamily::Activations => "activations not negative",
        ConstraintFamily::Velocity => "velocity",
        ConstraintFamily::Acceleration => "acceleration",
        ConstraintFamily::Reachability => "inside the training hull",
        ConstraintFamily::Separation => "distance between fingertips",
        ConstraintFamily::Holding => "contact points held",
    }
}

/// Times of single plans; `None` where none is known.
fn times(times: &[PlanTimes], methods: &[Method<'_>]) -> Option<Body> {
    let positive = |ms: f64| ms > 0.0 && ms.is_finite();
    let times: Vec<&PlanTimes> = (times.iter())
        .filter(|t| t.n > 0 && [t.p50_ms, t.p95_ms, t.max_ms].into_iter().all(positive))
        .collect();
    let low = times.iter().map(|t| t.p50_ms).fold(f64::INFINITY, f64::min);
    let high = times.iter().map(|t| t.max_ms).fold(0.0, f64::max);
    if times.is_empty() {
        return None;
    }
    let rows = times.iter().map(|own| {
        let method = named(methods, &own.method);
        let [p50, p95, max] = [own.p50_ms, own.p95_ms, own.max_ms].map(|ms| decimals(ms, 2));
        PlotRow {
            label: &own.method,
            class: method.map_or(PLAIN_CLASS, |method| &method.class),
            tooltip: format!(
                "{}: {} plans; median {p50}, 95 % {p95}, longest {max} ms",
                own.method,
                count(own.n)
            ),
            marks: vec![
                Mark::over(MarkShape::Whisker, [own.p50_ms, own.max_ms]),
                Mark::at(MarkShape::Median, own.p50_ms),
                Mark::at(MarkShape::Ring, own.p95_ms),
            ],
            numbers: vec![p50],
            ..PlotRow::default()
        }
    });
    let figure = Figure {
        id: "plan-times",
        title: "Time of single plans.".to_owned(),
        caption: format!(
            "Line: median; ring: 95 % quantile; whisker: up to the longest; n = {} plans a method. Times are those of the machine that made \
             the run, and of other work on it meanwhile.",
            count_range(&times.iter().map(|own| own.n).collect::<Vec<_>>())
        ),
        data: FigureData::about(&times)
            .words("method", |own| &*own.method)
            .counts("n", |own| own.n)
            .numbers("p50_ms", |own| own.p50_ms)
            .numbers("p95_ms", |own| own.p95_ms)
            .numbers("max_ms", |own| own.max_ms)
            .done(),
        legend: Vec::new(),
        panels: vec![row_plot::draw(&RowPlot {
            axis: ("time (ms)", Scale::log(low, high)),
            numbers: &["median"],
            rows: rows.collect(),
            ..RowPlot::default()
        })],
    };
    let table = Table::new("Time of single plans", &times, "method", |own| {
        own.method.clone()
    })
    .counts("plans", "", |own| own.n)
    .decimals("median", "ms", 2, |own| own.p50_ms)
    .decimals("95 %", "ms", 2, |own| own.p95_ms)
    .decimals("longest", "ms", 2, |own| own.max_ms);
    Some(Body::default().figure(figure).prose(table))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn violations_have_their_words_and_units() {
        let words = |family, worst_violation| {
            let facts = FamilyFacts {
                family,
                active: 0,
                worst_violation,
                would_mend: 0,
                largest_relaxation: 0.0,
            };
            violation_words(&facts, 1)
        };
        for (family, violation, expected) in [
            (
                ConstraintFamily::Reachability,
                -0.000_31,
                "satisfied (margin 0.31 mm)",
            ),
            (ConstraintFamily::Velocity, 2.0e-12, "2.0e-9 mm/s"),
            (ConstraintFamily::Velocity, 0.012_5, "12.50 mm/s"),
            (ConstraintFamily::Acceleration, 1.5, "1500.00 mm/s²"),
            (ConstraintFamily::Targets, 0.0, "satisfied exactly"),
            (ConstraintFamily::Separation, f64::NAN, NONE),
            (ConstraintFamily::Separation, f64::NEG_INFINITY, NONE),
        ] {
            assert_eq!(words(family, violation), expected);
        }
    }
}
