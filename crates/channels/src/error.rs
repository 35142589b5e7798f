//! Errors of writing and reading takes, dictionaries and events as MCAP.

use std::fmt::Display;

use inhand_container::ContainerError;
use thiserror::Error;

/// Why a file cannot be written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ChannelError {
    /// The file is no intact MCAP file, or cannot be read or written.
    #[error(transparent)]
    Container(#[from] ContainerError),
    /// A message does not say what its channel promises.
    #[error("{file}: {topic}, message {message}: expected {expected}, found {found}")]
    Message {
        /// File that was read.
        file: String,
        /// Topic of the channel.
        topic: String,
        /// Number of the message in its channel, from 0.
        message: usize,
        /// What should be there.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A third-party recording leaves open what its messages mean.
    #[error("{file}: {topic}: expected {expected}, found {found}; {hint}")]
    Unclear {
        /// File that was read.
        file: String,
        /// Topic of the messages.
        topic: String,
        /// What would be clear.
        expected: String,
        /// What is there.
        found: Box<str>,
        /// What to do.
        hint: Box<str>,
    },
    /// A metadata record does not say what it should.
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
        /// What should be there.
        expected: String,
        /// What is there.
        found: String,
    },
    /// An intact file without what was asked for.
    #[error("{file}: no {what}: the file has {found}; {hint}")]
    Absent {
        /// File that was read.
        file: String,
        /// What was asked for.
        what: String,
        /// What the file has instead.
        found: String,
        /// What to do.
        hint: String,
    },
    /// Values that cannot go into one file together.
    #[error("{what}: expected {expected}, found {found}")]
    Mismatch {
        /// Which value.
        what: String,
        /// What would fit.
        expected: String,
        /// What was given.
        found: String,
    },
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
