//! Errors of dictionaries against their rank.

/// An error on segments that were left out of learning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOut {
    /// Root mean square, metres.
    pub rms_m: f64,
    /// Its standard error over takes (over intervals of a single take), metres; `None` where only
    /// one of them was left out.
    pub standard_error_m: Option<f64>,
}

/// Errors of a dictionary of one rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankPoint {
    /// Number of primitives.
    pub rank: usize,
    /// Root mean square of the reconstruction error of the training segments, metres.
    pub training_rms_m: f64,
    /// Share of the training segments' variance that is explained: one less the squared error over
    /// the squared deviation of the segments from their mean segment. Negative where the mean
    /// segment alone does better.
    pub explained_variance: f64,
    /// Reconstruction error of segments left out of learning, all of their rows known. It falls
    /// with every primitive.
    pub reconstructed: HeldOut,
    /// Error on the middle part of segments left out of learning, from the rest of their rows. It
    /// rises again where primitives follow what does not repeat.
    pub predicted: HeldOut,
}
