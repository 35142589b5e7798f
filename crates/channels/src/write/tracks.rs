//! Recordings, what cleaning changed, and motions, sample by sample.

use foxglove::messages::{Log, log};
use inhand_model::{
    Change, Finding, Frame, Hand, Motion, PoseTrack, Position, Recording, Roles, Severity, Status,
    World,
};

use crate::error::ChannelError;
use crate::messages;
use crate::streams::{Sampling, Streams};
use crate::take::{CleanedTake, marker_indices};
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
