//! Findings about data that could still be used, and changes that cleaning made to it.

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::names::named;

named! {
    /// How much a finding matters.
    #[derive(PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Severity {
        /// Worth knowing.
        Info = "info",
        /// A number may be affected.
        Warning = "warning",
    }
}

/// Something found in data that was read all the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// Where: a line, column, marker or time, in words; empty for the whole take.
    pub place: String,
    /// What was expected, what was found, what was done about it.
    pub message: String,
}

impl Finding {
    /// A finding that may affect a number.
    pub fn warning(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Warning,
            place: place.into(),
            message: message.into(),
        }
    }

    /// A finding worth knowing.
    pub fn info(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Info,
            place: place.into(),
            message: message.into(),
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.place.is_empty() {
            f.write_str(&self.message)
        } else {
            write!(f, "{}: {}", self.place, self.message)
        }
    }
}

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
