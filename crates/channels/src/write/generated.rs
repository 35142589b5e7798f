//! Trajectories and plans of each method.

use std::ops::Range;

use inhand_model::{ConstraintFamily, Plan, Status};

use super::{Instant, Stream, Streams, fingertip, fingertips};
use crate::error::ChannelError;
use crate::messages;
use crate::output::{ChannelId, Output};
use crate::take::{GeneratedMethod, GeneratedSegment, UnsolvedPlan};
use crate::topic::MethodTopics;
use crate::wire::Timestamp;

pub(super) fn add<'a>(
    methods: &[GeneratedMethod<'a>],
    output: &mut Output,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    for method in methods {
        let topics = MethodTopics::new(method.name)?;
        let channel = output.channel::<messages::Fingertips>(&topics.fingertips, Some("hand"))?;
        let planned = method.segments.iter().any(|segment| segment.plan.is_some());
        let plans = if planned || !method.unsolved.is_empty() {
            Some(output.channel::<messages::Plan>(&topics.plan, Some("hand"))?)
        } else {
            None
        };
        if let (Some(channel), false) = (plans, method.unsolved.is_empty()) {
            let mut unsolved: Vec<_> = method.unsolved.iter().collect();
            unsolved.sort_by_key(|plan| plan.start_sample);
            streams.push(Box::new(Unsolved {
                channel,
                plans: unsolved,
                next: 0,
            }));
        }
        streams.push(Box::new(Trajectories {
            channel,
            plans,
            segments: by_start(method.segments),
            running: 0..0,
        }));
    }
    Ok(())
}

/// Segments in the order in which they start.
pub(crate) fn by_start<'a>(segments: &'a [GeneratedSegment<'a>]) -> Vec<&'a GeneratedSegment<'a>> {
    let mut segments: Vec<_> = segments.iter().collect();
    segments.sort_by_key(|segment| segment.start_sample);
    segments
}

struct Trajectories<'a> {
    channel: ChannelId,
    plans: Option<ChannelId>,
    segments: Vec<&'a GeneratedSegment<'a>>,
    /// The segments that have started, without those at the front that are over.
    running: Range<usize>,
}

impl Stream for Trajectories<'_> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        while let Some(segment) = self.segments.get(self.running.end)
            && segment.start_sample <= k
        {
            if let (Some(plans), Some(plan)) = (self.plans, segment.plan) {
                let samples = segment.trajectory.layout().samples;
                let message = plan_message(plan, (segment.start_sample, samples), unix_nanos);
                output.message(plans, self.running.end, unix_nanos, &message)?;
            }
            self.running.end += 1;
        }
        let samples = |segment: &GeneratedSegment| segment.trajectory.layout().samples;
        while let Some(segment) = self.segments.get(self.running.start)
            && self.running.start < self.running.end
            && k >= segment.start_sample + samples(segment)
        {
            self.running.start += 1;
        }
        for segment in &self.segments[self.running.clone()] {
            let t = k - segment.start_sample;
            if t < samples(segment) {
                let message = fingertips(unix_nanos, |finger| {
                    let position = segment.trajectory.position(t, finger);
                    fingertip(Some(position.to_array()), Status::Measured)
                });
                output.message(self.channel, k, unix_nanos, &message)?;
            }
        }
        Ok(())
    }
}

/// Plans without a trajectory, each at the sample at which its trajectory would start.
struct Unsolved<'a> {
    channel: ChannelId,
    plans: Vec<&'a UnsolvedPlan<'a>>,
    next: usize,
}

impl Stream for Unsolved<'_> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        while let Some(unsolved) = self.plans.get(self.next)
            && unsolved.start_sample <= k
        {
            let place = (unsolved.start_sample, unsolved.samples);
            let message = plan_message(unsolved.plan, place, unix_nanos);
            output.message(self.channel, self.next, unix_nanos, &message)?;
            self.next += 1;
        }
        Ok(())
    }
}

fn plan_message(
    plan: &Plan,
    (start_sample, samples): (usize, usize),
    unix_nanos: u64,
) -> messages::Plan {
    messages::Plan {
        timestamp: Some(Timestamp::from_unix_nanos(unix_nanos)),
        start_sample: start_sample as u64,
        samples: samples as u64,
        status: messages::PlanStatus::from(plan.status).into(),
        activations_m: plan.activations_m.as_slice().to_vec(),
        objective: plan.objective,
        stationarity: plan.certificate.stationarity,
        primal: plan.certificate.primal,
        dual: plan.certificate.dual,
        complementarity: plan.certificate.complementarity,
        active_velocity_bounds: plan.checks.active[ConstraintFamily::Velocity] as u64,
        active_activation_bounds: plan.checks.active[ConstraintFamily::Activations] as u64,
        rows_taken_up: plan.checks.rows_taken_up as u64,
        rounds: plan.rounds as u64,
        iterations: plan.iterations as u64,
        families: ConstraintFamily::ALL
            .into_iter()
            .filter_map(|family| family_message(plan, family))
            .collect(),
        rows: plan.checks.rows as u64,
        hull_distance_m: plan.checks.hull_distance_m,
        relaxations: (plan.relaxations.iter())
            .map(|relaxation| messages::Relaxation {
                family: messages::ConstraintFamily::from(relaxation.family).into(),
                by: relaxation.by,
                joint: relaxation.joint,
            })
            .collect(),
        hand_from_object: (plan.object.iter())
            .map(|pose| messages::PlannedPose {
                position_m: Some(pose.origin().to_array().into()),
                orientation: Some(pose.quaternion_xyzw().into()),
            })
            .collect(),
    }
}

/// A family of constraints, where there is anything to say of it.
fn family_message(plan: &Plan, family: ConstraintFamily) -> Option<messages::FamilyCheck> {
    let active = plan.checks.active[family] as u64;
    let violation = plan.checks.violation[family];
    (active > 0 || violation.is_some()).then(|| messages::FamilyCheck {
        family: messages::ConstraintFamily::from(family).into(),
        active,
        violation,
    })
}
