//! Everything about five fingertips at each instant of one segment, planned or recorded alike.

use inhand_contact::{FingerOffsets, HullProbe, nearest_pair_m};
use inhand_model::{
    Finger, Hand, Object, PerFinger, Pose, Position, SEGMENT_COORDINATES, SegmentLayout,
};

use crate::input::{EvaluationSettings, TestData};

/// The nearest pair of fingertips at an instant: their distance in metres, and which they are.
pub(crate) type NearestPair = (f64, Finger, Finger);

/// The instants of one segment, in order.
pub(crate) struct SegmentInstants {
    /// Signed distance of each fingertip to its training hull, metres.
    pub(crate) hull_distance_m: Vec<PerFinger<f64>>,
    pub(crate) nearest_pair: Vec<NearestPair>,
    /// Signed distance of each pad to the object, metres, NaN where the object is missing; empty
    /// where it has no shape or pose at all.
    pub(crate) distance_m: Vec<PerFinger<f64>>,
}

/// Probes of the training hulls. They remember where they were, which saves time and changes no
/// result: keep them from segment to segment.
pub(crate) type HullProbes<'h> = PerFinger<HullProbe<'h>>;

pub(crate) fn hull_probes<'h>(data: &TestData<'h>) -> HullProbes<'h> {
    (data.demonstrated.hulls.each_ref()).map(HullProbe::new)
}

/// Looks at the instants of a segment given by its 15 N numbers (t, finger, axis), metres.
/// `object_from_hand` has one pose for each instant, or none at all.
pub(crate) fn look(
    data: &TestData<'_>,
    settings: &EvaluationSettings,
    probes: &mut HullProbes<'_>,
    values_m: &[f64],
    object_from_hand: &[Option<Pose<Object, Hand>>],
) -> SegmentInstants {
    let offsets = FingerOffsets(settings.finger_offsets_m);
    let samples = values_m.len() / SEGMENT_COORDINATES;
    let mut instants = SegmentInstants {
        hull_distance_m: Vec::with_capacity(samples),
        nearest_pair: Vec::with_capacity(samples),
        distance_m: Vec::with_capacity(object_from_hand.len()),
    };
    for (t, configuration_m) in values_m.chunks_exact(SEGMENT_COORDINATES).enumerate() {
        let tips = tips(configuration_m);
        instants.hull_distance_m.push(PerFinger::from_fn(|finger| {
            probes[finger].distance_m(tips[finger].to_array())
        }));
        instants.nearest_pair.push(nearest_pair_m(&tips));
        if let (Some(shape), Some(object_from_hand)) = (&data.shape, object_from_hand.get(t)) {
            instants.distance_m.push(PerFinger::from_fn(|finger| {
                object_from_hand.map_or(f64::NAN, |object_from_hand| {
                    offsets.pad_distance_m(shape, finger, object_from_hand * tips[finger])
                })
            }));
        }
    }
    instants
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
