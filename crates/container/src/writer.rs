//! A file written from records as bytes, with indexes, summary and checksums of its own.

use std::collections::BTreeMap;
use std::io::{self, Write};

use crc32fast::Hasher;
use mcap::records::{
    AttachmentIndex, Channel, ChunkHeader, ChunkIndex, Header, MessageIndex, MessageIndexEntry,
    Metadata, MetadataIndex, SchemaHeader, Statistics, SummaryOffset, op,
};
use zstd::bulk::Compressor;

use crate::chunk::{Packing, ZSTD_LEVEL};
use crate::error::ContainerError;
use crate::format::{
    MessageFacts, PREFIX_BYTES, Records, id_of, prefix, push_record, set_id, spanned, to_bytes,
};

/// Uncompressed size at which a chunk ends: what a viewer has to read to show one instant.
pub(crate) const CHUNK_BYTES: usize = 1 << 20;

/// What a file holds that was written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Written {
    /// Size of the file.
    pub bytes: u64,
    /// Messages.
    pub messages: u64,
    /// Messages by id of the channel; channels without any are left out.
    pub messages_by_channel: BTreeMap<u16, u64>,
    /// Schemas.
    pub schemas: u64,
    /// Channels.
    pub channels: u64,
    /// Chunks.
    pub chunks: u64,
    /// Attachments.
    pub attachments: u64,
    /// Metadata records.
    pub metadata: u64,
    /// Log times of the earliest and the latest message, nanoseconds since 1970-01-01 UTC.
    pub span: Option<(u64, u64)>,
}

/// Writes a file record by record, in chunks of about a MiB.
///
/// ```
/// use inhand_container::{Packing, Writer};
///
/// # fn main() -> Result<(), inhand_container::ContainerError> {
/// let mut file = Vec::new();
/// let mut writer = Writer::new(&mut file, "", "example", Packing::Zstd)?;
/// let schema = writer.schema("Point", "jsonschema", b"{}")?;
/// let channel = writer.channel(schema, "/a", "json", &Default::default())?;
/// for log_time in 0..10 {
///     writer.message(channel, 0, log_time, |data| data.extend(b"{}"))?;
/// }
/// assert_eq!(writer.finish()?.messages, 10);
/// # Ok(())
/// # }
/// ```
pub struct Writer<'a> {
    out: Summed<'a>,
    /// Records of the chunk that is being filled.
    open: Vec<u8>,
    packing: Packing,
    zstd: Compressor<'static>,
    written: Written,
    /// Bodies of schema records by id, the first of each.
    schemas: BTreeMap<u16, Vec<u8>>,
    /// Bodies of channel records by id, the first of each.
    channels: BTreeMap<u16, Vec<u8>>,
    chunks: Vec<ChunkIndex>,
    attachments: Vec<AttachmentIndex>,
    metadata: Vec<MetadataIndex>,
}

/// An output with its position and the checksum of what went through.
struct Summed<'a> {
    out: &'a mut dyn Write,
    position: u64,
    sum: Hasher,
}

impl Write for Summed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.sum.update(&bytes[..written]);
        self.position += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

impl<'a> Writer<'a> {
    /// Starts a file that states the profile of its content and the library that writes it.
    ///
    /// # Errors
    ///
    /// [`ContainerError::Write`].
    pub fn new(
        out: &'a mut dyn Write,
        profile: &str,
        library: &str,
        packing: Packing,
    ) -> Result<Self, ContainerError> {
        let header = Header {
            profile: profile.to_owned(),
            library: library.to_owned(),
        };
        Self::with_header(out, &to_bytes(&header), packing)
    }

    /// Starts a file with the body of a header record.
    pub(crate) fn with_header(
        out: &'a mut dyn Write,
        header: &[u8],
        packing: Packing,
    ) -> Result<Self, ContainerError> {
        let mut writer = Self {
            out: Summed {
                out,
                position: 0,
                sum: Hasher::new(),
            },
            open: Vec::new(),
            packing,
            zstd: Compressor::new(ZSTD_LEVEL).map_err(ContainerError::write)?,
            written: Written::default(),
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            chunks: Vec::new(),
            attachments: Vec::new(),
            metadata: Vec::new(),
        };
        writer.emit(mcap::MAGIC)?;
        writer.emit_record(op::HEADER, header)?;
        Ok(writer)
    }

    /// Writes a metadata record, outside chunks.
    ///
    /// # Errors
    ///
    /// [`ContainerError::Write`].
    pub fn metadata(
        &mut self,
        name: &str,
        facts: &BTreeMap<String, String>,
    ) -> Result<(), ContainerError> {
        let record = Metadata {
            name: name.to_owned(),
            metadata: facts.clone(),
        };
        self.outside(op::METADATA, &to_bytes(&record))
    }

    /// The id of a schema, which is written unless the file has an equal one.
    ///
    /// # Errors
    ///
    /// [`ContainerError::Write`], also where ids run out.
    pub fn schema(
        &mut self,
        name: &str,
        encoding: &str,
        data: &[u8],
    ) -> Result<u16, ContainerError> {
        let header = SchemaHeader {
            id: 0,
            name: name.to_owned(),
            encoding: encoding.to_owned(),
        };
        let length = (data.len() as u32).to_le_bytes();
        self.define(op::SCHEMA, [&to_bytes(&header), &length[..], data].concat())
    }

    /// The id of a channel, which is written unless the file has an equal one. Schema 0 means none.
    ///
    /// # Errors
    ///
    /// [`ContainerError::Write`], also where ids run out.
    pub fn channel(
        &mut self,
        schema: u16,
        topic: &str,
        message_encoding: &str,
        metadata: &BTreeMap<String, String>,
    ) -> Result<u16, ContainerError> {
        let channel = Channel {
            id: 0,
            schema_id: schema,
            topic: topic.to_owned(),
            message_encoding: message_encoding.to_owned(),
            metadata: metadata.clone(),
        };
        self.define(op::CHANNEL, to_bytes(&channel))
    }

    fn define(&mut self, opcode: u8, mut body: Vec<u8>) -> Result<u16, ContainerError> {
        let known = match opcode {
            op::SCHEMA => &self.schemas,
            _ => &self.channels,
        };
        if let Some((&id, _)) = known.iter().find(|(_, known)| known[2..] == body[2..]) {
            return Ok(id);
        }
        let free = (1..=u16::MAX).find(|id| !known.contains_key(id));
        let id =
            free.ok_or_else(|| ContainerError::write(io::Error::other("too many channels")))?;
        set_id(&mut body, id);
        self.inside(opcode, &body)?;
        Ok(id)
    }

    /// Writes a message whose data `encode` adds to what it is given; it is published when it is logged.
    ///
    /// # Errors
    ///
    /// [`ContainerError::Write`].
    pub fn message(
        &mut self,
        channel: u16,
        sequence: u32,
        log_time: u64,
        encode: impl FnOnce(&mut Vec<u8>),
    ) -> Result<(), ContainerError> {
        self.close_full_chunk()?;
        let start = self.open.len();
        self.open.extend_from_slice(&[0; PREFIX_BYTES]);
        self.open.extend_from_slice(&channel.to_le_bytes());
        self.open.extend_from_slice(&sequence.to_le_bytes());
        self.open.extend_from_slice(&log_time.to_le_bytes());
        self.open.extend_from_slice(&log_time.to_le_bytes());
        encode(&mut self.open);
        let body = (self.open.len() - start - PREFIX_BYTES) as u64;
        self.open[start..start + PREFIX_BYTES].copy_from_slice(&prefix(op::MESSAGE, body));
        Ok(())
    }

    fn emit(&mut self, bytes: &[u8]) -> Result<(), ContainerError> {
        self.out.write_all(bytes).map_err(ContainerError::write)
    }

    fn emit_record(&mut self, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        self.emit(&prefix(opcode, body.len() as u64))?;
        self.emit(body)
    }

    /// How chunks are packed from here on that the writer makes itself.
    pub(crate) fn set_packing(&mut self, packing: Packing) {
        self.packing = packing;
    }

    /// Whether a schema or channel of this id was written.
    pub(crate) fn has(&self, opcode: u8, id: u16) -> bool {
        match opcode {
            op::SCHEMA => self.schemas.contains_key(&id),
            _ => self.channels.contains_key(&id),
        }
    }

    /// Adds a schema or channel to the chunk that is being filled, unless one of its id was written.
    pub(crate) fn inside_once(&mut self, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        match id_of(body).is_some_and(|id| self.has(opcode, id)) {
            true => Ok(()),
            false => self.inside(opcode, body),
        }
    }

    /// Counts a schema, channel or message; gives what a message says of itself.
    fn count(&mut self, opcode: u8, body: &[u8]) -> Option<MessageFacts> {
        let known = match opcode {
            op::MESSAGE => {
                let message = MessageFacts::read(body)?;
                self.written.messages += 1;
                let of_channel = self.written.messages_by_channel.entry(message.channel);
                *of_channel.or_default() += 1;
                self.written.span = Some(spanned(self.written.span, message.log_time));
                return Some(message);
            }
            op::SCHEMA => &mut self.schemas,
            op::CHANNEL => &mut self.channels,
            _ => return None,
        };
        known.entry(id_of(body)?).or_insert_with(|| body.to_vec());
        None
    }

    /// Writes a record outside chunks, after the chunk that is being filled.
    pub(crate) fn outside(&mut self, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        self.close_chunk()?;
        if opcode == op::METADATA {
            self.metadata.push(MetadataIndex {
                offset: self.out.position,
                length: (PREFIX_BYTES + body.len()) as u64,
                name: name(body),
            });
        }
        self.count(opcode, body);
        self.emit_record(opcode, body)
    }

    /// Adds a record to the chunk that is being filled; a full one is written first.
    pub(crate) fn inside(&mut self, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        if body.len() > CHUNK_BYTES {
            // Alone, so that the chunk takes no more memory than the record did.
            self.close_chunk()?;
        } else if opcode == op::MESSAGE {
            self.close_full_chunk()?;
        }
        if opcode != op::MESSAGE {
            self.count(opcode, body);
        }
        push_record(&mut self.open, opcode, body);
        self.close_full_chunk()
    }

    fn close_full_chunk(&mut self) -> Result<(), ContainerError> {
        match self.open.len() > CHUNK_BYTES {
            true => self.close_chunk(),
            false => Ok(()),
        }
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
        let packed = packing.pack(records, &mut self.zstd);
        self.packed_chunk(
            records,
            packing.name(),
            &packed.map_err(ContainerError::write)?,
        )
    }

    /// Writes these records as a chunk of their own, given how they are packed.
    pub(crate) fn packed_chunk(
        &mut self,
        records: &[u8],
        compression: &str,
        packed: &[u8],
    ) -> Result<(), ContainerError> {
        self.close_chunk()?;
        let (mut span, mut offset) = (None, 0);
        let mut indexes: BTreeMap<u16, Vec<MessageIndexEntry>> = BTreeMap::new();
        for (opcode, body) in Records(records).flatten() {
            if let Some(MessageFacts { channel, log_time }) = self.count(opcode, body) {
                span = Some(spanned(span, log_time));
                let entries = indexes.entry(channel).or_default();
                entries.push(MessageIndexEntry { log_time, offset });
            }
            offset += (PREFIX_BYTES + body.len()) as u64;
        }
        let (message_start_time, message_end_time) = span.unwrap_or_default();
        let header = ChunkHeader {
            message_start_time,
            message_end_time,
            uncompressed_size: records.len() as u64,
            uncompressed_crc: crc32fast::hash(records),
            compression: compression.to_owned(),
            compressed_size: packed.len() as u64,
        };
        let chunk_start_offset = self.out.position;
        let start = to_bytes(&header);
        self.emit(&prefix(op::CHUNK, (start.len() + packed.len()) as u64))?;
        self.emit(&start)?;
        self.emit(packed)?;
        let chunk_end = self.out.position;
        let mut message_index_offsets = BTreeMap::new();
        for (channel_id, records) in indexes {
            message_index_offsets.insert(channel_id, self.out.position);
            let index = MessageIndex {
                channel_id,
                records,
            };
            self.emit_record(op::MESSAGE_INDEX, &to_bytes(&index))?;
        }
        self.chunks.push(ChunkIndex {
            message_start_time,
            message_end_time,
            chunk_start_offset,
            chunk_length: chunk_end - chunk_start_offset,
            message_index_offsets,
            message_index_length: self.out.position - chunk_end,
            compression: header.compression,
            compressed_size: header.compressed_size,
            uncompressed_size: header.uncompressed_size,
        });
        Ok(())
    }

    /// Writes an attachment, whose body of so many bytes `pass` gives.
    pub(crate) fn attachment(
        &mut self,
        mut index: AttachmentIndex,
        bytes: u64,
        pass: impl FnOnce(&mut dyn Write) -> Result<(), ContainerError>,
    ) -> Result<(), ContainerError> {
        self.close_chunk()?;
        index.offset = self.out.position;
        index.length = PREFIX_BYTES as u64 + bytes;
        self.emit(&prefix(op::ATTACHMENT, bytes))?;
        pass(&mut self.out)?;
        debug_assert_eq!(self.out.position - index.offset, index.length);
        self.attachments.push(index);
        Ok(())
    }

    /// What was written so far, but for the chunk that is being filled.
    pub(crate) fn written(&self) -> Written {
        Written {
            bytes: self.out.position,
            schemas: self.schemas.len() as u64,
            channels: self.channels.len() as u64,
            chunks: self.chunks.len() as u64,
            attachments: self.attachments.len() as u64,
            metadata: self.metadata.len() as u64,
            ..self.written.clone()
        }
    }

    /// Ends the file with its summary.
    ///
    /// # Errors
    ///
    /// [`ContainerError::Write`].
    pub fn finish(mut self) -> Result<Written, ContainerError> {
        self.close_chunk()?;
        let data_sum = std::mem::take(&mut self.out.sum).finalize();
        self.emit_record(op::DATA_END, &data_sum.to_le_bytes())?;
        self.out.sum = Hasher::new();
        let summary_start = self.out.position;
        let mut offsets = Vec::new();
        for (opcode, bodies) in self.summary() {
            let group_start = self.out.position;
            for body in &bodies {
                self.emit_record(opcode, body)?;
            }
            if !bodies.is_empty() {
                offsets.push(SummaryOffset {
                    group_opcode: opcode,
                    group_start,
                    group_length: self.out.position - group_start,
                });
            }
        }
        let offsets_start = self.out.position;
        for offset in offsets {
            self.emit_record(op::SUMMARY_OFFSET, &to_bytes(&offset))?;
        }
        // The checksum covers the footer up to itself.
        self.emit(&prefix(op::FOOTER, 20))?;
        self.emit(&summary_start.to_le_bytes())?;
        self.emit(&offsets_start.to_le_bytes())?;
        let sum = self.out.sum.clone().finalize();
        self.emit(&sum.to_le_bytes())?;
        self.emit(mcap::MAGIC)?;
        self.out.flush().map_err(ContainerError::write)?;
        Ok(self.written())
    }

    /// Records of the summary in groups of one kind.
    fn summary(&self) -> [(u8, Vec<Vec<u8>>); 6] {
        let (start, end) = self.written.span.unwrap_or_default();
        let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let statistics = Statistics {
            message_count: self.written.messages,
            // Ids have 16 bits; of 65 536 schemas one would be the forbidden number 0.
            schema_count: u16::try_from(self.schemas.len()).unwrap_or(u16::MAX),
            channel_count: count(self.channels.len()),
            attachment_count: count(self.attachments.len()),
            metadata_count: count(self.metadata.len()),
            chunk_count: count(self.chunks.len()),
            message_start_time: start,
            message_end_time: end,
            channel_message_counts: self.written.messages_by_channel.clone(),
        };
        [
            (op::SCHEMA, self.schemas.values().cloned().collect()),
            (op::CHANNEL, self.channels.values().cloned().collect()),
            (op::STATISTICS, vec![to_bytes(&statistics)]),
            (op::CHUNK_INDEX, self.chunks.iter().map(to_bytes).collect()),
            (
                op::ATTACHMENT_INDEX,
                self.attachments.iter().map(to_bytes).collect(),
            ),
            (
                op::METADATA_INDEX,
                self.metadata.iter().map(to_bytes).collect(),
            ),
        ]
    }
}

/// The name of a metadata record; none where its body is too short or no text.
fn name(body: &[u8]) -> String {
    match crate::fields::parse_record(op::METADATA, body) {
        Ok(mcap::records::Record::Metadata(record)) => record.name,
        _ => String::new(),
    }
}

impl std::fmt::Debug for Writer<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (f.debug_struct("Writer"))
            .field("written", &self.written)
            .finish_non_exhaustive()
    }
}
