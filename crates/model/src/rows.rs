//! The single numbers, segments, contacts and phases behind an evaluation.

use std::ops::Range;

use crate::contact_dynamics::PhaseKind;
use crate::finger::{Finger, FingerSet, PerFinger};
use crate::segments::{SegmentLayout, SegmentOrigin};

/// Every judged instant behind an evaluation: what statistics of fingertips, their figures and intervals are
/// made of.
///
/// Instants are ordered segment after segment, sample after sample: sample `t` of segment `s` is at
/// `s * N + t`, in every list of this length here. What is not known is NaN.
#[derive(Clone, Debug)]
pub struct EvaluationRows {
    /// Samples N of a segment, and their rate.
    pub layout: SegmentLayout,
    /// Names of the test takes, in the order that [`SegmentOrigin::take`] counts.
    pub takes: Vec<String>,
    /// Where each segment comes from.
    pub segments: Vec<SegmentOrigin>,
    /// Whether each recorded fingertip was filled rather than measured.
    pub filled: Vec<PerFinger<bool>>,
    /// Whether the object's pose was filled; `false` where it is missing.
    pub object_filled: Vec<bool>,
    /// Signed distance of each recorded pad to the object's surface, metres, negative inside; `None` where
    /// no take has an object of known shape.
    pub recorded_distance_m: Option<Vec<PerFinger<f64>>>,
    /// Signed distance of each recorded fingertip to its training hull, metres, negative inside.
    pub recorded_hull_distance_m: Vec<PerFinger<f64>>,
    /// Distance between the nearest two recorded fingertips, metres.
    pub recorded_nearest_pair_m: Vec<f64>,
    /// Each method, in the order of the evaluation.
    pub methods: Vec<MethodRows>,
}

/// The instants of one method.
#[derive(Clone, Debug, Default)]
pub struct MethodRows {
    /// Name, such as `prior`.
    pub name: String,
    /// Distance between planned and recorded fingertip, metres.
    pub error_m: Vec<PerFinger<f64>>,
    /// Signed distance of each planned pad to the object's surface, metres, negative inside; `None` as for
    /// the recorded one.
    pub distance_m: Option<Vec<PerFinger<f64>>>,
    /// Signed distance of each planned fingertip to its training hull, metres, negative inside.
    pub hull_distance_m: Vec<PerFinger<f64>>,
    /// Distance between the nearest two fingertips, metres.
    pub nearest_pair_m: Vec<f64>,
    /// Distance between planned and recorded object, metres; `None` where the method plans none.
    pub object_position_error_m: Option<Vec<f64>>,
    /// Angle between planned and recorded object, radians; `None` likewise.
    pub object_angle_error_rad: Option<Vec<f64>>,
    /// Mahalanobis distance of each recorded fingertip from the planned prediction region, no unit; `None` where the method
    /// plans none.
    pub mahalanobis: Option<Vec<PerFinger<f64>>>,
}

impl MethodRows {
    /// The errors and distances alone, by which methods are compared; without the rest, which only tables show.
    #[must_use]
    pub fn compared(self) -> Self {
        Self {
            name: self.name,
            error_m: self.error_m,
            distance_m: self.distance_m,
            ..Self::default()
        }
    }
}

impl EvaluationRows {
    /// Instants of one method.
    pub fn instants(&self) -> usize {
        self.segments.len() * self.layout.samples
    }
}

/// What [`MovementAnalysis`](crate::MovementAnalysis) and [`ContactDynamics`](crate::ContactDynamics) are made
/// of. What is not known is NaN.
#[derive(Clone, Debug)]
pub struct MotionRows {
    /// Samples of a segment, and their rate.
    pub layout: SegmentLayout,
    /// Names of the test takes, in the order that [`SegmentOrigin::take`] counts.
    pub takes: Vec<String>,
    /// Where each segment comes from.
    pub segments: Vec<SegmentOrigin>,
    /// Whether any sample of each recorded fingertip was filled, for each segment.
    pub filled: Vec<PerFinger<bool>>,
    /// How each motion moves: the recording, [`MotionRows::RECORDED`], then each method.
    pub movement: Vec<MovementRows>,
    /// What touches in each segment, of the same motions in the same order; `None` without an object of known
    /// shape.
    pub contacts: Option<Vec<Vec<ContactRows>>>,
    /// What touches in each whole take; `None` for a take without an object, empty without a shape.
    pub take_contacts: Vec<Option<ContactRows>>,
}

impl MotionRows {
    /// What the recording is called beside methods.
    pub const RECORDED: &str = "recorded";
}

/// Measures of one motion, segment by segment.
#[derive(Clone, Debug, PartialEq)]
pub struct MovementRows {
    /// `recorded`, or the method.
    pub name: String,
    /// A row for each segment; all NaN where the plan failed.
    pub segments: Vec<SegmentMovement>,
}

/// Measures of one motion over one segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentMovement {
    /// Each fingertip.
    pub by_finger: PerFinger<PathFacts>,
    /// Warped distance to the nearest demonstration, metres.
    pub nearest_demonstration_m: f64,
    /// Which one that is, counted over all training segments; `None` where there is none.
    pub nearest_demonstration: Option<usize>,
}

/// Measures of one path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathFacts {
    /// Length, metres.
    pub length_m: f64,
    /// Largest speed, m/s.
    pub peak_speed_m_s: f64,
    /// Share of the steps slower than the static speed, 0 to 1.
    pub static_share: f64,
    /// Spectral arc length, no unit.
    pub sparc: f64,
    /// Log dimensionless jerk of the speed, no unit.
    pub ldlj: f64,
}

/// Contacts over one stretch of time, a take or a segment. Samples count from its first one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactRows {
    /// Samples.
    pub samples: usize,
    /// Samples at which it is not known whether a finger touches.
    pub unknown: PerFinger<Vec<Range<usize>>>,
    /// Contacts of each finger, in order.
    pub contacts: PerFinger<Vec<ContactRow>>,
    /// Which fingers touch, in order, wherever that is known of all five.
    pub states: Vec<StateRow>,
    /// Phases in order; of takes alone.
    pub phases: Vec<PhaseRow>,
    /// Steps of fingers, by their lifts; of takes alone.
    pub gaits: Vec<GaitRow>,
}

impl ContactRows {
    /// Samples at which it is known whether a finger touches.
    pub fn known(&self, finger: Finger) -> usize {
        let unknown: usize = (self.unknown[finger].iter())
            .map(ExactSizeIterator::len)
            .sum();
        self.samples.saturating_sub(unknown)
    }
}

/// One contact of a finger.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactRow {
    /// The samples in contact.
    pub samples: Range<usize>,
    /// Whether it was seen to begin.
    pub made: bool,
    /// Whether it was seen to end.
    pub broken: bool,
    /// Whether the fingertip or the object was filled at any of its samples.
    pub filled: bool,
    /// Displacement over the object's surface from the first to the last sample, metres.
    pub slip_m: f64,
}

/// A stretch in which the same fingers touch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateRow {
    /// The fingers.
    pub fingers: FingerSet,
    /// The samples.
    pub samples: Range<usize>,
    /// Whether both ends are changes to other known states.
    pub complete: bool,
}

/// A phase of manipulation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PhaseRow {
    /// What goes on.
    pub kind: PhaseKind,
    /// The samples.
    pub samples: Range<usize>,
    /// The fingers that touch throughout.
    pub holding: FingerSet,
}

/// A step of a finger.
#[derive(Clone, Debug, PartialEq)]
pub struct GaitRow {
    /// The finger.
    pub finger: Finger,
    /// The samples without contact: lifted at the first, set down again at the end (the first sample in
    /// contact).
    pub samples: Range<usize>,
    /// The fingers that touch all the while.
    pub holding: FingerSet,
    /// How far, in the object's frame, the pad at its first sample in contact is from its last one before
    /// the lift, metres; NaN where one of them is missing.
    pub step_m: f64,
}
