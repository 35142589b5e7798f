//! Errors of detection and cleaning.

use inhand_model::ClockError;
use inhand_motion::MotionError;
use thiserror::Error;

/// Why a recording could not be searched or cleaned.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CleaningError {
    /// A setting is out of range, a role names nothing in the take, or the hand's pose cannot be fitted.
    #[error(transparent)]
    Motion(#[from] MotionError),
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
}
