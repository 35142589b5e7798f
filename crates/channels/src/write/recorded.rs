//! Writes the measured channels: markers, bodies, fingertips, findings.

use foxglove::messages::{Log, log};
use inhand_model::{Finding, PerFinger, Position, Recording, Roles, Severity, Status};

use super::{Instant, Stream, Streams, fingertip, fingertips};
use crate::error::ChannelError;
use crate::messages;
use crate::outline::Outline;
use crate::output::{ChannelId, Output};
use crate::take::TakeFile;
use crate::topic;
use crate::wire::{Point, Quaternion, Timestamp, viewer_time};

const WORLD: Option<&str> = Some("world");

pub(super) fn add(
    file: &TakeFile<'_>,
    outline: &Outline,
    output: &mut Output,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    let recording = file.recording;
    if !recording.markers.is_empty() {
        streams.push(Box::new(Markers::new(
            recording,
            topic::RECORDING_MARKERS,
            output,
        )?));
    }
    if !recording.bodies.is_empty() {
        streams.push(Box::new(Bodies::new(
            recording,
            topic::RECORDING_BODIES,
            output,
        )?));
    }
    if let Some(roles) = file.roles {
        streams.push(Box::new(Fingertips {
            channel: output.channel::<messages::Fingertips>(topic::RECORDING_FINGERTIPS, WORLD)?,
            markers: marker_indices(recording, roles),
        }));
    }
    if !outline.findings.is_empty() {
        let channel = output.channel::<Log>(topic::RECORDING_FINDINGS, None)?;
        let unix_nanos = recording.clock.unix_nanos(0);
        for (n, finding) in outline.findings.iter().enumerate() {
            output.message(channel, n, unix_nanos, &log_message(finding, unix_nanos))?;
        }
    }
    Ok(())
}

/// A finding as viewers list it: the place stands where a logger's name would.
fn log_message(finding: &Finding, unix_nanos: u64) -> Log {
    let level = match finding.severity {
        Severity::Info => log::Level::Info,
        Severity::Warning => log::Level::Warning,
    };
    Log {
        timestamp: Some(viewer_time(unix_nanos)),
        level: level.into(),
        message: finding.message.clone(),
        name: finding.place.clone(),
        ..Log::default()
    }
}

/// Which of the take's markers is on which fingertip.
pub(crate) fn marker_indices(recording: &Recording, roles: &Roles) -> PerFinger<Option<usize>> {
    roles.fingers.each_ref().map(|name| {
        let named = recording.marker(name)?;
        (recording.markers.iter()).position(|marker| std::ptr::eq(marker, named))
    })
}

/// NaN stands for "not there" in memory; in a message the field is absent.
fn present(series: Option<&Vec<f64>>, k: usize) -> Option<f64> {
    series
        .map(|values| values[k])
        .filter(|value| !value.is_nan())
}

pub(super) struct Markers {
    channel: ChannelId,
    /// Reused for every sample: the names stay.
    message: messages::Markers,
}

impl Markers {
    pub(super) fn new(
        recording: &Recording,
        topic: &str,
        output: &mut Output,
    ) -> Result<Self, ChannelError> {
        let markers = (recording.markers.iter())
            .map(|marker| messages::Marker {
                name: marker.name.clone(),
                id: marker.id.clone(),
                ..messages::Marker::default()
            })
            .collect();
        Ok(Self {
            channel: output.channel::<messages::Markers>(topic, WORLD)?,
            message: messages::Markers {
                timestamp: None,
                markers,
            },
        })
    }
}

impl Stream for Markers {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        self.message.timestamp = Some(Timestamp::from_unix_nanos(unix_nanos));
        for (message, marker) in self.message.markers.iter_mut().zip(&at.block.markers) {
            message.position_m = marker.track.get(at.row).map(|p| Point::from(p.to_array()));
            message.status = messages::Status::from(marker.track.status(at.row)).into();
            message.quality = present(marker.quality.as_ref(), at.row);
        }
        output.message(self.channel, k, unix_nanos, &self.message)
    }
}

pub(super) struct Bodies {
    channel: ChannelId,
    message: messages::Bodies,
}

impl Bodies {
    pub(super) fn new(
        recording: &Recording,
        topic: &str,
        output: &mut Output,
    ) -> Result<Self, ChannelError> {
        let bodies = (recording.bodies.iter())
            .map(|body| messages::Body {
                name: body.name.clone(),
                ..messages::Body::default()
            })
            .collect();
        Ok(Self {
            channel: output.channel::<messages::Bodies>(topic, WORLD)?,
            message: messages::Bodies {
                timestamp: None,
                bodies,
            },
        })
    }
}

impl Stream for Bodies {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        self.message.timestamp = Some(Timestamp::from_unix_nanos(unix_nanos));
        for (message, body) in self.message.bodies.iter_mut().zip(&at.block.bodies) {
            let pose = body.track.get(at.row);
            message.position_m = pose.map(|pose| Point::from(pose.origin().to_array()));
            message.orientation = pose.map(|pose| Quaternion::from(pose.quaternion_xyzw()));
            message.status = messages::Status::from(body.track.status(at.row)).into();
            message.marker_error_m = present(body.marker_error_m.as_ref(), at.row);
        }
        output.message(self.channel, k, unix_nanos, &self.message)
    }
}

struct Fingertips {
    channel: ChannelId,
    markers: PerFinger<Option<usize>>,
}

impl Stream for Fingertips {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        let message = fingertips(unix_nanos, |finger| {
            match self.markers[finger].and_then(|n| at.block.markers.get(n)) {
                Some(marker) => fingertip(
                    marker.track.get(at.row).map(Position::to_array),
                    marker.track.status(at.row),
                ),
                None => fingertip(None, Status::Missing),
            }
        });
        output.message(self.channel, k, unix_nanos, &message)
    }
}
