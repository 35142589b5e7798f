//! Trajectories and plans of each method, and how they compare with the recorded motion.

use inhand_model::{Clock, ConstraintFamily, Frame, Hand, Plan, Status};

use crate::error::ChannelError;
use crate::messages;
use crate::streams::Streams;
use crate::take::{EvaluatedMethod, GeneratedMethod, by_start};
use crate::topic::MethodTopics;
use crate::wire::Timestamp;

const HAND: Option<&str> = Some(Hand::NAME);

/// Adds what each method generated.
pub(super) fn add_generated<'a>(
    methods: &[GeneratedMethod<'a>],
    clock: Clock,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    for method in methods {
        let topics = MethodTopics::new(method.name)?;
        let channel = (streams.output).channel::<messages::Fingertips>(&topics.fingertips, HAND)?;
        let planned = method.segments.iter().any(|segment| segment.plan.is_some());
        let segments = by_start(method.segments);
        if planned || !method.unsolved.is_empty() {
            let channel = (streams.output).channel::<messages::Plan>(&topics.plan, HAND)?;
            let message = move |n, plan, start_sample, samples| {
                let unix_nanos = clock.unix_nanos(start_sample);
                (
                    n,
                    unix_nanos,
                    plan_message(plan, start_sample, samples, unix_nanos),
                )
            };
            let mut unsolved: Vec<_> = method.unsolved.iter().collect();
            unsolved.sort_by_key(|plan| plan.start_sample);
            let unsolved = unsolved.into_iter().enumerate();
            streams.listed(
                channel,
                unsolved
                    .map(move |(n, plan)| message(n, plan.plan, plan.start_sample, plan.samples)),
            );
            let solved = segments.clone().into_iter().enumerate();
            streams.listed(
                channel,
                solved.filter_map(move |(n, segment)| {
                    let samples = segment.trajectory.layout().samples;
                    Some(message(n, segment.plan?, segment.start_sample, samples))
                }),
            );
        }
        // Where trajectories overlap, they come in the order in which they start.
        let mut samples: Vec<_> = (segments.into_iter())
            .flat_map(|segment| {
                let start = segment.start_sample;
                (0..segment.trajectory.layout().samples).map(move |t| (start + t, segment))
            })
            .collect();
        samples.sort_by_key(|&(k, _)| k);
        let messages = samples.into_iter().map(move |(k, segment)| {
            let unix_nanos = clock.unix_nanos(k);
            let message = messages::Fingertips::new(unix_nanos, |finger| {
                let position = (segment.trajectory).position(k - segment.start_sample, finger);
                messages::Fingertip::new(Some(position.to_array()), Status::Measured)
            });
            (k, unix_nanos, message)
        });
        streams.listed(channel, messages);
    }
    Ok(())
}

fn plan_message(
    plan: &Plan,
    start_sample: usize,
    samples: usize,
    unix_nanos: u64,
) -> messages::Plan {
    let checks = &plan.checks;
    let families = ConstraintFamily::ALL.into_iter().filter_map(|family| {
        let (active, violation) = (checks.active[family] as u64, checks.violation[family]);
        (active > 0 || violation.is_some()).then(|| messages::FamilyCheck {
            family: messages::ConstraintFamily::from(family).into(),
            active,
            violation,
        })
    });
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
        active_velocity_bounds: checks.active[ConstraintFamily::Velocity] as u64,
        active_activation_bounds: checks.active[ConstraintFamily::Activations] as u64,
        rows_taken_up: checks.rows_taken_up as u64,
        rounds: plan.rounds as u64,
        iterations: plan.iterations as u64,
        families: families.collect(),
        rows: checks.rows as u64,
        hull_distance_m: checks.hull_distance_m,
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

/// Adds errors and contacts of each method.
pub(super) fn add_evaluated<'a>(
    methods: &'a [EvaluatedMethod],
    clock: Clock,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    for method in methods {
        let topics = MethodTopics::new(&method.name)?;
        let mut samples: Vec<_> = method.samples.iter().collect();
        samples.sort_by_key(|judged| judged.sample);
        let at = move |sample| (sample, clock.unix_nanos(sample));
        if samples.iter().any(|judged| judged.error_m.is_some()) {
            let channel =
                (streams.output).channel::<messages::FingerErrors>(&topics.error, HAND)?;
            let messages = samples.clone().into_iter().filter_map(move |judged| {
                let (k, unix_nanos) = at(judged.sample);
                let message = messages::FingerErrors::new(unix_nanos, judged.error_m.as_ref()?);
                Some((k, unix_nanos, message))
            });
            streams.listed(channel, messages);
        }
        if samples.iter().any(|judged| judged.contact.is_some()) {
            let channel = (streams.output).channel::<messages::Contacts>(&topics.contact, HAND)?;
            let messages = samples.into_iter().filter_map(move |judged| {
                let (k, unix_nanos) = at(judged.sample);
                let message = messages::Contacts::new(unix_nanos, judged.contact.as_ref()?);
                Some((k, unix_nanos, message))
            });
            streams.listed(channel, messages);
        }
    }
    Ok(())
}
