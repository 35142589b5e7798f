//! Motion over more than a segment, and motion that has to change on the way.

use inhand_model::{Finger, PerFinger, Plan, PlanStatus, SegmentLayout, Trajectory};

use crate::error::PlanError;
use crate::planner::Planner;
use crate::spline::Spline;
use crate::target::{Target, Tips};

/// Longest chain, in segments: an hour of seconds. Catches times in milliseconds.
const MOST_SEGMENTS: usize = 3600;

/// Where fingertips are to be at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// Seconds since the start; taken to the nearest sample.
    pub time_s: f64,
    /// Positions of some of the fingers, metres, hand frame.
    pub tips: Tips,
    /// Velocities of some of the fingers, m/s. Those left open follow from the knots around.
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
/// Segments share the sample at which one ends and the next starts: there position and velocity
/// (from that sample's neighbours on both sides) are the same in both, exactly. Where no knot gives
/// them they are those of the cubic spline through the knots (twice continuously differentiable;
/// with the velocities given at the ends, natural without). A finger that no knot gives goes on from
/// where the segment before has left it. After the last knot motion goes straight on to the end of
/// its segment, and is cut off.
///
/// Every target counts as hard, whatever the planner's settings say.
///
/// # Errors
///
/// [`PlanError::Knots`] for fewer than two knots, a first one that is not at 0 s, times that do not
/// rise by a sample, or more than an hour; [`PlanError`] as for [`Planner::plan`].
pub fn plan_chain(planner: &Planner, knots: &[Knot]) -> Result<Chain, PlanError> {
    let layout = planner.layout();
    let samples = knot_samples(knots, layout)?;
    let last = samples.last().copied().unwrap_or(0);
    let steps = layout.samples - 1;
    let segments = last.div_ceil(steps);
    let planner = planner.clone().exact()?;
    let route = Route::new(knots, &samples, layout, segments * steps);
    let mut chain = Chain {
        plans: Vec::with_capacity(segments),
        starts_s: Vec::with_capacity(segments),
        trajectory: None,
    };
    let mut motion_m: Vec<f64> = Vec::new();
    for segment in 0..segments {
        let before = chain.plans.last().and_then(|plan| plan.trajectory.as_ref());
        let plan = planner.plan(&route.target(segment, before))?;
        let solved = plan.trajectory.clone();
        chain.plans.push(plan);
        chain
            .starts_s
            .push((segment * steps) as f64 / layout.rate_hz);
        let Some(trajectory) = solved else {
            return Ok(chain);
        };
        // The first sample is the last one of the segment before.
        let shared = if segment == 0 {
            0
        } else {
            trajectory.values_m().len() / layout.samples
        };
        motion_m.extend_from_slice(&trajectory.values_m()[shared..]);
    }
    let whole = SegmentLayout {
        samples: last + 1,
        object: false,
        ..layout
    };
    motion_m.truncate(whole.finger_rows());
    chain.trajectory = Some(Trajectory::new(whole, motion_m)?);
    Ok(chain)
}

/// Plans anew from a state that is not the one planned: the target with what lies ahead of
/// `elapsed_s`, the state there (positions and velocities of some or all fingers) exactly, and the
/// constraints from there on. Of the plan's trajectory the samples from `elapsed_s` on are the new
/// motion; those before show where such a motion would have come from.
///
/// What the target gives of the start stays: it says what the hand set out to do.
///
/// # Errors
///
/// As for [`Planner::plan`]; [`PlanError::WaypointTime`] for a time outside the segment.
pub fn replan(
    planner: &Planner,
    target: &Target,
    elapsed_s: f64,
    state: &Knot,
) -> Result<Plan, PlanError> {
    let mut ahead = target.clone();
    let sample = 1.0 / planner.layout().rate_hz;
    // Half a sample ahead: what is now is known better.
    ahead
        .waypoints
        .retain(|w| w.time_s > elapsed_s + 0.5 * sample);
    ahead.steps.retain(|s| s.time_s > elapsed_s + 0.5 * sample);
    // The start was reached with other motion than the one that leads to this state.
    ahead.first_velocity_m_s = Tips::default();
    let ahead = ahead
        .waypoint(elapsed_s, state.tips)
        .velocity_at(elapsed_s, state.velocity)
        .constrained_from(elapsed_s);
    planner.plan(&ahead)
}

/// The sample of each knot.
fn knot_samples(knots: &[Knot], layout: SegmentLayout) -> Result<Vec<usize>, PlanError> {
    let longest_s = MOST_SEGMENTS as f64 * layout.duration_s();
    let wrong = |knot: usize, expected: String, time_s: f64| PlanError::Knots {
        knot,
        expected,
        time_s,
    };
    let mut samples: Vec<usize> = Vec::with_capacity(knots.len());
    for (i, knot) in knots.iter().enumerate() {
        if !(knot.time_s >= 0.0 && knot.time_s <= longest_s) {
            return Err(wrong(
                i,
                format!("a time from 0 to {longest_s} s"),
                knot.time_s,
            ));
        }
        let sample = (knot.time_s * layout.rate_hz).round() as usize;
        match samples.last() {
            None if sample != 0 => return Err(wrong(0, "the first at 0 s".into(), knot.time_s)),
            Some(&before) if sample <= before => {
                let expected = format!("a time after {} s", knots[i - 1].time_s);
                return Err(wrong(i, expected, knot.time_s));
            }
            _ => samples.push(sample),
        }
    }
    if samples.len() < 2 {
        let time_s = knots.first().map_or(0.0, |knot| knot.time_s);
        return Err(wrong(samples.len(), "at least two knots".into(), time_s));
    }
    Ok(samples)
}

/// What knots say about every segment of a chain.
struct Route<'a> {
    knots: &'a [Knot],
    samples: &'a [usize],
    layout: SegmentLayout,
    /// The way of each finger that some knot gives.
    splines: PerFinger<Option<[Spline; 3]>>,
}

impl<'a> Route<'a> {
    fn new(knots: &'a [Knot], samples: &'a [usize], layout: SegmentLayout, end: usize) -> Self {
        let time = |sample: usize| sample as f64 / layout.rate_hz;
        let splines = PerFinger::from_fn(|finger| {
            let given: Vec<_> = (knots.iter().zip(samples))
                .filter_map(|(knot, &s)| {
                    Some((time(s), knot.tips.0[finger]?, knot.velocity.0[finger]))
                })
                .collect();
            (!given.is_empty()).then(|| {
                [0, 1, 2].map(|axis| {
                    let points: Vec<_> = (given.iter())
                        .map(|(time, position, velocity)| {
                            (*time, position[axis], velocity.map(|v| v[axis]))
                        })
                        .collect();
                    Spline::through(&points, time(end))
                })
            })
        });
        Self {
            knots,
            samples,
            layout,
            splines,
        }
    }

    /// The target of one segment, given the motion of the one before.
    fn target(&self, segment: usize, before: Option<&Trajectory>) -> Target {
        let steps = self.layout.samples - 1;
        let (first, last) = (segment * steps, (segment + 1) * steps);
        let mut target = Target::new();
        for (knot, &sample) in self.knots.iter().zip(self.samples) {
            if sample > first && sample < last {
                let time_s = (sample - first) as f64 / self.layout.rate_hz;
                target = target.waypoint(time_s, knot.tips);
            }
        }
        let step_s = 1.0 / self.layout.rate_hz;
        let end_step_s = (steps - 1) as f64 * step_s;
        let (goal, goal_velocity) = self.joint(last);
        target = target
            .last(goal)
            .last_velocity(goal_velocity)
            .velocity_at(end_step_s, goal_velocity);
        let (mut start, mut start_velocity) = self.joint(first);
        if segment == 0 {
            start_velocity = Tips(PerFinger::from_fn(|f| self.knots[0].velocity.0[f]));
            return target.first(start).first_velocity(start_velocity);
        }
        if let Some(before) = before {
            for finger in Finger::ALL {
                if start.0[finger].is_none() {
                    let [a, b] = [steps - 1, steps].map(|t| before.position(t, finger).to_array());
                    start.0[finger] = Some(b);
                    let velocity = [0, 1, 2].map(|i| (b[i] - a[i]) * self.layout.rate_hz);
                    start_velocity.0[finger] = Some(velocity);
                }
            }
        }
        target
            .first(start)
            .first_velocity(start_velocity)
            .velocity_at(0.0, start_velocity)
    }

    /// Position and velocity of the fingers that knots give, at a sample.
    fn joint(&self, sample: usize) -> (Tips, Tips) {
        let time_s = sample as f64 / self.layout.rate_hz;
        let at = |value: fn(&Spline, f64) -> f64| {
            Tips(PerFinger::from_fn(|finger| {
                let axes = self.splines[finger].as_ref()?;
                Some([0, 1, 2].map(|axis| value(&axes[axis], time_s)))
            }))
        };
        (at(Spline::position), at(Spline::velocity))
    }
}

impl Chain {
    /// Whether every segment has a solution.
    pub fn is_solved(&self) -> bool {
        let solved = |plan: &Plan| plan.status == PlanStatus::Solved;
        self.trajectory.is_some() && self.plans.iter().all(solved)
    }
}
