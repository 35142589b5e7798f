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
    /// A message does not fit its channel.
    #[error("{file}: {topic}, message {message}: expected {expected}, found {found}")]
    Message {
        /// File that was read.
        file: String,
        /// Topic of the channel.
        topic: String,
        /// Number of the message in its channel, from 0.
        message: usize,
        /// Expected content.
        expected: String,
        /// Content found.
        found: String,
    },
    /// A third-party recording leaves open what its messages mean.
    #[error("{file}: {topic}: expected {expected}, found {found}; {hint}")]
    Unclear {
        /// File that was read.
        file: String,
        /// Topic of the messages.
        topic: String,
        /// Expected content.
        expected: String,
        /// Content found.
        found: Box<str>,
        /// Remedy.
        hint: Box<str>,
    },
    /// A key of a metadata record is missing or does not parse.
    #[error(
        "{file}: metadata record \"{record}\", key \"{key}\": expected {expected}, found {found}"
    )]
    Metadata {
        /// File that was read.
        file: String,
        /// Name of the record.
        record: String,
        /// The key.
        key: String,
        /// Expected content.
        expected: String,
        /// Content found.
        found: String,
    },
    /// An intact file without what was asked for.
    #[error("{file}: no {what}: the file has {found}; {hint}")]
    Absent {
        /// File that was read.
        file: String,
        /// Content that is missing.
        what: String,
        /// Content found instead.
        found: String,
        /// Remedy.
        hint: String,
    },
    /// Values that cannot go into one file together.
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
        ChannelError::Message {
            file: file.to_owned(),
            topic: topic.to_owned(),
            message,
            expected: expected.to_string(),
            found: found.to_string(),
        }
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
