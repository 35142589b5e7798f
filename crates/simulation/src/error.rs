//! Errors of simulation.

use inhand_model::{ClockError, RecordingError, Shape};
use thiserror::Error;

/// Why a take cannot be simulated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// A setting outside its range, or no number at all.
    #[error("setting {setting} is {found}: expected {min} to {max}")]
    Setting {
        /// Name of the setting, with its unit.
        setting: &'static str,
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
        /// Value found.
        found: f64,
    },
    /// An object that the simulated hand does not span or grasp.
    #[error(
        "the simulated hand does not hold {shape}: {dimension} is {found_m} m, expected {min_m} to {max_m} m"
    )]
    Size {
        /// The object.
        shape: Shape,
        /// Which dimension.
        dimension: &'static str,
        /// Smallest size that it holds, metres.
        min_m: f64,
        /// Largest size that it holds, metres.
        max_m: f64,
        /// Size found, metres.
        found_m: f64,
    },
    /// No arrangement of five fingertips on the object keeps them apart.
    #[error(
        "no grasp of {shape} with five fingertips {separation_m} m apart was found: give a larger object"
    )]
    Grasp {
        /// The object.
        shape: Shape,
        /// Distance that was to be kept, metres.
        separation_m: f64,
    },
    /// The gaps asked for do not fit into the take.
    #[error(
        "gaps of {samples_missing} samples in {gaps} runs do not fit into {samples} samples: lower the share or make the gaps longer"
    )]
    Gaps {
        /// Missing samples asked for.
        samples_missing: usize,
        /// Runs they would make.
        gaps: usize,
        /// Samples of the take.
        samples: usize,
    },
    /// The faults asked for do not fit into the take beside each other.
    #[error(
        "no place was found for {kind} number {number} of {wanted} in {samples} samples: ask for fewer faults or a longer take"
    )]
    Crowded {
        /// Kind of the fault.
        kind: &'static str,
        /// Which of them, from 1.
        number: usize,
        /// How many were asked for.
        wanted: usize,
        /// Samples of the take.
        samples: usize,
    },
    /// The sample rate makes no clock.
    #[error(transparent)]
    Clock(#[from] ClockError),
    /// The tracks make no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}
