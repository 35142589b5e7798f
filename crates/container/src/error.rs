//! Errors of reading, copying and writing MCAP files.

use std::io;

use thiserror::Error;

/// Why a file cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ContainerError {
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
    /// Files whose channels cannot lie in one file as they are.
    #[error("{file}: {what}: expected {expected}, found {found}")]
    Collision {
        /// The file that does not go with those before it.
        file: String,
        /// Which part of it.
        what: String,
        /// What would go with them.
        expected: String,
        /// What it has.
        found: String,
    },
    /// What was written does not read back as it was meant.
    #[error("{what}: expected {expected}, found {found}; the output is not kept")]
    Verification {
        /// Which number.
        what: String,
        /// What was written.
        expected: u64,
        /// What is read.
        found: u64,
    },
    /// The file could not be read.
    #[error("{file}: reading failed")]
    Read {
        /// File that was read.
        file: String,
        /// Why.
        source: io::Error,
    },
    /// The file could not be written.
    #[error("writing MCAP failed")]
    Write {
        /// Why.
        source: io::Error,
    },
}

impl ContainerError {
    pub(crate) fn write(source: io::Error) -> Self {
        ContainerError::Write { source }
    }
}
