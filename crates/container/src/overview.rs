//! Overview of a file before it is read: summary, metadata, time range.

use std::collections::BTreeMap;
use std::io::{Cursor, Read, Seek};

use mcap::records::{Record, op};

use crate::channel::{ChannelFacts, Definitions};
use crate::error::ContainerError;
use crate::format::{
    ChunkFacts, FOOTER_BYTES, FOOTER_COVERED_BYTES, MessageFacts, PREFIX_BYTES, Records, id_of,
};
use crate::index::spanned;
use crate::source::Source;
use crate::walk::{Depth, parse, walk_source};

/// What a chunk's header may take, with the name of its compression.
pub(crate) const CHUNK_START_BYTES: u64 = 256;

/// Bytes that a summary may have; one of a file of a terabyte has fewer.
const MOST_SUMMARY_BYTES: u64 = 256 << 20;

/// A chunk as the summary lists it.
pub(crate) struct ListedChunk {
    /// Channels with messages in it; none where it has no message index.
    pub(crate) channels: Vec<u16>,
    /// Log times from first to last.
    pub(crate) span: (u64, u64),
    /// Size of the record with its prefix.
    pub(crate) bytes: u64,
    /// Size of the message indexes behind it.
    pub(crate) index_bytes: u64,
}

/// What the summary at the end of a file says.
#[derive(Default)]
pub(crate) struct Overview {
    /// Bodies of schema records by id.
    pub(crate) schemas: BTreeMap<u16, Vec<u8>>,
    /// Bodies of channel records by id.
    pub(crate) channels: BTreeMap<u16, Vec<u8>>,
    /// The chunk that starts at a byte.
    pub(crate) chunks: BTreeMap<u64, ListedChunk>,
    /// Messages and their log times from first to last.
    pub(crate) messages: Option<(u64, Option<(u64, u64)>)>,
    /// Whether all schemas, channels and chunks of the file are listed.
    pub(crate) complete: bool,
}

impl Overview {
    /// The summary of a file; empty where it has none or one that is not sound. The source then
    /// stands at its first record.
    pub(crate) fn read<R: Read + Seek>(source: &mut Source<R>) -> Result<Self, ContainerError> {
        let end = End::read(source)?;
        source.rewind()?;
        Ok(match end {
            Some(End::Summary(overview)) => overview,
            _ => Self::default(),
        })
    }

    fn parse(summary: &[u8]) -> Option<Self> {
        let mut overview = Self::default();
        let mut counted = None;
        for record in Records(summary) {
            let (opcode, body) = record?;
            match crate::fields::parse_record(opcode, body).ok()? {
                Record::Schema { header, .. } => {
                    overview.schemas.insert(header.id, body.to_vec());
                }
                Record::Channel(channel) => {
                    overview.channels.insert(channel.id, body.to_vec());
                }
                Record::ChunkIndex(index) => {
                    let listed = ListedChunk {
                        channels: index.message_index_offsets.into_keys().collect(),
                        span: (index.message_start_time, index.message_end_time),
                        bytes: index.chunk_length,
                        index_bytes: index.message_index_length,
                    };
                    overview.chunks.insert(index.chunk_start_offset, listed);
                }
                Record::Statistics(statistics) => counted = Some(statistics),
                _ => {}
            }
        }
        if let Some(counted) = counted {
            let span = (counted.message_start_time, counted.message_end_time);
            let span = (counted.message_count > 0).then_some(span);
            overview.messages = Some((counted.message_count, span));
            overview.complete = usize::from(counted.schema_count) == overview.schemas.len()
                && counted.channel_count as usize == overview.channels.len()
                && counted.chunk_count as usize == overview.chunks.len();
        }
        Some(overview)
    }
}

/// How a file ends that ends as one should.
pub(crate) enum End {
    /// By a footer alone.
    Bare,
    /// By a summary that is damaged.
    Damaged,
    /// By a sound summary.
    Summary(Overview),
}

impl End {
    /// `None` for a file without a footer at its end.
    pub(crate) fn read<R: Read + Seek>(
        source: &mut Source<R>,
    ) -> Result<Option<Self>, ContainerError> {
        let end = (FOOTER_BYTES + mcap::MAGIC.len()) as u64;
        let Some(footer_offset) = source.bytes().checked_sub(end) else {
            return Ok(None);
        };
        let mut footer = Vec::new();
        source.read_at(footer_offset, end, &mut footer)?;
        let Some(footer) = footer.strip_suffix(mcap::MAGIC) else {
            return Ok(None);
        };
        let (Some((&[opcode, ..], body)), Some(&covered)) = (
            footer.split_first_chunk::<PREFIX_BYTES>(),
            footer.first_chunk::<{ PREFIX_BYTES + FOOTER_COVERED_BYTES }>(),
        ) else {
            return Ok(None);
        };
        let Ok(Record::Footer(footer)) = crate::fields::parse_record(opcode, body) else {
            return Ok(None);
        };
        if footer.summary_start == 0 {
            return Ok(Some(End::Bare));
        }
        let length = footer_offset.checked_sub(footer.summary_start);
        let Some(length) = length.filter(|&length| length <= MOST_SUMMARY_BYTES) else {
            return Ok(Some(End::Damaged));
        };
        let mut summary = Vec::new();
        source.read_at(footer.summary_start, length, &mut summary)?;
        summary.extend_from_slice(&covered);
        if footer.summary_crc != 0 && footer.summary_crc != crc32fast::hash(&summary) {
            return Ok(Some(End::Damaged));
        }
        summary.truncate(summary.len() - covered.len());
        let overview = Overview::parse(&summary);
        Ok(Some(overview.map_or(End::Damaged, End::Summary)))
    }
}

/// A metadata record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MetadataRecord {
    /// Its name; a file may have several of one name.
    pub name: String,
    /// What it says.
    pub facts: BTreeMap<String, String>,
}

impl MetadataRecord {
    pub(crate) fn parse(body: &[u8]) -> Option<Self> {
        match crate::fields::parse_record(op::METADATA, body).ok()? {
            Record::Metadata(record) => Some(Self {
                name: record.name,
                facts: record.metadata,
            }),
            _ => None,
        }
    }

    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut facts = Vec::new();
        for (key, value) in &self.facts {
            crate::format::push_text(&mut facts, key);
            crate::format::push_text(&mut facts, value);
        }
        let mut bytes = Vec::new();
        crate::format::push_text(&mut bytes, &self.name);
        bytes.extend_from_slice(&(facts.len() as u32).to_le_bytes());
        bytes.extend_from_slice(&facts);
        bytes
    }
}

/// The metadata records of a file in their order; nothing else of it is looked at.
///
/// # Errors
///
/// [`ContainerError::Truncated`] and [`ContainerError::Damaged`] where records do not follow each
/// other or a metadata record does not parse, [`ContainerError::Read`].
pub fn metadata<R: Read + Seek>(
    source: &mut Source<R>,
) -> Result<Vec<MetadataRecord>, ContainerError> {
    source.rewind()?;
    let (mut found, mut body) = (Vec::new(), Vec::new());
    while let Some(head) = source.next_head()? {
        match head.opcode {
            op::METADATA => {
                source.body(head, &mut body)?;
                let place = source.place(head.offset);
                if let Record::Metadata(record) = parse(place, head.opcode, &body)? {
                    found.push(MetadataRecord {
                        name: record.name,
                        facts: record.metadata,
                    });
                }
            }
            op::DATA_END | op::FOOTER => break,
            _ => {}
        }
    }
    source.rewind()?;
    Ok(found)
}

/// Log times of the earliest and the latest message of a file, nanoseconds since 1970-01-01 UTC, as
/// its summary states them, else as its chunks do; `None` without messages.
///
/// # Errors
///
/// [`ContainerError::Truncated`] and [`ContainerError::Damaged`] for files without a summary whose
/// records do not follow each other, [`ContainerError::Read`].
pub fn span<R: Read + Seek>(source: &mut Source<R>) -> Result<Option<(u64, u64)>, ContainerError> {
    if let Some((_, span)) = Overview::read(source)?.messages {
        return Ok(span);
    }
    let (mut span, mut start) = (None, Vec::new());
    while let Some(head) = source.next_head()? {
        match head.opcode {
            op::MESSAGE => {
                source.read_at(head.body(), head.bytes.min(CHUNK_START_BYTES), &mut start)?;
                if let Some(facts) = MessageFacts::of(&start) {
                    span = Some(spanned(span, facts.log_time));
                }
            }
            op::CHUNK => {
                source.read_at(head.body(), head.bytes.min(CHUNK_START_BYTES), &mut start)?;
                // Chunks without messages have no times.
                if let Some(facts) = ChunkFacts::of(&start).filter(|facts| facts.end != 0) {
                    span = Some(spanned(Some(spanned(span, facts.start)), facts.end));
                }
            }
            op::DATA_END | op::FOOTER => break,
            _ => {}
        }
    }
    source.rewind()?;
    Ok(span)
}

/// The channels of a file by id: as its summary lists them, else as its records define them, for which
/// the file is read to its end.
///
/// # Errors
///
/// [`ContainerError::Truncated`] and [`ContainerError::Damaged`] for files without a sound summary
/// whose records do not follow each other, [`ContainerError::Read`].
pub fn channels<R: Read + Seek>(
    source: &mut Source<R>,
) -> Result<Vec<ChannelFacts>, ContainerError> {
    let overview = Overview::read(source)?;
    let mut definitions = Definitions::default();
    let mut found = BTreeMap::new();
    let mut add = |record: Record<'_>| {
        if let Some(channel) = definitions.add(record) {
            found.entry(channel.id).or_insert(channel);
        }
    };
    if overview.complete {
        let place = source.place(0);
        for body in overview.schemas.values() {
            add(parse(place, op::SCHEMA, body)?);
        }
        for body in overview.channels.values() {
            add(parse(place, op::CHANNEL, body)?);
        }
    } else {
        walk_source(source, |record| {
            add(record);
            Ok::<_, ContainerError>(Depth::Everything)
        })?;
        source.rewind()?;
    }
    Ok(found.into_values().collect())
}

/// The metadata records of a file in memory; see [`metadata`].
///
/// # Errors
///
/// As for [`metadata`], and [`ContainerError::NotMcap`].
pub fn metadata_of(file: &str, bytes: &[u8]) -> Result<Vec<MetadataRecord>, ContainerError> {
    metadata(&mut Source::open(file, Cursor::new(bytes))?)
}

/// The id of the schema that a channel's body names.
pub(crate) fn schema_of(channel: &[u8]) -> Option<u16> {
    channel.get(2..).and_then(id_of)
}
