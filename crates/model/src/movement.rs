//! Measures of movement: lengths, speeds, smoothness, distance to the nearest demonstration.

use crate::evaluation::Statistics;
use crate::finger::PerFinger;

/// Measures of motion over the test segments: of the recording and of each method, at the same segments.
#[derive(Clone, Debug, PartialEq)]
pub struct MovementAnalysis {
    /// The recorded motion.
    pub recorded: Movement,
    /// Each method, by its name, in the order of the evaluation.
    pub methods: Vec<(String, Movement)>,
    /// Steps slower than this count as standing still, m/s.
    pub static_speed_m_s: f64,
    /// Demonstrations that the nearest was looked for among: complete segments of the training takes. 0 where
    /// those are not at hand, as when motion that was stored before is judged.
    pub demonstrations: usize,
    /// Demonstrations there are: more than were looked at only in very long sessions.
    pub demonstrations_available: usize,
    /// Widest shift in time that warping may make, samples; `None` for any.
    pub warping_band: Option<usize>,
}

/// Measures of one motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Movement {
    /// Each finger, over segments.
    pub by_finger: PerFinger<FingerMovement>,
    /// Warped distance of the whole hand to the nearest demonstration, metres, over segments
    /// (normalised by the length of the path through the alignment: the mean distance of matched
    /// configurations); `None` without demonstrations.
    pub nearest_demonstration_m: Option<Statistics>,
}

/// Measures of one fingertip, a value for each segment. Segments that gaps took away, failed plans, and motion
/// that has no such measure (SPARC and jerk of a fingertip that does not move at all) are left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerMovement {
    /// Length of the path, metres.
    pub length_m: Statistics,
    /// Largest speed, m/s.
    pub peak_speed_m_s: Statistics,
    /// Share of the steps slower than the static speed, 0 to 1.
    pub static_share: Statistics,
    /// Spectral arc length, no unit, below 0; nearer to 0 is smoother.
    pub sparc: Statistics,
    /// Log dimensionless jerk of the speed, no unit; larger is smoother.
    pub ldlj: Statistics,
}
