//! Explains infeasibility: the smallest relaxation of the constraints that has a solution.

mod elastic;
mod program;

use inhand_model::{ConstraintFamily, Relaxation};

use self::elastic::least;
use crate::given::Given;
use crate::solve::{Taken, Task};

/// By how much each family of constraints alone would have to give way for the rest to have a
/// solution, and where none alone is enough, by how much all of them together, each by the same
/// number of its units. Families are those of the task and hard targets; signs never give way.
///
/// Solves `minimise s` with the bounds of a family moved outwards by `s`, rows taken up as needed.
/// For fingertips kept apart that is the linearised problem.
pub(crate) fn relaxations(task: &Task<'_>, rows: &[Taken]) -> Vec<Relaxation> {
    let mut families = task.families.on();
    if task.problem.equalities.is_some() {
        let family = |given: &Given| family_of(*given);
        for target in [
            ConstraintFamily::Targets,
            ConstraintFamily::TargetVelocities,
        ] {
            if task.problem.given.iter().map(family).any(|f| f == target) {
                families.push(target);
            }
        }
    }
    families.sort();
    let alone: Vec<Relaxation> = (families.iter())
        .filter_map(|&family| {
            Some(Relaxation {
                family,
                by: least(task, rows, &[family])?,
                joint: false,
            })
        })
        .collect();
    if !alone.is_empty() {
        return alone;
    }
    let Some(by) = least(task, rows, &families) else {
        return Vec::new();
    };
    let together = |family| Relaxation {
        family,
        by,
        joint: true,
    };
    families.into_iter().map(together).collect()
}

/// The family of a hard target.
pub(crate) const fn family_of(given: Given) -> ConstraintFamily {
    match given {
        Given::Velocity { .. } | Given::Step { .. } => ConstraintFamily::TargetVelocities,
        // A rotation counts by its way at the lever.
        Given::Position { .. } | Given::ObjectPosition { .. } | Given::ObjectRotation { .. } => {
            ConstraintFamily::Targets
        }
    }
}
