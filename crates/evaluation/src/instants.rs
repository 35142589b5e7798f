//! Everything about five fingertips at each instant of the test segments, planned or recorded alike.

use inhand_contact::{FingerOffsets, HullProbe, nearest_pair_m};
use inhand_model::{
    Finger, Hand, Object, PerFinger, Pose, Position, SEGMENT_COORDINATES, SegmentLayout,
};
use rayon::prelude::*;

use crate::input::{EvaluationSettings, TestData};

/// The nearest pair of fingertips at an instant: their distance in metres, and which they are.
pub(crate) type NearestPair = (f64, Finger, Finger);

/// Nothing known of any finger.
pub(crate) const UNKNOWN: PerFinger<f64> = PerFinger::new([f64::NAN; Finger::COUNT]);

/// Instants in order; NaN where there is no motion.
#[derive(Default)]
pub(crate) struct Instants {
    /// Signed distance of each fingertip to its training hull, metres.
    pub(crate) hull_distance_m: Vec<PerFinger<f64>>,
    pub(crate) nearest_pair: Vec<NearestPair>,
    /// Signed distance of each pad to the object, metres, NaN where the object is missing; empty
    /// where it has no shape or pose at all.
    pub(crate) distance_m: Vec<PerFinger<f64>>,
}

/// Measures the instants of all segments, each given by its 15 N numbers (t, finger, axis), metres, or `None`
/// without motion. `object_from_hand` has one pose for each instant, or none at all.
pub(crate) fn measure<'v>(
    data: &TestData<'_>,
    settings: &EvaluationSettings,
    object_from_hand: &[Option<Pose<Object, Hand>>],
    values_m: impl Fn(usize) -> Option<&'v [f64]> + Sync,
) -> Instants {
    let offsets = FingerOffsets(settings.finger_offsets_m);
    let samples = data.segments.layout().samples;
    let shape = data.shape.as_ref().filter(|_| !object_from_hand.is_empty());
    // Probes remember where they were, which saves time and changes no result.
    let probes = || (data.demonstrated.hulls.each_ref()).map(HullProbe::new);
    let segment_instants = |probes: &mut PerFinger<HullProbe<'_>>, segment: usize| {
        let mut instants = Instants::default();
        let Some(values_m) = values_m(segment) else {
            instants.hull_distance_m = vec![UNKNOWN; samples];
            instants.nearest_pair = vec![(f64::NAN, Finger::Thumb, Finger::Index); samples];
            instants.distance_m = vec![UNKNOWN; shape.map_or(0, |_| samples)];
            return instants;
        };
        for (t, tips) in fingertips(values_m).enumerate() {
            instants.hull_distance_m.push(PerFinger::from_fn(|finger| {
                probes[finger].distance_m(tips[finger].to_array())
            }));
            instants.nearest_pair.push(nearest_pair_m(&tips));
            if let Some(shape) = shape {
                let object_from_hand = object_from_hand[segment * samples + t];
                instants.distance_m.push(PerFinger::from_fn(|finger| {
                    object_from_hand.map_or(f64::NAN, |object_from_hand| {
                        offsets.pad_distance_m(shape, finger, object_from_hand * tips[finger])
                    })
                }));
            }
        }
        instants
    };
    let segments: Vec<Instants> = (0..data.segments.len())
        .into_par_iter()
        .map_init(probes, segment_instants)
        .collect();
    // A list that grows bit by bit would take up to twice its room.
    let count = segments.len() * samples;
    let mut all = Instants {
        hull_distance_m: Vec::with_capacity(count),
        nearest_pair: Vec::with_capacity(count),
        distance_m: Vec::with_capacity(shape.map_or(0, |_| count)),
    };
    for segment in segments {
        all.hull_distance_m.extend(segment.hull_distance_m);
        all.nearest_pair.extend(segment.nearest_pair);
        all.distance_m.extend(segment.distance_m);
    }
    all
}

/// The five fingertips of each configuration.
pub(crate) fn fingertips(values_m: &[f64]) -> impl Iterator<Item = PerFinger<Position<Hand>>> {
    values_m.chunks_exact(SEGMENT_COORDINATES).map(tips)
}

/// The five fingertips of a configuration.
pub(crate) fn tips(configuration_m: &[f64]) -> PerFinger<Position<Hand>> {
    PerFinger::from_fn(|finger| {
        let row = SegmentLayout::row(0, finger, 0);
        Position::new(
            configuration_m[row],
            configuration_m[row + 1],
            configuration_m[row + 2],
        )
    })
}
