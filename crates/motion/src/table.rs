//! Sample table that segments are cut from: a take without names and clocks.

use std::f64::consts::TAU;
use std::ops::Range;

use inhand_model::{
    Configuration, EndConditions, Finger, Hand, Motion, OBJECT_COORDINATES, Object, ObjectEnds,
    Pose, ROTATION_LEVER_M, SEGMENT_COORDINATES, SegmentLayout,
};
use nalgebra::{Unit, UnitQuaternion, Vector3};

/// A turn below which its axis is rounding, radians: unit quaternions carry some 1e-16.
const SMALLEST_TURN_RAD: f64 = 1e-9;

/// Fingertips and object of a take at every sample, hand frame, metres: time-major, so that a
/// segment is one piece of it.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentTable {
    /// Configurations, NaN where a fingertip is missing.
    fingertips_m: Vec<Configuration>,
    /// Poses of the object, NaN where missing; empty where it is not tracked.
    object: Vec<Pose<Hand, Object>>,
    /// Samples that segments may be cut from; `None` for all.
    selected: Option<Vec<Range<usize>>>,
}

impl SegmentTable {
    /// The table of a motion.
    pub fn from_motion(motion: &Motion) -> Self {
        let fingertips_m = (0..motion.len())
            .map(|k| {
                let mut configuration = [f64::NAN; SEGMENT_COORDINATES];
                for finger in Finger::ALL {
                    if let Some(position) = motion.fingertips[finger].get(k) {
                        configuration[finger.index() * 3..][..3]
                            .copy_from_slice(&position.to_array());
                    }
                }
                configuration
            })
            .collect();
        let object = (motion.object.as_ref()).map_or_else(Vec::new, |o| o.values().to_vec());
        Self {
            fingertips_m,
            object,
            selected: motion.selected.clone(),
        }
    }

    /// A table from its parts; `object` has as many poses as there are configurations, or none.
    /// What is selected lies inside them, in order.
    pub fn new(
        fingertips_m: Vec<Configuration>,
        object: Vec<Pose<Hand, Object>>,
        selected: Option<Vec<Range<usize>>>,
    ) -> Option<Self> {
        let in_order = selected
            .iter()
            .flatten()
            .is_sorted_by(|a, b| a.end <= b.start);
        let inside = (selected.iter().flatten())
            .all(|range| range.start < range.end && range.end <= fingertips_m.len());
        let lengths = object.is_empty() || object.len() == fingertips_m.len();
        (lengths && in_order && inside).then_some(Self {
            fingertips_m,
            object,
            selected,
        })
    }

    /// Samples.
    pub fn len(&self) -> usize {
        self.fingertips_m.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.fingertips_m.is_empty()
    }

    /// Configurations, NaN where a fingertip is missing, metres.
    pub fn fingertips_m(&self) -> &[Configuration] {
        &self.fingertips_m
    }

    /// Poses of the object, NaN where missing; empty where it is not tracked.
    pub fn object(&self) -> &[Pose<Hand, Object>] {
        &self.object
    }

    /// Samples that segments may be cut from; `None` for all.
    pub fn selected(&self) -> Option<&[Range<usize>]> {
        self.selected.as_deref()
    }

    /// Whether all five fingertips are there at a sample.
    pub fn is_present(&self, k: usize) -> bool {
        self.fingertips_m[k].iter().all(|v| !v.is_nan())
    }

    /// Whether the object is there at a sample.
    pub fn has_object(&self, k: usize) -> bool {
        self.object_at(k).is_some()
    }

    fn object_at(&self, k: usize) -> Option<Pose<Hand, Object>> {
        self.object.get(k).copied().filter(|pose| pose.is_finite())
    }

    pub(crate) fn fill(&self, layout: SegmentLayout, start: usize, column_m: &mut [f64]) {
        let samples = start..start + layout.samples;
        let (fingers, object_m) = column_m.split_at_mut(layout.finger_rows());
        fingers.copy_from_slice(self.fingertips_m[samples.clone()].as_flattened());
        if layout.object {
            fill_object(object_m, self.object.get(samples).unwrap_or_default());
        }
    }

    pub(crate) fn ends(&self, layout: SegmentLayout, margin: usize, start: usize) -> EndConditions {
        let last = start + layout.samples - 1;
        let velocity = |from: usize, to: usize| -> Configuration {
            let per_second = layout.rate_hz / margin as f64;
            std::array::from_fn(|i| {
                (self.fingertips_m[to][i] - self.fingertips_m[from][i]) * per_second
            })
        };
        let object = match (self.object_at(start), self.object_at(last)) {
            (Some(first), Some(last)) => Some(ObjectEnds { first, last }),
            _ => None,
        };
        EndConditions {
            first_m: self.fingertips_m[start],
            last_m: self.fingertips_m[last],
            first_velocity_m_s: velocity(start - margin, start),
            last_velocity_m_s: velocity(last, last + margin),
            object,
        }
    }
}

/// Fills the object's rows of a column (6 N, time-major) from its poses at the N samples, all of them
/// present: position in the hand's frame, metres, and the rotation vector since the first sample
/// (hand frame) times [`ROTATION_LEVER_M`].
///
/// A rotation has many vectors, whole turns apart along its axis. The first sample's is zero, and
/// each further sample takes the one nearest to the sample before, so that a steady turn is a
/// straight line beyond half a turn too. Near a whole turn the axis of what is left is lost in noise
/// and the vector with it, as for any three numbers that stand for a rotation.
fn fill_object(rows_m: &mut [f64], poses: &[Pose<Hand, Object>]) {
    let Some(first) = poses.first() else {
        return;
    };
    let back = first.isometry().rotation.inverse();
    let mut turned = Vector3::zeros();
    for (k, (row, pose)) in (rows_m
        .as_chunks_mut::<OBJECT_COORDINATES>()
        .0
        .iter_mut()
        .zip(poses))
    .enumerate()
    {
        let [x, y, z] = pose.origin().to_array();
        if k > 0 {
            turned = nearest_rotation_vector(pose.isometry().rotation * back, turned);
        }
        let [a, b, c]: [f64; 3] = (turned * ROTATION_LEVER_M).into();
        *row = [x, y, z, a, b, c];
    }
}

/// The rotation vector of a rotation that is nearest to `previous`, radians: of
/// `axis * (angle + 2 pi k)` over whole k.
fn nearest_rotation_vector(rotation: UnitQuaternion<f64>, previous: Vector3<f64>) -> Vector3<f64> {
    let shortest = rotation.scaled_axis();
    let angle = shortest.norm();
    // No turn, or whole turns, have any axis: the nearest vector lies along the previous one.
    let axis = Unit::try_new(shortest, SMALLEST_TURN_RAD)
        .or_else(|| Unit::try_new(previous, SMALLEST_TURN_RAD));
    let Some(axis) = axis else {
        return shortest;
    };
    // Half a turn from nowhere is as near either way and stays as it is: ties go to even.
    let turns = ((axis.dot(&previous) - angle) / TAU).round_ties_even();
    axis.into_inner() * (angle + TAU * turns)
}
