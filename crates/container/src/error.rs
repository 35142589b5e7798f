//! Errors of reading, copying and writing MCAP files, with their place.

use std::io;

use mcap::McapError;
use mcap::records::{Record, op};
use thiserror::Error;

use crate::fields::parse_record;
use crate::format::{FOOTER_BYTES, PREFIX_BYTES, name_of};
use crate::limit::memory_limit;

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
    /// A record that would take more memory than it may.
    #[error(
        "{file}: the {record} at byte {offset} takes {bytes} bytes of memory, the limit is {limit}; raise it with --memory-limit if the file is to be trusted"
    )]
    Memory {
        /// File that was read.
        file: String,
        /// Where the record starts.
        offset: u64,
        /// What kind of record it is.
        record: String,
        /// Bytes that it takes, unpacked.
        bytes: u64,
        /// Bytes that it may take.
        limit: u64,
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

/// A record of a file, the one that is being read.
#[derive(Clone, Copy)]
pub(crate) struct Place<'a> {
    pub(crate) file: &'a str,
    pub(crate) offset: u64,
}

/// The bytes from a place to the end of the file.
pub(crate) struct Rest {
    /// The first of them, [`Rest::SHOWN`] at most.
    pub(crate) start: Vec<u8>,
    pub(crate) bytes: u64,
}

impl Rest {
    pub(crate) const SHOWN: usize = 12;

    pub(crate) fn describe(&self) -> String {
        if self.bytes == 0 {
            return "nothing".to_owned();
        }
        let start: String = (self.start.iter().take(Self::SHOWN))
            .flat_map(|byte| byte.escape_ascii())
            .map(char::from)
            .collect();
        format!("\"{start}\" ({} bytes)", self.bytes)
    }
}

impl Place<'_> {
    /// Takes a record apart; an attachment's checksum is compared.
    pub(crate) fn parse(self, opcode: u8, body: &[u8]) -> Result<Record<'_>, ContainerError> {
        parse_record(opcode, body).map_err(|error| self.damaged(opcode, error))
    }

    /// The file ends before what starts here does.
    pub(crate) fn cut(self, rest: &Rest, after_footer: bool) -> ContainerError {
        let (record, expected) = match rest.start.split_first_chunk::<PREFIX_BYTES>() {
            _ if after_footer => ("the mark at the end", mcap::MAGIC.len() as u64),
            None if rest.bytes == 0 => ("the footer", (FOOTER_BYTES + mcap::MAGIC.len()) as u64),
            None => ("a record", PREFIX_BYTES as u64),
            Some((&[opcode, ref length @ ..], _)) => {
                match (opcode, u64::from_le_bytes(*length)) {
                    // Writers leave this length in place until they know the true one.
                    (op::CHUNK, u64::MAX) => ("a chunk that its writer never closed", u64::MAX),
                    (_, length) => (name_of(opcode), length.saturating_add(PREFIX_BYTES as u64)),
                }
            }
        };
        self.truncated(record, expected, rest.bytes)
    }

    pub(crate) fn truncated(self, record: &str, expected: u64, found: u64) -> ContainerError {
        ContainerError::Truncated {
            file: self.file.to_owned(),
            offset: self.offset,
            record: record.to_owned(),
            expected,
            found,
        }
    }

    /// Refuses a record beyond the memory limit.
    pub(crate) fn check_memory(self, opcode: u8, bytes: u64) -> Result<(), ContainerError> {
        let limit = memory_limit();
        match bytes <= limit {
            true => Ok(()),
            false => Err(ContainerError::Memory {
                file: self.file.to_owned(),
                offset: self.offset,
                record: name_of(opcode).to_owned(),
                bytes,
                limit,
            }),
        }
    }

    /// A checksum is another one.
    pub(crate) fn bad_sum(self, what: &str, stated: u32, calculated: u32) -> ContainerError {
        let crc = |sum: u32| format!("CRC {sum:08x}");
        self.error(what, crc(stated), crc(calculated))
    }

    /// Why a record of this kind does not parse.
    fn damaged(self, opcode: u8, error: McapError) -> ContainerError {
        let lengths =
            |stated: u64, available: u64| (format!("{stated} bytes"), available.to_string());
        let (expected, found) = match error {
            McapError::BadAttachmentCrc { saved, calculated } => {
                return self.bad_sum(name_of(opcode), saved, calculated);
            }
            McapError::BadChunkLength { header, available }
            | McapError::BadAttachmentLength { header, available } => lengths(header, available),
            McapError::BadSchemaLength { header, available } => {
                lengths(header.into(), available.into())
            }
            McapError::UnexpectedEof => return self.short(opcode),
            McapError::Parse(error) => (
                "fields as the format has them".to_owned(),
                error.root_cause().to_string(),
            ),
            other => ("a sound record".to_owned(), other.to_string()),
        };
        self.error(name_of(opcode), expected, found)
    }

    /// A record without room for its fields.
    pub(crate) fn short(self, opcode: u8) -> ContainerError {
        self.error(name_of(opcode), "all its fields", "a shorter record")
    }

    pub(crate) fn error(
        self,
        record: &str,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> ContainerError {
        ContainerError::Damaged {
            file: self.file.to_owned(),
            offset: self.offset,
            record: record.to_owned(),
            expected: expected.into(),
            found: found.into(),
        }
    }
}
