//! MCAP files, written.
//!
//! Every chunk is filled in memory, packed in one go and never touched again, which the mcap
//! crate's writer (a stream compressor fed field by field) cannot do: this takes three fifths of its
//! processor time, packs chunks on all threads, and needs no seeking. Chunks end at fixed sizes and lie in
//! the file in the order of their messages, so that the bytes do not depend on the threads.

mod bytes;
mod summary;

use std::collections::BTreeMap;
use std::io::{self, Write};

use mcap::records::op;
use rayon::prelude::*;

use bytes::{Checked, put_map, put_string, record};
use summary::Summary;

/// Uncompressed size at which a chunk ends: what a viewer has to read to show one instant.
const CHUNK_BYTES: usize = 1024 * 1024;

/// Chunks that wait to be packed together; bounds the memory.
const BATCH: usize = 8;

/// Level 1: higher ones take several times as long for a few per cent, since most bytes are
/// mantissas that no level can shrink.
const ZSTD_LEVEL: i32 = 1;

const COMPRESSION: &str = "zstd";

/// A file being written. [`Container::finish`] makes it one.
pub(crate) struct Container<'a> {
    out: Checked<&'a mut dyn Write>,
    chunk: Chunk,
    waiting: Vec<Chunk>,
    /// Buffers of chunks that have been written.
    spare: Vec<Chunk>,
    summary: Summary,
}

/// Records of a chunk, not yet packed.
#[derive(Default)]
struct Chunk {
    records: Vec<u8>,
    /// Log time and place of each message, by channel id.
    index: Vec<Vec<(u64, u64)>>,
    /// First and last log time.
    times: Option<(u64, u64)>,
}

impl Chunk {
    fn clear(&mut self) {
        self.records.clear();
        self.index.iter_mut().for_each(Vec::clear);
        self.times = None;
    }
}

impl<'a> Container<'a> {
    /// Starts a file; `library` says what wrote it.
    pub(crate) fn create(out: &'a mut dyn Write, library: &str) -> io::Result<Self> {
        let mut out = Checked::new(out);
        out.write(mcap::MAGIC)?;
        let mut header = Vec::new();
        record(&mut header, op::HEADER, |body| {
            put_string(body, "");
            put_string(body, library);
        });
        out.write(&header)?;
        Ok(Self {
            out,
            chunk: Chunk::default(),
            waiting: Vec::with_capacity(BATCH),
            spare: Vec::new(),
            summary: Summary::default(),
        })
    }

    /// Adds a metadata record; to be called before there are messages.
    pub(crate) fn metadata(
        &mut self,
        name: &str,
        facts: &BTreeMap<String, String>,
    ) -> io::Result<()> {
        let mut metadata = Vec::new();
        record(&mut metadata, op::METADATA, |body| {
            put_string(body, name);
            put_map(body, facts);
        });
        let offset = self.out.position();
        self.out.write(&metadata)?;
        (self.summary).add_metadata(name, offset, self.out.position() - offset);
        Ok(())
    }

    /// Adds a channel of protobuf messages and, where it is new, its schema; gives its id.
    pub(crate) fn channel(
        &mut self,
        topic: &str,
        schema_name: &str,
        descriptors: &[u8],
        metadata: &BTreeMap<String, String>,
    ) -> io::Result<u16> {
        let records = &mut self.chunk.records;
        let schema = (self.summary).schema(schema_name, descriptors, records)?;
        self.summary.channel(schema, topic, metadata, records)
    }

    /// Adds a message; `encode` appends its bytes.
    pub(crate) fn message(
        &mut self,
        channel: u16,
        sequence: u32,
        unix_nanos: u64,
        encode: impl FnOnce(&mut Vec<u8>),
    ) -> io::Result<()> {
        let Chunk {
            records,
            index,
            times,
        } = &mut self.chunk;
        let place = records.len() as u64;
        record(records, op::MESSAGE, |body| {
            body.extend(channel.to_le_bytes());
            body.extend(sequence.to_le_bytes());
            // Log time and publish time: a sample is published when it is taken.
            body.extend(unix_nanos.to_le_bytes());
            body.extend(unix_nanos.to_le_bytes());
            encode(body);
        });
        let id = usize::from(channel);
        if index.len() <= id {
            index.resize_with(id + 1, Vec::new);
        }
        index[id].push((unix_nanos, place));
        let (first, last) = times.unwrap_or((unix_nanos, unix_nanos));
        *times = Some((first.min(unix_nanos), last.max(unix_nanos)));
        if records.len() >= CHUNK_BYTES {
            self.close_chunk()?;
        }
        Ok(())
    }

    fn close_chunk(&mut self) -> io::Result<()> {
        let next = self.spare.pop().unwrap_or_default();
        (self.waiting).push(std::mem::replace(&mut self.chunk, next));
        if self.waiting.len() >= BATCH {
            self.write_waiting()?;
        }
        Ok(())
    }

    fn write_waiting(&mut self) -> io::Result<()> {
        let packed: Vec<io::Result<Vec<u8>>> = (self.waiting.par_iter())
            .map(|chunk| zstd::bulk::compress(&chunk.records, ZSTD_LEVEL))
            .collect();
        for (mut chunk, packed) in std::mem::take(&mut self.waiting).into_iter().zip(packed) {
            self.write_chunk(&chunk, &packed?)?;
            chunk.clear();
            self.spare.push(chunk);
        }
        Ok(())
    }

    fn write_chunk(&mut self, chunk: &Chunk, packed: &[u8]) -> io::Result<()> {
        let (first, last) = chunk.times.unwrap_or_default();
        let size = chunk.records.len() as u64;
        let start = self.out.position();
        let mut front = Vec::with_capacity(64);
        front.extend(first.to_le_bytes());
        front.extend(last.to_le_bytes());
        front.extend(size.to_le_bytes());
        front.extend(crc32fast::hash(&chunk.records).to_le_bytes());
        put_string(&mut front, COMPRESSION);
        front.extend((packed.len() as u64).to_le_bytes());
        let length = (front.len() + packed.len()) as u64;
        self.out.write(&[op::CHUNK])?;
        self.out.write(&length.to_le_bytes())?;
        self.out.write(&front)?;
        self.out.write(packed)?;

        let index_start = self.out.position();
        let mut index_offsets = Vec::new();
        let mut indexes = Vec::new();
        for (id, entries) in (0_u16..).zip(&chunk.index) {
            if entries.is_empty() {
                continue;
            }
            index_offsets.push((id, index_start + indexes.len() as u64));
            record(&mut indexes, op::MESSAGE_INDEX, |body| {
                body.extend(id.to_le_bytes());
                // A chunk holds fewer messages than 32 bits can count bytes for.
                body.extend((entries.len() as u32 * 16).to_le_bytes());
                for (unix_nanos, place) in entries {
                    body.extend(unix_nanos.to_le_bytes());
                    body.extend(place.to_le_bytes());
                }
            });
            self.summary.count(id, entries.len() as u64);
        }
        self.out.write(&indexes)?;
        self.summary.add_chunk(|body| {
            body.extend(first.to_le_bytes());
            body.extend(last.to_le_bytes());
            body.extend(start.to_le_bytes());
            body.extend((index_start - start).to_le_bytes());
            body.extend((index_offsets.len() as u32 * 10).to_le_bytes());
            for (id, offset) in &index_offsets {
                body.extend(id.to_le_bytes());
                body.extend(offset.to_le_bytes());
            }
            body.extend((indexes.len() as u64).to_le_bytes());
            put_string(body, COMPRESSION);
            body.extend((packed.len() as u64).to_le_bytes());
            body.extend(size.to_le_bytes());
        });
        self.summary.span(chunk.times);
        Ok(())
    }

    /// Writes what waits, the summary and the end.
    pub(crate) fn finish(mut self) -> io::Result<()> {
        if self.chunk.times.is_some() {
            self.close_chunk()?;
        }
        self.write_waiting()?;
        // Schemas and channels that no message followed need no chunk.
        let bare = std::mem::take(&mut self.chunk.records);
        self.out.write(&bare)?;

        let crc = self.out.crc();
        let mut end = Vec::new();
        record(&mut end, op::DATA_END, |body| {
            body.extend(crc.to_le_bytes());
        });
        let summary_start = self.out.position() + end.len() as u64;
        end.extend(self.summary.section(summary_start));
        end.extend(mcap::MAGIC);
        self.out.write(&end)?;
        self.out.flush()
    }
}
