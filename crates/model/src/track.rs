//! Samples over time, each with what is known of it: measured, filled or missing.

use std::ops::Range;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::frame::{Frame, Pose, Position};
use crate::names::named;

named! {
    /// What is known of one sample.
    #[derive(Default, PartialOrd, Ord, Hash)]
    pub enum Status {
        /// As the cameras saw it (or computed from samples that were all measured).
        Measured = "measured",
        /// Interpolated, or computed from a sample that was.
        Filled = "filled",
        /// Not there.
        #[default]
        Missing = "missing",
    }
}

impl Status {
    /// What is known of a value computed from samples of both statuses: the lesser knowledge.
    #[must_use]
    pub fn and(self, other: Status) -> Status {
        self.max(other)
    }

    /// Measured or filled.
    pub fn is_present(self) -> bool {
        self != Status::Missing
    }
}

/// A value that a [`Track`] can hold; NaN stands in memory where it is missing, so that a missing
/// value used by mistake cannot pass for a number.
pub trait Sample: Copy {
    /// The stand-in for a missing value.
    fn missing() -> Self;
    /// Whether every component is a finite number.
    fn is_finite(self) -> bool;
}

impl<F: Frame> Sample for Position<F> {
    fn missing() -> Self {
        Self::new(f64::NAN, f64::NAN, f64::NAN)
    }

    fn is_finite(self) -> bool {
        Position::is_finite(self)
    }
}

impl<To: Frame, From: Frame> Sample for Pose<To, From> {
    fn missing() -> Self {
        let rotation = Quaternion::new(f64::NAN, f64::NAN, f64::NAN, f64::NAN);
        Self::new(Isometry3::from_parts(
            Translation3::from(Vector3::repeat(f64::NAN)),
            UnitQuaternion::new_unchecked(rotation),
        ))
    }

    fn is_finite(self) -> bool {
        Pose::is_finite(self)
    }
}

/// How many samples of a track have each status.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrackCounts {
    /// Measured samples.
    pub measured: usize,
    /// Filled samples.
    pub filled: usize,
    /// Missing samples.
    pub missing: usize,
}

/// One quantity at every sample of a take. A sample is present if and only if its value is finite.
#[derive(Clone, Debug)]
pub struct Track<T> {
    values: Vec<T>,
    status: Vec<Status>,
}

/// Positions over time in frame `F`.
pub type PointTrack<F> = Track<Position<F>>;
/// Poses over time.
pub type PoseTrack<To, From> = Track<Pose<To, From>>;

impl<T: Sample> Track<T> {
    /// A track of `len` missing samples.
    pub fn missing(len: usize) -> Self {
        Self {
            values: vec![T::missing(); len],
            status: vec![Status::Missing; len],
        }
    }

    /// An empty track with room for `capacity` samples.
    pub fn with_capacity(capacity: usize) -> Self {
        Self {
            values: Vec::with_capacity(capacity),
            status: Vec::with_capacity(capacity),
        }
    }

    /// A track from measured samples; `None` and values that are not finite are missing.
    pub fn from_measured(samples: impl IntoIterator<Item = Option<T>>) -> Self {
        samples
            .into_iter()
            .map(|sample| (sample, Status::Measured))
            .collect()
    }

    /// Appends a sample. `None`, a value that is not finite and [`Status::Missing`] all append a
    /// missing sample.
    pub fn push(&mut self, value: Option<T>, status: Status) {
        let (value, status) = normalised(value, status);
        self.values.push(value);
        self.status.push(status);
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there is no sample at all.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The value at sample `k`, unless it is missing or outside the track.
    pub fn get(&self, k: usize) -> Option<T> {
        (self.status(k).is_present()).then(|| self.values[k])
    }

    /// The status of sample `k`; outside the track it is missing.
    pub fn status(&self, k: usize) -> Status {
        self.status.get(k).copied().unwrap_or(Status::Missing)
    }

    /// Statuses of all samples.
    pub fn statuses(&self) -> &[Status] {
        &self.status
    }

    /// Values of all samples, NaN where missing.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// Replaces sample `k`, by the rules of [`Track::push`].
    ///
    /// # Panics
    ///
    /// If `k` is outside the track.
    pub fn set(&mut self, k: usize, value: Option<T>, status: Status) {
        (self.values[k], self.status[k]) = normalised(value, status);
    }

    /// Values in order, `None` where missing.
    pub fn iter(&self) -> impl Iterator<Item = Option<T>> {
        let samples = self.values.iter().zip(&self.status);
        samples.map(|(&value, status)| status.is_present().then_some(value))
    }

    /// A track of the same length, each present value changed, statuses kept.
    pub fn map<U: Sample>(&self, mut change: impl FnMut(T) -> U) -> Track<U> {
        let samples = self.iter().zip(&self.status);
        samples
            .map(|(value, &status)| (value.map(&mut change), status))
            .collect()
    }

    /// The samples `range` as a track of its own.
    ///
    /// # Panics
    ///
    /// If the range goes outside the track.
    #[must_use]
    pub fn slice(&self, range: Range<usize>) -> Self {
        Self {
            values: self.values[range.clone()].to_vec(),
            status: self.status[range].to_vec(),
        }
    }

    /// How many samples have each status.
    pub fn counts(&self) -> TrackCounts {
        let mut counts = TrackCounts::default();
        for status in &self.status {
            match status {
                Status::Measured => counts.measured += 1,
                Status::Filled => counts.filled += 1,
                Status::Missing => counts.missing += 1,
            }
        }
        counts
    }

    /// Runs of missing samples as `start..end`, in order.
    pub fn gaps(&self) -> Vec<Range<usize>> {
        runs(0..self.len(), |k| !self.status[k].is_present())
    }

    /// Runs of present samples as `start..end`, in order.
    pub fn present(&self) -> Vec<Range<usize>> {
        runs(0..self.len(), |k| self.status[k].is_present())
    }
}

/// Samples with their statuses, by the rules of [`Track::push`].
impl<T: Sample> FromIterator<(Option<T>, Status)> for Track<T> {
    fn from_iter<I: IntoIterator<Item = (Option<T>, Status)>>(samples: I) -> Self {
        let samples = samples.into_iter();
        let mut track = Self::with_capacity(samples.size_hint().0);
        samples.for_each(|(value, status)| track.push(value, status));
        track
    }
}

/// Maximal runs of samples among `range` for which `holds` is true, in order.
///
/// ```
/// use inhand_model::runs;
///
/// assert_eq!(runs(0..6, |k| k != 2 && k != 3), [0..2, 4..6]);
/// ```
pub fn runs(range: Range<usize>, holds: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut start = None;
    for k in range.clone() {
        match (holds(k), start) {
            (true, None) => start = Some(k),
            (false, Some(from)) => {
                runs.push(from..k);
                start = None;
            }
            _ => {}
        }
    }
    runs.extend(start.map(|from| from..range.end));
    runs
}

fn normalised<T: Sample>(value: Option<T>, status: Status) -> (T, Status) {
    match value {
        Some(value) if status.is_present() && value.is_finite() => (value, status),
        _ => (T::missing(), Status::Missing),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::World;

    #[test]
    fn missing_and_nan_are_the_same() {
        let present = Position::<World>::new(1.0, 2.0, 3.0);
        let nan = Position::<World>::new(f64::NAN, 0.0, 0.0);
        let mut track = PointTrack::from_measured([Some(present), None, Some(nan)]);
        assert_eq!(
            track.statuses(),
            [Status::Measured, Status::Missing, Status::Missing]
        );
        assert_eq!(track.get(0), Some(present));
        assert_eq!(
            (track.get(1), track.get(2), track.get(99)),
            (None, None, None)
        );
        track.set(1, Some(present), Status::Filled);
        assert_eq!(
            track.counts(),
            TrackCounts {
                measured: 1,
                filled: 1,
                missing: 1
            }
        );
        assert_eq!(track.gaps(), vec![2..3]);
        track.set(0, None, Status::Measured);
        assert_eq!(track.gaps(), vec![0..1, 2..3]);
    }
}
