//! A file written from records as bytes, with indexes, summary and checksums of its own.

use std::io::Write;

use crc32fast::Hasher;
use mcap::records::op;

use crate::chunk::Packing;
use crate::error::ContainerError;
use crate::format::{ChunkFacts, MessageFacts, Records, push_record};
use crate::index::{AttachmentFacts, ChunkEntry, Index, MetadataEntry, Written};

/// Uncompressed size at which a chunk ends: what a viewer has to read to show one instant.
const CHUNK_BYTES: usize = 1 << 20;

/// Writes a file record by record. Bodies of records go in as they are.
pub(crate) struct Writer<W> {
    out: W,
    position: u64,
    sum: Hasher,
    /// Records of the chunk that is being filled.
    open: Vec<u8>,
    packing: Packing,
    index: Index,
}

impl<W: Write> Writer<W> {
    /// Starts a file with the body of a header record. Chunks that the writer makes itself are packed
    /// by `packing`.
    pub(crate) fn create(out: W, header: &[u8], packing: Packing) -> Result<Self, ContainerError> {
        let mut writer = Self {
            out,
            position: 0,
            sum: Hasher::new(),
            open: Vec::new(),
            packing,
            index: Index::default(),
        };
        writer.emit(mcap::MAGIC)?;
        writer.emit_record(op::HEADER, header)?;
        Ok(writer)
    }

    fn emit(&mut self, bytes: &[u8]) -> Result<(), ContainerError> {
        self.out.write_all(bytes).map_err(ContainerError::write)?;
        self.sum.update(bytes);
        self.position += bytes.len() as u64;
        Ok(())
    }

    fn emit_record(&mut self, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        self.emit(&[opcode])?;
        self.emit(&(body.len() as u64).to_le_bytes())?;
        self.emit(body)
    }

    /// How chunks are packed from here on that the writer makes itself.
    pub(crate) fn set_packing(&mut self, packing: Packing) {
        self.packing = packing;
    }

    /// What has been written of channels and messages so far.
    pub(crate) fn index(&self) -> &Index {
        &self.index
    }

    /// Writes a record outside chunks, after the chunk that is being filled.
    pub(crate) fn outside(&mut self, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        self.close_chunk()?;
        if opcode == op::METADATA {
            self.index
                .metadata
                .push(MetadataEntry::of(body, self.position));
        }
        self.index.add(opcode, body);
        self.emit_record(opcode, body)
    }

    /// Adds a record to the chunk that is being filled; a full one is written first.
    pub(crate) fn inside(&mut self, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        if opcode == op::MESSAGE && self.open.len() > CHUNK_BYTES {
            self.close_chunk()?;
        }
        push_record(&mut self.open, opcode, body);
        Ok(())
    }

    /// Writes the chunk that is being filled, if there is one.
    pub(crate) fn close_chunk(&mut self) -> Result<(), ContainerError> {
        if self.open.is_empty() {
            return Ok(());
        }
        let records = std::mem::take(&mut self.open);
        let result = self.chunk(&records, self.packing);
        self.open = records;
        self.open.clear();
        result
    }

    /// Writes these records as a chunk of their own.
    pub(crate) fn chunk(&mut self, records: &[u8], packing: Packing) -> Result<(), ContainerError> {
        let packed = packing.pack(records).map_err(ContainerError::write)?;
        self.packed_chunk(records, packing.name(), &packed)
    }

    /// Writes these records as a chunk of their own, given how they are packed.
    pub(crate) fn packed_chunk(
        &mut self,
        records: &[u8],
        compression: &str,
        packed: &[u8],
    ) -> Result<(), ContainerError> {
        self.close_chunk()?;
        let mut entry = ChunkEntry::of(records);
        let facts = ChunkFacts {
            start: entry.span.map_or(0, |(start, _)| start),
            end: entry.span.map_or(0, |(_, end)| end),
            unpacked_bytes: records.len() as u64,
            crc: crc32fast::hash(records),
            compression: compression.to_owned(),
            packed_bytes: packed.len() as u64,
        };
        for (opcode, body) in Records(records).flatten() {
            self.index.add(opcode, body);
        }
        let header = facts.to_bytes();
        entry.offset = self.position;
        self.emit(&[op::CHUNK])?;
        self.emit(&((header.len() + packed.len()) as u64).to_le_bytes())?;
        self.emit(&header)?;
        self.emit(packed)?;
        entry.bytes = self.position - entry.offset;
        for (channel, body) in entry.message_indexes() {
            entry.index_offsets.push((channel, self.position));
            self.emit_record(op::MESSAGE_INDEX, &body)?;
        }
        entry.index_bytes = self.position - entry.offset - entry.bytes;
        entry.facts = Some(facts);
        entry.messages.clear();
        self.index.chunks.push(entry);
        Ok(())
    }

    /// Writes an attachment, whose body `pass` gives.
    pub(crate) fn attachment(
        &mut self,
        mut facts: AttachmentFacts,
        bytes: u64,
        pass: impl FnOnce(&mut dyn Write) -> Result<(), ContainerError>,
    ) -> Result<(), ContainerError> {
        self.close_chunk()?;
        facts.offset = self.position;
        self.emit(&[op::ATTACHMENT])?;
        self.emit(&bytes.to_le_bytes())?;
        let body = self.position;
        pass(&mut Counted(self))?;
        debug_assert_eq!(self.position - body, bytes);
        facts.bytes = self.position - facts.offset;
        self.index.attachments.push(facts);
        Ok(())
    }

    /// Ends the file: what is in it, where, and that it is complete.
    pub(crate) fn finish(mut self) -> Result<Written, ContainerError> {
        self.close_chunk()?;
        let data_sum = std::mem::take(&mut self.sum).finalize();
        self.emit_record(op::DATA_END, &data_sum.to_le_bytes())?;

        self.sum = Hasher::new();
        let summary_start = self.position;
        let mut offsets = Vec::new();
        for (opcode, bodies) in self.index.summary() {
            let start = self.position;
            for body in bodies {
                self.emit_record(opcode, &body)?;
            }
            let mut offset = vec![opcode];
            offset.extend_from_slice(&start.to_le_bytes());
            offset.extend_from_slice(&(self.position - start).to_le_bytes());
            offsets.push(offset);
        }
        let offsets_start = self.position;
        for offset in offsets {
            self.emit_record(op::SUMMARY_OFFSET, &offset)?;
        }
        self.emit(&[op::FOOTER])?;
        self.emit(&20_u64.to_le_bytes())?;
        self.emit(&summary_start.to_le_bytes())?;
        self.emit(&offsets_start.to_le_bytes())?;
        let sum = self.sum.clone().finalize();
        self.emit(&sum.to_le_bytes())?;
        self.emit(mcap::MAGIC)?;
        self.out.flush().map_err(ContainerError::write)?;
        Ok(self.index.written(self.position))
    }
}

/// The writer as something that takes bytes.
struct Counted<'a, W>(&'a mut Writer<W>);

impl<W: Write> Write for Counted<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.0.out.write(bytes)?;
        self.0.sum.update(&bytes[..written]);
        self.0.position += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.0.out.flush()
    }
}

/// The log time and channel of a message record's body, for records that were read as messages.
pub(crate) fn message_facts(opcode: u8, body: &[u8]) -> Option<MessageFacts> {
    (opcode == op::MESSAGE)
        .then(|| MessageFacts::of(body))
        .flatten()
}
