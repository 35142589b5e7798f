//! Records as bytes: an opcode, a length, a body.

use std::io::Cursor;

use binrw::{BinWrite, BinWriterExt as _};
use mcap::records::op;

/// Opcode and length in front of each record.
pub(crate) const PREFIX_BYTES: usize = 9;

/// Length of the footer with its prefix.
pub(crate) const FOOTER_BYTES: usize = PREFIX_BYTES + FOOTER_COVERED_BYTES + 4;

/// Bytes of a footer's body that the checksum of the summary covers: where the summary and its
/// offsets start.
pub(crate) const FOOTER_COVERED_BYTES: usize = 16;

/// Bytes of a message record in front of its data: channel, sequence, log time, publish time.
pub(crate) const MESSAGE_HEADER_BYTES: usize = 22;

/// What a reader calls records of this kind.
pub(crate) fn name_of(opcode: u8) -> &'static str {
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

/// Whether records of this kind only point into the file or repeat it, so that a copy has its own.
pub(crate) fn is_made_anew(opcode: u8) -> bool {
    matches!(
        opcode,
        op::HEADER
            | op::MESSAGE_INDEX
            | op::CHUNK_INDEX
            | op::ATTACHMENT_INDEX
            | op::METADATA_INDEX
            | op::STATISTICS
            | op::SUMMARY_OFFSET
    )
}

/// The bytes in front of a body of this length.
pub(crate) fn prefix(opcode: u8, bytes: u64) -> [u8; PREFIX_BYTES] {
    let mut prefix = [opcode; PREFIX_BYTES];
    prefix[1..].copy_from_slice(&bytes.to_le_bytes());
    prefix
}

/// Adds a record to the bytes.
pub(crate) fn push_record(bytes: &mut Vec<u8>, opcode: u8, body: &[u8]) {
    bytes.extend_from_slice(&prefix(opcode, body.len() as u64));
    bytes.extend_from_slice(body);
}

/// The body of a record, but for data that follow its header.
pub(crate) fn to_bytes<T>(record: &T) -> Vec<u8>
where
    T: for<'a> BinWrite<Args<'a> = ()>,
{
    let mut bytes = Cursor::new(Vec::new());
    bytes
        .write_le(record)
        .expect("memory takes the numbers and texts of a record");
    bytes.into_inner()
}

/// Opcodes and bodies of the records that follow each other in these bytes; ends after `None`, where
/// one does not fit.
pub(crate) struct Records<'a>(pub(crate) &'a [u8]);

impl<'a> Iterator for Records<'a> {
    type Item = Option<(u8, &'a [u8])>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.0.is_empty() {
            return None;
        }
        let record = self.split();
        if record.is_none() {
            self.0 = &[];
        }
        Some(record)
    }
}

impl<'a> Records<'a> {
    fn split(&mut self) -> Option<(u8, &'a [u8])> {
        let (&[opcode, ref length @ ..], rest) = self.0.split_first_chunk::<PREFIX_BYTES>()?;
        let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
        let (body, rest) = rest.split_at_checked(length)?;
        self.0 = rest;
        Some((opcode, body))
    }
}

/// The channel and log time of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MessageFacts {
    pub(crate) channel: u16,
    pub(crate) log_time: u64,
}

impl MessageFacts {
    /// From the body of a message record; `None` where it is too short to be one.
    pub(crate) fn read(body: &[u8]) -> Option<Self> {
        let header = body.get(..MESSAGE_HEADER_BYTES)?;
        Some(Self {
            channel: id_of(header)?,
            log_time: u64::from_le_bytes(*header[6..].first_chunk()?),
        })
    }
}

/// Gives a schema, a channel or a message's channel another id.
pub(crate) fn set_id(body: &mut [u8], id: u16) {
    if let Some(bytes) = body.first_chunk_mut() {
        *bytes = id.to_le_bytes();
    }
}

/// Gives a message another log time.
pub(crate) fn set_log_time(body: &mut [u8], log_time: u64) {
    if let Some(bytes) = body.get_mut(6..).and_then(<[u8]>::first_chunk_mut) {
        *bytes = log_time.to_le_bytes();
    }
}

/// The id of a schema, a channel or a message's channel, which its body starts with.
pub(crate) fn id_of(body: &[u8]) -> Option<u16> {
    body.first_chunk().map(|id| u16::from_le_bytes(*id))
}

/// A range of log times that this one is in as well.
pub(crate) fn spanned(span: Option<(u64, u64)>, time: u64) -> (u64, u64) {
    span.map_or((time, time), |(start, end)| {
        (start.min(time), end.max(time))
    })
}
