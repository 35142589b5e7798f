//! Samples that segments are cut from: a take without names and clocks.

use std::ops::Range;

use inhand_model::{
    Configuration, Finger, Hand, Motion, Object, PerFinger, PointTrack, Pose, PoseTrack, Position,
    SEGMENT_COORDINATES, Status,
};

/// Place of the object among the parts of a sample: the fingers are 0 to 4.
pub(crate) const OBJECT_PART: usize = Finger::COUNT;

/// Fingertips and object of a take at every sample, hand frame, metres. Those of a motion share its memory.
#[derive(Clone, Debug)]
pub struct SegmentTable {
    fingertips: PerFinger<PointTrack<Hand>>,
    /// `None` where it is not tracked.
    object: Option<PoseTrack<Hand, Object>>,
    /// Samples that segments may be cut from; `None` for all.
    selected: Option<Vec<Range<usize>>>,
}

impl SegmentTable {
    /// The table of a motion.
    pub fn from_motion(motion: &Motion) -> Self {
        Self {
            fingertips: motion.fingertips.clone(),
            object: motion.object.clone(),
            selected: motion.selected.clone(),
        }
    }

    /// A table without samples, with or without the object.
    pub fn new(has_object: bool, selected: Option<Vec<Range<usize>>>) -> Self {
        Self {
            fingertips: PerFinger::from_fn(|_| PointTrack::with_capacity(0)),
            object: has_object.then(|| PoseTrack::with_capacity(0)),
            selected,
        }
    }

    /// Appends a sample: a configuration (metres) and a pose, NaN where missing, and the parts that were measured, as
    /// [`measured_parts`](Self::measured_parts) gives them.
    pub fn push(
        &mut self,
        fingertips_m: &Configuration,
        object: Option<Pose<Hand, Object>>,
        measured: u8,
    ) {
        let status = |part: usize| match measured >> part & 1 {
            1 => Status::Measured,
            _ => Status::Filled,
        };
        for finger in Finger::ALL {
            let [x, y, z] = [0, 1, 2].map(|axis| fingertips_m[3 * finger.index() + axis]);
            let track = &mut self.fingertips[finger];
            track.push(Some(Position::new(x, y, z)), status(finger.index()));
        }
        if let Some(track) = &mut self.object {
            track.push(object, status(OBJECT_PART));
        }
    }

    /// Samples.
    pub fn len(&self) -> usize {
        self.fingertips[Finger::Thumb].len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The configuration at a sample, metres, NaN where a fingertip is missing.
    ///
    /// # Panics
    ///
    /// If there is no such sample.
    pub fn configuration_m(&self, k: usize) -> Configuration {
        let mut configuration = [f64::NAN; SEGMENT_COORDINATES];
        for (finger, track) in self.fingertips.iter() {
            configuration[3 * finger.index()..][..3].copy_from_slice(&track.value(k).to_array());
        }
        configuration
    }

    /// Poses of the object, where it is tracked.
    pub fn object(&self) -> Option<&PoseTrack<Hand, Object>> {
        self.object.as_ref()
    }

    /// Parts of a sample that were measured, a bit each: fingers in their order, then the object.
    pub fn measured_parts(&self, k: usize) -> u8 {
        let parts = (0..=OBJECT_PART).filter(|&part| self.status(part, k) == Status::Measured);
        parts.fold(0, |bits, part| bits | 1 << part)
    }

    /// Samples of a range at which a part was measured, in order.
    pub(crate) fn measured(
        &self,
        range: Range<usize>,
        part: usize,
    ) -> impl Iterator<Item = usize> + Clone + '_ {
        range.filter(move |&k| self.status(part, k) == Status::Measured)
    }

    fn status(&self, part: usize, k: usize) -> Status {
        match (Finger::ALL.get(part), &self.object) {
            (Some(&finger), _) => self.fingertips[finger].status(k),
            (None, Some(object)) => object.status(k),
            (None, None) => Status::Missing,
        }
    }

    /// Samples that segments may be cut from; `None` for all.
    pub fn selected(&self) -> Option<&[Range<usize>]> {
        self.selected.as_deref()
    }

    /// Whether all five fingertips are there at a sample.
    pub fn is_present(&self, k: usize) -> bool {
        Finger::ALL.into_iter().all(|finger| self.has(finger, k))
    }

    /// Whether a fingertip is there at a sample.
    pub(crate) fn has(&self, finger: Finger, k: usize) -> bool {
        self.fingertips[finger].status(k).is_present()
    }

    /// Whether the object is there at a sample.
    pub fn has_object(&self, k: usize) -> bool {
        self.status(OBJECT_PART, k).is_present()
    }

    pub(crate) fn object_at(&self, k: usize) -> Option<Pose<Hand, Object>> {
        self.object.as_ref()?.get(k)
    }
}
