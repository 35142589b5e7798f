//! Finds where records start in bytes that are not to be trusted.

use mcap::records::{ChunkHeader, op};

use crate::chunk::{Packing, Unpacked, header_bytes, unpack_start};
use crate::error::ContainerError;
use crate::fields::{attachment_index, chunk_header, stated_bytes, summed_bytes};
use crate::format::{MessageFacts, PREFIX_BYTES, id_of};
use crate::limit::memory_limit;
use crate::overview::CHUNK_START_BYTES;
use crate::source::{Head, Source};

/// Bytes that are searched at once: a few at first, since the next record is mostly near, and at most so many.
const WINDOW_BYTES: (u64, u64) = (4 << 10, 1 << 20);

/// Bytes of a record by which it is recognised.
const PARSED_BYTES: u64 = 64 << 10;

/// First byte of the mark that files start and end with.
const MAGIC_START: u8 = mcap::MAGIC[0];

/// Nanoseconds.
const HOUR: u64 = 3_600_000_000_000;

/// What is known of a file's messages.
pub(super) trait Known {
    /// Whether the file has the channel that a message names.
    fn knows(&self, message: MessageFacts) -> bool;
    /// Whether it was logged while others were; `None` where no others are known.
    fn spans(&self, message: MessageFacts) -> Option<bool>;
}

/// Kinds of records to search for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Sought {
    Any,
    /// Those that chunks do not hold.
    Outside,
    Chunks,
}

impl Sought {
    fn includes(self, opcode: u8) -> bool {
        match self {
            Sought::Any => true,
            Sought::Outside => !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE),
            Sought::Chunks => opcode == op::CHUNK,
        }
    }
}

/// The start of a chunk record, taken apart.
pub(super) struct ChunkStart {
    pub(super) header: ChunkHeader,
    /// Where its packed records start.
    pub(super) data: u64,
    /// Length of the packed records as the record and as the chunk's header state it, where the file
    /// has as many bytes.
    pub(super) by_record: Option<u64>,
    pub(super) by_header: Option<u64>,
}

impl ChunkStart {
    /// The lengths that it may have, the shorter one first.
    pub(super) fn lengths(&self) -> impl Iterator<Item = u64> {
        let (record, header) = (self.by_record, self.by_header);
        let shorter = record.into_iter().chain(header).min();
        let longer = record.max(header).filter(|_| record != header);
        shorter
            .into_iter()
            .chain(longer.filter(|&longer| Some(longer) != shorter))
    }
}

impl Source<'_> {
    /// What the bytes here say as the head of a record; `None` where the file ends before it.
    pub(super) fn head_at(&mut self, offset: u64) -> Result<Option<Head>, ContainerError> {
        let mut prefix = Vec::new();
        self.read_at(offset, PREFIX_BYTES as u64, &mut prefix)?;
        Ok(head_of(offset, &prefix))
    }

    /// Whether the file is long enough for a record.
    pub(super) fn fits(&self, head: Head) -> bool {
        head.bytes <= self.bytes().saturating_sub(head.body())
    }

    /// Whether the mark that files start and end with is here.
    pub(super) fn is_magic(&mut self, offset: u64) -> Result<bool, ContainerError> {
        let mut magic = Vec::new();
        self.read_at(offset, mcap::MAGIC.len() as u64, &mut magic)?;
        Ok(magic == mcap::MAGIC)
    }

    /// The chunk that starts here; `None` where nothing here is one.
    pub(super) fn chunk_start(&mut self, head: Head) -> Result<Option<ChunkStart>, ContainerError> {
        let left = self.bytes().saturating_sub(head.body());
        let mut start = Vec::new();
        self.read_at(head.body(), left.min(CHUNK_START_BYTES), &mut start)?;
        let header = chunk_header(&start);
        let known = |header: &ChunkHeader| Packing::from_name(&header.compression).is_some();
        Ok(header.filter(known).map(|header| {
            let header_bytes = header_bytes(&header) as u64;
            let most = left.saturating_sub(header_bytes).min(memory_limit());
            ChunkStart {
                data: head.body() + header_bytes,
                by_record: (head.bytes.checked_sub(header_bytes)).filter(|&bytes| bytes <= most),
                by_header: Some(header.compressed_size).filter(|&bytes| bytes <= most),
                header,
            }
        }))
    }

    /// Unpacks so many packed bytes of a chunk as far as they can be; gives them with what it found.
    pub(super) fn unpack(
        &mut self,
        chunk: &ChunkStart,
        packed_bytes: u64,
        records: &mut Vec<u8>,
    ) -> Result<(Vec<u8>, Unpacked), ContainerError> {
        let mut packed = Vec::new();
        self.read_at(chunk.data, packed_bytes, &mut packed)?;
        let unpacked = unpack_start(&chunk.header, &packed, records);
        Ok((packed, unpacked))
    }

    /// Whether what starts here shows that the record before it is as long as it says.
    pub(super) fn follows(
        &mut self,
        offset: u64,
        known: &dyn Known,
    ) -> Result<bool, ContainerError> {
        if offset == self.bytes() || self.is_magic(offset)? {
            return Ok(true);
        }
        match self.head_at(offset)? {
            Some(head) if head.opcode >= 0x80 && self.fits(head) => self.is_followed(head),
            Some(head) if self.is_likely(head) => self.starts(head, known),
            _ => Ok(false),
        }
    }

    /// The first place from `offset` on, and before `until`, at which a record starts.
    pub(super) fn next_record(
        &mut self,
        mut offset: u64,
        until: u64,
        sought: Sought,
        known: &dyn Known,
    ) -> Result<Option<u64>, ContainerError> {
        let (mut window, (mut most, largest)) = (Vec::new(), WINDOW_BYTES);
        while offset < until {
            // Up to the end of a head that starts as late as it may.
            let heads = (until - offset).saturating_add(PREFIX_BYTES as u64 - 1);
            self.read_at(offset, heads.min(most), &mut window)?;
            for start in 0..window.len().saturating_sub(PREFIX_BYTES - 1) {
                let begin = &window[start..];
                if !matches!(begin[0], op::HEADER..=op::DATA_END | MAGIC_START) {
                    continue;
                }
                let at = offset + start as u64;
                if sought != Sought::Chunks && begin.starts_with(mcap::MAGIC) {
                    return Ok(Some(at));
                }
                if let Some(head) = head_of(at, begin)
                    && sought.includes(head.opcode)
                    && self.is_likely(head)
                    && self.starts(head, known)?
                {
                    return Ok(Some(at));
                }
            }
            if (window.len() as u64) < most {
                break;
            }
            // A head may lie across two windows.
            offset += most - (PREFIX_BYTES as u64 - 1);
            most = largest.min(2 * most);
        }
        Ok(None)
    }

    /// Whether records follow each other from one place to the other.
    pub(super) fn leads_to(&mut self, mut offset: u64, end: u64) -> Result<bool, ContainerError> {
        while offset < end {
            match self.head_at(offset)? {
                Some(head) if head.opcode >= 0x80 || self.is_likely(head) => offset = head.end(),
                _ => return Ok(false),
            }
        }
        Ok(offset == end)
    }

    /// By its head alone.
    fn is_likely(&self, head: Head) -> bool {
        let least = match head.opcode {
            op::HEADER => 8,
            op::SCHEMA => 14,
            op::CHANNEL => 16,
            op::MESSAGE => 22,
            op::CHUNK => return head.bytes >= 40,
            op::MESSAGE_INDEX => 6,
            op::CHUNK_INDEX => 64,
            op::ATTACHMENT => 36,
            op::STATISTICS => 46,
            op::METADATA => 8,
            op::ATTACHMENT_INDEX => 48,
            op::METADATA_INDEX => 20,
            op::SUMMARY_OFFSET => return head.bytes == 17 && self.fits(head),
            op::DATA_END => return head.bytes == 4 && self.fits(head),
            op::FOOTER => return head.bytes == 20 && self.fits(head),
            _ => return false,
        };
        head.bytes >= least && self.fits(head)
    }

    /// Whether the head of a record, the mark at the end or the end itself follows.
    pub(super) fn is_followed(&mut self, head: Head) -> Result<bool, ContainerError> {
        Ok(match self.head_at(head.end())? {
            None => head.end() == self.bytes() || self.is_magic(head.end())?,
            Some(next) if next.opcode >= 0x80 => self.fits(next) || self.is_magic(head.end())?,
            Some(next) => self.is_likely(next),
        })
    }

    /// Whether a record starts here, by its content, and where that says little by what follows.
    fn starts(&mut self, head: Head, known: &dyn Known) -> Result<bool, ContainerError> {
        if head.opcode == op::CHUNK {
            return self.chunk_starts(head);
        }
        let mut body = Vec::new();
        self.read_at(head.body(), head.bytes.min(PARSED_BYTES), &mut body)?;
        let whole = body.len() as u64 == head.bytes;
        let parses = |body| self.place(head.offset).parse(head.opcode, body).is_ok();
        match head.opcode {
            op::MESSAGE => {
                let message = MessageFacts::read(&body).filter(|message| known.knows(*message));
                Ok(match message {
                    Some(message) => {
                        let is_timely = known.spans(message).unwrap_or_else(|| is_prompt(&body));
                        is_timely || self.is_followed(head)?
                    }
                    None => false,
                })
            }
            op::ATTACHMENT => {
                let index = attachment_index(&body, head.bytes);
                Ok(
                    match index.map(|index| summed_bytes(&index) + 4 == head.bytes) {
                        Some(is_exact) => is_exact || self.is_followed(head)?,
                        None => false,
                    },
                )
            }
            op::SCHEMA if id_of(&body) == Some(0) => Ok(false),
            op::DATA_END | op::FOOTER => Ok(whole),
            op::HEADER | op::SCHEMA | op::CHANNEL | op::METADATA | op::MESSAGE_INDEX => {
                let stated = stated_bytes(head.opcode, &body);
                Ok(match stated == Some(head.bytes) {
                    true => !whole || parses(&body),
                    // Padded.
                    false => whole && parses(&body) && self.is_followed(head)?,
                })
            }
            _ if whole && parses(&body) => self.is_followed(head),
            _ => Ok(false),
        }
    }

    /// Whether a chunk starts here: both its lengths agree, or its checksum holds for one of them.
    fn chunk_starts(&mut self, head: Head) -> Result<bool, ContainerError> {
        let Some(chunk) = self.chunk_start(head)? else {
            return Ok(false);
        };
        if chunk.by_record.is_some() && chunk.by_record == chunk.by_header {
            return Ok(true);
        }
        let crc = chunk.header.uncompressed_crc;
        for bytes in chunk.lengths() {
            let (_, unpacked) = self.unpack(&chunk, bytes, &mut Vec::new())?;
            if crc != 0 && unpacked.sums.contains(&crc) {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// Whether a message was logged within an hour of its publication.
fn is_prompt(body: &[u8]) -> bool {
    let time = |at: usize| {
        body.get(at..)?
            .first_chunk()
            .map(|time| u64::from_le_bytes(*time))
    };
    let (logged, published) = (time(6), time(14));
    logged
        .zip(published)
        .is_some_and(|(logged, published)| logged.abs_diff(published) < HOUR)
}

fn head_of(offset: u64, bytes: &[u8]) -> Option<Head> {
    let (&[opcode, ref length @ ..], _) = bytes.split_first_chunk::<PREFIX_BYTES>()?;
    let length = u64::from_le_bytes(*length);
    Some(Head {
        offset,
        opcode,
        // Lengths beyond any file would run over where they are added.
        bytes: length.min(u64::MAX >> 1),
    })
}
