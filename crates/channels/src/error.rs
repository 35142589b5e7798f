//! Errors of writing and reading takes, dictionaries and events as MCAP.

use std::fmt::Display;
use std::io;

use thiserror::Error;

/// Why a file cannot be written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ChannelError {
    /// The bytes are something else.
    #[error("{file}: not an MCAP file: expected it to start with \\x89MCAP0\\r\\n, found {found}")]
    NotMcap {
        /// File that was read.
        file: String,
        /// Its first bytes, in words.
        found: String,
    },
    /// The file ends too early.
    #[error(
        "{file}: the file is cut off: {record} at byte {offset} needs {expected} bytes, {found} are left; copy the file again or record it anew (`inhand recover` saves what is complete)"
    )]
    Truncated {
        /// File that was read.
        file: String,
        /// Where the record starts.
        offset: u64,
        /// What kind of record is cut.
        record: String,
        /// Bytes that it needs.
        expected: u64,
        /// Bytes that are left.
        found: u64,
    },
    /// Bytes that contradict the format or their checksum.
    #[error(
        "{file}: damaged at byte {offset} ({record}): expected {expected}, found {found}; copy the file again (`inhand recover` saves what is sound)"
    )]
    Damaged {
        /// File that was read.
        file: String,
        /// Where the record starts.
        offset: u64,
        /// What kind of record it is.
        record: String,
        /// What should be there.
        expected: String,
        /// What is there.
        found: String,
    },
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
    /// A recording of others leaves open what its messages mean.
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
    /// A sound file without what was asked for.
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
    /// The file could not be read for another reason.
    #[error(transparent)]
    Container {
        /// Why.
        source: Box<inhand_container::ContainerError>,
    },
    /// The file could not be written.
    #[error("writing MCAP failed")]
    Write {
        /// Why.
        source: io::Error,
    },
}

impl ChannelError {
    pub(crate) fn write(error: mcap::McapError) -> Self {
        ChannelError::Write {
            source: match error {
                mcap::McapError::Io(source) => source,
                other => io::Error::other(other),
            },
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
