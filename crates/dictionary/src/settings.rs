//! Settings of learning.

use crate::product::{squared_norm, sum};
use serde::{Deserialize, Serialize};

/// Update rule of the factors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Update {
    /// Hierarchical alternating least squares: exact minimisation over one coordinate after the
    /// other, several sweeps for each matrix product (Cichocki and Phan 2009; Gillis and Glineur
    /// 2012).
    #[default]
    Hals,
    /// Multiplicative updates (Lee and Seung 2001): slow, kept for comparison with older work.
    Multiplicative,
}

/// Kind of numbers that products and descents run in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Double precision.
    #[default]
    F64,
    /// Single precision for data and activations; sums over blocks, the primitives' own half step and
    /// everything that follows stay double. Half the memory, and errors of about 1e-7 of the data.
    F32,
}

/// Penalty of a factor: `l1` times the sum of its numbers plus `l2` times half the sum of their
/// squares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Penalty {
    /// Weight of the sum.
    pub l1: f64,
    /// Weight of half the sum of squares.
    pub l2: f64,
}

impl Penalty {
    /// Whether there is none.
    pub fn is_none(self) -> bool {
        self == Self::default()
    }

    /// The same for a factor of which the data has `size` numbers for each of its own.
    pub(crate) fn scaled(self, size: f64) -> Self {
        Self {
            l1: self.l1 * size,
            l2: self.l2 * size,
        }
    }

    /// Cost of a factor by the sum of its numbers and that of their squares.
    pub(crate) fn of(self, sum: f64, squares: f64) -> f64 {
        self.l1 * sum + 0.5 * self.l2 * squares
    }

    /// Cost of these numbers.
    pub(crate) fn of_all(self, numbers: &[f64]) -> f64 {
        match self.is_none() {
            true => 0.0,
            false => self.of(sum(numbers), squared_norm(numbers)),
        }
    }
}

/// Start of the primitives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Start {
    /// Uniform random numbers in a narrow range, at the scale of the data.
    #[default]
    Random,
    /// Training segments drawn without replacement: ahead before the first iteration, behind after
    /// the second.
    Segments,
    /// One pass over the segments in small batches, each of which updates the primitives (Mairal,
    /// Bach, Ponce and Sapiro 2010): ahead where there are more segments than passes can be afforded.
    /// With [`max_iterations`](NmfSettings::max_iterations) 0 it is all of learning but the last
    /// look at every segment.
    Online,
    /// Leading singular vectors of the shifted data, of each the part of one sign that carries more
    /// (NNDSVD; Boutsidis and Gallopoulos 2008), zeros filled with the data's mean. Costs as much as
    /// some five iterations; does not depend on luck.
    Nndsvd,
}

/// Settings of non-negative matrix factorisation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Learning stops once an iteration lowers the root mean square error of takes that are left out by less
    /// than this share of it; 0 learns from all takes from the start. Rounds before the last two then learn from
    /// the other takes alone ([`folds`](crate::folds); with one take, from other intervals of it).
    pub left_out_change: f64,
    /// Learning stops once the root mean square error is not above this, metres.
    pub stop_rms_m: Option<f64>,
    /// Distance between each coordinate's training minimum and zero after the shift, metres.
    pub offset_margin_m: f64,
    /// Update rule of the factors.
    pub update: Update,
    /// Sweeps of coordinate descent over the activations for each product with the data, with
    /// [`Update::Hals`]; at least 1 (Gillis and Glineur 2012). Primitives, which change less from one
    /// iteration to the next, get half as many, rounded up.
    pub sweeps: usize,
    /// Start of the primitives.
    pub start: Start,
    /// Penalty of activations, on the scale of the problem (see [`primitive_penalty`](Self::primitive_penalty)).
    pub activation_penalty: Penalty,
    /// Penalty of primitives. With `n` segments of `m` numbers the objective is
    ///
    /// ```text
    /// 1/2 |V - offset - W H|² + m * activation_penalty(H) + n * primitive_penalty(W)
    /// ```
    ///
    /// so that a weight means the same for any number of segments and any segment length, as in
    /// scikit-learn (`alpha_W`, `alpha_H`; the two are exchanged there, where samples are rows).
    /// Penalties hold for both factors or for none: with one alone, the scale would move to the other
    /// until the penalty is nothing.
    pub primitive_penalty: Penalty,
    /// Kind of numbers.
    pub precision: Precision,
    /// Whether numbers may be missing (NaN); otherwise they are an error.
    pub may_miss: bool,
    /// Starts, with seeds counted up from [`seed`](Self::seed); the result is that of the smallest
    /// objective. At least 1.
    pub restarts: usize,
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
            left_out_change: 0.0,
            stop_rms_m: None,
            offset_margin_m: 0.005,
            update: Update::default(),
            sweeps: 4,
            start: Start::default(),
            activation_penalty: Penalty::default(),
            primitive_penalty: Penalty::default(),
            precision: Precision::default(),
            may_miss: false,
            restarts: 1,
        }
    }
}
