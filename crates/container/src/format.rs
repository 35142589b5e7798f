//! Records as bytes: an opcode, a length, a body.

use mcap::records::op;

/// Opcode and length in front of each record.
pub(crate) const PREFIX_BYTES: usize = 9;

/// Length of the footer with its prefix.
pub(crate) const FOOTER_BYTES: usize = PREFIX_BYTES + FOOTER_COVERED_BYTES + 4;

/// Bytes of a footer's body that the checksum of the summary covers: where the summary and its
/// offsets start.
pub(crate) const FOOTER_COVERED_BYTES: usize = 16;

/// Bytes of a chunk record in front of its packed records, but for the name of the compression:
/// start and end time, size, CRC, two lengths.
pub(crate) const CHUNK_HEADER_BYTES: usize = 40;

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

/// Adds a record to the bytes.
pub(crate) fn push_record(bytes: &mut Vec<u8>, opcode: u8, body: &[u8]) {
    bytes.push(opcode);
    bytes.extend_from_slice(&(body.len() as u64).to_le_bytes());
    bytes.extend_from_slice(body);
}

/// Adds a text with its length in front.
pub(crate) fn push_text(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend_from_slice(&(text.len() as u32).to_le_bytes());
    bytes.extend_from_slice(text.as_bytes());
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

/// What stands in front of a message's data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MessageFacts {
    pub(crate) channel: u16,
    pub(crate) log_time: u64,
}

impl MessageFacts {
    /// From the body of a message record; `None` where it is too short to be one.
    pub(crate) fn of(body: &[u8]) -> Option<Self> {
        if body.len() < MESSAGE_HEADER_BYTES {
            return None;
        }
        let (channel, rest) = body.split_first_chunk()?;
        let (_sequence, rest) = rest.split_first_chunk::<4>()?;
        let (log_time, _) = rest.split_first_chunk()?;
        Some(Self {
            channel: u16::from_le_bytes(*channel),
            log_time: u64::from_le_bytes(*log_time),
        })
    }
}

/// Gives a message another channel.
pub(crate) fn set_channel(body: &mut [u8], channel: u16) {
    if let Some(bytes) = body.first_chunk_mut() {
        *bytes = channel.to_le_bytes();
    }
}

/// Gives a message another log time.
pub(crate) fn set_log_time(body: &mut [u8], log_time: u64) {
    if let Some(bytes) = body.get_mut(6..).and_then(<[u8]>::first_chunk_mut) {
        *bytes = log_time.to_le_bytes();
    }
}

/// The number that a schema or channel goes by, which its body starts with.
pub(crate) fn id_of(body: &[u8]) -> Option<u16> {
    body.first_chunk().map(|id| u16::from_le_bytes(*id))
}

/// The start of a chunk record's body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ChunkFacts {
    pub(crate) start: u64,
    pub(crate) end: u64,
    pub(crate) unpacked_bytes: u64,
    pub(crate) crc: u32,
    pub(crate) compression: String,
    pub(crate) packed_bytes: u64,
}

impl ChunkFacts {
    /// From what a chunk record's body starts with; `None` where that is too short or no text.
    pub(crate) fn of(body: &[u8]) -> Option<Self> {
        let (start, rest) = body.split_first_chunk()?;
        let (end, rest) = rest.split_first_chunk()?;
        let (unpacked_bytes, rest) = rest.split_first_chunk()?;
        let (crc, rest) = rest.split_first_chunk()?;
        let (length, rest) = rest.split_first_chunk()?;
        let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
        let (compression, rest) = rest.split_at_checked(length)?;
        let (packed_bytes, _) = rest.split_first_chunk()?;
        Some(Self {
            start: u64::from_le_bytes(*start),
            end: u64::from_le_bytes(*end),
            unpacked_bytes: u64::from_le_bytes(*unpacked_bytes),
            crc: u32::from_le_bytes(*crc),
            compression: str::from_utf8(compression).ok()?.to_owned(),
            packed_bytes: u64::from_le_bytes(*packed_bytes),
        })
    }

    /// Bytes of the body in front of the packed records.
    pub(crate) fn header_bytes(&self) -> usize {
        CHUNK_HEADER_BYTES + self.compression.len()
    }

    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.header_bytes());
        bytes.extend_from_slice(&self.start.to_le_bytes());
        bytes.extend_from_slice(&self.end.to_le_bytes());
        bytes.extend_from_slice(&self.unpacked_bytes.to_le_bytes());
        bytes.extend_from_slice(&self.crc.to_le_bytes());
        push_text(&mut bytes, &self.compression);
        bytes.extend_from_slice(&self.packed_bytes.to_le_bytes());
        bytes
    }
}
