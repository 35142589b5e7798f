//! Faults of a file, with their place.

use mcap::McapError;
use mcap::records::op;

use crate::error::ContainerError;
use crate::format::{ChunkFacts, FOOTER_BYTES, PREFIX_BYTES, name_of};

/// A record of a file, the one that is being read.
#[derive(Clone, Copy)]
pub(crate) struct Place<'a> {
    pub(crate) file: &'a str,
    pub(crate) offset: u64,
}

/// What lies from a place to the end of the file.
pub(crate) struct Rest {
    /// The first bytes of it, [`Rest::SHOWN`] at most.
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
        ContainerError::Truncated {
            file: self.file.to_owned(),
            offset: self.offset,
            record: record.to_owned(),
            expected,
            found: rest.bytes,
        }
    }

    /// The footer is not followed by the mark at the end and that alone.
    pub(crate) fn bad_end(self, rest: &Rest) -> ContainerError {
        self.error(
            "end of the file",
            "\\x89MCAP0\\r\\n and nothing after it",
            rest.describe(),
        )
    }

    /// A checksum over several records is another one.
    pub(crate) fn bad_sum(self, what: &str, saved: u32, calculated: u32) -> ContainerError {
        self.error(
            what,
            format!("CRC {saved:08x}"),
            format!("CRC {calculated:08x}"),
        )
    }

    /// Why a record of this kind does not parse, here or in the chunk that starts here.
    pub(crate) fn damaged(self, opcode: u8, error: McapError) -> ContainerError {
        let (expected, found) = match error {
            McapError::BadChunkCrc { saved, calculated }
            | McapError::BadAttachmentCrc { saved, calculated } => {
                (format!("CRC {saved:08x}"), format!("CRC {calculated:08x}"))
            }
            McapError::BadChunkLength { header, available }
            | McapError::BadAttachmentLength { header, available } => {
                (format!("{header} bytes"), format!("{available}"))
            }
            McapError::BadSchemaLength { header, available } => {
                (format!("{header} bytes"), format!("{available}"))
            }
            McapError::UnsupportedCompression(name) => (
                "compression by zstd, lz4 or none".to_owned(),
                format!("\"{name}\""),
            ),
            McapError::UnexpectedEof => {
                ("all its fields".to_owned(), "a shorter record".to_owned())
            }
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

    /// Why the chunk that starts here does not unpack within `limit` bytes.
    pub(crate) fn chunk_fault(
        self,
        facts: &ChunkFacts,
        limit: usize,
        error: McapError,
    ) -> ContainerError {
        let (expected, found) = match error {
            McapError::UnexpectedEof | McapError::UnexpectedEoc => (
                format!("{} bytes of whole records", facts.unpacked_bytes),
                "an end before that".to_owned(),
            ),
            McapError::RecordTooLarge { len, .. } | McapError::ChunkTooLarge(len) => (
                format!("at most {limit} bytes"),
                format!("a length of {len}"),
            ),
            McapError::DecompressionError(why) => (format!("{} data", facts.compression), why),
            other => return self.damaged(op::CHUNK, other),
        };
        self.error(name_of(op::CHUNK), expected, found)
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
