//! The single numbers behind an evaluation.

use crate::finger::PerFinger;
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
#[derive(Clone, Debug)]
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
    /// Mahalanobis distance of each recorded fingertip from the planned corridor, no unit; `None` where the method
    /// plans none.
    pub mahalanobis: Option<Vec<PerFinger<f64>>>,
}

impl EvaluationRows {
    /// Instants of one method.
    pub fn instants(&self) -> usize {
        self.segments.len() * self.layout.samples
    }
}
