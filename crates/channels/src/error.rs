//! Errors of writing and reading takes, dictionaries and events as MCAP.

use std::fmt::Display;

use inhand_container::ContainerError;
use thiserror::Error;

/// An error of reading or writing a file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ChannelError {
    /// The file is no intact MCAP file, or cannot be read or written.
    #[error(transparent)]
    Container(#[from] ContainerError),
    /// An intact file without what was asked for: what it has instead and what to do.
    #[error("{0}")]
    Absent(String),
    /// A message, a metadata record or a value that is not what it must be.
    #[error("{what}: expected {expected}, found {found}")]
    Mismatch {
        /// Name of the value.
        what: String,
        /// Expected value.
        expected: String,
        /// Value found.
        found: String,
    },
}

/// Refuses what does not fit: `what`, what was expected of it and what was found.
pub(crate) fn ensure(
    fits: bool,
    what: impl Into<String>,
    expected: impl Display,
    found: impl Display,
) -> Result<(), ChannelError> {
    if fits {
        return Ok(());
    }
    Err(ChannelError::mismatch(what, expected, found))
}

impl ChannelError {
    pub(crate) fn message(
        file: &str,
        topic: &str,
        message: usize,
        expected: impl Display,
        found: impl Display,
    ) -> Self {
        let what = format!("{file}: {topic}, message {message}");
        Self::mismatch(what, expected, found)
    }

    pub(crate) fn mismatch(
        what: impl Into<String>,
        expected: impl Display,
        found: impl Display,
    ) -> Self {
        ChannelError::Mismatch {
            what: what.into(),
            expected: expected.to_string(),
            found: found.to_string(),
        }
    }
}
