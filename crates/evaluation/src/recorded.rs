//! Measures of the recorded motion itself, computed once for all methods.

use inhand_model::{Hand, Object, PerFinger, Pose, Status};
use rayon::prelude::*;

use crate::input::{EvaluationSettings, TestData};
use crate::instants::{NearestPair, SegmentInstants, hull_probes, look};

/// The recorded motion at every instant of the test segments: segment after segment, sample after
/// sample, so that sample `t` of segment `s` has the index `s * N + t`.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Whether each fingertip was filled there rather than measured.
    pub filled: Vec<PerFinger<bool>>,
    /// Whether the object's pose was filled there; `false` where it is missing.
    pub object_filled: Vec<bool>,
    /// Signed distance of each pad to the object's surface, metres, NaN where the object is missing;
    /// `None` where no take has an object, or its shape is not known.
    pub distance_m: Option<Vec<PerFinger<f64>>>,
    /// Signed distance of each fingertip to its training hull, metres, negative inside.
    pub hull_distance_m: Vec<PerFinger<f64>>,
    /// Distance between the nearest two fingertips, metres, and which they are.
    pub nearest_pair: Vec<NearestPair>,
    /// Where the object is, for planned fingertips and objects; empty where no take has one.
    pub(crate) object_from_hand: Vec<Option<Pose<Object, Hand>>>,
}

/// Looks at the recorded motion at every instant of the test segments.
///
/// Positions are those of the segments; statuses and the object's pose (`hand_from_object`, filtered)
/// are those of the motion that each segment was cut from. Where a segment's take is not among the
/// motions the object is missing.
pub fn recorded(data: &TestData<'_>, settings: &EvaluationSettings) -> Recorded {
    let samples = data.segments.layout().samples;
    let has_object = data.motions.iter().any(|m| m.object.is_some());
    let has_distance = has_object && data.shape.is_some();
    let segments: Vec<(Vec<Known>, SegmentInstants)> = (0..data.segments.len())
        .into_par_iter()
        .map_init(
            || hull_probes(data),
            |probes, segment| {
                let known: Vec<Known> = (0..samples).map(|t| known(data, segment, t)).collect();
                let poses: Vec<_> = (known.iter().filter(|_| has_object))
                    .map(|known| known.object_from_hand)
                    .collect();
                let instants = look(
                    data,
                    settings,
                    probes,
                    data.segments.fingertips_m(segment),
                    &poses,
                );
                (known, instants)
            },
        )
        .collect();

    let count = samples * data.segments.len();
    let mut recorded = Recorded {
        filled: Vec::with_capacity(count),
        object_filled: Vec::with_capacity(count),
        distance_m: has_distance.then(|| Vec::with_capacity(count)),
        hull_distance_m: Vec::with_capacity(count),
        nearest_pair: Vec::with_capacity(count),
        object_from_hand: Vec::with_capacity(if has_object { count } else { 0 }),
    };
    for (known, instants) in segments {
        for known in known {
            recorded.filled.push(known.filled);
            recorded.object_filled.push(known.object_filled);
            if has_object {
                recorded.object_from_hand.push(known.object_from_hand);
            }
        }
        if let Some(distance_m) = &mut recorded.distance_m {
            distance_m.extend(instants.distance_m);
        }
        recorded.hull_distance_m.extend(instants.hull_distance_m);
        recorded.nearest_pair.extend(instants.nearest_pair);
    }
    recorded
}

impl Recorded {
    /// Poses of the object at the instants of a segment of `samples`; none where there is no object.
    pub(crate) fn object_from_hand(
        &self,
        segment: usize,
        samples: usize,
    ) -> &[Option<Pose<Object, Hand>>] {
        self.object_from_hand
            .get(segment * samples..(segment + 1) * samples)
            .unwrap_or_default()
    }
}

/// What a take knows of one instant.
struct Known {
    filled: PerFinger<bool>,
    object_filled: bool,
    object_from_hand: Option<Pose<Object, Hand>>,
}

fn known(data: &TestData<'_>, segment: usize, t: usize) -> Known {
    let origin = data.segments.origins()[segment];
    let sample = origin.start + t;
    let motion = data.motions.get(origin.take);
    let object = motion.and_then(|motion| motion.object.as_ref());
    Known {
        filled: PerFinger::from_fn(|finger| {
            motion.is_some_and(|m| m.fingertips[finger].status(sample) == Status::Filled)
        }),
        object_filled: object.is_some_and(|object| object.status(sample) == Status::Filled),
        object_from_hand: object
            .and_then(|object| object.get(sample))
            .map(Pose::inverse),
    }
}
