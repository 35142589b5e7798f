//! Summary of the certificates of a method's plans.

use inhand_model::{ConstraintFamily, FamilyFacts, Plan, PlanFacts, PlanStatus};

pub(crate) fn plan_facts(plans: &[Plan]) -> PlanFacts {
    let solved: Vec<_> = (plans.iter())
        .filter(|plan| plan.trajectory.is_some())
        .collect();
    let infeasible: Vec<_> = (plans.iter())
        .filter(|plan| plan.status == PlanStatus::Infeasible)
        .collect();
    let families = ConstraintFamily::ALL
        .into_iter()
        .filter_map(|family| family_facts(family, &solved, &infeasible))
        .collect();
    let outside = (solved.iter())
        .filter_map(|plan| plan.checks.hull_distance_m)
        .map(|distance_m| usize::from(distance_m > 0.0));
    let active = |plan: &&&Plan| plan.checks.active[ConstraintFamily::Velocity] > 0;
    PlanFacts {
        solved: solved.len(),
        infeasible: infeasible.len(),
        failed: plans.len().saturating_sub(solved.len() + infeasible.len()),
        // NaN is the worst of all.
        worst_kkt_residual: (solved.iter())
            .map(|plan| plan.certificate.worst())
            .max_by(f64::total_cmp)
            .unwrap_or(0.0),
        velocity_bound_active: solved.iter().filter(active).count(),
        families,
        outside_hull: outside.clone().next().map(|_| outside.sum()),
    }
}

/// Facts of one family; `None` where it was off in every plan.
fn family_facts(
    family: ConstraintFamily,
    solved: &[&Plan],
    infeasible: &[&Plan],
) -> Option<FamilyFacts> {
    let violations = || {
        solved
            .iter()
            .filter_map(|plan| plan.checks.violation[family])
    };
    let relaxations: Vec<f64> = (infeasible.iter())
        .flat_map(|plan| &plan.relaxations)
        .filter(|relaxation| relaxation.family == family && !relaxation.joint)
        .map(|relaxation| relaxation.by)
        .collect();
    let on = |plan: &&Plan| plan.checks.violation[family].is_some();
    if !solved
        .iter()
        .chain(infeasible)
        .copied()
        .any(|plan| on(&plan))
    {
        return None;
    }
    Some(FamilyFacts {
        family,
        active: (solved.iter())
            .filter(|plan| plan.checks.active[family] > 0)
            .count(),
        // Null in files where no plan has a motion to judge.
        worst_violation: violations().max_by(f64::total_cmp).unwrap_or(f64::NAN),
        would_mend: relaxations.len(),
        largest_relaxation: relaxations.into_iter().fold(0.0, f64::max),
    })
}
