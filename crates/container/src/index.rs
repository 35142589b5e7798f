//! Index of a file, from its summary.

use std::collections::BTreeMap;

use mcap::records::op;

use crate::format::{ChunkFacts, PREFIX_BYTES, Records, id_of, push_text};
use crate::writer::message_facts;

/// What has been written, as far as the summary needs it.
#[derive(Default)]
pub(crate) struct Index {
    /// Bodies of schema records by id, the first of each.
    pub(crate) schemas: BTreeMap<u16, Vec<u8>>,
    /// Bodies of channel records by id, the first of each.
    pub(crate) channels: BTreeMap<u16, Vec<u8>>,
    messages: BTreeMap<u16, u64>,
    span: Option<(u64, u64)>,
    pub(crate) chunks: Vec<ChunkEntry>,
    pub(crate) attachments: Vec<AttachmentFacts>,
    pub(crate) metadata: Vec<MetadataEntry>,
}

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

impl Index {
    /// Counts a schema, channel or message.
    pub(crate) fn add(&mut self, opcode: u8, body: &[u8]) {
        let definitions = match opcode {
            op::SCHEMA => &mut self.schemas,
            op::CHANNEL => &mut self.channels,
            _ => {
                if let Some(facts) = message_facts(opcode, body) {
                    *self.messages.entry(facts.channel).or_default() += 1;
                    self.span = Some(spanned(self.span, facts.log_time));
                }
                return;
            }
        };
        if let Some(id) = id_of(body) {
            definitions.entry(id).or_insert_with(|| body.to_vec());
        }
    }

    pub(crate) fn written(&self, bytes: u64) -> Written {
        Written {
            bytes,
            messages: self.messages.values().sum(),
            messages_by_channel: self.messages.clone(),
            schemas: self.schemas.len() as u64,
            channels: self.channels.len() as u64,
            chunks: self.chunks.len() as u64,
            attachments: self.attachments.len() as u64,
            metadata: self.metadata.len() as u64,
            span: self.span,
        }
    }

    /// Records of the summary in groups of one kind.
    pub(crate) fn summary(&self) -> Vec<(u8, Vec<Vec<u8>>)> {
        let groups = vec![
            (op::SCHEMA, self.schemas.values().cloned().collect()),
            (op::CHANNEL, self.channels.values().cloned().collect()),
            (op::STATISTICS, vec![self.statistics()]),
            (op::CHUNK_INDEX, bodies(&self.chunks, ChunkEntry::to_bytes)),
            (
                op::ATTACHMENT_INDEX,
                bodies(&self.attachments, AttachmentFacts::to_bytes),
            ),
            (
                op::METADATA_INDEX,
                bodies(&self.metadata, MetadataEntry::to_bytes),
            ),
        ];
        let mut groups: Vec<(u8, Vec<Vec<u8>>)> = groups;
        groups.retain(|(_, bodies)| !bodies.is_empty());
        groups
    }

    fn statistics(&self) -> Vec<u8> {
        let (start, end) = self.span.unwrap_or_default();
        let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX).to_le_bytes();
        let mut bytes = Vec::new();
        bytes.extend(self.messages.values().sum::<u64>().to_le_bytes());
        // Ids have 16 bits; of 65 536 schemas one would be the forbidden number 0.
        bytes.extend(
            u16::try_from(self.schemas.len())
                .unwrap_or(u16::MAX)
                .to_le_bytes(),
        );
        bytes.extend(count(self.channels.len()));
        bytes.extend(count(self.attachments.len()));
        bytes.extend(count(self.metadata.len()));
        bytes.extend(count(self.chunks.len()));
        bytes.extend(start.to_le_bytes());
        bytes.extend(end.to_le_bytes());
        bytes.extend(((self.messages.len() * 10) as u32).to_le_bytes());
        for (channel, messages) in &self.messages {
            bytes.extend(channel.to_le_bytes());
            bytes.extend(messages.to_le_bytes());
        }
        bytes
    }
}

fn bodies<T>(entries: &[T], to_bytes: impl Fn(&T) -> Vec<u8>) -> Vec<Vec<u8>> {
    entries.iter().map(to_bytes).collect()
}

pub(crate) fn spanned(span: Option<(u64, u64)>, time: u64) -> (u64, u64) {
    span.map_or((time, time), |(start, end)| {
        (start.min(time), end.max(time))
    })
}

/// A chunk of the file.
pub(crate) struct ChunkEntry {
    pub(crate) offset: u64,
    pub(crate) bytes: u64,
    pub(crate) index_bytes: u64,
    /// Where the message index of each channel is.
    pub(crate) index_offsets: Vec<(u16, u64)>,
    /// Log times and places of messages by channel, until the message indexes are written.
    pub(crate) messages: BTreeMap<u16, Vec<(u64, u64)>>,
    pub(crate) span: Option<(u64, u64)>,
    pub(crate) facts: Option<ChunkFacts>,
}

impl ChunkEntry {
    /// A chunk of these records, which has no place yet.
    pub(crate) fn of(records: &[u8]) -> Self {
        let mut messages: BTreeMap<u16, Vec<(u64, u64)>> = BTreeMap::new();
        let (mut span, mut offset) = (None, 0);
        for (opcode, body) in Records(records).flatten() {
            if let Some(facts) = message_facts(opcode, body) {
                span = Some(spanned(span, facts.log_time));
                let places = messages.entry(facts.channel).or_default();
                places.push((facts.log_time, offset));
            }
            offset += (PREFIX_BYTES + body.len()) as u64;
        }
        Self {
            offset: 0,
            bytes: 0,
            index_bytes: 0,
            index_offsets: Vec::new(),
            messages,
            span,
            facts: None,
        }
    }

    /// Bodies of the message index records by channel.
    pub(crate) fn message_indexes(&self) -> Vec<(u16, Vec<u8>)> {
        (self.messages.iter())
            .map(|(&channel, places)| {
                let mut body = channel.to_le_bytes().to_vec();
                body.extend(((places.len() * 16) as u32).to_le_bytes());
                for (time, offset) in places {
                    body.extend(time.to_le_bytes());
                    body.extend(offset.to_le_bytes());
                }
                (channel, body)
            })
            .collect()
    }

    fn to_bytes(&self) -> Vec<u8> {
        let (start, end) = self.span.unwrap_or_default();
        let mut bytes = Vec::new();
        for number in [start, end, self.offset, self.bytes] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(((self.index_offsets.len() * 10) as u32).to_le_bytes());
        for (channel, offset) in &self.index_offsets {
            bytes.extend(channel.to_le_bytes());
            bytes.extend(offset.to_le_bytes());
        }
        bytes.extend(self.index_bytes.to_le_bytes());
        if let Some(facts) = &self.facts {
            push_text(&mut bytes, &facts.compression);
            bytes.extend(facts.packed_bytes.to_le_bytes());
            bytes.extend(facts.unpacked_bytes.to_le_bytes());
        }
        bytes
    }
}

/// What stands in front of an attachment's data, and where it is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct AttachmentFacts {
    pub(crate) offset: u64,
    pub(crate) bytes: u64,
    pub(crate) log_time: u64,
    create_time: u64,
    data_bytes: u64,
    /// Bytes of the body that its checksum covers; the sum follows, and after it there may be more.
    pub(crate) summed_bytes: u64,
    pub(crate) name: String,
    media_type: String,
}

impl AttachmentFacts {
    /// From what the body starts with; `None` where that is too short, no text, or the data and a
    /// checksum do not fit into `bytes` bytes of body.
    pub(crate) fn of(start: &[u8], bytes: u64) -> Option<Self> {
        let text = |bytes: &mut &[u8]| -> Option<String> {
            let (length, rest) = bytes.split_first_chunk()?;
            let length = usize::try_from(u32::from_le_bytes(*length)).ok()?;
            let (text, rest) = rest.split_at_checked(length)?;
            *bytes = rest;
            Some(str::from_utf8(text).ok()?.to_owned())
        };
        let (log_time, rest) = start.split_first_chunk()?;
        let (create_time, mut rest) = rest.split_first_chunk()?;
        let name = text(&mut rest)?;
        let media_type = text(&mut rest)?;
        let (data_bytes, rest) = rest.split_first_chunk()?;
        let data_bytes = u64::from_le_bytes(*data_bytes);
        let header_bytes = (start.len() - rest.len()) as u64;
        let summed_bytes = header_bytes.checked_add(data_bytes)?;
        let fits = summed_bytes.checked_add(4)? <= bytes;
        fits.then(|| Self {
            summed_bytes,
            offset: 0,
            bytes: 0,
            log_time: u64::from_le_bytes(*log_time),
            create_time: u64::from_le_bytes(*create_time),
            data_bytes,
            name,
            media_type,
        })
    }

    fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let numbers = [
            self.offset,
            self.bytes,
            self.log_time,
            self.create_time,
            self.data_bytes,
        ];
        for number in numbers {
            bytes.extend(number.to_le_bytes());
        }
        push_text(&mut bytes, &self.name);
        push_text(&mut bytes, &self.media_type);
        bytes
    }
}

/// A metadata record of the file.
pub(crate) struct MetadataEntry {
    offset: u64,
    bytes: u64,
    /// The name with its length, as it stands in the record.
    name: Vec<u8>,
}

impl MetadataEntry {
    /// Of the record with this body at this place.
    pub(crate) fn of(body: &[u8], offset: u64) -> Self {
        let name_bytes = body
            .first_chunk()
            .and_then(|length| usize::try_from(u32::from_le_bytes(*length).checked_add(4)?).ok());
        let name = name_bytes.and_then(|bytes| body.get(..bytes));
        Self {
            offset,
            bytes: (PREFIX_BYTES + body.len()) as u64,
            name: name.unwrap_or(&[0; 4]).to_vec(),
        }
    }

    fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = self.offset.to_le_bytes().to_vec();
        bytes.extend(self.bytes.to_le_bytes());
        bytes.extend_from_slice(&self.name);
        bytes
    }
}
