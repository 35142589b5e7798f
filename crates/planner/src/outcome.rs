//! Turns a solver's result into a plan with its certificate.

use inhand_contact::HullProbe;
use inhand_model::{
    ConstraintFamily, Finger, Hull, PerFamily, PerFinger, Plan, PlanChecks, PlanStatus, Trajectory,
};
use nalgebra::DVector;

use crate::MM_PER_M;
use crate::active_set::Constraint;
use crate::error::PlanError;
use crate::explain::{family_of, relaxations};
use crate::object::planned_poses;
use crate::solve::{Judged, Outcome, SOLVED, Task};
use crate::target::Target;

/// Worst certificate residual of a plan that counts as almost solved.
const ALMOST_SOLVED: f64 = 1e-4;

pub(crate) fn plan_from(
    task: &Task<'_>,
    outcome: &Outcome,
    target: &Target,
    hulls: Option<&PerFinger<Hull>>,
) -> Result<Plan, PlanError> {
    let judged = &outcome.judged;
    let status = match judged.certificate.worst() {
        _ if outcome.infeasible => PlanStatus::Infeasible,
        worst if worst <= SOLVED => PlanStatus::Solved,
        worst if worst <= ALMOST_SOLVED => PlanStatus::AlmostSolved,
        _ => PlanStatus::Failed,
    };
    let usable = matches!(status, PlanStatus::Solved | PlanStatus::AlmostSolved);
    let layout = task.model.layout;
    let trajectory = if usable {
        let fingers = &judged.motion_mm[..layout.finger_rows()];
        let values_m = fingers.iter().map(|v| v / MM_PER_M).collect();
        Some(Trajectory::new(layout, values_m)?)
    } else {
        None
    };
    let signs = usize::from(task.model.signs) * task.model.unknowns();
    let rows: usize = task.families.all.iter().map(|family| family.rows()).sum();
    let equations = (task.problem.equalities.as_ref()).map_or(0, |e| e.rows.nrows());
    Ok(Plan {
        status,
        object: match target.object_first {
            Some(first) if usable && layout.object => {
                planned_poses(layout, &judged.motion_mm, first)
            }
            _ => Vec::new(),
        },
        activations_m: if usable {
            &judged.unknowns / MM_PER_M
        } else {
            DVector::zeros(0)
        },
        objective: if outcome.infeasible {
            f64::INFINITY
        } else {
            judged.objective
        },
        certificate: judged.certificate,
        checks: PlanChecks {
            active: active(task, outcome, usable),
            violation: violation(task, judged),
            rows: rows + signs + equations,
            rows_taken_up: outcome.rows.len(),
            hull_distance_m: (trajectory.as_ref().zip(hulls))
                .map(|(trajectory, hulls)| worst_hull_distance_m(trajectory, hulls)),
        },
        relaxations: if outcome.infeasible {
            relaxations(task, &outcome.rows)
        } else {
            Vec::new()
        },
        trajectory,
        rounds: outcome.rounds,
        iterations: outcome.iterations,
    })
}

/// Largest signed distance of a trajectory's fingertips to their hulls, metres: negative inside.
pub fn worst_hull_distance_m(trajectory: &Trajectory, hulls: &PerFinger<Hull>) -> f64 {
    let mut worst = f64::NEG_INFINITY;
    for finger in Finger::ALL {
        let mut probe = HullProbe::new(&hulls[finger]);
        for t in 0..trajectory.layout().samples {
            worst = worst.max(probe.distance_m(trajectory.position(t, finger).to_array()));
        }
    }
    worst
}

fn active(task: &Task<'_>, outcome: &Outcome, usable: bool) -> PerFamily<usize> {
    let judged = &outcome.judged;
    let mut active = PerFamily::default();
    for &(constraint, multiplier) in &judged.multipliers {
        let Constraint::Row(j) = constraint else {
            continue;
        };
        let row = &outcome.rows[j].row;
        // An interior point gives every row a multiplier, and those that are not active a slack that
        // is larger.
        if multiplier > row.slack(&judged.motion_mm).abs() {
            active[row.family] += 1;
        }
    }
    if task.model.signs && usable {
        active[ConstraintFamily::Activations] =
            judged.unknowns.iter().filter(|h| **h == 0.0).count();
    }
    active
}

/// Largest violation of each family that is on, in its unit.
fn violation(task: &Task<'_>, judged: &Judged) -> PerFamily<Option<f64>> {
    let mut violation = PerFamily::from_fn(|family| judged.worst[family].map(|worst| worst.by));
    let unknowns = &judged.unknowns;
    if task.model.signs {
        violation[ConstraintFamily::Activations] = Some((0.0 - unknowns.min()) / MM_PER_M);
    }
    if let Some(equalities) = &task.problem.equalities {
        let found = &equalities.rows * unknowns;
        for (k, (found, value)) in found.iter().zip(task.instance.values.iter()).enumerate() {
            let worst = &mut violation[family_of(task.problem.pattern[k / 3])];
            let miss = (found - value).abs() / MM_PER_M;
            *worst = Some(worst.map_or(miss, |worst| worst.max(miss)));
        }
    }
    violation
}
