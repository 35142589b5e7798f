//! Motion that has to change on the way.

use inhand_model::Plan;

use crate::MM_PER_M;
use crate::chain::Knot;
use crate::error::{PlanError, check_size};
use crate::planner::Planner;
use crate::target::{Target, Tips};

/// Plans anew what is left of a motion, from a state that need not be the planned one.
///
/// `state` is where fingers are at its time (seconds since the plan's first sample), and how they
/// move from there to the next sample; fingers that it leaves out may be anywhere. The new plan
/// starts from it exactly (within some nanometres where targets are soft), reaches what the target gives
/// of later times, and keeps the constraints from the state on. Its trajectory is a whole segment:
/// the samples from the state on are the motion to be made, those before show where such a motion
/// would have come from.
///
/// What was passed is not given any more, since it need not lead to the state. It is remembered by
/// the plan instead: of all motions that go on from the state to the goal, the new plan is the one
/// that differs from the old one by what is most likely for demonstrations. So a state on the plan
/// changes nothing, over any number of times; a sudden change does not bend the motion ahead as
/// though the hand had moved there smoothly from its start; and the target itself may change.
///
/// Soft targets are weighed anew, so that a plan that was kept from its goal is drawn back to it.
/// From a state on the plan they move the motion by part of what it misses them by.
///
/// # Errors
///
/// [`PlanError::Target`] for a state before the first sample or after the last but one;
/// [`PlanError::Model`] for a plan without a solution or of another planner; else as for
/// [`Planner::plan`].
pub fn replan(
    planner: &Planner,
    plan: &Plan,
    target: &Target,
    state: &Knot,
) -> Result<Plan, PlanError> {
    let layout = planner.layout();
    let elapsed_s = state.time_s;
    let half_sample_s = 0.5 / layout.rate_hz;
    let limit_s = layout.samples.saturating_sub(2) as f64 / layout.rate_hz;
    if !(elapsed_s >= -half_sample_s && elapsed_s < limit_s + half_sample_s) {
        return Err(PlanError::Target(format!(
            "planning anew at {elapsed_s} s: expected a time from 0 to {limit_s} s"
        )));
    }
    check_size(
        "number of activations of the plan to go on from",
        planner.unknowns(),
        plan.activations_m.len(),
    )?;
    let elapsed_s = elapsed_s.max(0.0);
    let mut ahead = target.clone();
    // What is now is known better.
    let sample = |time_s: f64| (time_s * layout.rate_hz).round();
    let later = |time_s: f64| sample(time_s) > sample(elapsed_s);
    ahead.waypoints.retain(|waypoint| later(waypoint.time_s));
    ahead.steps.retain(|step| later(step.time_s));
    ahead.first_m = Tips::default();
    ahead.first_velocity_m_s = Tips::default();
    let mut ahead = ahead
        .waypoint(elapsed_s, state.tips)
        .velocity_at(elapsed_s, state.velocity)
        .constrained_from(elapsed_s);
    ahead.now_s = Some(elapsed_s);
    planner.plan_near(&ahead, Some(&plan.activations_m * MM_PER_M))
}
