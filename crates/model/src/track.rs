//! Samples over time, each with what is known of it: measured, filled or missing.

use std::marker::PhantomData;
use std::ops::Range;

use nalgebra::{Isometry3, Point3};
use serde::{Deserialize, Serialize};

use crate::frame::{Body, Frame, Pose, Position};
use crate::names::named;

mod values;

use self::values::Values;

pub use self::values::Number;

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

/// A value that a [`Track`] can hold.
pub trait Sample: Copy {
    /// The value without its frames.
    type Number: Number;
    /// The value without its frames.
    fn number(self) -> Self::Number;
    /// The value in its frames.
    fn of_number(number: Self::Number) -> Self;
}

impl<F: Frame> Sample for Position<F> {
    type Number = Point3<f64>;

    fn number(self) -> Point3<f64> {
        self.point()
    }

    fn of_number(point: Point3<f64>) -> Self {
        Self::from_point(point)
    }
}

impl<To: Frame, From: Frame> Sample for Pose<To, From> {
    type Number = Isometry3<f64>;

    fn number(self) -> Isometry3<f64> {
        self.isometry()
    }

    fn of_number(isometry: Isometry3<f64>) -> Self {
        Self::new(isometry)
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
///
/// A copy takes memory for its statuses and for what is changed in it. Values of all tracks together take some 100 MB
/// of memory; those beyond are kept in a temporary file.
#[derive(Clone, Debug)]
pub struct Track<T> {
    values: Values,
    status: Vec<Status>,
    kind: PhantomData<T>,
}

/// Positions over time in frame `F`.
pub type PointTrack<F> = Track<Position<F>>;
/// Poses over time.
pub type PoseTrack<To, From> = Track<Pose<To, From>>;

impl<To: Frame> PoseTrack<To, Body> {
    /// Poses in the frame of the role that a body plays, which are the same numbers.
    pub fn in_role<F: Frame>(self) -> PoseTrack<To, F> {
        Track {
            values: self.values,
            status: self.status,
            kind: PhantomData,
        }
    }
}

impl<T: Sample> Track<T> {
    /// A track of `len` missing samples.
    pub fn missing(len: usize) -> Self {
        (0..len).map(|_| (None, Status::Missing)).collect()
    }

    /// An empty track with room for `capacity` samples.
    pub fn with_capacity(capacity: usize) -> Self {
        Self {
            values: Values::default(),
            status: Vec::with_capacity(capacity),
            kind: PhantomData,
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
        let (number, status) = normalised(value, status);
        self.values.push(number);
        self.status.push(status);
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.status.len()
    }

    /// Whether there is no sample at all.
    pub fn is_empty(&self) -> bool {
        self.status.is_empty()
    }

    /// The value at sample `k`, unless it is missing or outside the track.
    pub fn get(&self, k: usize) -> Option<T> {
        (self.status(k).is_present()).then(|| T::of_number(self.values.get(k)))
    }

    /// The status of sample `k`; outside the track it is missing.
    pub fn status(&self, k: usize) -> Status {
        self.status.get(k).copied().unwrap_or(Status::Missing)
    }

    /// Statuses of all samples.
    pub fn statuses(&self) -> &[Status] {
        &self.status
    }

    /// The value at sample `k`, NaN where it is missing.
    ///
    /// # Panics
    ///
    /// If `k` is outside the track.
    pub fn value(&self, k: usize) -> T {
        assert!(k < self.len(), "sample {k} is in the track");
        T::of_number(self.values.get(k))
    }

    /// Values of all samples, NaN where missing.
    pub fn values(&self) -> impl ExactSizeIterator<Item = T> + Clone {
        (0..self.len()).map(|k| self.value(k))
    }

    /// Replaces sample `k`, by the rules of [`Track::push`].
    ///
    /// # Panics
    ///
    /// If `k` is outside the track.
    pub fn set(&mut self, k: usize, value: Option<T>, status: Status) {
        let (number, status) = normalised(value, status);
        self.values.set(k, number);
        self.status[k] = status;
    }

    /// Values in order, `None` where missing.
    pub fn iter(&self) -> impl Iterator<Item = Option<T>> {
        (0..self.len()).map(|k| self.get(k))
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
        assert!(range.end <= self.len(), "a part of a track lies inside it");
        range.map(|k| (self.get(k), self.status[k])).collect()
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

fn normalised<T: Sample>(value: Option<T>, status: Status) -> (T::Number, Status) {
    match value.map(T::number) {
        Some(number) if status.is_present() && number.is_finite() => (number, status),
        _ => (T::Number::missing(), Status::Missing),
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
