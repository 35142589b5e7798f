//! Motion over more than a segment, and motion that has to change on the way.

use std::borrow::Cow;

use inhand_model::{PerFinger, Plan, SegmentLayout, Trajectory};

use crate::MM_PER_M;
use crate::error::{PlanError, check_size};
use crate::planner::Planner;
use crate::spline::Spline;
use crate::target::{Target, Tips};
use crate::target_values::{FARTHEST_M, FASTEST_M_S, check_tips};

/// Longest chain, seconds: an hour. Catches times in milliseconds.
const LONGEST_S: f64 = 3600.0;
/// Velocities are the same up to here, m/s.
const SAME_M_S: f64 = 1e-6;
/// Fewest samples of a segment: with fewer, the way to its end is the way from its start.
const FEWEST_SAMPLES: usize = 3;

/// Positions and velocities of fingertips at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// Seconds since the start; taken to the nearest sample.
    pub time_s: f64,
    /// Positions of some of the fingers, metres, hand frame.
    pub tips: Tips,
    /// Velocities of some of the fingers, m/s: on arriving at the first knot of a chain, on leaving
    /// its last one if a segment ends there, and from the knot's sample to the next one otherwise.
    /// Those left open follow from the knots around.
    pub velocity: Tips,
}

/// Segments one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// The plan of each segment, in order; ends with the first that has no solution.
    pub plans: Vec<Plan>,
    /// When each segment starts, seconds since the start.
    pub starts_s: Vec<f64>,
    /// The whole motion, from the first knot to the last; `None` unless every segment has one.
    pub trajectory: Option<Trajectory>,
}

/// Plans motion through knots, over as many segments as it takes.
///
/// A segment starts at the last sample of the one before, from the same position, and with the
/// velocity from the sample before to the sample after it being one and the same, so that there is
/// no acceleration at a joint, and none that bounds on it would have missed. Segments meet on the
/// cubic spline through the knots (twice continuously differentiable but where velocities are
/// given) with its velocity; knots a sample away from a joint decide the velocity there.
///
/// Where a finger is not given any more, it goes on from the segment before as the demonstrations
/// have it; where it is not given yet, it goes to where it is given first. What the last segment
/// does after the last knot is left to the demonstrations, and cut off.
///
/// Every target counts as hard: a planner that has soft ones is made
/// [exact](Planner::exact) for each call.
///
/// # Errors
///
/// [`PlanError::Knots`] for fewer than two knots, a first one that is not at 0 s, times that do not
/// rise by a sample, more than an hour, positions and velocities that [`Planner::plan`] refuses, and
/// segments of fewer than three samples; [`PlanError::Segment`] where the way between knots is refused.
pub fn plan_chain(planner: &Planner, knots: &[Knot]) -> Result<Chain, PlanError> {
    let route = Route::new(planner.layout(), knots)?;
    let planner = match planner.is_exact() {
        true => Cow::Borrowed(planner),
        false => Cow::Owned(planner.clone().exact()?),
    };
    let layout = planner.layout();
    let mut chain = Chain {
        plans: Vec::new(),
        starts_s: Vec::new(),
        trajectory: None,
    };
    let mut motion_m: Vec<f64> = Vec::new();
    for segment in 0..route.last_sample.div_ceil(layout.samples - 1) {
        let before = chain.plans.last().and_then(|plan| plan.trajectory.as_ref());
        let start_s = route.time_s(segment * (layout.samples - 1));
        let plan = (planner.plan(&route.target(segment, before))).map_err(|source| {
            PlanError::Segment {
                segment,
                start_s,
                source: Box::new(source),
            }
        })?;
        let solved = plan.trajectory.clone();
        chain.plans.push(plan);
        chain.starts_s.push(start_s);
        let Some(trajectory) = solved else {
            return Ok(chain);
        };
        // The first sample is the last one of the segment before.
        let shared = usize::from(segment > 0);
        let numbers = layout.finger_rows() / layout.samples;
        motion_m.extend_from_slice(&trajectory.values_m()[shared * numbers..]);
    }
    let whole = SegmentLayout {
        samples: route.last_sample + 1,
        object: false,
        ..layout
    };
    motion_m.truncate(whole.finger_rows());
    chain.trajectory = Some(Trajectory::new(whole, motion_m)?);
    Ok(chain)
}

/// A knot at a sample.
struct Placed {
    sample: usize,
    tips: Tips,
    velocity: Tips,
}

/// Course of every segment of a chain, from its knots.
struct Route {
    knots: Vec<Placed>,
    last_sample: usize,
    layout: SegmentLayout,
    /// The way of each finger that some knot gives.
    splines: PerFinger<Option<[Spline; 3]>>,
}

impl Route {
    fn new(layout: SegmentLayout, knots: &[Knot]) -> Result<Self, PlanError> {
        if layout.samples < FEWEST_SAMPLES {
            return Err(PlanError::Knots(format!(
                "segments of {} samples make no chain: expected at least {FEWEST_SAMPLES}",
                layout.samples
            )));
        }
        let knots = placed(knots, layout)?;
        let splines = PerFinger::from_fn(|finger| {
            let given: Vec<_> = (knots.iter())
                .filter_map(|knot| {
                    let time_s = knot.sample as f64 / layout.rate_hz;
                    Some((time_s, knot.tips.0[finger]?, knot.velocity.0[finger]))
                })
                .collect();
            (!given.is_empty()).then(|| {
                [0, 1, 2].map(|axis| {
                    let points: Vec<_> = (given.iter())
                        .map(|(time_s, tip, velocity)| {
                            (*time_s, tip[axis], velocity.map(|v| v[axis]))
                        })
                        .collect();
                    Spline::through(&points)
                })
            })
        });
        Ok(Self {
            last_sample: knots.last().map_or(0, |knot| knot.sample),
            knots,
            layout,
            splines,
        })
    }

    fn time_s(&self, sample: usize) -> f64 {
        sample as f64 / self.layout.rate_hz
    }

    /// The target of one segment, given the motion of the one before.
    fn target(&self, segment: usize, before: Option<&Trajectory>) -> Target {
        let steps = self.layout.samples - 1;
        let (first, last) = (segment * steps, (segment + 1) * steps);
        let mut target = Target::new();
        for knot in &self.knots {
            if knot.sample > first && knot.sample < last {
                let time_s = self.time_s(knot.sample - first);
                target = target
                    .waypoint(time_s, knot.tips)
                    .velocity_at(time_s, knot.velocity);
            }
        }
        target = match before {
            None => (target.first(self.knots[0].tips)).first_velocity(self.knots[0].velocity),
            Some(before) => {
                let joint = self.joint(first);
                let velocity = PerFinger::from_fn(|finger| {
                    Some(joint[finger].map_or_else(
                        || {
                            let [a, b] =
                                [steps - 1, steps].map(|t| before.position(t, finger).to_array());
                            self.velocity(a, b)
                        },
                        |joint| joint.after,
                    ))
                });
                (target.first(before.configuration_m(steps))).velocity_at(0.0, velocity)
            }
        };
        if last < self.last_sample {
            let joint = self.joint(last);
            let tips = PerFinger::from_fn(|finger| joint[finger].map(|joint| joint.position));
            let velocity = PerFinger::from_fn(|finger| joint[finger].map(|joint| joint.before));
            return target
                .last(tips)
                .velocity_at(self.time_s(steps - 1), velocity);
        }
        match self.knots.last() {
            Some(knot) if knot.sample == last => {
                target.last(knot.tips).last_velocity(knot.velocity)
            }
            _ => target,
        }
    }

    /// How each finger passes from one segment to the next, but for those that are not given any
    /// more.
    fn joint(&self, sample: usize) -> PerFinger<Option<Joint>> {
        let time_s = self.time_s(sample);
        let around = [sample - 1, sample, sample + 1].map(|sample| {
            let found = self.knots.binary_search_by_key(&sample, |knot| knot.sample);
            found.ok().map(|i| &self.knots[i])
        });
        PerFinger::from_fn(|finger| {
            let axes = (self.splines[finger].as_ref()).filter(|axes| axes[0].end() >= time_s)?;
            let spline =
                |value: fn(&Spline, f64) -> f64| [0, 1, 2].map(|i| value(&axes[i], time_s));
            let [before, here, after] = around.map(|knot| knot.and_then(|k| k.tips.0[finger]));
            let [leaving, given, _] = around.map(|knot| knot.and_then(|k| k.velocity.0[finger]));
            let position = match (before, here, after) {
                (_, Some(here), _) => here,
                (Some(before), None, after) => match (leaving, after) {
                    (Some(v), _) => {
                        [0, 1, 2].map(|axis| before[axis] + v[axis] / self.layout.rate_hz)
                    }
                    (None, Some(after)) => [0, 1, 2].map(|axis| 0.5 * (before[axis] + after[axis])),
                    (None, None) => spline(Spline::position),
                },
                _ => spline(Spline::position),
            };
            let from = before.map(|before| self.velocity(before, position));
            let to = after.map(|after| self.velocity(position, after));
            let free = || spline(Spline::velocity);
            Some(Joint {
                position,
                before: (from.or(given).or(to)).unwrap_or_else(free),
                after: (to.or(given).or(from)).unwrap_or_else(free),
            })
        })
    }

    /// Velocity from one position to the next.
    fn velocity(&self, from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| (to[axis] - from[axis]) * self.layout.rate_hz)
    }
}

/// End of one segment and begin of the next.
#[derive(Clone, Copy)]
struct Joint {
    /// Metres.
    position: [f64; 3],
    /// Velocity from the sample before, m/s.
    before: [f64; 3],
    /// Velocity to the sample after; the same but where knots say otherwise.
    after: [f64; 3],
}

/// Checks knots and takes them to samples.
fn placed(knots: &[Knot], layout: SegmentLayout) -> Result<Vec<Placed>, PlanError> {
    let wrong = |knot: usize, expected: String, time_s: f64| {
        PlanError::Knots(format!("knot {knot} at {time_s} s: expected {expected}"))
    };
    let mut placed: Vec<Placed> = Vec::with_capacity(knots.len());
    for (i, knot) in knots.iter().enumerate() {
        let time_s = knot.time_s;
        if !(0.0..=LONGEST_S).contains(&time_s) {
            return Err(wrong(i, format!("a time from 0 to {LONGEST_S} s"), time_s));
        }
        check_tips("position", &knot.tips, FARTHEST_M)
            .and_then(|()| check_tips("velocity", &knot.velocity, FASTEST_M_S))
            .map_err(|source| PlanError::Knots(format!("knot {i} at {time_s} s: {source}")))?;
        let sample = (time_s * layout.rate_hz).round() as usize;
        match placed.last() {
            None if sample != 0 => return Err(wrong(0, "the first at 0 s".into(), time_s)),
            Some(before) if sample <= before.sample => {
                let sample_s = 1.0 / layout.rate_hz;
                let before_s = knots[i - 1].time_s;
                let expected = format!("a time later than {before_s} s by a sample ({sample_s} s)");
                return Err(wrong(i, expected, time_s));
            }
            _ => placed.push(Placed {
                sample,
                tips: knot.tips,
                velocity: knot.velocity,
            }),
        }
    }
    for i in 1..placed.len() {
        let (sample, next) = (placed[i].sample, placed[i].tips);
        let knot = &mut placed[i - 1];
        if knot.sample == 0 || knot.sample + 1 != sample {
            continue;
        }
        // Positions a sample apart are a velocity already.
        for (finger, next) in next.0.iter() {
            if let (Some(a), Some(b)) = (knot.tips.0[finger], *next)
                && let Some(v) = knot.velocity.0[finger].take()
            {
                let way = [0, 1, 2].map(|axis| (b[axis] - a[axis]) * layout.rate_hz);
                if (0..3).any(|axis| (v[axis] - way[axis]).abs() > SAME_M_S) {
                    let expected = format!(
                        "the velocity of {finger} that leads to the next knot a sample later, \
                         {way:?} m/s, found {v:?}"
                    );
                    return Err(wrong(i - 1, expected, knots[i - 1].time_s));
                }
            }
        }
    }
    if placed.len() < 2 {
        let time_s = knots.first().map_or(0.0, |knot| knot.time_s);
        return Err(wrong(placed.len(), "at least two knots".into(), time_s));
    }
    Ok(placed)
}

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
