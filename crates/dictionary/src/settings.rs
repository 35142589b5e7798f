//! How to learn.

/// How the factors are updated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Update {
    /// Hierarchical alternating least squares: exact minimisation over one coordinate after the
    /// other, several sweeps for each matrix product (Cichocki and Phan 2009; Gillis and Glineur
    /// 2012).
    #[default]
    Hals,
    /// Multiplicative updates (Lee and Seung 2001): slow, kept for comparison with older work.
    Multiplicative,
}

impl Update {
    /// Lower-case name, as in files and settings.
    pub const fn name(self) -> &'static str {
        match self {
            Update::Hals => "hals",
            Update::Multiplicative => "multiplicative",
        }
    }
}

/// Where the primitives start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Start {
    /// Uniform random numbers in a narrow range, at the scale of the data.
    #[default]
    Random,
    /// Training segments drawn without replacement: ahead before the first iteration, behind after
    /// the second.
    Segments,
}

impl Start {
    /// Lower-case name, as in files and settings.
    pub const fn name(self) -> &'static str {
        match self {
            Start::Segments => "segments",
            Start::Random => "random",
        }
    }
}

/// Settings of non-negative matrix factorisation.
#[derive(Clone, Debug, PartialEq)]
pub struct NmfSettings {
    /// Number of primitives, at least 1 and at most the number of segments.
    pub rank: usize,
    /// Seed of the start.
    pub seed: u64,
    /// Iterations after which learning stops in any case; an iteration updates primitives, then
    /// activations.
    pub max_iterations: usize,
    /// Learning has converged when an iteration lowers the objective by less than this share of
    /// it; 0 switches the rule off.
    pub relative_change: f64,
    /// Learning stops once the root mean square error is not above this, metres.
    pub stop_rms_m: Option<f64>,
    /// What stays between each coordinate's training minimum and zero after the shift, metres.
    pub offset_margin_m: f64,
    /// How the factors are updated.
    pub update: Update,
    /// Sweeps of coordinate descent over a factor for each product with the data, with
    /// [`Update::Hals`]; at least 1 (Gillis and Glineur 2012). A sweep costs a tenth of the product,
    /// and with three the error falls as fast in one iteration as in two to three with one.
    pub sweeps: usize,
    /// Where the primitives start.
    pub start: Start,
}

impl Default for NmfSettings {
    /// Settings of a hand session: 200 primitives as published, 5 mm margin, 10 iterations at most:
    /// about 0.1 mm of reconstruction error, below which plans on takes left out of training do not
    /// get better.
    fn default() -> Self {
        Self {
            rank: 200,
            seed: 0,
            max_iterations: 10,
            relative_change: 1e-4,
            stop_rms_m: None,
            offset_margin_m: 0.005,
            update: Update::default(),
            sweeps: 3,
            start: Start::default(),
        }
    }
}
