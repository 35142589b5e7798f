//! Tracks from messages, one message a sample.

use foxglove::messages::{Log, log};
use inhand_model::{
    Body, Clock, Finding, Finger, Frame, Hand, Marker, PointTrack, Pose, PoseTrack, Position,
    Severity, Status, Track, TrackedBody, World,
};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use prost::Message;

use crate::error::ChannelError;
use crate::messages;
use crate::metadata::{BodyFacts, MarkerFacts};
use crate::wire;

/// Rotations off unit length by more than this are no rotations; sources round to six decimals.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Messages of a channel read so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counter(pub(super) usize);

/// The message at hand and what it has to agree with.
pub(super) struct Channel<'a> {
    pub(super) file: &'a str,
    pub(super) topic: &'static str,
    pub(super) clock: Clock,
    pub(super) samples: usize,
    /// Whether messages of some samples may be lost.
    pub(super) lossy: bool,
    pub(super) log_time: u64,
}

impl Channel<'_> {
    pub(super) fn error(&self, read: Counter, expected: String, found: String) -> ChannelError {
        ChannelError::Message {
            file: self.file.to_owned(),
            topic: self.topic.to_owned(),
            message: read.0,
            expected,
            found,
        }
    }

    pub(super) fn decode<M: Message + Default>(
        &self,
        read: Counter,
        data: &[u8],
    ) -> Result<M, ChannelError> {
        M::decode(data).map_err(|error| {
            self.error(
                read,
                format!("{} bytes of protobuf", data.len()),
                error.to_string(),
            )
        })
    }

    /// Samples before this message's own whose messages are lost. Nothing else than the length that the
    /// take states bounds them, so what a damaged file may claim is limited.
    fn lost_before(&self, read: Counter) -> usize {
        if !self.lossy {
            return 0;
        }
        let since_start = self.log_time.saturating_sub(self.clock.start_unix_nanos());
        let sample = self.clock.nearest_sample(since_start as f64 / 1e9);
        let off = self.clock.unix_nanos(sample).abs_diff(self.log_time);
        let fits = off <= super::TIME_TOLERANCE_NANOS && sample < self.samples.min(MOST_LOSSY);
        if fits {
            sample.saturating_sub(read.0)
        } else {
            0
        }
    }

    /// The next message is that of the next sample.
    fn next_sample<M: Message + Default>(
        &self,
        read: Counter,
        data: &[u8],
    ) -> Result<M, ChannelError> {
        if read.0 >= self.samples {
            return Err(self.error(
                read,
                format!("{} messages, one for each sample", self.samples),
                "more".to_owned(),
            ));
        }
        let time = self.clock.unix_nanos(read.0);
        if self.log_time.abs_diff(time) > super::TIME_TOLERANCE_NANOS {
            return Err(self.error(
                read,
                format!("the time of sample {}, {time} ns", read.0),
                format!("{} ns", self.log_time),
            ));
        }
        self.decode(read, data)
    }

    fn count(&self, read: Counter, expected: usize, found: usize) -> Result<(), ChannelError> {
        if expected == found {
            return Ok(());
        }
        let entries = |n| format!("{n} entries");
        Err(self.error(read, entries(expected), entries(found)))
    }

    /// A status that agrees with whether there is a value.
    fn status(&self, read: Counter, status: i32, present: bool) -> Result<Status, ChannelError> {
        let status_or_none = messages::Status::to_model(status);
        match status_or_none {
            Some(status) if status.is_present() == present => Ok(status),
            _ => Err(self.error(
                read,
                "a status of measured or filled with a position, or missing without".to_owned(),
                format!(
                    "status {status} {} a position",
                    if present { "with" } else { "without" }
                ),
            )),
        }
    }

    fn finite(&self, read: Counter, numbers: &[f64]) -> Result<(), ChannelError> {
        if numbers.iter().all(|number| number.is_finite()) {
            return Ok(());
        }
        Err(self.error(
            read,
            "finite coordinates".to_owned(),
            format!("{numbers:?}"),
        ))
    }

    fn push_point<F: Frame>(
        &self,
        read: Counter,
        track: &mut PointTrack<F>,
        position_m: Option<wire::Point>,
        status: i32,
    ) -> Result<(), ChannelError> {
        let status = self.status(read, status, position_m.is_some())?;
        let position = position_m.map(wire::Point::to_array);
        if let Some(position) = &position {
            self.finite(read, position)?;
        }
        track.push(position.map(Position::from), status);
        Ok(())
    }

    fn push_pose<To: Frame, From: Frame>(
        &self,
        read: Counter,
        track: &mut PoseTrack<To, From>,
        body: &BodySample,
    ) -> Result<(), ChannelError> {
        let parts = body.position_m.zip(body.orientation);
        let status = self.status(read, body.status, parts.is_some())?;
        let Some((position, rotation)) = parts else {
            track.push(None, status);
            return Ok(());
        };
        let wire::Quaternion { x, y, z, w } = rotation;
        self.finite(read, &[position.x, position.y, position.z, x, y, z, w])?;
        let quaternion = Quaternion::new(w, x, y, z);
        let norm = quaternion.norm();
        if (norm - 1.0).abs() > UNIT_TOLERANCE {
            return Err(self.error(
                read,
                "a quaternion of unit length".to_owned(),
                format!("one of length {norm}"),
            ));
        }
        // Normalising again would change its last bits.
        let rotation = UnitQuaternion::new_unchecked(quaternion);
        let translation = Translation3::new(position.x, position.y, position.z);
        let pose = Pose::new(Isometry3::from_parts(translation, rotation));
        track.push(Some(pose), status);
        Ok(())
    }
}

/// Longest take of which samples may be lost: three days at 100 Hz would be 26 million.
const MOST_LOSSY: usize = 1 << 24;

/// A track with the source's own number for each sample, where it has one.
type WithSeries<T> = (Track<T>, Option<Vec<f64>>);

/// An `inhand.Markers` without the names, which do not change: reading them anew for every sample
/// would cost more than the rest.
#[derive(Clone, PartialEq, Message)]
struct MarkerSamples {
    #[prost(message, repeated, tag = "2")]
    markers: Vec<MarkerSample>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct MarkerSample {
    #[prost(message, optional, tag = "3")]
    position_m: Option<wire::Point>,
    #[prost(int32, tag = "4")]
    status: i32,
    #[prost(double, optional, tag = "5")]
    quality: Option<f64>,
}

/// An `inhand.Bodies` without the names.
#[derive(Clone, PartialEq, Message)]
struct BodySamples {
    #[prost(message, repeated, tag = "2")]
    bodies: Vec<BodySample>,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct BodySample {
    #[prost(message, optional, tag = "2")]
    position_m: Option<wire::Point>,
    #[prost(message, optional, tag = "3")]
    orientation: Option<wire::Quaternion>,
    #[prost(int32, tag = "4")]
    status: i32,
    #[prost(double, optional, tag = "5")]
    marker_error_m: Option<f64>,
}

/// Position tracks and qualities of all markers.
pub(super) struct MarkerTracks {
    tracks: Vec<WithSeries<Position<World>>>,
    pub(super) read: Counter,
}

impl MarkerTracks {
    pub(super) fn new(markers: &[MarkerFacts]) -> Self {
        let tracks = (markers.iter())
            .map(|marker| (PointTrack::missing(0), marker.has_quality.then(Vec::new)));
        Self {
            tracks: tracks.collect(),
            read: Counter::default(),
        }
    }

    pub(super) fn message(
        &mut self,
        channel: &Channel,
        markers: &[MarkerFacts],
        data: &[u8],
    ) -> Result<(), ChannelError> {
        self.miss(channel.lost_before(self.read));
        let message: MarkerSamples = channel.next_sample(self.read, data)?;
        channel.count(self.read, markers.len(), message.markers.len())?;
        for ((track, quality), marker) in self.tracks.iter_mut().zip(&message.markers) {
            channel.push_point(self.read, track, marker.position_m, marker.status)?;
            if let Some(quality) = quality {
                quality.push(marker.quality.unwrap_or(f64::NAN));
            }
        }
        self.read.0 += 1;
        Ok(())
    }

    /// Samples without a message.
    pub(super) fn miss(&mut self, samples: usize) {
        for _ in 0..samples {
            for (track, quality) in &mut self.tracks {
                track.push(None, Status::Missing);
                quality
                    .iter_mut()
                    .for_each(|quality| quality.push(f64::NAN));
            }
        }
        self.read.0 += samples;
    }

    pub(super) fn into_markers(self, facts: Vec<MarkerFacts>) -> Vec<Marker> {
        (facts.into_iter().zip(self.tracks))
            .map(|(facts, (track, quality))| Marker {
                name: facts.name,
                id: facts.id,
                kind: facts.kind,
                track,
                quality,
            })
            .collect()
    }
}

/// Pose tracks and marker errors of all bodies.
pub(super) struct BodyTracks {
    tracks: Vec<WithSeries<Pose<World, Body>>>,
    pub(super) read: Counter,
}

impl BodyTracks {
    pub(super) fn new(bodies: &[BodyFacts]) -> Self {
        let tracks = (bodies.iter())
            .map(|body| (PoseTrack::missing(0), body.has_marker_error.then(Vec::new)));
        Self {
            tracks: tracks.collect(),
            read: Counter::default(),
        }
    }

    pub(super) fn message(
        &mut self,
        channel: &Channel,
        bodies: &[BodyFacts],
        data: &[u8],
    ) -> Result<(), ChannelError> {
        self.miss(channel.lost_before(self.read));
        let message: BodySamples = channel.next_sample(self.read, data)?;
        channel.count(self.read, bodies.len(), message.bodies.len())?;
        for ((track, error_m), body) in self.tracks.iter_mut().zip(&message.bodies) {
            channel.push_pose(self.read, track, body)?;
            if let Some(error_m) = error_m {
                error_m.push(body.marker_error_m.unwrap_or(f64::NAN));
            }
        }
        self.read.0 += 1;
        Ok(())
    }

    /// Samples without a message.
    pub(super) fn miss(&mut self, samples: usize) {
        for _ in 0..samples {
            for (track, error_m) in &mut self.tracks {
                track.push(None, Status::Missing);
                error_m
                    .iter_mut()
                    .for_each(|error_m| error_m.push(f64::NAN));
            }
        }
        self.read.0 += samples;
    }

    pub(super) fn into_bodies(self, facts: Vec<BodyFacts>) -> Vec<TrackedBody> {
        (facts.into_iter().zip(self.tracks))
            .map(|(facts, (track, marker_error_m))| TrackedBody {
                name: facts.name,
                id: facts.id,
                kind: facts.kind,
                track,
                marker_error_m,
            })
            .collect()
    }
}

/// Fingertip tracks in the hand's frame.
pub(super) struct FingertipTracks {
    pub(super) tracks: [PointTrack<Hand>; Finger::COUNT],
    pub(super) read: Counter,
}

impl Default for FingertipTracks {
    fn default() -> Self {
        Self {
            tracks: Finger::ALL.map(|_| PointTrack::missing(0)),
            read: Counter::default(),
        }
    }
}

impl FingertipTracks {
    /// Samples without a message.
    pub(super) fn miss(&mut self, samples: usize) {
        for track in &mut self.tracks {
            (0..samples).for_each(|_| track.push(None, Status::Missing));
        }
        self.read.0 += samples;
    }

    pub(super) fn message(&mut self, channel: &Channel, data: &[u8]) -> Result<(), ChannelError> {
        self.miss(channel.lost_before(self.read));
        let message: messages::Fingertips = channel.next_sample(self.read, data)?;
        for (track, tip) in self.tracks.iter_mut().zip(message.tips().into_array()) {
            let tip = tip.unwrap_or_default();
            channel.push_point(self.read, track, tip.position_m, tip.status)?;
        }
        self.read.0 += 1;
        Ok(())
    }
}

/// The track of a channel whose `inhand.Bodies` hold one body.
pub(super) struct PoseFromBodies<To: Frame, From: Frame> {
    pub(super) track: PoseTrack<To, From>,
    pub(super) read: Counter,
}

impl<To: Frame, From: Frame> Default for PoseFromBodies<To, From> {
    fn default() -> Self {
        Self {
            track: PoseTrack::missing(0),
            read: Counter::default(),
        }
    }
}

impl<To: Frame, From: Frame> PoseFromBodies<To, From> {
    /// Samples without a message.
    pub(super) fn miss(&mut self, samples: usize) {
        (0..samples).for_each(|_| self.track.push(None, Status::Missing));
        self.read.0 += samples;
    }

    pub(super) fn message(&mut self, channel: &Channel, data: &[u8]) -> Result<(), ChannelError> {
        self.miss(channel.lost_before(self.read));
        let message: BodySamples = channel.next_sample(self.read, data)?;
        channel.count(self.read, 1, message.bodies.len())?;
        for body in &message.bodies {
            channel.push_pose(self.read, &mut self.track, body)?;
        }
        self.read.0 += 1;
        Ok(())
    }
}

/// A finding from the message that stands for it.
pub(super) fn finding(
    channel: &Channel,
    read: &mut Counter,
    data: &[u8],
) -> Result<Finding, ChannelError> {
    let log: Log = channel.decode(*read, data)?;
    read.0 += 1;
    Ok(Finding {
        severity: if log.level() == log::Level::Info {
            Severity::Info
        } else {
            Severity::Warning
        },
        place: log.name,
        message: log.message,
    })
}
