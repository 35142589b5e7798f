//! Fingertips from wherever they are known, and their point clouds.

use inhand_model::{Finger, Motion, PerFinger};

use super::cloud::Cloud;
use super::entities::{CONTACT_SPHERE_M, SPHERE_M};
use crate::colour::{FINGER_COLOURS, Rgb};
use crate::error::ChannelError;
use crate::output::{ChannelId, Output};
use crate::take::{ContactSample, EvaluatedSample, GeneratedSegment};
use crate::write::{Instant, Stream, by_start};

/// Where fingertips are at each sample of a take, metres, in one frame.
pub(crate) trait Tips {
    fn position_m(&self, at: &Instant<'_>, finger: Finger) -> Option<[f64; 3]>;
}

/// As measured, frame `world`.
#[derive(Clone)]
pub(crate) struct RecordedTips {
    /// Which of the take's markers.
    pub(crate) markers: PerFinger<Option<usize>>,
}

impl Tips for RecordedTips {
    fn position_m(&self, at: &Instant<'_>, finger: Finger) -> Option<[f64; 3]> {
        let marker = at.block.markers.get(self.markers[finger]?)?;
        Some(marker.track.get(at.row)?.to_array())
    }
}

/// Processed, frame `hand`.
#[derive(Clone)]
pub(crate) struct ProcessedTips<'a> {
    pub(crate) motion: &'a Motion,
}

impl Tips for ProcessedTips<'_> {
    fn position_m(&self, at: &Instant<'_>, finger: Finger) -> Option<[f64; 3]> {
        Some(self.motion.fingertips[finger].get(at.k)?.to_array())
    }
}

/// Generated, frame `hand`; where segments overlap, the one that started last.
#[derive(Clone)]
pub(crate) struct GeneratedTips<'a> {
    segments: Vec<&'a GeneratedSegment<'a>>,
}

impl<'a> GeneratedTips<'a> {
    pub(crate) fn new(segments: &'a [GeneratedSegment<'a>]) -> Self {
        Self {
            segments: by_start(segments),
        }
    }
}

impl Tips for GeneratedTips<'_> {
    fn position_m(&self, at: &Instant<'_>, finger: Finger) -> Option<[f64; 3]> {
        let k = at.k;
        let started = self.segments.partition_point(|s| s.start_sample <= k);
        let segment = self.segments[..started].last()?;
        let t = k - segment.start_sample;
        let inside = t < segment.trajectory.layout().samples;
        inside.then(|| segment.trajectory.position(t, finger).to_array())
    }
}

/// Contacts by sample.
#[derive(Clone)]
pub(crate) struct Contacts<'a> {
    samples: Vec<(usize, &'a ContactSample)>,
}

impl<'a> Contacts<'a> {
    pub(crate) fn new(samples: &'a [EvaluatedSample]) -> Self {
        let mut samples: Vec<_> = (samples.iter())
            .filter_map(|judged| Some((judged.sample, judged.contact.as_ref()?)))
            .collect();
        samples.sort_by_key(|&(sample, _)| sample);
        Self { samples }
    }

    /// Whether nothing is known at any sample.
    pub(crate) fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Whether the finger touches the object; `None` where nobody knows.
    pub(crate) fn in_contact(&self, k: usize, finger: Finger) -> Option<bool> {
        let n = (self.samples)
            .binary_search_by_key(&k, |&(sample, _)| sample)
            .ok()?;
        Some(self.samples[n].1.in_contact[finger])
    }
}

/// What a fingertip's colour says.
#[derive(Clone, Copy)]
pub(crate) enum Paint {
    /// Which finger it is.
    Fingers,
    /// Whose motion it is.
    One(Rgb),
}

impl Paint {
    pub(crate) fn of(self, finger: Finger) -> Rgb {
        match self {
            Paint::Fingers => FINGER_COLOURS[finger],
            Paint::One(colour) => colour,
        }
    }
}

/// What stands for a fingertip in a cloud.
#[derive(Clone, Copy)]
pub(crate) enum Dot {
    Point,
    /// A ball of its size, for viewers that draw no scenes.
    Ball,
}

/// Fingertips as points or balls, numbered from the thumb.
pub(crate) struct FingertipCloud<T> {
    channel: ChannelId,
    stride: usize,
    dot: Dot,
    paint: Paint,
    tips: T,
    cloud: Cloud,
}

impl<T: Tips> FingertipCloud<T> {
    pub(crate) fn new(
        channel: ChannelId,
        frame: &str,
        (stride, dot): (usize, Dot),
        paint: Paint,
        tips: T,
    ) -> Self {
        Self {
            channel,
            stride,
            dot,
            paint,
            tips,
            cloud: Cloud::new(frame, "finger"),
        }
    }
}

impl<T: Tips> Stream for FingertipCloud<T> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        if !k.is_multiple_of(self.stride) {
            return Ok(());
        }
        self.cloud.clear();
        for finger in Finger::ALL {
            if let Some(position_m) = self.tips.position_m(at, finger) {
                let (number, colour) = (finger.index(), self.paint.of(finger));
                match self.dot {
                    Dot::Point => self.cloud.push(position_m, number, colour),
                    Dot::Ball => (self.cloud).push_ball(position_m, SPHERE_M, number, colour),
                }
            }
        }
        output.message(self.channel, k, unix_nanos, self.cloud.message(unix_nanos))
    }
}

/// What touches, as points: brighter than any finger.
const TOUCHING: Rgb = [0xFF, 0xFF, 0xFF];

/// The fingertips that touch the object: balls around them, numbered from the thumb.
pub(crate) struct ContactCloud<'a, T> {
    channel: ChannelId,
    stride: usize,
    tips: T,
    contacts: Contacts<'a>,
    cloud: Cloud,
}

impl<'a, T: Tips> ContactCloud<'a, T> {
    pub(crate) fn new(
        channel: ChannelId,
        frame: &str,
        stride: usize,
        tips: T,
        contacts: Contacts<'a>,
    ) -> Self {
        Self {
            channel,
            stride,
            tips,
            contacts,
            cloud: Cloud::new(frame, "finger"),
        }
    }
}

impl<T: Tips> Stream for ContactCloud<'_, T> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        let &Instant { k, unix_nanos, .. } = at;
        if !k.is_multiple_of(self.stride) {
            return Ok(());
        }
        self.cloud.clear();
        for finger in Finger::ALL {
            if let Some(true) = self.contacts.in_contact(k, finger)
                && let Some(position_m) = self.tips.position_m(at, finger)
            {
                let number = finger.index();
                (self.cloud).push_ball(position_m, CONTACT_SPHERE_M, number, TOUCHING);
            }
        }
        output.message(self.channel, k, unix_nanos, self.cloud.message(unix_nanos))
    }
}
