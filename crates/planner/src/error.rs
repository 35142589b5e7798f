//! Why a planner cannot be built, or a target cannot be planned to.

use inhand_model::{DictionaryError, Finger, TrajectoryError};
use thiserror::Error;

/// Why a planner cannot be built, or a target cannot be planned to.
///
/// A problem that has no solution is no error: it comes back as a plan with the status
/// [`Infeasible`](inhand_model::PlanStatus::Infeasible).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The dictionary's parts do not fit together.
    #[error(transparent)]
    Dictionary(#[from] DictionaryError),
    /// The dictionary has no primitive to plan with.
    #[error("the dictionary has no primitives: planning needs at least one")]
    NoPrimitives,
    /// Segments too short for a velocity, or without a usable rate.
    #[error(
        "the dictionary's segments have {samples} samples at {rate_hz} Hz: \
         planning needs at least 2 samples and a positive rate"
    )]
    Layout {
        /// Samples in a segment.
        samples: usize,
        /// Samples per second.
        rate_hz: f64,
    },
    /// A setting outside its range.
    #[error("planner setting {name} is {value}: expected {expected}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// The value found.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// Velocity bounds that nothing satisfies, or that are no numbers.
    #[error(
        "velocity bounds of {finger}, axis {axis}, run from {min_m_s} to {max_m_s} m/s: \
         expected two numbers, the first not above the second"
    )]
    VelocityBounds {
        /// The finger.
        finger: Finger,
        /// 0 = x.
        axis: usize,
        /// Lower bound, m/s.
        min_m_s: f64,
        /// Upper bound, m/s.
        max_m_s: f64,
    },
    /// The activations' covariance cannot be inverted.
    #[error(
        "the covariance of the {rank} activations is not positive definite \
         (smallest eigenvalue {smallest_m2:e} m²): learn with shrinkage, fewer primitives or more segments"
    )]
    Covariance {
        /// Number of activations.
        rank: usize,
        /// Smallest eigenvalue, m².
        smallest_m2: f64,
    },
    /// Targets so sharp that rounding leaves no problem to solve.
    #[error(
        "with sigma_m {sigma_m:e} the problem of {rank} activations cannot be factorised: \
         allow targets a larger deviation"
    )]
    Conditioning {
        /// Number of activations.
        rank: usize,
        /// The setting, metres.
        sigma_m: f64,
    },
    /// A target with a number that is none, or that no hand reaches.
    #[error(
        "target: {what} of {finger}, axis {axis}, is {value}: \
         expected a number of at most {limit} in size (metres and seconds)"
    )]
    Target {
        /// Which part of the target.
        what: &'static str,
        /// The finger.
        finger: Finger,
        /// 0 = x.
        axis: usize,
        /// The value found.
        value: f64,
        /// The largest size it may have.
        limit: f64,
    },
    /// A word that names no method.
    #[error("unknown planning method \"{name}\": expected one of {expected}")]
    UnknownMethod {
        /// The word found.
        name: String,
        /// The names there are.
        expected: String,
    },
    /// The solver returned numbers that make no trajectory.
    #[error("the solver's answer is no trajectory: {0}")]
    Trajectory(#[from] TrajectoryError),
}
