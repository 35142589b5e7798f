//! Chunks of a damaged file, whatever their lengths and checksums say.

use mcap::records::op;

use crate::chunk::frame_bytes;
use crate::error::ContainerError;
use crate::format::Records;
use crate::limit::memory_limit;
use crate::recover::probe::{ChunkStart, Sought};
use crate::recover::scan::{Damage, FoundChunk, Kind, Scan};
use crate::source::Head;

/// Bytes of a message by which it is found again: channel, sequence, log time.
const OWN_BYTES: usize = 14;

impl Scan<'_, '_> {
    /// A chunk, whatever its lengths say; `None` where nothing here is one.
    pub(super) fn chunk(&mut self, head: Head) -> Result<Option<u64>, ContainerError> {
        let Some(chunk) = self.source.chunk_start(head)? else {
            return Ok(None);
        };
        for packed_bytes in chunk.lengths() {
            if let Some(next) = self.sound_chunk(head, &chunk, packed_bytes)? {
                return Ok(Some(next));
            }
        }
        let header = &chunk.header;
        let span = (header.message_start_time, header.message_end_time);
        let span = Some(span).filter(|&(start, end)| end != 0 && end >= start);
        let end = self.source.bytes();
        if chunk.by_header.is_none() && chunk.by_record.is_none() {
            let next = self.end_of_open(&chunk)?;
            self.unpack(&chunk, next - chunk.data, Kind::Open)?;
            let kept = Records(&self.records).flatten();
            let kept = kept.filter(|(opcode, _)| *opcode == op::MESSAGE).count();
            let what = match self.source.fits(head) {
                true => "a chunk beyond the memory limit (--memory-limit)".to_owned(),
                false if next == end => {
                    format!("the rest of a chunk that is cut off, after {kept} messages")
                }
                false => format!("the rest of a chunk that has no end, after {kept} messages"),
            };
            self.lose(head.offset, next, what, span);
            return Ok(Some(next));
        }
        let confirmed = self.confirmed_end(&chunk)?;
        let next = match confirmed {
            Some(next) => next,
            None if !header.compression.is_empty() => self.end_of_packed(&chunk)?,
            None => (self.source)
                .next_record(head.offset + 1, end, Sought::Any, &*self.visitor)?
                .unwrap_or(end),
        };
        // Of a chunk that is not packed and has no certain end, the records are found one by one.
        if next > chunk.data && (confirmed.is_some() || !header.compression.is_empty()) {
            self.unpack(&chunk, next - chunk.data, Kind::Damaged)?;
        }
        let what = match header.uncompressed_size > memory_limit() {
            true => format!(
                "a chunk of {} bytes, beyond the memory limit (--memory-limit)",
                header.uncompressed_size
            ),
            false => "a chunk whose content is damaged".to_owned(),
        };
        self.lose(head.offset, next, what, span);
        Ok(Some(next))
    }

    /// Unpacks what it can of a chunk and passes it on.
    fn unpack(
        &mut self,
        chunk: &ChunkStart,
        packed_bytes: u64,
        kind: Kind,
    ) -> Result<(), ContainerError> {
        let bytes = packed_bytes.min(memory_limit());
        self.source.unpack(chunk, bytes, &mut self.records)?;
        let found = FoundChunk {
            kind,
            compression: &chunk.header.compression,
            packed: None,
        };
        self.visitor.chunk(&found, &self.records)
    }

    /// Passes a chunk of so many packed bytes on if its checksum holds, or if it has none and is as long
    /// as it should be.
    fn sound_chunk(
        &mut self,
        head: Head,
        chunk: &ChunkStart,
        packed_bytes: u64,
    ) -> Result<Option<u64>, ContainerError> {
        let (packed, unpacked) = self.source.unpack(chunk, packed_bytes, &mut self.records)?;
        let header = &chunk.header;
        let is_whole = unpacked.is_ok && unpacked.bytes == self.records.len() as u64;
        let agree = chunk.by_record == chunk.by_header;
        let kind = match header.uncompressed_crc {
            0 if is_whole && agree && unpacked.bytes == header.uncompressed_size => Kind::Unchecked,
            crc if crc != 0 && unpacked.sums.contains(&crc) => Kind::Checked,
            _ => return Ok(None),
        };
        let frame = frame_bytes(&header.compression, &packed, &self.records);
        let frame = match frame {
            // Of a frame with bytes behind it: that it holds all.
            Some(bytes) if bytes < packed.len() => {
                let (_, alone) = self.source.unpack(chunk, bytes as u64, &mut self.records)?;
                frame.filter(|_| alone.is_ok && alone.sums == unpacked.sums)
            }
            _ => frame.filter(|_| unpacked.is_ok),
        };
        let end = chunk.data + frame.map_or(packed_bytes, |bytes| bytes as u64);
        // There may be more in the record than the packed bytes, or other records if its length is wrong.
        let padded = head.end() > end && self.source.fits(head) && {
            let inside = (self.source).next_record(end, head.end(), Sought::Any, &*self.visitor)?;
            inside.is_none() && self.source.follows(head.end(), &*self.visitor)?
        };
        let is_strict = frame == Some(packed.len()) && is_whole;
        self.has_data();
        let wrong = match () {
            () if !is_strict => Some("packing of a chunk"),
            () if !padded && !agree => Some("length of a chunk"),
            () if unpacked.bytes != header.uncompressed_size => Some("unpacked length of a chunk"),
            () => None,
        };
        if let Some(wrong) = wrong {
            self.visitor.damage(Damage::Mended(head.offset, wrong));
        }
        let found = FoundChunk {
            kind,
            compression: &header.compression,
            packed: frame.map(|bytes| &packed[..bytes]),
        };
        self.visitor.chunk(&found, &self.records)?;
        Ok(Some(if padded { head.end() } else { end }))
    }

    /// Where a packed chunk of unknown length ends: at the next record that is not one of its own, since
    /// some packings leave records as they are.
    fn end_of_packed(&mut self, chunk: &ChunkStart) -> Result<u64, ContainerError> {
        let (end, visitor) = (self.source.bytes(), &*self.visitor);
        let outside = (self.source).next_record(chunk.data, end, Sought::Outside, visitor)?;
        let outside = outside.unwrap_or(end);
        let bytes = (outside - chunk.data).min(memory_limit());
        self.source.unpack(chunk, bytes, &mut self.records)?;
        // Compared by their ids and log times: the rest may be packed all the same.
        let start = |body: &[u8]| {
            let mut start = [0; OWN_BYTES];
            let bytes = body.len().min(OWN_BYTES);
            start[..bytes].copy_from_slice(&body[..bytes]);
            start
        };
        let mut own: Vec<[u8; OWN_BYTES]> = (Records(&self.records).flatten())
            .filter(|(opcode, _)| matches!(*opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE))
            .map(|(_, body)| start(body))
            .collect();
        own.sort_unstable();
        let (mut from, mut body) = (chunk.data, Vec::new());
        while let Some(next) = (self.source).next_record(from, outside, Sought::Any, visitor)? {
            let Some(head) = self.source.head_at(next)? else {
                break;
            };
            let bytes = head.bytes.min(OWN_BYTES as u64);
            self.source.read_at(head.body(), bytes, &mut body)?;
            if own.binary_search(&start(&body)).is_err() {
                return Ok(next);
            }
            from = next + 1;
        }
        Ok(outside)
    }

    /// Where a chunk without an end stops: of one that is not packed, behind the last record that belongs
    /// into chunks.
    fn end_of_open(&mut self, chunk: &ChunkStart) -> Result<u64, ContainerError> {
        if !chunk.header.compression.is_empty() {
            return self.end_of_packed(chunk);
        }
        let mut offset = chunk.data;
        while let Some(head) = self.source.head_at(offset)?
            && matches!(head.opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE)
            && self.source.fits(head)
            && head.end() - chunk.data <= memory_limit()
            && self.source.is_followed(head)?
        {
            offset = head.end();
        }
        let end = self.source.bytes();
        let next = (self.source).next_record(offset, end, Sought::Any, &*self.visitor)?;
        Ok(next.unwrap_or(end))
    }

    /// The end of a damaged chunk, where there is no doubt: a record follows there, and none of
    /// others lies before.
    fn confirmed_end(&mut self, chunk: &ChunkStart) -> Result<Option<u64>, ContainerError> {
        for bytes in chunk.lengths() {
            let end = chunk.data + bytes;
            if !self.source.follows(end, &*self.visitor)? {
                continue;
            }
            if chunk.header.compression.is_empty() {
                let (_, unpacked) = self.source.unpack(chunk, bytes, &mut self.records)?;
                let of_chunks =
                    |opcode| matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE | 0x80..);
                let mut records = Records(&self.records).flatten();
                if unpacked.bytes != self.records.len() as u64
                    || !records.all(|(opcode, _)| of_chunks(opcode))
                {
                    continue;
                }
            }
            let first = match chunk.header.compression.is_empty() {
                true => {
                    (self.source).next_record(chunk.data, end, Sought::Chunks, &*self.visitor)?
                }
                false => Some(self.end_of_packed(chunk)?),
            };
            if first.is_none_or(|first| first >= end) {
                return Ok(Some(end));
            }
        }
        Ok(None)
    }
}
