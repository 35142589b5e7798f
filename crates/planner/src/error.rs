//! Errors of building a planner and of planning.

use std::fmt::Display;

use inhand_model::{DictionaryError, TrajectoryError};
use thiserror::Error;

/// Reasons why a planner cannot be built, or a target cannot be planned to.
///
/// A problem that has no solution is no error: it comes back as a plan with the status
/// [`Infeasible`](inhand_model::PlanStatus::Infeasible).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The dictionary's parts do not fit together.
    #[error(transparent)]
    Dictionary(#[from] DictionaryError),
    /// A dictionary or deviation that cannot be planned with: sizes, numbers, covariances.
    #[error("{0}")]
    Model(String),
    /// A setting outside its range, or one that this dictionary or method does not allow.
    #[error("{0}")]
    Setting(String),
    /// A target that gives nothing, contradicts itself, or gives what no hand or segment can reach.
    #[error("{0}")]
    Target(String),
    /// Too few fingers in contact at both ends.
    #[error("{0}")]
    TooFewHold(String),
    /// Knots that make no chain.
    #[error("{0}")]
    Knots(String),
    /// A segment of a chain that cannot be planned.
    #[error("segment {segment} of the chain, from {start_s} s on: {source}")]
    Segment {
        /// Which one, counted from 0.
        segment: usize,
        /// When it starts, seconds since the start.
        start_s: f64,
        /// Why not.
        source: Box<PlanError>,
    },
    /// The solver returned numbers that make no trajectory.
    #[error("the solver's answer is no trajectory: {0}")]
    Trajectory(#[from] TrajectoryError),
}

impl PlanError {
    pub(crate) fn setting(name: &str, value: f64, expected: impl Display) -> Self {
        PlanError::Setting(format!(
            "planner setting {name} is {value}: expected {expected}"
        ))
    }

    pub(crate) fn no_hull(finger: impl Display) -> Self {
        PlanError::Setting(format!(
            "reachability needs the training hull of every finger, and that of {finger} has no \
             faces: give hulls in the settings, or switch reachability off"
        ))
    }
}

/// Refuses a part of another size.
pub(crate) fn check_size(what: &str, expected: usize, found: usize) -> Result<(), PlanError> {
    if expected == found {
        return Ok(());
    }
    Err(PlanError::Model(format!(
        "{what} is {found}, expected {expected}"
    )))
}
