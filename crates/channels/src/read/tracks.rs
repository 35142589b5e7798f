//! Tracks from messages, one message a sample.

use std::fmt::Display;

use inhand_model::{Clock, Frame, Pose, Position, Sample, Status, Track};
use mcap::records::MessageHeader;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use prost::{DecodeError, Message};

use crate::error::ChannelError;
use crate::messages;
use crate::metadata::RecordingFacts;
use crate::wire;

/// Tolerance between the time of a message and that of its sample. Both are rounded to nanoseconds, and a
/// cut counts them from another sample; samples are much farther apart.
pub(crate) const TIME_TOLERANCE_NANOS: u64 = 1000;

/// Rotations off unit length by more than this are no rotations; sources round to six decimals.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Longest take of which samples may be lost: three days at 100 Hz would be 26 million.
const MOST_LOSSY: usize = 1 << 24;

/// The message at hand and what it has to agree with.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) file: &'a str,
    pub(super) topic: &'a str,
    /// Number of the message in errors.
    pub(super) number: usize,
    pub(super) clock: Clock,
    pub(super) samples: usize,
    /// Whether messages of some samples may be lost.
    pub(super) lossy: bool,
    pub(super) log_time: u64,
}

impl<'a> Place<'a> {
    /// A message of a take with these facts.
    pub(super) fn new(
        file: &'a str,
        topic: &'a str,
        facts: &RecordingFacts,
        header: &MessageHeader,
    ) -> Self {
        Self {
            file,
            topic,
            number: 0,
            clock: facts.clock,
            samples: facts.samples,
            lossy: facts.lossy,
            log_time: header.log_time,
        }
    }

    pub(super) fn error(&self, expected: impl Display, found: impl Display) -> ChannelError {
        ChannelError::message(self.file, self.topic, self.number, expected, found)
    }

    pub(super) fn decoded<M>(&self, message: Result<M, DecodeError>) -> Result<M, ChannelError> {
        message.map_err(|error| self.error("a message in protobuf", error))
    }

    /// The sample whose time is the nearest, and whether that is the time of the message.
    pub(super) fn nearest_sample(&self) -> (usize, bool) {
        let since_start = self.log_time.saturating_sub(self.clock.start_unix_nanos());
        let sample = self.clock.nearest_sample(since_start as f64 / 1e9);
        (sample, sample < self.samples && self.is_time_of(sample))
    }

    fn is_time_of(&self, sample: usize) -> bool {
        self.clock.unix_nanos(sample).abs_diff(self.log_time) <= TIME_TOLERANCE_NANOS
    }

    /// Samples before this message's own whose messages are lost. Nothing else than the length that the
    /// take states bounds them, so what a damaged file may claim is limited.
    fn lost_after(&self, read: usize) -> usize {
        match self.nearest_sample() {
            (sample, true) if self.lossy && sample < MOST_LOSSY => sample.saturating_sub(read),
            _ => 0,
        }
    }

    pub(super) fn finite(&self, numbers: &[f64]) -> Result<(), ChannelError> {
        if numbers.iter().all(|number| number.is_finite()) {
            return Ok(());
        }
        Err(self.error("finite coordinates", format!("{numbers:?}")))
    }
}

/// One marker, body or fingertip of a message.
#[derive(Clone, Copy, Default)]
pub(super) struct Entry {
    pub(super) position_m: Option<wire::Point>,
    pub(super) orientation: Option<wire::Quaternion>,
    pub(super) status: i32,
    /// The source's own number for the sample.
    pub(super) quality: Option<f64>,
}

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

type Entries = Result<Vec<Entry>, DecodeError>;

/// Entries of an `inhand.Markers`.
pub(super) fn markers(data: &[u8]) -> Entries {
    let entry = |marker: MarkerSample| Entry {
        position_m: marker.position_m,
        orientation: None,
        status: marker.status,
        quality: marker.quality,
    };
    MarkerSamples::decode(data).map(|message| message.markers.into_iter().map(entry).collect())
}

/// Entries of an `inhand.Bodies`.
pub(super) fn bodies(data: &[u8]) -> Entries {
    let entry = |body: BodySample| Entry {
        position_m: body.position_m,
        orientation: body.orientation,
        status: body.status,
        quality: body.marker_error_m,
    };
    BodySamples::decode(data).map(|message| message.bodies.into_iter().map(entry).collect())
}

/// Entries of an `inhand.Fingertips`.
pub(super) fn fingertips(data: &[u8]) -> Entries {
    let entry = |tip: Option<messages::Fingertip>| {
        let messages::Fingertip { position_m, status } = tip.unwrap_or_default();
        Entry {
            position_m,
            status,
            ..Entry::default()
        }
    };
    messages::Fingertips::decode(data).map(|message| message.tips().map(entry).into_array().into())
}

/// A value that an entry may hold.
pub(super) trait FromEntry: Sample {
    /// The value of an entry, if it has one.
    fn from_entry(entry: &Entry, at: &Place<'_>) -> Result<Option<Self>, ChannelError>;
}

impl<F: Frame> FromEntry for Position<F> {
    fn from_entry(entry: &Entry, at: &Place<'_>) -> Result<Option<Self>, ChannelError> {
        let Some(position_m) = entry.position_m.map(wire::Point::to_array) else {
            return Ok(None);
        };
        at.finite(&position_m)?;
        Ok(Some(Position::from(position_m)))
    }
}

impl<To: Frame, From: Frame> FromEntry for Pose<To, From> {
    fn from_entry(entry: &Entry, at: &Place<'_>) -> Result<Option<Self>, ChannelError> {
        let Some((position, rotation)) = entry.position_m.zip(entry.orientation) else {
            return Ok(None);
        };
        let wire::Quaternion { x, y, z, w } = rotation;
        at.finite(&[position.x, position.y, position.z, x, y, z, w])?;
        let quaternion = Quaternion::new(w, x, y, z);
        let norm = quaternion.norm();
        if (norm - 1.0).abs() > UNIT_TOLERANCE {
            return Err(at.error(
                "a quaternion of unit length",
                format!("one of length {norm}"),
            ));
        }
        // Normalising again would change its last bits.
        let rotation = UnitQuaternion::new_unchecked(quaternion);
        let translation = Translation3::new(position.x, position.y, position.z);
        let isometry = Isometry3::from_parts(translation, rotation);
        Ok(Some(Pose::new(isometry)))
    }
}

/// A track with the source's own number for each sample, where it has one.
type WithQuality<V> = (Track<V>, Option<Vec<f64>>);

/// Tracks of the entries of a channel's messages, as far as they have been read.
pub(super) struct TrackReader<V> {
    topic: &'static str,
    entries: fn(&[u8]) -> Entries,
    tracks: Vec<WithQuality<V>>,
    /// Samples so far.
    pub(super) read: usize,
}

impl<V: FromEntry> TrackReader<V> {
    /// Tracks that have qualities or not.
    pub(super) fn new(
        topic: &'static str,
        entries: fn(&[u8]) -> Entries,
        with_quality: impl IntoIterator<Item = bool>,
    ) -> Self {
        let track = |quality: bool| (Track::missing(0), quality.then(Vec::new));
        Self {
            topic,
            entries,
            tracks: with_quality.into_iter().map(track).collect(),
            read: 0,
        }
    }

    /// Reads the message of the next sample.
    pub(super) fn message(&mut self, mut at: Place<'_>, data: &[u8]) -> Result<(), ChannelError> {
        self.miss(at.lost_after(self.read));
        at.number = self.read;
        if self.read >= at.samples {
            let expected = format!("{} messages, one for each sample", at.samples);
            return Err(at.error(expected, "more"));
        }
        if !at.is_time_of(self.read) {
            let time = at.clock.unix_nanos(self.read);
            let expected = format!("the time of sample {}, {time} ns", self.read);
            return Err(at.error(expected, format!("{} ns", at.log_time)));
        }
        let entries = at.decoded((self.entries)(data))?;
        if entries.len() != self.tracks.len() {
            let count = |n| format!("{n} entries");
            return Err(at.error(count(self.tracks.len()), count(entries.len())));
        }
        for ((track, quality), entry) in self.tracks.iter_mut().zip(&entries) {
            let value = V::from_entry(entry, &at)?;
            let present = value.is_some();
            let status = messages::Status::to_model(entry.status)
                .filter(|status| status.is_present() == present);
            let status = status.ok_or_else(|| {
                let with = if present { "with" } else { "without" };
                at.error(
                    "a status of measured or filled with a position, or missing without",
                    format!("status {} {with} a position", entry.status),
                )
            })?;
            track.push(value, status);
            if let Some(quality) = quality {
                quality.push(entry.quality.unwrap_or(f64::NAN));
            }
        }
        self.read += 1;
        Ok(())
    }

    /// Ends the tracks, some of whose messages may be lost, after so many samples.
    pub(super) fn end_at(&mut self, samples: usize) {
        self.miss(samples - self.read);
    }

    /// Samples without a message.
    fn miss(&mut self, samples: usize) {
        for (track, quality) in &mut self.tracks {
            for _ in 0..samples {
                track.push(None, Status::Missing);
            }
            if let Some(quality) = quality {
                quality.resize(quality.len() + samples, f64::NAN);
            }
        }
        self.read += samples;
    }

    /// The tracks of so many entries without qualities.
    pub(super) fn into_array<const N: usize>(
        self,
        samples: usize,
        file: &str,
    ) -> Result<[Track<V>; N], ChannelError> {
        let mut tracks = self.into_tracks(samples, file)?.into_iter();
        let track = |_| {
            tracks
                .next()
                .map_or_else(|| Track::missing(samples), |(track, _)| track)
        };
        Ok(std::array::from_fn(track))
    }

    /// The tracks, each with its qualities, once there is a message for each sample. What has no track needs
    /// no message.
    pub(super) fn into_tracks(
        self,
        samples: usize,
        file: &str,
    ) -> Result<Vec<WithQuality<V>>, ChannelError> {
        if self.read == samples || self.tracks.is_empty() {
            return Ok(self.tracks);
        }
        let expected = format!("one message for each of the {samples} samples");
        let found = format!("{} messages", self.read);
        Err(ChannelError::message(
            file, self.topic, self.read, expected, found,
        ))
    }
}
