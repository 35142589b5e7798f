//! The document's structs, in the order of its keys. They are written to fit
//! `schemas/evaluation.schema.json` and nothing outside this folder sees them. Lengths are
//! millimetres and say so in their keys; a number that does not exist is null.

pub(super) mod motion;

use inhand_model::Finger;
use serde::{Deserialize, Serialize};

/// Raised when a key changes its meaning or goes away; new keys alone do not raise it.
pub(crate) const SCHEMA_VERSION: u32 = 1;

/// A number, or null. A type of its own, because serde takes a missing `Option` for null and a
/// missing key must be an error.
#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct Number(pub(super) Option<f64>);

impl Number {
    /// The number, or null where it is not finite.
    pub(super) fn finite(value: f64) -> Self {
        Self(Some(value).filter(|value| value.is_finite()))
    }

    /// Null unless `exists`.
    pub(super) fn only_if(self, exists: bool) -> Self {
        Self(self.0.filter(|_| exists))
    }
}

#[derive(Serialize, Deserialize)]
pub(super) struct Document {
    pub(super) schema_version: u32,
    pub(super) session: Session,
    pub(super) default_method: String,
    // Documents of this version were written before methods were chosen.
    #[serde(default)]
    pub(super) choice: Option<Choice>,
    pub(super) dictionary: Dictionary,
    pub(super) methods: Vec<Method>,
    pub(super) quality: Quality,
    // Documents of this version were written before intervals were worked out.
    #[serde(default)]
    pub(super) intervals: Option<super::intervals::Document>,
    // Documents of this version were written before there was movement, or contacts over time.
    #[serde(default)]
    pub(super) movement: Option<motion::Movements>,
    #[serde(default)]
    pub(super) contacts: Option<motion::Contacts>,
    pub(super) provenance: Vec<Step>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Session {
    pub(super) name: String,
    pub(super) rate_hz: Number,
    pub(super) segment_samples: usize,
    pub(super) object: Option<String>,
    // Documents of this version were written before these two were.
    #[serde(default)]
    pub(super) participant: Option<String>,
    #[serde(default)]
    pub(super) task: Option<String>,
    pub(super) train: Vec<Take>,
    pub(super) test: Vec<Take>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Take {
    pub(super) name: String,
    pub(super) samples: usize,
    pub(super) duration_s: Number,
    pub(super) segments: usize,
    pub(super) left_out: usize,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Dictionary {
    pub(super) kind: String,
    pub(super) rank: usize,
    pub(super) segments: usize,
    pub(super) rms_mm: Number,
    pub(super) relative_error: Number,
    pub(super) iterations: usize,
    pub(super) stop_reason: String,
    pub(super) objective_history_mm2: Vec<Number>,
    pub(super) velocity_bounds_mm_s: ByFinger<Bounds>,
    // Documents of this version were written before deviations were learned.
    #[serde(default)]
    pub(super) deviation: Option<Deviation>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Deviation {
    pub(super) primitives: usize,
    pub(super) demonstrations: usize,
    pub(super) profile_weight: f64,
    pub(super) hand_weight: f64,
    pub(super) finger_weight: f64,
    pub(super) hand_bandwidth: f64,
    pub(super) finger_bandwidth: f64,
    pub(super) validation: Validated,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Validated {
    pub(super) folds: usize,
    pub(super) segments: usize,
    pub(super) smooth_error_mm: Number,
    pub(super) error_mm: Number,
    pub(super) standard_error_mm: Number,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Choice {
    pub(super) method: String,
    pub(super) candidates: Vec<Candidate>,
    pub(super) gain_mm: Number,
    pub(super) gain_standard_error_mm: Number,
    pub(super) folds: usize,
    pub(super) segments: usize,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Candidate {
    pub(super) name: String,
    pub(super) mean_error_mm: Number,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Bounds {
    pub(super) min: [Number; 3],
    pub(super) max: [Number; 3],
}

#[derive(Serialize, Deserialize)]
pub(super) struct Method {
    pub(super) name: String,
    pub(super) description: String,
    pub(super) baseline: bool,
    pub(super) error_mm: WithAll<Distribution>,
    pub(super) error_at_start_mm: Distribution,
    pub(super) error_at_goal_mm: Distribution,
    pub(super) median_error_by_sample_mm: Vec<Number>,
    pub(super) reachability: Reach,
    pub(super) collision: Collisions,
    pub(super) velocity: Velocity,
    pub(super) contact: Option<Contact>,
    pub(super) distance_difference_mm: Option<ByFinger<Distribution>>,
    pub(super) object_error_mm: Option<Distribution>,
    pub(super) object_angle_deg: Option<Distribution>,
    // Documents of this version were written before there were corridors.
    #[serde(default)]
    pub(super) corridors: Vec<Corridor>,
    pub(super) plan: Option<Plans>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct ByFinger<T> {
    pub(super) thumb: T,
    pub(super) index: T,
    pub(super) middle: T,
    pub(super) ring: T,
    pub(super) little: T,
}

#[derive(Serialize, Deserialize)]
pub(super) struct WithAll<T> {
    pub(super) all: T,
    #[serde(flatten)]
    pub(super) fingers: ByFinger<T>,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct Distribution {
    pub(super) n: usize,
    pub(super) n_filled: usize,
    pub(super) n_left_out: usize,
    pub(super) mean: Number,
    pub(super) rmse: Number,
    pub(super) min: Number,
    pub(super) p5: Number,
    pub(super) p25: Number,
    pub(super) p50: Number,
    pub(super) p75: Number,
    pub(super) p95: Number,
    pub(super) max: Number,
    pub(super) whisker_low: Number,
    pub(super) whisker_high: Number,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Reach {
    pub(super) n: usize,
    pub(super) inside: WithAll<Number>,
    pub(super) recorded_inside: WithAll<Number>,
    pub(super) worst_outside_mm: ByFinger<Number>,
    pub(super) distance_mm: ByFinger<Distribution>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Collisions {
    pub(super) n: usize,
    pub(super) limit_mm: Number,
    pub(super) instants: usize,
    pub(super) trajectories: usize,
    pub(super) nearest_mm: Number,
    pub(super) nearest_pair: Option<[String; 2]>,
    pub(super) recorded_instants: usize,
    pub(super) recorded_nearest_mm: Number,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
pub(super) struct Velocity {
    pub(super) n: usize,
    pub(super) outside: usize,
    pub(super) trajectories_outside: usize,
    pub(super) worst_ratio: Number,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Contact {
    pub(super) n: usize,
    pub(super) n_filled: usize,
    pub(super) n_left_out: usize,
    pub(super) tau_mm: Number,
    pub(super) three_or_more: Number,
    pub(super) recorded_three_or_more: Number,
    pub(super) by_finger: ByFinger<Number>,
    pub(super) recorded_by_finger: ByFinger<Number>,
    pub(super) by_tau: Vec<AtTau>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct AtTau {
    pub(super) tau_mm: Number,
    pub(super) three_or_more: Number,
    pub(super) recorded_three_or_more: Number,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Corridor {
    pub(super) share_stated: Number,
    pub(super) mahalanobis: Number,
    pub(super) n: usize,
    pub(super) n_filled: usize,
    pub(super) n_left_out: usize,
    pub(super) inside: WithAll<Number>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Plans {
    pub(super) solved: usize,
    pub(super) infeasible: usize,
    pub(super) failed: usize,
    pub(super) worst_kkt_residual: Number,
    pub(super) velocity_bound_active: usize,
    // Documents of this version were written before there were other families.
    #[serde(default)]
    pub(super) constraints: Vec<Family>,
    #[serde(default)]
    pub(super) outside_hull: Option<usize>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Family {
    pub(super) family: String,
    pub(super) unit: String,
    pub(super) active: usize,
    pub(super) worst_violation: Number,
    pub(super) would_mend: usize,
    pub(super) largest_relaxation: Number,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Quality {
    pub(super) warnings: usize,
    pub(super) takes: Vec<TakeState>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct TakeState {
    pub(super) take: String,
    pub(super) role: String,
    pub(super) hand_tracked: Number,
    pub(super) object_tracked: Option<Number>,
    pub(super) fingers: ByFinger<TrackState>,
    pub(super) findings: Vec<Found>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct TrackState {
    pub(super) recorded: Counts,
    pub(super) processed: Counts,
    pub(super) longest_gap_s: Number,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Counts {
    pub(super) measured: usize,
    pub(super) filled: usize,
    pub(super) missing: usize,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Found {
    pub(super) severity: String,
    pub(super) place: String,
    pub(super) message: String,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Step {
    pub(super) tool: String,
    pub(super) step: String,
    pub(super) settings: serde_json::Value,
    pub(super) inputs: Vec<Input>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct Input {
    pub(super) name: String,
    pub(super) sha256: String,
}

impl<T> ByFinger<T> {
    /// Calls `make` once for each finger.
    pub(super) fn from_fn(mut make: impl FnMut(Finger) -> T) -> Self {
        Self {
            thumb: make(Finger::Thumb),
            index: make(Finger::Index),
            middle: make(Finger::Middle),
            ring: make(Finger::Ring),
            little: make(Finger::Little),
        }
    }

    /// The values in the order of all fingers.
    pub(super) fn into_array(self) -> [T; Finger::COUNT] {
        [self.thumb, self.index, self.middle, self.ring, self.little]
    }
}
