//! What was measured: markers, bodies, fingertips, findings.

use foxglove::messages::{Log, log};
use inhand_model::{Finding, Marker, PerFinger, Position, Recording, Severity, Status};

use super::{Stream, Streams, fingertip, fingertips};
use crate::error::ChannelError;
use crate::messages;
use crate::output::{ChannelId, Output};
use crate::take::TakeFile;
use crate::topic;
use crate::wire::{Point, Quaternion, Timestamp, viewer_time};

const WORLD: Option<&str> = Some("world");

pub(super) fn add<'a>(
    file: &TakeFile<'a>,
    output: &mut Output,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let recording = file.recording;
    if !recording.markers.is_empty() {
        streams.push(Box::new(Markers::new(recording, output)?));
    }
    if !recording.bodies.is_empty() {
        streams.push(Box::new(Bodies::new(recording, output)?));
    }
    if let Some(roles) = file.roles {
        streams.push(Box::new(Fingertips {
            channel: output.channel::<messages::Fingertips>(topic::RECORDING_FINGERTIPS, WORLD)?,
            markers: roles.fingers.each_ref().map(|name| recording.marker(name)),
        }));
    }
    if !recording.findings.is_empty() {
        let channel = output.channel::<Log>(topic::RECORDING_FINDINGS, None)?;
        let unix_nanos = recording.clock.unix_nanos(0);
        for (n, finding) in recording.findings.iter().enumerate() {
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

/// NaN stands for "not there" in memory; in a message the field is absent.
fn present(series: Option<&Vec<f64>>, k: usize) -> Option<f64> {
    series
        .map(|values| values[k])
        .filter(|value| !value.is_nan())
}

struct Markers<'a> {
    channel: ChannelId,
    recording: &'a Recording,
    /// Reused for every sample: the names stay.
    message: messages::Markers,
}

impl<'a> Markers<'a> {
    fn new(recording: &'a Recording, output: &mut Output) -> Result<Self, ChannelError> {
        let markers = (recording.markers.iter())
            .map(|marker| messages::Marker {
                name: marker.name.clone(),
                id: marker.id.clone(),
                ..messages::Marker::default()
            })
            .collect();
        Ok(Self {
            channel: output.channel::<messages::Markers>(topic::RECORDING_MARKERS, WORLD)?,
            recording,
            message: messages::Markers {
                timestamp: None,
                markers,
            },
        })
    }
}

impl Stream for Markers<'_> {
    fn sample(
        &mut self,
        k: usize,
        unix_nanos: u64,
        output: &mut Output,
    ) -> Result<(), ChannelError> {
        self.message.timestamp = Some(Timestamp::from_unix_nanos(unix_nanos));
        for (message, marker) in self.message.markers.iter_mut().zip(&self.recording.markers) {
            message.position_m = marker.track.get(k).map(|p| Point::from(p.to_array()));
            message.status = messages::Status::from(marker.track.status(k)).into();
            message.quality = present(marker.quality.as_ref(), k);
        }
        output.message(self.channel, k, unix_nanos, &self.message)
    }
}

struct Bodies<'a> {
    channel: ChannelId,
    recording: &'a Recording,
    message: messages::Bodies,
}

impl<'a> Bodies<'a> {
    fn new(recording: &'a Recording, output: &mut Output) -> Result<Self, ChannelError> {
        let bodies = (recording.bodies.iter())
            .map(|body| messages::Body {
                name: body.name.clone(),
                ..messages::Body::default()
            })
            .collect();
        Ok(Self {
            channel: output.channel::<messages::Bodies>(topic::RECORDING_BODIES, WORLD)?,
            recording,
            message: messages::Bodies {
                timestamp: None,
                bodies,
            },
        })
    }
}

impl Stream for Bodies<'_> {
    fn sample(
        &mut self,
        k: usize,
        unix_nanos: u64,
        output: &mut Output,
    ) -> Result<(), ChannelError> {
        self.message.timestamp = Some(Timestamp::from_unix_nanos(unix_nanos));
        for (message, body) in self.message.bodies.iter_mut().zip(&self.recording.bodies) {
            let pose = body.track.get(k);
            message.position_m = pose.map(|pose| Point::from(pose.origin().to_array()));
            message.orientation = pose.map(|pose| Quaternion::from(pose.quaternion_xyzw()));
            message.status = messages::Status::from(body.track.status(k)).into();
            message.marker_error_m = present(body.marker_error_m.as_ref(), k);
        }
        output.message(self.channel, k, unix_nanos, &self.message)
    }
}

struct Fingertips<'a> {
    channel: ChannelId,
    markers: PerFinger<Option<&'a Marker>>,
}

impl Stream for Fingertips<'_> {
    fn sample(
        &mut self,
        k: usize,
        unix_nanos: u64,
        output: &mut Output,
    ) -> Result<(), ChannelError> {
        let message = fingertips(unix_nanos, |finger| match self.markers[finger] {
            Some(marker) => fingertip(
                marker.track.get(k).map(Position::to_array),
                marker.track.status(k),
            ),
            None => fingertip(None, Status::Missing),
        });
        output.message(self.channel, k, unix_nanos, &message)
    }
}
