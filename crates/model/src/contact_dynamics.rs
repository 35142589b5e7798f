//! Contact and its dynamics: makes and breaks, states, phases, slip.

use serde::{Deserialize, Serialize};

use crate::finger::{Finger, FingerSet, PerFinger};
use crate::names::named;
use crate::statistics::Statistics;
use crate::units::{self, AsIs, Millimetres, Unit};

/// More than rounding can do to a distance between a finger and the object in its hand, metres, so
/// that a distance of exactly tau is a contact; far below what any camera can tell apart.
const CONTACT_ROUNDING_M: f64 = 1e-12;

/// Whether a pad at this signed distance from the object's surface is in contact: within tau of it,
/// outside or inside. Not where the distance is not known.
pub fn in_contact(distance_m: f64, tau_m: f64) -> bool {
    distance_m.abs() <= tau_m + CONTACT_ROUNDING_M
}

/// What counts as a contact, a grasp and a step of a finger.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactRules {
    /// Largest distance to the surface, from outside or inside, that counts as contact, metres.
    #[serde(rename = "tau_mm", with = "Millimetres")]
    pub tau_m: f64,
    /// Contacts, and lifts, that last less are no changes, seconds.
    pub min_duration_s: f64,
    /// A finger that stays off longer has left the grasp: setting down again later is no gait, seconds.
    pub max_lift_s: f64,
    /// Fingers that hold at least.
    pub min_fingers: usize,
}

/// Contacts over time: of whole test takes, and inside segments of recording and methods alike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactDynamics {
    /// What counted as what.
    pub rules: ContactRules,
    /// Each test take with an object, as recorded.
    pub takes: Vec<TakeContacts>,
    /// The recording inside the test segments, for comparison with the methods.
    pub recorded: SegmentContacts,
    /// Each method inside the test segments, by its name, in the order of the evaluation.
    #[serde(with = "units::named")]
    pub methods: Vec<(String, SegmentContacts)>,
}

/// Contacts of one finger over a stretch of time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FingerContactFacts {
    /// Time over which it is known whether the finger touches, seconds.
    pub known_s: f64,
    /// Share of that in contact, 0 to 1; NaN where nothing is known.
    #[serde(with = "AsIs")]
    pub duty: f64,
    /// Contacts seen to begin.
    pub makes: usize,
    /// Contacts seen to end.
    pub breaks: usize,
    /// Durations of contacts seen from make to break, seconds; filled where the fingertip or the object was
    /// filled at any sample of the contact.
    #[serde(with = "AsIs")]
    pub duration_s: Statistics,
    /// Contacts cut by an end or a gap, which lasted at least as long as was seen: in no duration.
    pub censored: usize,
    /// Displacement over the object's surface from the first to the last sample of each contact, seen whole or
    /// not, metres; left out are contacts of a single known sample.
    #[serde(rename = "slip_mm", with = "Millimetres")]
    pub slip_m: Statistics,
}

/// Contacts inside segments: each segment on its own, so that a contact that spans two is cut.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SegmentContacts {
    /// Segments at which it is known of any finger whether it touches: without those that have no object, and
    /// those whose plan failed.
    pub segments: usize,
    /// Each finger, over all segments.
    pub by_finger: PerFinger<FingerContactFacts>,
    /// Instants at which 0, 1, .. 5 fingers touch; those at which all five are known.
    pub by_fingers: [usize; Finger::COUNT + 1],
}

/// Contacts of one take as recorded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TakeContacts {
    /// Take.
    pub take: String,
    /// Samples a second.
    pub rate_hz: f64,
    /// Length, seconds.
    pub duration_s: f64,
    /// Each finger.
    pub by_finger: PerFinger<FingerContactFacts>,
    /// When each finger touches, seconds since the first sample: begin and end of every contact, for raster and
    /// gait diagram.
    pub contacts_s: PerFinger<Vec<[f64; 2]>>,
    /// When it is not known whether a finger touches.
    pub unknown_s: PerFinger<Vec<[f64; 2]>>,
    /// The states of contact, most frequent first.
    pub states: Vec<StateFacts>,
    /// What came after what.
    pub transitions: Vec<Transition>,
    /// Phases in order.
    pub phases: Vec<PhaseFacts>,
    /// Steps of fingers, by their lifts.
    pub gaits: Vec<GaitFacts>,
}

/// How often and how long a set of fingers held.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateFacts {
    /// The fingers.
    pub fingers: FingerSet,
    /// Samples in this state.
    pub samples: usize,
    /// Share of the samples at which all five fingers are known, 0 to 1.
    #[serde(with = "AsIs")]
    pub share: f64,
    /// Unbroken stretches.
    pub runs: usize,
    /// Durations of those with both ends seen, seconds.
    #[serde(with = "AsIs")]
    pub duration_s: Statistics,
}

/// A change from one state to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Transition {
    /// Before.
    pub from: FingerSet,
    /// After.
    pub to: FingerSet,
    /// How often.
    pub count: usize,
}

named! {
    /// Kind of manipulation in a phase.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum PhaseKind {
        /// The fingers of the phase keep their contacts, whether the object moves between them or is
        /// held still.
        InGrasp = "in_grasp",
        /// At least one finger is on the way from a lift to where it sets down, others hold.
        FingerGaiting = "finger_gaiting",
        /// Fewer fingers than a grasp needs, between two grasps.
        Regrasp = "regrasp",
        /// The same at the beginning or end of what is known: taken up or let go.
        NoGrasp = "no_grasp",
    }
}

/// A phase of manipulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseFacts {
    /// What goes on.
    pub kind: PhaseKind,
    /// Begin and end, seconds since the take's first sample.
    pub span_s: [f64; 2],
    /// The fingers that touch throughout.
    pub holding: FingerSet,
}

/// A finger that lifts and sets down again while others hold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GaitFacts {
    /// The finger.
    pub finger: Finger,
    /// Lift and set-down, seconds since the take's first sample.
    pub span_s: [f64; 2],
    /// The fingers that hold all the while.
    pub holding: FingerSet,
    /// How far over the object it stepped, metres; NaN where that is not known.
    #[serde(rename = "step_mm", with = "Millimetres")]
    pub step_m: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contact_is_near_from_either_side() {
        for (distance_m, touches) in [
            (0.0, true),
            (0.005, true),
            (-0.005, true),
            (0.1 + 0.2 - 0.295, true),
            (0.005_001, false),
            (-0.005_001, false),
            (f64::NAN, false),
        ] {
            assert_eq!(in_contact(distance_m, 0.005), touches, "{distance_m}");
        }
    }
}
