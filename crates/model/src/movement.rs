//! Measures of movement: lengths, speeds, smoothness, distance to the nearest demonstration.

use serde::{Deserialize, Serialize};

use crate::finger::PerFinger;
use crate::statistics::Statistics;
use crate::units::{AsIs, Millimetres, Unit, named};

/// Measures of motion over the test segments: of the recording and of each method, at the same segments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MovementAnalysis {
    /// Steps slower than this count as standing still, m/s.
    #[serde(rename = "static_speed_mm_s", with = "Millimetres")]
    pub static_speed_m_s: f64,
    /// Demonstrations that the nearest was looked for among: complete segments of the training takes. 0 where
    /// those are not at hand, as when motion that was stored before is judged.
    pub demonstrations: usize,
    /// Demonstrations there are: more than were looked at only in very long sessions.
    pub demonstrations_available: usize,
    /// Widest shift in time that warping may make, samples; `None` for any.
    #[serde(rename = "warping_band_samples")]
    pub warping_band: Option<usize>,
    /// The recorded motion.
    pub recorded: Movement,
    /// Each method, by its name, in the order of the evaluation.
    #[serde(with = "named")]
    pub methods: Vec<(String, Movement)>,
}

/// Measures of one motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Movement {
    /// Warped distance of the whole hand to the nearest demonstration, metres, over segments
    /// (normalised by the length of the path through the alignment: the mean distance of matched
    /// configurations); `None` without demonstrations.
    #[serde(rename = "nearest_demonstration_mm", default, with = "Millimetres")]
    pub nearest_demonstration_m: Option<Statistics>,
    /// Each finger, over segments.
    pub by_finger: PerFinger<FingerMovement>,
}

/// Measures of one fingertip, a value for each segment. Segments that gaps took away, failed plans, and motion
/// that has no such measure (SPARC and jerk of a fingertip that does not move at all) are left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FingerMovement {
    /// Length of the path, metres.
    #[serde(rename = "length_mm", with = "Millimetres")]
    pub length_m: Statistics,
    /// Largest speed, m/s.
    #[serde(rename = "peak_speed_mm_s", with = "Millimetres")]
    pub peak_speed_m_s: Statistics,
    /// Share of the steps slower than the static speed, 0 to 1.
    #[serde(with = "AsIs")]
    pub static_share: Statistics,
    /// Spectral arc length, no unit, below 0; nearer to 0 is smoother.
    #[serde(with = "AsIs")]
    pub sparc: Statistics,
    /// Log dimensionless jerk of the speed, no unit; larger is smoother.
    #[serde(with = "AsIs")]
    pub ldlj: Statistics,
}
