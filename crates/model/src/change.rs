//! Changes that a cleaning step made to a recording.

use std::fmt;
use std::ops::Range;

/// What kind of change it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ChangeKind {
    /// Fingertip labels were given back to their own fingers.
    Swapped,
    /// A body in a wrong pose was turned back.
    TurnedBack,
    /// Samples were taken away and are missing now.
    Removed,
    /// Samples of an unlabelled marker were given to a fingertip.
    Stitched,
    /// Missing samples were filled.
    Filled,
    /// Samples were computed anew at another rate.
    Resampled,
    /// A marker was moved to where the pad of its finger is.
    Moved,
}

impl ChangeKind {
    /// Every kind.
    pub const ALL: [ChangeKind; 7] = [
        ChangeKind::Swapped,
        ChangeKind::TurnedBack,
        ChangeKind::Removed,
        ChangeKind::Stitched,
        ChangeKind::Filled,
        ChangeKind::Resampled,
        ChangeKind::Moved,
    ];

    /// Lower-case name, as in files.
    pub const fn name(self) -> &'static str {
        match self {
            ChangeKind::Swapped => "swapped",
            ChangeKind::TurnedBack => "turned_back",
            ChangeKind::Removed => "removed",
            ChangeKind::Stitched => "stitched",
            ChangeKind::Filled => "filled",
            ChangeKind::Resampled => "resampled",
            ChangeKind::Moved => "moved",
        }
    }

    /// The kind of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        ChangeKind::ALL.into_iter().find(|kind| kind.name() == name)
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
