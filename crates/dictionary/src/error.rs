//! Errors of learning and using dictionaries.

use thiserror::Error;

/// Reason why a dictionary cannot be learned or used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LearnError {
    /// A setting out of its range.
    #[error("{name} is {found}: expected {expected}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// The range.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
    /// More primitives than the segments support.
    #[error(
        "rank {rank} is too large for {segments} training segments of {rows} numbers: \
         the largest possible {kind} rank is {largest}; lower the rank or the stride"
    )]
    RankTooLarge {
        /// The rank asked for.
        rank: usize,
        /// The largest rank possible.
        largest: usize,
        /// Training segments.
        segments: usize,
        /// Numbers in a segment.
        rows: usize,
        /// Kind of dictionary.
        kind: &'static str,
    },
    /// Penalties under which nothing is the best factorisation.
    #[error(
        "the penalties are so heavy that every activation is zero: lower them (weights from 1e-7 to \
         1e-5 change a hand's dictionary without emptying it)"
    )]
    PenaltyOfEverything,
    /// Training segments or states of learning that cannot be used: which, why and what to do.
    #[error("{0}")]
    Data(String),
}

/// Refuses a setting out of its range.
pub(crate) fn check_setting(
    fits: bool,
    name: &'static str,
    expected: &'static str,
    found: f64,
) -> Result<(), LearnError> {
    let error = LearnError::Setting {
        name,
        expected,
        found,
    };
    if fits { Ok(()) } else { Err(error) }
}

impl LearnError {
    /// An error for `map_err` where segments or activations could not be read.
    pub fn reading(error: impl std::fmt::Display) -> Self {
        LearnError::Data(format!("training segments cannot be read: {error}"))
    }

    /// Segments or primitives of another size than the dictionary's.
    pub(crate) fn column_length(expected: usize, found: usize) -> Self {
        LearnError::Data(format!(
            "a segment of {found} numbers does not fit a dictionary of {expected} rows"
        ))
    }
}
