//! Samples that segments are cut from: a motion, or a table of one without names and clocks.

use std::ops::Range;

use inhand_model::{
    Configuration, Finger, Hand, Motion, Object, Pose, SEGMENT_COORDINATES, Status,
};

/// Place of the object among the parts of a sample: the fingers are 0 to 4.
pub(crate) const OBJECT_PART: usize = Finger::COUNT;

/// Samples of a take that segments are cut from, in the frame `hand`.
pub trait SegmentSamples: Sync {
    /// Number of samples.
    fn samples(&self) -> usize;

    /// Samples that segments may be cut from; `None` for all.
    fn selected(&self) -> Option<&[Range<usize>]>;

    /// Fingertips at a sample, NaN where missing, metres.
    fn fingertips_m(&self, k: usize) -> Configuration;

    /// Pose of the object at a sample.
    fn object(&self, k: usize) -> Option<Pose<Hand, Object>>;

    /// Whether a part was measured at a sample: fingers in their order, then the object.
    fn is_measured(&self, k: usize, part: usize) -> bool;

    /// Whether all five fingertips are there at a sample.
    fn is_present(&self, k: usize) -> bool {
        self.fingertips_m(k).iter().all(|v| !v.is_nan())
    }
}

impl SegmentSamples for Motion {
    fn samples(&self) -> usize {
        self.len()
    }

    fn selected(&self) -> Option<&[Range<usize>]> {
        self.selected.as_deref()
    }

    fn fingertips_m(&self, k: usize) -> Configuration {
        let mut configuration = [f64::NAN; SEGMENT_COORDINATES];
        for (finger, track) in self.fingertips.iter() {
            if let Some(position) = track.get(k) {
                configuration[finger.index() * 3..][..3].copy_from_slice(&position.to_array());
            }
        }
        configuration
    }

    fn object(&self, k: usize) -> Option<Pose<Hand, Object>> {
        self.object.as_ref()?.get(k).filter(|pose| pose.is_finite())
    }

    fn is_measured(&self, k: usize, part: usize) -> bool {
        let status = match Finger::ALL.get(part) {
            Some(&finger) => self.fingertips[finger].status(k),
            None => (self.object.as_ref()).map_or(Status::Missing, |object| object.status(k)),
        };
        status == Status::Measured
    }
}

/// Fingertips and object of a take at every sample, hand frame, metres, as long runs of learning store them.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentTable {
    /// Configurations, NaN where a fingertip is missing.
    fingertips_m: Vec<Configuration>,
    /// Poses of the object, NaN where missing; empty where it is not tracked.
    object: Vec<Pose<Hand, Object>>,
    /// Parts of each sample that were measured, a bit each: fingers in their order, then the object.
    measured: Vec<u8>,
    /// Samples that segments may be cut from; `None` for all.
    selected: Option<Vec<Range<usize>>>,
}

impl SegmentTable {
    /// The table of a motion.
    pub fn from_motion(motion: &Motion) -> Self {
        let object = (motion.object.as_ref()).map_or_else(Vec::new, |o| o.values().to_vec());
        let measured = (0..motion.len()).map(|k| {
            let parts = (0..=OBJECT_PART).filter(|&part| motion.is_measured(k, part));
            parts.fold(0, |bits, part| bits | 1 << part)
        });
        Self {
            fingertips_m: (0..motion.len()).map(|k| motion.fingertips_m(k)).collect(),
            object,
            measured: measured.collect(),
            selected: motion.selected.clone(),
        }
    }

    /// A table from its parts; `object` has as many poses as there are configurations, or none, and `measured`
    /// as many. What is selected lies inside them, in order.
    pub fn new(
        fingertips_m: Vec<Configuration>,
        object: Vec<Pose<Hand, Object>>,
        measured: Vec<u8>,
        selected: Option<Vec<Range<usize>>>,
    ) -> Option<Self> {
        let in_order = selected
            .iter()
            .flatten()
            .is_sorted_by(|a, b| a.end <= b.start);
        let inside = (selected.iter().flatten())
            .all(|range| range.start < range.end && range.end <= fingertips_m.len());
        let lengths = (object.is_empty() || object.len() == fingertips_m.len())
            && measured.len() == fingertips_m.len();
        (lengths && in_order && inside).then_some(Self {
            fingertips_m,
            object,
            measured,
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

    /// Parts of each sample that were measured, a bit each: fingers in their order, then the object.
    pub fn measured_parts(&self) -> &[u8] {
        &self.measured
    }

    /// Samples that segments may be cut from; `None` for all.
    pub fn selected(&self) -> Option<&[Range<usize>]> {
        self.selected.as_deref()
    }
}

impl SegmentSamples for SegmentTable {
    fn samples(&self) -> usize {
        self.len()
    }

    fn selected(&self) -> Option<&[Range<usize>]> {
        self.selected()
    }

    fn fingertips_m(&self, k: usize) -> Configuration {
        self.fingertips_m[k]
    }

    fn object(&self, k: usize) -> Option<Pose<Hand, Object>> {
        self.object.get(k).copied().filter(|pose| pose.is_finite())
    }

    fn is_measured(&self, k: usize, part: usize) -> bool {
        self.measured[k] >> part & 1 == 1
    }
}
