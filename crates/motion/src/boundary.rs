//! Boundary conditions of segments: positions and velocities where a segment begins and ends.

use std::ops::Range;

use inhand_model::{
    Configuration, EndConditions, Finger, Hand, Object, ObjectEnds, Pose, SEGMENT_COORDINATES,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::table::{OBJECT_PART, SegmentSamples};

/// Samples that boundary conditions are taken from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Boundary {
    /// First sample of the segment.
    pub(crate) first: usize,
    /// Last sample of the segment.
    pub(crate) last: usize,
    /// Samples of a line or a difference.
    pub(crate) samples: usize,
    pub(crate) rate_hz: f64,
}

impl Boundary {
    /// Recorded positions, and the velocity over the samples outside the segment.
    pub(crate) fn differences(self, table: &impl SegmentSamples) -> EndConditions {
        let Self { first, last, .. } = self;
        let per_second = self.rate_hz / self.samples as f64;
        let velocity = |from: usize, to: usize| -> Configuration {
            let [from_m, to_m] = [from, to].map(|k| table.fingertips_m(k));
            std::array::from_fn(|i| (to_m[i] - from_m[i]) * per_second)
        };
        EndConditions {
            first_m: table.fingertips_m(first),
            last_m: table.fingertips_m(last),
            first_velocity_m_s: velocity(first - self.samples, first),
            last_velocity_m_s: velocity(last, last + self.samples),
            object: object_ends(table.object(first), table.object(last)),
        }
    }

    /// Values and slopes of least-squares lines over measured samples: the last ones up to the segment's first,
    /// and those from its last on.
    pub(crate) fn lines(self, table: &impl SegmentSamples) -> EndConditions {
        let [before, after] = self.windows();
        let side = |window: &Range<usize>, at: usize| {
            let lines: [_; SEGMENT_COORDINATES] = std::array::from_fn(|i| {
                let measured = measured(table, window.clone(), i / 3);
                let point = |k: usize| (self.time_s(k, at), table.fingertips_m(k)[i]);
                line(measured.map(point))
            });
            [0, 1].map(|part| lines.map(|line| line[part]))
        };
        let [first_m, first_velocity_m_s] = side(&before, self.first);
        let [last_m, last_velocity_m_s] = side(&after, self.last);
        let object = |window, at| self.object_on_line(table, window, at);
        EndConditions {
            first_m,
            last_m,
            first_velocity_m_s,
            last_velocity_m_s,
            object: object_ends(object(before, self.first), object(after, self.last)),
        }
    }

    /// Whether there are measured samples enough for the lines of every fingertip and, where asked for, of the
    /// object: half of them.
    pub(crate) fn has_lines(self, table: &impl SegmentSamples, object: bool) -> bool {
        let parts = 0..Finger::COUNT + usize::from(object);
        let windows = self.windows();
        parts.into_iter().all(|part| {
            let enough = |window: &Range<usize>| self.is_enough(table, window.clone(), part);
            windows.iter().all(enough)
        })
    }

    fn windows(self) -> [Range<usize>; 2] {
        let Self {
            first,
            last,
            samples,
            ..
        } = self;
        [first + 1 - samples..first + 1, last..last + samples]
    }

    fn is_enough(self, table: &impl SegmentSamples, window: Range<usize>, part: usize) -> bool {
        measured(table, window, part).count() >= self.samples.div_ceil(2)
    }

    fn time_s(self, k: usize, at: usize) -> f64 {
        (k as f64 - at as f64) / self.rate_hz
    }

    /// The object's pose at a sample, by lines through its positions and through rotation vectors from the measured
    /// pose nearest to it.
    fn object_on_line(
        self,
        table: &impl SegmentSamples,
        window: Range<usize>,
        at: usize,
    ) -> Option<Pose<Hand, Object>> {
        if !self.is_enough(table, window.clone(), OBJECT_PART) {
            return None;
        }
        let poses = || {
            let measured = measured(table, window.clone(), OBJECT_PART);
            measured.filter_map(|k| Some((k, table.object(k)?)))
        };
        let (_, nearest) = poses().min_by_key(|(k, _)| k.abs_diff(at))?;
        let back = nearest.isometry().rotation.inverse();
        let at_zero = |coordinate: &dyn Fn(Pose<Hand, Object>) -> f64| {
            line(poses().map(|(k, pose)| (self.time_s(k, at), coordinate(pose))))[0]
        };
        let position = Vector3::from_fn(|i, _| at_zero(&|pose| pose.origin().to_array()[i]));
        let turned = Vector3::from_fn(|i, _| {
            at_zero(&|pose| (pose.isometry().rotation * back).scaled_axis()[i])
        });
        let rotation = UnitQuaternion::from_scaled_axis(turned) * nearest.isometry().rotation;
        let translation = Translation3::from(position);
        Some(Pose::new(Isometry3::from_parts(translation, rotation)))
    }
}

/// Samples of a range at which a part was measured, in order.
fn measured(
    table: &impl SegmentSamples,
    range: Range<usize>,
    part: usize,
) -> impl Iterator<Item = usize> + Clone {
    range.filter(move |&k| table.is_measured(k, part))
}

fn object_ends(
    first: Option<Pose<Hand, Object>>,
    last: Option<Pose<Hand, Object>>,
) -> Option<ObjectEnds> {
    let (first, last) = first.zip(last)?;
    Some(ObjectEnds { first, last })
}

/// Value at time 0 and slope of the least-squares line through points (time, value), two at least. Sums run in the
/// order of the points.
fn line(points: impl Iterator<Item = (f64, f64)> + Clone) -> [f64; 2] {
    let (mut count, mut times, mut values) = (0.0, 0.0, 0.0);
    for (time, value) in points.clone() {
        count += 1.0;
        times += time;
        values += value;
    }
    let (mean_time, mean_value) = (times / count, values / count);
    let (mut products, mut squares) = (0.0, 0.0);
    for (time, value) in points {
        products += (time - mean_time) * (value - mean_value);
        squares += (time - mean_time) * (time - mean_time);
    }
    let slope = products / squares;
    [mean_value - slope * mean_time, slope]
}
