//! Errors of simulation.

use inhand_model::{ClockError, RecordingError};
use thiserror::Error;

/// Reasons why a take cannot be simulated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// A setting outside its range, or no number at all.
    #[error("{0}")]
    Setting(String),
    /// An object that the simulated hand does not span or grasp.
    #[error("{0}")]
    Object(String),
    /// Gaps or faults that do not fit into the take beside each other.
    #[error("{0}")]
    Crowded(String),
    /// The sample rate makes no clock.
    #[error(transparent)]
    Clock(#[from] ClockError),
    /// The tracks make no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}
