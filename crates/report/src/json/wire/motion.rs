//! Motion and contacts over time.

use serde::{Deserialize, Serialize};

use super::{ByFinger, Distribution, Number};

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct Movements {
    pub(in crate::json) static_speed_mm_s: Number,
    pub(in crate::json) demonstrations: usize,
    pub(in crate::json) demonstrations_available: usize,
    pub(in crate::json) warping_band_samples: Option<usize>,
    pub(in crate::json) recorded: Movement,
    pub(in crate::json) methods: Vec<Named<Movement>>,
}

/// Something of a method.
#[derive(Serialize, Deserialize)]
pub(in crate::json) struct Named<T> {
    pub(in crate::json) name: String,
    #[serde(flatten)]
    pub(in crate::json) of_method: T,
}

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct Movement {
    pub(in crate::json) nearest_demonstration_mm: Option<Distribution>,
    pub(in crate::json) by_finger: ByFinger<Moved>,
}

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct Moved {
    pub(in crate::json) length_mm: Distribution,
    pub(in crate::json) peak_speed_mm_s: Distribution,
    pub(in crate::json) static_share: Distribution,
    pub(in crate::json) sparc: Distribution,
    pub(in crate::json) ldlj: Distribution,
}

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct Contacts {
    pub(in crate::json) rules: Rules,
    pub(in crate::json) takes: Vec<TakeContacts>,
    pub(in crate::json) recorded: SegmentContacts,
    pub(in crate::json) methods: Vec<Named<SegmentContacts>>,
}

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct Rules {
    pub(in crate::json) tau_mm: Number,
    pub(in crate::json) min_duration_s: Number,
    pub(in crate::json) max_lift_s: Number,
    pub(in crate::json) min_fingers: usize,
}

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct FingerContacts {
    pub(in crate::json) known_s: Number,
    pub(in crate::json) duty: Number,
    pub(in crate::json) makes: usize,
    pub(in crate::json) breaks: usize,
    pub(in crate::json) duration_s: Distribution,
    pub(in crate::json) censored: usize,
    pub(in crate::json) slip_mm: Distribution,
}

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct SegmentContacts {
    pub(in crate::json) segments: usize,
    pub(in crate::json) by_finger: ByFinger<FingerContacts>,
    /// Instants with 0, 1, .. 5 contacts.
    pub(in crate::json) by_fingers: [usize; 6],
}

/// From when to when, seconds.
pub(in crate::json) type Span = [Number; 2];

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct TakeContacts {
    pub(in crate::json) take: String,
    pub(in crate::json) rate_hz: Number,
    pub(in crate::json) duration_s: Number,
    pub(in crate::json) by_finger: ByFinger<FingerContacts>,
    pub(in crate::json) contacts_s: ByFinger<Vec<Span>>,
    pub(in crate::json) unknown_s: ByFinger<Vec<Span>>,
    pub(in crate::json) states: Vec<State>,
    pub(in crate::json) transitions: Vec<Change>,
    pub(in crate::json) phases: Vec<Phase>,
    pub(in crate::json) gaits: Vec<Gait>,
}

/// Names of fingers.
pub(in crate::json) type Fingers = Vec<String>;

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct State {
    pub(in crate::json) fingers: Fingers,
    pub(in crate::json) samples: usize,
    pub(in crate::json) share: Number,
    pub(in crate::json) runs: usize,
    pub(in crate::json) duration_s: Distribution,
}

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct Change {
    pub(in crate::json) from: Fingers,
    pub(in crate::json) to: Fingers,
    pub(in crate::json) count: usize,
}

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct Phase {
    pub(in crate::json) kind: String,
    pub(in crate::json) span_s: Span,
    pub(in crate::json) holding: Fingers,
}

#[derive(Serialize, Deserialize)]
pub(in crate::json) struct Gait {
    pub(in crate::json) finger: String,
    pub(in crate::json) span_s: Span,
    pub(in crate::json) holding: Fingers,
    pub(in crate::json) step_mm: Number,
}
