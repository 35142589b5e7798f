//! What a file repeats at its end: schemas, channels, counts, and where everything is.

use std::collections::BTreeMap;
use std::io;

use mcap::records::op;

use super::bytes::{put_bytes, put_map, put_string, record};

/// The summary as it grows with the file. Groups are kept as the bytes of their records.
#[derive(Default)]
pub(super) struct Summary {
    schemas: Vec<u8>,
    /// Ids of schemas by name; a name stands for one schema.
    schema_ids: BTreeMap<String, u16>,
    channels: Vec<u8>,
    /// Messages by channel; channel `n` has the id `n + 1`.
    messages: Vec<u64>,
    chunk_indexes: Vec<u8>,
    chunks: u32,
    metadata_indexes: Vec<u8>,
    metadata: u32,
    times: Option<(u64, u64)>,
}

impl Summary {
    /// The schema's id; a new one goes into `chunk` too.
    pub(super) fn schema(
        &mut self,
        name: &str,
        descriptors: &[u8],
        chunk: &mut Vec<u8>,
    ) -> io::Result<u16> {
        if let Some(&id) = self.schema_ids.get(name) {
            return Ok(id);
        }
        let id = next_id(self.schema_ids.len(), "schemas")?;
        let start = self.schemas.len();
        record(&mut self.schemas, op::SCHEMA, |body| {
            body.extend(id.to_le_bytes());
            put_string(body, name);
            put_string(body, "protobuf");
            put_bytes(body, descriptors);
        });
        chunk.extend_from_slice(&self.schemas[start..]);
        self.schema_ids.insert(name.to_owned(), id);
        Ok(id)
    }

    /// A new channel's id; the channel goes into `chunk` too.
    pub(super) fn channel(
        &mut self,
        schema: u16,
        topic: &str,
        metadata: &BTreeMap<String, String>,
        chunk: &mut Vec<u8>,
    ) -> io::Result<u16> {
        let id = next_id(self.messages.len(), "channels")?;
        let start = self.channels.len();
        record(&mut self.channels, op::CHANNEL, |body| {
            body.extend(id.to_le_bytes());
            body.extend(schema.to_le_bytes());
            put_string(body, topic);
            put_string(body, "protobuf");
            put_map(body, metadata);
        });
        chunk.extend_from_slice(&self.channels[start..]);
        self.messages.push(0);
        Ok(id)
    }

    pub(super) fn add_metadata(&mut self, name: &str, offset: u64, length: u64) {
        record(&mut self.metadata_indexes, op::METADATA_INDEX, |body| {
            body.extend(offset.to_le_bytes());
            body.extend(length.to_le_bytes());
            put_string(body, name);
        });
        self.metadata += 1;
    }

    pub(super) fn add_chunk(&mut self, fill: impl FnOnce(&mut Vec<u8>)) {
        record(&mut self.chunk_indexes, op::CHUNK_INDEX, fill);
        self.chunks += 1;
    }

    pub(super) fn count(&mut self, channel: u16, messages: u64) {
        self.messages[usize::from(channel) - 1] += messages;
    }

    /// Takes in the first and last log time of a chunk.
    pub(super) fn span(&mut self, times: Option<(u64, u64)>) {
        self.times = match (self.times, times) {
            (Some((a, b)), Some((c, d))) => Some((a.min(c), b.max(d))),
            (known, new) => known.or(new),
        };
    }

    /// The summary section, which starts at byte `start` of the file, and the footer.
    pub(super) fn section(&self, start: u64) -> Vec<u8> {
        let mut statistics = Vec::new();
        record(&mut statistics, op::STATISTICS, |body| {
            self.statistics(body);
        });
        let mut section = Vec::new();
        let mut offsets = Vec::new();
        for (opcode, group) in [
            (op::SCHEMA, &self.schemas),
            (op::CHANNEL, &self.channels),
            (op::STATISTICS, &statistics),
            (op::CHUNK_INDEX, &self.chunk_indexes),
            (op::METADATA_INDEX, &self.metadata_indexes),
        ] {
            if group.is_empty() {
                continue;
            }
            let group_start = start + section.len() as u64;
            section.extend_from_slice(group);
            record(&mut offsets, op::SUMMARY_OFFSET, |body| {
                body.push(opcode);
                body.extend(group_start.to_le_bytes());
                body.extend((group.len() as u64).to_le_bytes());
            });
        }
        let offsets_start = start + section.len() as u64;
        section.extend(offsets);
        record(&mut section, op::FOOTER, |body| {
            body.extend(start.to_le_bytes());
            body.extend(offsets_start.to_le_bytes());
            // Length is part of what the checksum covers, so the field is there from the start.
            body.extend([0; 4]);
        });
        let covered = section.len() - 4;
        let crc = crc32fast::hash(&section[..covered]);
        section[covered..].copy_from_slice(&crc.to_le_bytes());
        section
    }

    fn statistics(&self, body: &mut Vec<u8>) {
        let (first, last) = self.times.unwrap_or_default();
        body.extend(self.messages.iter().sum::<u64>().to_le_bytes());
        body.extend((self.schema_ids.len() as u16).to_le_bytes());
        body.extend((self.messages.len() as u32).to_le_bytes());
        // No attachments.
        body.extend(0_u32.to_le_bytes());
        body.extend(self.metadata.to_le_bytes());
        body.extend(self.chunks.to_le_bytes());
        body.extend(first.to_le_bytes());
        body.extend(last.to_le_bytes());
        let mut counts = Vec::new();
        for (id, messages) in (1_u16..).zip(&self.messages) {
            counts.extend(id.to_le_bytes());
            counts.extend(messages.to_le_bytes());
        }
        put_bytes(body, &counts);
    }
}

/// Ids count from 1 and have 16 bits.
fn next_id(used: usize, what: &str) -> io::Result<u16> {
    u16::try_from(used + 1)
        .ok()
        .filter(|&id| id != u16::MAX)
        .ok_or_else(|| io::Error::other(format!("an MCAP file holds at most 65534 {what}")))
}
