//! Recordings, what cleaning changed, motions and what methods generated, sample by sample.

use foxglove::messages::{Log, log};
use inhand_model::{
    Change, ConstraintFamily, Finding, Frame, Hand, Motion, Plan, PoseTrack, Position, Protocol,
    Recording, Roles, Severity, Status, World,
};

use crate::error::ChannelError;
use crate::messages;
use crate::streams::{Sampling, Streams};
use crate::take::{
    CleanedTake, EvaluatedMethod, GeneratedMethod, GeneratedSegment, marker_indices,
};
use crate::topic;
use crate::wire::{Point, Timestamp, viewer_time};

const WORLD: Option<&str> = Some(World::NAME);
const HAND: Option<&str> = Some(Hand::NAME);

/// Adds the markers and bodies of a recording: of `whole`, or else of the blocks that are written.
pub(super) fn add_entities<'a>(
    recording: &Recording,
    whole: Option<&'a Recording>,
    [markers_topic, bodies_topic]: [&str; 2],
    samples: Sampling,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    if !recording.markers.is_empty() {
        let channel = (streams.output).channel::<messages::Markers>(markers_topic, WORLD)?;
        // Reused for every sample: the names stay.
        let markers = (recording.markers.iter())
            .map(|marker| messages::Marker {
                name: marker.name.clone(),
                id: marker.id.clone(),
                ..messages::Marker::default()
            })
            .collect();
        let mut message = messages::Markers {
            timestamp: None,
            markers,
        };
        streams.add(samples, move |at, output| {
            let Some((recording, row)) = at.recorded(whole) else {
                return Ok(());
            };
            message.timestamp = Some(Timestamp::from_unix_nanos(at.unix_nanos));
            for (message, marker) in message.markers.iter_mut().zip(&recording.markers) {
                message.position_m = marker.track.get(row).map(|p| Point::from(p.to_array()));
                message.status = messages::Status::from(marker.track.status(row)).into();
                message.quality = present(marker.quality.as_ref(), row);
            }
            output.message(channel, at.k, at.unix_nanos, &message)
        });
    }
    if !recording.bodies.is_empty() {
        let channel = (streams.output).channel::<messages::Bodies>(bodies_topic, WORLD)?;
        let bodies = (recording.bodies.iter())
            .map(|body| messages::Body {
                name: body.name.clone(),
                ..messages::Body::default()
            })
            .collect();
        let mut message = messages::Bodies {
            timestamp: None,
            bodies,
        };
        streams.add(samples, move |at, output| {
            let Some((recording, row)) = at.recorded(whole) else {
                return Ok(());
            };
            message.timestamp = Some(Timestamp::from_unix_nanos(at.unix_nanos));
            for (message, body) in message.bodies.iter_mut().zip(&recording.bodies) {
                message.place(&body.track, row);
                message.marker_error_m = present(body.marker_error_m.as_ref(), row);
            }
            output.message(channel, at.k, at.unix_nanos, &message)
        });
    }
    Ok(())
}

/// A number of a series: NaN in memory is an absent field in a message.
fn present(series: Option<&Vec<f64>>, k: usize) -> Option<f64> {
    series
        .map(|values| values[k])
        .filter(|value| !value.is_nan())
}

/// Adds the markers that have the roles of fingertips.
pub(super) fn add_recorded_tips<'a>(
    recording: &Recording,
    whole: Option<&'a Recording>,
    roles: &Roles,
    samples: Sampling,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let markers = marker_indices(recording, roles);
    streams.sampled(topic::RECORDING_FINGERTIPS, WORLD, samples, move |at| {
        let (recording, row) = at.recorded(whole)?;
        Some(messages::Fingertips::new(
            at.unix_nanos,
            |finger| match markers[finger].and_then(|n| recording.markers.get(n)) {
                Some(marker) => messages::Fingertip::new(
                    marker.track.get(row).map(Position::to_array),
                    marker.track.status(row),
                ),
                None => messages::Fingertip::new(None, Status::Missing),
            },
        ))
    })
}

/// Writes findings as viewers list them: the place is where a logger's name would be.
pub(super) fn write_findings(
    findings: &[Finding],
    unix_nanos: u64,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    if findings.is_empty() {
        return Ok(());
    }
    let channel = (streams.output).channel::<Log>(topic::RECORDING_FINDINGS, None)?;
    for (n, finding) in findings.iter().enumerate() {
        let level = match finding.severity {
            Severity::Info => log::Level::Info,
            Severity::Warning => log::Level::Warning,
        };
        let message = Log {
            timestamp: Some(viewer_time(unix_nanos)),
            level: level.into(),
            message: finding.message.clone(),
            name: finding.place.clone(),
            ..Log::default()
        };
        (streams.output).message(channel, n, unix_nanos, &message)?;
    }
    Ok(())
}

/// Adds what cleaning changed. Changes count samples of the recording as measured.
pub(super) fn add_changes<'a>(
    cleaned: &CleanedTake<'a>,
    measured: Sampling,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    if cleaned.changes.is_empty() {
        return Ok(());
    }
    let clock = measured.clock;
    let mut changes: Vec<(usize, &Change)> = cleaned.changes.iter().enumerate().collect();
    // By time; `sequence` keeps the order of the steps.
    changes.sort_by_key(|(n, change)| (change.samples.start, *n));
    let message = move |(n, change): (usize, &Change)| {
        let start = clock.unix_nanos(change.samples.start);
        let last = change.samples.end.saturating_sub(1);
        let end = clock.unix_nanos(last.max(change.samples.start));
        let message = messages::Change {
            timestamp: Some(Timestamp::from_unix_nanos(start)),
            end: Some(Timestamp::from_unix_nanos(end)),
            kind: change.kind.name().to_owned(),
            entity: change.entity.clone(),
            first_sample: change.samples.start as u64,
            samples: change.samples.len() as u64,
            message: change.message.clone(),
        };
        (n, start, message)
    };
    let channel = (streams.output).channel::<messages::Change>(topic::CLEANED_CHANGES, None)?;
    streams.listed(channel, changes.into_iter().map(message));
    Ok(())
}

/// Adds a take in the hand's frame: fingertips, object, and the hand itself in the world.
pub(super) fn add_motion<'a>(
    motion: &'a Motion,
    samples: Sampling,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    streams.sampled(topic::PROCESSED_FINGERTIPS, HAND, samples, |at| {
        Some(messages::Fingertips::new(at.unix_nanos, |finger| {
            let track = &motion.fingertips[finger];
            let position_m = track.get(at.k).map(Position::to_array);
            messages::Fingertip::new(position_m, track.status(at.k))
        }))
    })?;
    if let Some(object) = &motion.object {
        add_pose(topic::PROCESSED_OBJECT, object, samples, streams)?;
    }
    add_pose(topic::PROCESSED_HAND, &motion.hand, samples, streams)
}

/// Adds the pose of a frame as an `inhand.Bodies` of one.
fn add_pose<'a, To: Frame, From: Frame>(
    topic: &str,
    track: &'a PoseTrack<To, From>,
    samples: Sampling,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    streams.sampled(topic, Some(To::NAME), samples, |at| {
        let mut body = messages::Body {
            name: From::NAME.to_owned(),
            ..messages::Body::default()
        };
        body.place(track, at.k);
        Some(messages::Bodies {
            timestamp: Some(Timestamp::from_unix_nanos(at.unix_nanos)),
            bodies: vec![body],
        })
    })
}

/// Adds what each method generated under a protocol.
pub(super) fn add_generated(
    protocol: Protocol,
    methods: &[GeneratedMethod<'_>],
    samples: Sampling,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    for (place, method) in methods.iter().enumerate() {
        let topic = |leaf| topic::named(topic::generated(protocol), method.name, leaf);
        let channel =
            (streams.output).channel::<messages::Fingertips>(&topic("fingertips"), HAND)?;
        if method.plans {
            let channel = (streams.output).channel::<messages::Plan>(&topic("plan"), HAND)?;
            // Plans without a trajectory are counted by themselves.
            let mut counts = [0, 0];
            streams.add(samples, move |at, output| {
                let segments = at.made().and_then(|made| made.generated(protocol, place));
                for segment in segments.map_or(&[][..], |segments| segments.starting(at.k)) {
                    let count = &mut counts[usize::from(segment.trajectory.is_some())];
                    if let Some(plan) = segment.plan {
                        let message = plan_message(segment, plan, at.unix_nanos);
                        output.message(channel, *count, at.unix_nanos, &message)?;
                    }
                    *count += 1;
                }
                Ok(())
            });
        }
        // Where trajectories overlap, they come in the order in which they start.
        streams.add(samples, move |at, output| {
            let segments = at.made().and_then(|made| made.generated(protocol, place));
            for (t, trajectory) in segments.into_iter().flat_map(|segments| segments.at(at.k)) {
                let message = messages::Fingertips::new(at.unix_nanos, |finger| {
                    let position = trajectory.position(t, finger);
                    messages::Fingertip::new(Some(position.to_array()), Status::Measured)
                });
                output.message(channel, at.k, at.unix_nanos, &message)?;
            }
            Ok(())
        });
    }
    Ok(())
}

fn plan_message(segment: &GeneratedSegment<'_>, plan: &Plan, unix_nanos: u64) -> messages::Plan {
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
        start_sample: segment.start_sample as u64,
        samples: segment.samples as u64,
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
pub(super) fn add_evaluated(
    methods: &[EvaluatedMethod],
    samples: Sampling,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    for (place, method) in methods.iter().enumerate() {
        let topic = |leaf| topic::named(topic::EVALUATION, &method.name, leaf);
        if method.samples.iter().any(|judged| judged.error_m.is_some()) {
            let channel =
                (streams.output).channel::<messages::FingerErrors>(&topic("error"), HAND)?;
            streams.add(samples, move |at, output| {
                let judged = at
                    .made()
                    .map_or(&[][..], |made| made.evaluated(place, at.k));
                for error_m in judged.iter().filter_map(|judged| judged.error_m.as_ref()) {
                    let message = messages::FingerErrors::new(at.unix_nanos, error_m);
                    output.message(channel, at.k, at.unix_nanos, &message)?;
                }
                Ok(())
            });
        }
        if method.samples.iter().any(|judged| judged.contact.is_some()) {
            let channel =
                (streams.output).channel::<messages::Contacts>(&topic("contact"), HAND)?;
            streams.add(samples, move |at, output| {
                let judged = at
                    .made()
                    .map_or(&[][..], |made| made.evaluated(place, at.k));
                for contact in judged.iter().filter_map(|judged| judged.contact.as_ref()) {
                    let message = messages::Contacts::new(at.unix_nanos, contact);
                    output.message(channel, at.k, at.unix_nanos, &message)?;
                }
                Ok(())
            });
        }
    }
    Ok(())
}
