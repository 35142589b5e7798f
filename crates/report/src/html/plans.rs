//! Certificates of all plans, and activity of each family of constraints.

use inhand_model::{ConstraintFamily, FamilyFacts, PlanFacts};
use maud::{Markup, html};

use super::Method;
use super::constraints::part_of;
use super::session::name;
use super::table::{Column, Group, Line, grouped, numbers, table, words};
use crate::number::{NARROW_SPACE, NONE, count, decimals, scientific, to_mm};

/// A method with what is known of its plans.
type Planned<'a, 'b> = (&'a Method<'b>, &'b PlanFacts);

/// Certificates by method, then families of constraints by method.
pub(super) fn tables(methods: &[Method<'_>]) -> Markup {
    let planned: Vec<Planned<'_, '_>> = methods
        .iter()
        .filter_map(|method| Some((method, method.evaluation.plan.as_ref()?)))
        .collect();
    html! {
        @if planned.is_empty() {
            p { "No method solved an optimisation." }
        } @else {
            (certificates(&planned))
            @if planned.iter().any(|(_, plan)| !plan.families.is_empty()) {
                (families(&planned))
            }
        }
    }
}

const CERTIFICATES: [Column<'static>; 7] = [
    words("method"),
    numbers("solved", "plans"),
    numbers("infeasible", "plans"),
    numbers("failed", "plans"),
    numbers("velocity bound active", "plans"),
    numbers("velocity outside", "plans"),
    numbers("KKT residual", "worst"),
];

fn certificates(planned: &[Planned<'_, '_>]) -> Markup {
    let with_hull = planned.iter().any(|(_, plan)| plan.outside_hull.is_some());
    let mut columns: Vec<Column<'_>> = CERTIFICATES.into();
    if with_hull {
        columns.push(numbers("outside the hull", "plans"));
    }
    let lines = planned
        .iter()
        .map(|(method, plan)| {
            let outside = method.evaluation.velocity.trajectories_outside;
            let mut cells: Vec<String> = [
                plan.solved,
                plan.infeasible,
                plan.failed,
                plan.velocity_bound_active,
                outside,
            ]
            .map(|n| count(n, NARROW_SPACE))
            .into();
            cells.push(scientific(plan.worst_kkt_residual));
            if with_hull {
                cells.push(match plan.outside_hull {
                    Some(outside) if plan.solved > 0 => part_of(outside, plan.solved),
                    _ => NONE.to_owned(),
                });
            }
            Line {
                head: name(method),
                cells,
                best: Vec::new(),
                stressed: method.default,
            }
        })
        .collect();
    html! {
        (table("Plans and their certificates", &columns, lines))
        p.note {
            "Infeasible: shown to have no solution. Failed: the solver ended with neither a solution nor such a proof. Neither has a \
             trajectory, so neither is in the statistics above."
            @if with_hull {
                " Outside the hull: solved plans with a fingertip outside its training hull at some instant. That is a finding and no error \
                 unless reachability was asked for: recorded motion leaves the hull of the training takes as well, and a plan starts and \
                 ends where it is told to."
            }
        }
    }
}

const FAMILIES: [Column<'static>; 3] = [
    words("constraint"),
    numbers("active", "plans"),
    words("worst violation"),
];

fn families(planned: &[Planned<'_, '_>]) -> Markup {
    // Where every plan has a solution there is nothing to mend.
    let any_infeasible = planned.iter().any(|(_, plan)| plan.infeasible > 0);
    let mut columns: Vec<Column<'_>> = FAMILIES.into();
    if any_infeasible {
        columns.push(numbers("would mend", "infeasible plans"));
        columns.push(numbers("largest relaxation", "needed for that"));
    }
    let groups: Vec<Group> = planned
        .iter()
        .filter(|(_, plan)| !plan.families.is_empty())
        .map(|(method, plan)| Group {
            head: Some(name(method)),
            lines: plan
                .families
                .iter()
                .map(|facts| Line {
                    head: html! { (family_words(facts.family)) },
                    cells: cells(plan, facts, any_infeasible),
                    best: Vec::new(),
                    stressed: false,
                })
                .collect(),
        })
        .collect();
    html! {
        (grouped("What each family of constraints did, by method", &columns, &groups))
        p.note {
            "Families that were off are not listed. Active: solved plans with at least one bound that held them back. Worst violation: over \
             all bounds of all solved plans, recomputed from the motion; one far below what cameras resolve is the solver's rounding. "
            @if any_infeasible {
                "Would mend: infeasible plans that would have a solution if this family alone gave way, all its bounds moving outwards by at \
                 most the largest relaxation."
            } @else {
                "No plan was infeasible, so no constraint had to give way."
            }
        }
    }
}

fn cells(plan: &PlanFacts, facts: &FamilyFacts, any_infeasible: bool) -> Vec<String> {
    let mut cells = vec![
        part_of(facts.active, plan.solved),
        violation_words(facts, plan.solved),
    ];
    if any_infeasible {
        cells.push(match plan.infeasible {
            0 => NONE.to_owned(),
            infeasible => part_of(facts.would_mend, infeasible),
        });
        cells.push(match facts.would_mend {
            0 => NONE.to_owned(),
            _ => amount(facts.largest_relaxation, facts.family),
        });
    }
    cells
}

fn violation_words(facts: &FamilyFacts, solved: usize) -> String {
    let violation = facts.worst_violation;
    if solved == 0 || !violation.is_finite() {
        NONE.to_owned()
    } else if violation < 0.0 {
        format!("kept with {} to spare", amount(-violation, facts.family))
    } else if violation == 0.0 {
        "kept exactly".to_owned()
    } else {
        amount(violation, facts.family)
    }
}

/// A number in the family's unit, with the metre turned into millimetres as everywhere in reports.
/// Small ones keep their order of magnitude, which tells rounding from a bound that was broken.
fn amount(value: f64, family: ConstraintFamily) -> String {
    let value = to_mm(value);
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let digits = if value < 0.01 {
        scientific(value)
    } else {
        decimals(value, 2)
    };
    format!("{digits} m{}", family.unit())
}

const fn family_words(family: ConstraintFamily) -> &'static str {
    match family {
        ConstraintFamily::Targets => "given positions met",
        ConstraintFamily::TargetVelocities => "given velocities met",
        ConstraintFamily::Activations => "activations not negative",
        ConstraintFamily::Velocity => "velocity",
        ConstraintFamily::Acceleration => "acceleration",
        ConstraintFamily::Reachability => "inside the training hull",
        ConstraintFamily::Separation => "distance between fingertips",
        ConstraintFamily::Holding => "contact points held",
    }
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
                "kept with 0.31 mm to spare",
            ),
            (ConstraintFamily::Velocity, 2.0e-12, "2.0e-9 mm/s"),
            (ConstraintFamily::Velocity, 0.012_5, "12.50 mm/s"),
            (ConstraintFamily::Acceleration, 1.5, "1500.00 mm/s²"),
            (ConstraintFamily::Targets, 0.0, "kept exactly"),
            (ConstraintFamily::Separation, f64::NAN, NONE),
            (ConstraintFamily::Separation, f64::NEG_INFINITY, NONE),
        ] {
            assert_eq!(words(family, violation), expected);
        }
    }
}
