//! Why a recording could not be searched or cleaned.

use inhand_model::{ClockError, RecordingError};
use inhand_motion::MotionError;
use thiserror::Error;

/// Why a recording could not be searched or cleaned.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CleaningError {
    /// A setting outside its range.
    #[error("{setting} is {found}: expected {expected}")]
    Setting {
        /// The setting.
        setting: &'static str,
        /// The value found.
        found: String,
        /// What it may be.
        expected: &'static str,
    },
    /// A role names a marker or body that the take does not contain.
    #[error(
        "take \"{take}\" has no {kind} \"{name}\", wanted as {role}: map the role to one that it has"
    )]
    NotInTake {
        /// The take.
        take: String,
        /// What was wanted of it.
        role: String,
        /// `rigid body` or `marker`.
        kind: &'static str,
        /// The name looked for.
        name: String,
    },
    /// The hand's pose could not be fitted to its markers.
    #[error(transparent)]
    Hand(#[from] MotionError),
    /// The new rate makes no clock.
    #[error(transparent)]
    Clock(#[from] ClockError),
    /// The new tracks make no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}
