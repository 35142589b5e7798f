//! Sample table that segments are cut from: a take without names and clocks.

use std::ops::Range;

use inhand_model::{Configuration, Finger, Hand, Motion, Object, Pose, SEGMENT_COORDINATES};

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

    pub(crate) fn object_at(&self, k: usize) -> Option<Pose<Hand, Object>> {
        self.object.get(k).copied().filter(|pose| pose.is_finite())
    }
}
