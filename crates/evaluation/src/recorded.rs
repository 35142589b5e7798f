//! Measures of the recorded motion itself, computed once for all methods.

use inhand_model::{EvaluationRows, Hand, Object, PerFinger, Pose, Status};
use rayon::prelude::*;

use crate::input::{EvaluationSettings, TestData};
use crate::instants::measure;

/// The recorded motion at every instant of the test segments: segment after segment, sample after
/// sample, so that sample `t` of segment `s` has the index `s * N + t`.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// What was measured, without any method.
    pub rows: EvaluationRows,
    /// Where the object is, for planned fingertips and objects; empty where no take has one.
    pub(crate) object_from_hand: Vec<Option<Pose<Object, Hand>>>,
}

/// Looks at the recorded motion at every instant of the test segments.
///
/// Positions are those of the segments; statuses and the object's pose (`hand_from_object`, filtered)
/// are those of the motion that each segment was cut from. Where a segment's take is not among the
/// motions the object is missing.
pub fn recorded(data: &TestData<'_>, settings: &EvaluationSettings) -> Recorded {
    let layout = data.segments.layout();
    let has_object = data.motions.iter().any(|m| m.object.is_some());
    // The take of an instant, and its sample there.
    let at = |k: usize| {
        let origin = data.segments.origins()[k / layout.samples];
        (
            data.motions.get(origin.take),
            origin.start + k % layout.samples,
        )
    };
    let object = |k: usize| {
        let (motion, sample) = at(k);
        Some((motion?.object.as_ref()?, sample))
    };
    let all = (0..data.segments.len() * layout.samples).into_par_iter();
    let object_from_hand: Vec<_> = (all.clone().filter(|_| has_object))
        .map(|k| object(k).and_then(|(track, sample)| track.get(sample).map(Pose::inverse)))
        .collect();
    let instants = measure(data, settings, &object_from_hand, |segment| {
        Some(data.segments.fingertips_m(segment))
    });
    let has_distance = has_object && data.shape.is_some();
    let rows = EvaluationRows {
        layout,
        takes: data.motions.iter().map(|m| m.name.clone()).collect(),
        segments: data.segments.origins().to_vec(),
        filled: (all.clone())
            .map(|k| {
                let (motion, sample) = at(k);
                PerFinger::from_fn(|finger| {
                    motion.is_some_and(|m| m.fingertips[finger].status(sample) == Status::Filled)
                })
            })
            .collect(),
        object_filled: all
            .map(|k| object(k).is_some_and(|(track, k)| track.status(k) == Status::Filled))
            .collect(),
        recorded_distance_m: has_distance.then_some(instants.distance_m),
        recorded_hull_distance_m: instants.hull_distance_m,
        recorded_nearest_pair_m: instants.nearest_pair.iter().map(|pair| pair.0).collect(),
        methods: Vec::new(),
    };
    Recorded {
        rows,
        object_from_hand,
    }
}

impl Recorded {
    /// Whether each fingertip or the object was filled at an instant.
    pub(crate) fn any_filled(&self, k: usize) -> PerFinger<bool> {
        self.rows.filled[k].map(|finger| finger || self.rows.object_filled[k])
    }
}
