//! What the mcap crate finds wrong with a file, with the place.

use mcap::McapError;
use mcap::records::{ChunkHeader, op};

use super::is_mcap;
use crate::error::ChannelError;

/// Opcode and length in front of each record.
pub(super) const PREFIX_BYTES: usize = 9;

/// Length of the footer with its prefix.
const FOOTER_BYTES: usize = PREFIX_BYTES + 20;

/// A record of the file, the one that is being read.
pub(super) struct Place<'a> {
    file: &'a str,
    bytes: &'a [u8],
    offset: usize,
    after_footer: bool,
}

impl<'a> Place<'a> {
    /// The first record; refuses bytes that do not start as an MCAP file does.
    pub(super) fn start(file: &'a str, bytes: &'a [u8]) -> Result<Self, ChannelError> {
        if !is_mcap(bytes) {
            return Err(ChannelError::NotMcap {
                file: file.to_owned(),
                found: describe(bytes),
            });
        }
        Ok(Self {
            file,
            bytes,
            offset: mcap::MAGIC.len(),
            after_footer: false,
        })
    }

    /// Goes on to the record after this one.
    pub(super) fn advance(&mut self, opcode: u8, body: &[u8]) {
        self.offset += PREFIX_BYTES + body.len();
        self.after_footer = opcode == op::FOOTER;
    }

    /// Why the reader does not get past this record.
    pub(super) fn fault(&self, error: McapError) -> ChannelError {
        match error {
            McapError::UnexpectedEof | McapError::RecordTooLarge { .. } => self.cut(),
            McapError::BadMagic | McapError::BytesAfterEndMagic => self.error(
                "end of the file",
                "\\x89MCAP0\\r\\n and nothing after it".to_owned(),
                describe(self.rest()),
            ),
            McapError::BadDataCrc { .. } => self.damage("checksum of everything before it", error),
            McapError::BadSummaryCrc { .. } => self.damage("checksum of the summary", error),
            other => self.damaged(self.rest().first().copied().unwrap_or_default(), other),
        }
    }

    /// Why a record of this kind does not parse, here or in the chunk that starts here.
    pub(super) fn damaged(&self, opcode: u8, error: McapError) -> ChannelError {
        self.damage(name_of(opcode), error)
    }

    /// A record without room for its fields.
    pub(super) fn short(&self, opcode: u8) -> ChannelError {
        let (expected, found) = ("all its fields", "a shorter record");
        self.error(name_of(opcode), expected.to_owned(), found.to_owned())
    }

    /// Why the chunk that starts here does not unpack within `limit` bytes.
    pub(super) fn chunk_fault(
        &self,
        header: &ChunkHeader,
        limit: usize,
        error: McapError,
    ) -> ChannelError {
        let (expected, found) = match error {
            McapError::UnexpectedEof | McapError::UnexpectedEoc => (
                format!("{} bytes of whole records", header.uncompressed_size),
                "an end before that".to_owned(),
            ),
            McapError::RecordTooLarge { len, .. } | McapError::ChunkTooLarge(len) => (
                format!("at most {limit} bytes"),
                format!("a length of {len}"),
            ),
            McapError::DecompressionError(why) => (format!("{} data", header.compression), why),
            other => return self.damaged(op::CHUNK, other),
        };
        self.error(name_of(op::CHUNK), expected, found)
    }

    fn damage(&self, record: &str, error: McapError) -> ChannelError {
        let (expected, found) = match error {
            McapError::BadChunkCrc { saved, calculated }
            | McapError::BadAttachmentCrc { saved, calculated }
            | McapError::BadDataCrc { saved, calculated }
            | McapError::BadSummaryCrc { saved, calculated } => {
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
            McapError::Parse(error) => (
                "fields as the format has them".to_owned(),
                error.root_cause().to_string(),
            ),
            other => ("a sound record".to_owned(), other.to_string()),
        };
        self.error(record, expected, found)
    }

    fn error(&self, record: &str, expected: String, found: String) -> ChannelError {
        ChannelError::Damaged {
            file: self.file.to_owned(),
            offset: self.offset as u64,
            record: record.to_owned(),
            expected,
            found,
        }
    }

    /// The file ends before what starts here does.
    fn cut(&self) -> ChannelError {
        let rest = self.rest();
        let (record, expected) = match rest.split_first_chunk::<PREFIX_BYTES>() {
            _ if self.after_footer => ("the mark at the end", mcap::MAGIC.len() as u64),
            None if rest.is_empty() => ("the footer", (FOOTER_BYTES + mcap::MAGIC.len()) as u64),
            None => ("a record", PREFIX_BYTES as u64),
            Some((&[opcode, ref length @ ..], _)) => {
                match (opcode, u64::from_le_bytes(*length)) {
                    // Writers leave this length in place until they know the true one.
                    (op::CHUNK, u64::MAX) => ("a chunk that its writer never closed", u64::MAX),
                    (_, length) => (name_of(opcode), length.saturating_add(PREFIX_BYTES as u64)),
                }
            }
        };
        ChannelError::Truncated {
            file: self.file.to_owned(),
            offset: self.offset as u64,
            record: record.to_owned(),
            expected,
            found: rest.len() as u64,
        }
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.offset..]
    }
}

fn describe(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "nothing".to_owned();
    }
    let start: String = (bytes.iter().take(12))
        .flat_map(|byte| byte.escape_ascii())
        .map(char::from)
        .collect();
    format!("\"{start}\" ({} bytes)", bytes.len())
}

fn name_of(opcode: u8) -> &'static str {
    match opcode {
        op::HEADER => "header",
        op::FOOTER => "footer",
        op::SCHEMA => "schema",
        op::CHANNEL => "channel",
        op::MESSAGE => "message",
        op::CHUNK => "chunk",
        op::MESSAGE_INDEX => "message index",
        op::CHUNK_INDEX => "chunk index",
        op::ATTACHMENT => "attachment",
        op::ATTACHMENT_INDEX => "attachment index",
        op::STATISTICS => "statistics",
        op::METADATA => "metadata",
        op::METADATA_INDEX => "metadata index",
        op::SUMMARY_OFFSET => "summary offset",
        op::DATA_END => "end of the data",
        _ => "record of unknown kind",
    }
}
