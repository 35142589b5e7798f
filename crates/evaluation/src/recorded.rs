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
    let known: Vec<Known> = (0..data.segments.len() * layout.samples)
        .into_par_iter()
        .map(|k| known(data, k / layout.samples, k % layout.samples))
        .collect();
    let object_from_hand: Vec<_> = (known.iter().filter(|_| has_object))
        .map(|known| known.object_from_hand)
        .collect();
    let instants = measure(data, settings, &object_from_hand, |segment| {
        Some(data.segments.fingertips_m(segment))
    });
    let has_distance = has_object && data.shape.is_some();
    let rows = EvaluationRows {
        layout,
        takes: data.motions.iter().map(|m| m.name.clone()).collect(),
        segments: data.segments.origins().to_vec(),
        filled: known.iter().map(|known| known.filled).collect(),
        object_filled: known.iter().map(|known| known.object_filled).collect(),
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

/// Statuses and pose of one instant of a take.
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
