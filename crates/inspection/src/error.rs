//! Errors of detection and cleaning.

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
    /// Too few markers of a cluster say where another one is.
    #[error(
        "take \"{take}\": marker \"{marker}\" of the cluster \"{cluster}\" has {found} others that are \
         no fingertip, and 3 are needed to fill it by the cluster: name more markers, or fill by another \
         method"
    )]
    TooFewMarkers {
        /// The take.
        take: String,
        /// The marker with a gap.
        marker: String,
        /// The markers that make the cluster.
        cluster: String,
        /// How many others there are.
        found: usize,
    },
    /// The new rate makes no clock.
    #[error(transparent)]
    Clock(#[from] ClockError),
    /// The new tracks make no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}
