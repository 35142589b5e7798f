//! Changes that a cleaning step made to a recording.

use std::fmt;
use std::ops::Range;

use crate::names::named;

named! {
    /// What kind of change it is.
    #[derive(PartialOrd, Ord, Hash)]
    pub enum ChangeKind {
        /// Fingertip labels were given back to their own fingers.
        Swapped = "swapped",
        /// A body in a wrong pose was turned back.
        TurnedBack = "turned_back",
        /// Samples were taken away and are missing now.
        Removed = "removed",
        /// Samples of an unlabelled marker were given to a fingertip.
        Stitched = "stitched",
        /// Missing samples were filled.
        Filled = "filled",
        /// Samples were computed anew at another rate.
        Resampled = "resampled",
        /// A marker was moved to where the pad of its finger is.
        Moved = "moved",
    }
}

/// One change to a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// What was done.
    pub kind: ChangeKind,
    /// The marker or body that was changed, or several separated by commas.
    pub entity: String,
    /// The samples that were changed, in the recording that it was done to.
    pub samples: Range<usize>,
    /// What was found and what was done about it.
    pub message: String,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.entity, self.message)
    }
}
