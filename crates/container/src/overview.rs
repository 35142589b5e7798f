//! Overview of a file before it is read: summary, metadata, time range.

use std::collections::BTreeMap;

use mcap::records::{ChunkIndex, Footer, Metadata, Record, Statistics, op};

use crate::channel::{ChannelFacts, Definitions};
use crate::error::ContainerError;
use crate::fields::parse_record;
use crate::format::{FOOTER_BYTES, FOOTER_COVERED_BYTES, PREFIX_BYTES, Records, spanned, to_bytes};
use crate::source::{Head, Source};
use crate::walk::{Depth, walk_source};

/// What a chunk's header may take, with the name of its compression.
pub(crate) const CHUNK_START_BYTES: u64 = 256;

/// Bytes that a summary may have; one of a file of a terabyte has fewer.
const MOST_SUMMARY_BYTES: u64 = 256 << 20;

/// What the summary at the end of a file says.
#[derive(Default)]
pub(crate) struct Overview {
    /// Bodies of schema records by id.
    pub(crate) schemas: BTreeMap<u16, Vec<u8>>,
    /// Bodies of channel records by id.
    pub(crate) channels: BTreeMap<u16, Vec<u8>>,
    /// The chunk that starts at a byte.
    pub(crate) chunks: BTreeMap<u64, ChunkIndex>,
    pub(crate) statistics: Option<Statistics>,
    /// Whether all schemas, channels and chunks of the file are listed.
    pub(crate) complete: bool,
}

impl Overview {
    /// The summary of a file; empty where it has none or one that is not sound. The source is then
    /// at its first record.
    pub(crate) fn read(source: &mut Source<'_>) -> Result<Self, ContainerError> {
        let end = End::read(source)?;
        source.rewind()?;
        Ok(match end {
            Some(End::Summary(overview)) => overview,
            _ => Self::default(),
        })
    }

    fn parse(summary: &[u8]) -> Option<Self> {
        let mut overview = Self::default();
        for record in Records(summary) {
            let (opcode, body) = record?;
            match parse_record(opcode, body).ok()? {
                Record::Schema { header, .. } => {
                    overview.schemas.insert(header.id, body.to_vec());
                }
                Record::Channel(channel) => {
                    overview.channels.insert(channel.id, body.to_vec());
                }
                Record::ChunkIndex(index) => {
                    overview.chunks.insert(index.chunk_start_offset, index);
                }
                Record::Statistics(statistics) => overview.statistics = Some(statistics),
                _ => {}
            }
        }
        overview.complete = overview.statistics.as_ref().is_some_and(|counted| {
            usize::from(counted.schema_count) == overview.schemas.len()
                && counted.channel_count as usize == overview.channels.len()
                && counted.chunk_count as usize == overview.chunks.len()
        });
        Some(overview)
    }

    /// Whether the times of a chunk are the same in its header, in the summary and in its message indexes.
    pub(crate) fn agrees(
        &self,
        source: &mut Source<'_>,
        head: Head,
        span: (u64, u64),
    ) -> Result<bool, ContainerError> {
        let Some(listed) = self.chunks.get(&head.offset) else {
            return Ok(false);
        };
        if (listed.message_start_time, listed.message_end_time) != span {
            return Ok(false);
        }
        let (mut indexes, mut indexed) = (Vec::new(), None);
        source.read_at(head.end(), listed.message_index_length, &mut indexes)?;
        for (opcode, body) in Records(&indexes).flatten() {
            if let Ok(Record::MessageIndex(index)) = parse_record(opcode, body) {
                for entry in index.records {
                    indexed = Some(spanned(indexed, entry.log_time));
                }
            }
        }
        Ok(indexed == Some(span))
    }

    /// Log times of the messages, where those of the statistics and of the chunks are the same.
    fn span(&self) -> Option<Option<(u64, u64)>> {
        let counted = self.statistics.as_ref().filter(|_| self.complete)?;
        let chunks = self.chunks.values();
        let chunks = chunks.filter(|chunk| chunk.message_end_time != 0);
        let of_chunks = chunks.fold(None, |span, chunk| {
            let span = spanned(span, chunk.message_start_time);
            Some(spanned(Some(span), chunk.message_end_time))
        });
        let stated = (counted.message_start_time, counted.message_end_time);
        let stated = (counted.message_count > 0).then_some(stated);
        (stated == of_chunks).then_some(stated)
    }

    /// Opcodes and bodies of the schemas, then of the channels.
    pub(crate) fn definitions(&self) -> impl Iterator<Item = (u8, &[u8])> {
        let schemas = self.schemas.values().map(|body| (op::SCHEMA, &body[..]));
        schemas.chain(self.channels.values().map(|body| (op::CHANNEL, &body[..])))
    }
}

/// End of a file that has a footer.
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
    pub(crate) fn read(source: &mut Source<'_>) -> Result<Option<Self>, ContainerError> {
        let Some(stored) = footer(source)? else {
            return Ok(None);
        };
        let StoredFooter { footer, .. } = stored;
        if footer.summary_start == 0 {
            return Ok(Some(End::Bare));
        }
        let summary = summary_bytes(source, &stored)?;
        let sound = summary.filter(|(_, sum)| [0, *sum].contains(&footer.summary_crc));
        let overview = sound.and_then(|(summary, _)| Overview::parse(&summary));
        Ok(Some(overview.map_or(End::Damaged, End::Summary)))
    }
}

/// The footer of a file with its place.
pub(crate) struct StoredFooter {
    pub(crate) offset: u64,
    pub(crate) footer: Footer,
    /// Bytes of it that the checksum of the summary covers.
    covered: [u8; PREFIX_BYTES + FOOTER_COVERED_BYTES],
}

/// The footer that a file ends with; `None` for a file that ends otherwise.
pub(crate) fn footer(source: &mut Source<'_>) -> Result<Option<StoredFooter>, ContainerError> {
    let end = (FOOTER_BYTES + mcap::MAGIC.len()) as u64;
    let Some(offset) = source.bytes().checked_sub(end) else {
        return Ok(None);
    };
    let mut bytes = Vec::new();
    source.read_at(offset, end, &mut bytes)?;
    let Some(bytes) = bytes.strip_suffix(mcap::MAGIC) else {
        return Ok(None);
    };
    let (Some((&[opcode, ..], body)), Some(&covered)) = (
        bytes.split_first_chunk::<PREFIX_BYTES>(),
        bytes.first_chunk(),
    ) else {
        return Ok(None);
    };
    Ok(match parse_record(opcode, body) {
        Ok(Record::Footer(footer)) => Some(StoredFooter {
            offset,
            footer,
            covered,
        }),
        _ => None,
    })
}

/// The summary of a file with its checksum; `None` where the footer points to none or to one that is too large.
pub(crate) fn summary_bytes(
    source: &mut Source<'_>,
    stored: &StoredFooter,
) -> Result<Option<(Vec<u8>, u32)>, ContainerError> {
    let start = stored.footer.summary_start;
    let length = stored.offset.checked_sub(start);
    let Some(length) = length.filter(|&length| length <= MOST_SUMMARY_BYTES) else {
        return Ok(None);
    };
    let mut summary = Vec::new();
    source.read_at(start, length, &mut summary)?;
    let mut sum = crc32fast::Hasher::new();
    sum.update(&summary);
    sum.update(&stored.covered);
    Ok(Some((summary, sum.finalize())))
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
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        to_bytes(&Metadata {
            name: self.name.clone(),
            metadata: self.facts.clone(),
        })
    }
}

impl From<Metadata> for MetadataRecord {
    fn from(record: Metadata) -> Self {
        Self {
            name: record.name,
            facts: record.metadata,
        }
    }
}

/// The metadata records of a file in their order; nothing else of it is looked at.
///
/// # Errors
///
/// [`ContainerError::Truncated`] and [`ContainerError::Damaged`] where records do not follow each
/// other or a metadata record does not parse, [`ContainerError::Read`].
pub fn metadata(source: &mut Source<'_>) -> Result<Vec<MetadataRecord>, ContainerError> {
    source.rewind()?;
    let (mut found, mut body) = (Vec::new(), Vec::new());
    while let Some(head) = source.next_head()? {
        match head.opcode {
            op::METADATA => {
                source.body(head, &mut body)?;
                let place = source.place(head.offset);
                if let Record::Metadata(record) = place.parse(head.opcode, &body)? {
                    found.push(record.into());
                }
            }
            op::DATA_END | op::FOOTER => break,
            _ => {}
        }
    }
    source.rewind()?;
    Ok(found)
}

/// The profile that a file states, such as `ros2`; empty where it states none.
///
/// # Errors
///
/// [`ContainerError::Truncated`] and [`ContainerError::Damaged`] where the file does not start with a sound record,
/// [`ContainerError::Read`].
pub fn profile(source: &mut Source<'_>) -> Result<String, ContainerError> {
    source.rewind()?;
    let header = source.header()?.unwrap_or_default();
    source.rewind()?;
    Ok(match parse_record(op::HEADER, &header) {
        Ok(Record::Header(header)) => header.profile,
        _ => String::new(),
    })
}

/// Log times of the earliest and the latest message of a file, nanoseconds since 1970-01-01 UTC, as
/// its summary states them; where that is damaged or contradicts itself, as its messages do, for which the
/// file is read to its end. `None` without messages.
///
/// # Errors
///
/// [`ContainerError::Truncated`] and [`ContainerError::Damaged`] for files without a sound summary
/// whose records do not follow each other, [`ContainerError::Read`].
pub fn span(source: &mut Source<'_>) -> Result<Option<(u64, u64)>, ContainerError> {
    if let Some(span) = Overview::read(source)?.span() {
        return Ok(span);
    }
    let mut span = None;
    walk_source(source, |record| {
        if let Record::Message { header, .. } = record {
            span = Some(spanned(span, header.log_time));
        }
        Ok::<_, ContainerError>(Depth::Everything)
    })?;
    source.rewind()?;
    Ok(span)
}

/// What the summary of a file lists and counts; nothing where there is none or one that is damaged.
#[derive(Clone, Debug, Default)]
pub struct Listed {
    /// Channels by id.
    pub channels: Vec<ChannelFacts>,
    /// Counts and log times of messages.
    pub statistics: Option<Statistics>,
}

/// Reads the summary of a file, nothing else of it.
///
/// # Errors
///
/// [`ContainerError::Read`], [`ContainerError::Damaged`].
pub fn listed(source: &mut Source<'_>) -> Result<Listed, ContainerError> {
    let overview = Overview::read(source)?;
    let mut definitions = Definitions::default();
    for (opcode, body) in overview.definitions() {
        definitions.add(&source.place(0).parse(opcode, body)?);
    }
    Ok(Listed {
        channels: definitions.channels.into_values().collect(),
        statistics: overview.statistics,
    })
}

/// The channels of a file by id: as its summary lists them, else as its records define them, for which
/// the file is read to its end.
///
/// # Errors
///
/// [`ContainerError::Truncated`] and [`ContainerError::Damaged`] for files without a sound summary
/// whose records do not follow each other, [`ContainerError::Read`].
pub fn channels(source: &mut Source<'_>) -> Result<Vec<ChannelFacts>, ContainerError> {
    let overview = Overview::read(source)?;
    let mut definitions = Definitions::default();
    walk_definitions(source, &overview, |record| {
        definitions.add(&record);
        Ok(())
    })?;
    Ok(definitions.channels.into_values().collect())
}

/// Visits the schemas and channels of a file: those that its summary lists, and unless that is complete
/// those that its records define, for which the file is read to its end. Then the source is at its first
/// record.
pub(crate) fn walk_definitions(
    source: &mut Source<'_>,
    overview: &Overview,
    mut visit: impl FnMut(Record<'_>) -> Result<(), ContainerError>,
) -> Result<(), ContainerError> {
    for (opcode, body) in overview.definitions() {
        visit(source.place(0).parse(opcode, body)?)?;
    }
    if overview.complete {
        return Ok(());
    }
    walk_source(source, |record| visit(record).map(|()| Depth::Everything))?;
    source.rewind()
}
