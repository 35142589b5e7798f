//! Comparison of everything that a file states twice.

mod chunk;
mod differences;
mod summary;

use std::collections::BTreeMap;
use std::fmt::Display;

use mcap::records::{AttachmentIndex, MessageHeader, MetadataIndex, Record, Statistics, op};

use crate::attachment::check_whole;
use crate::channel::{ChannelFacts, Definitions};
use crate::chunk::unpack;
use crate::error::{ContainerError, Place};
use crate::format::{PREFIX_BYTES, Records, spanned};
use crate::source::{Head, Source};
use chunk::OpenChunk;
pub use differences::{Difference, Differences};
use summary::Summary;

/// Result of an [`audit`].
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Audit {
    /// Messages in all channels.
    pub messages: u64,
    /// Chunks.
    pub chunks: u64,
    /// Channels that are defined in the data.
    pub channels: u64,
    /// Attachments.
    pub attachments: u64,
    /// Metadata records.
    pub metadata: u64,
    /// What the file does not have, so that it was not compared.
    pub notes: Vec<String>,
    /// Statements of the file that contradict its content.
    pub differences: Differences,
}

/// Takes a message with its channel, and the differences so far.
pub type Visit<'v> = dyn FnMut(&ChannelFacts, &MessageHeader, &[u8], &mut Differences) + 'v;

/// Reads a whole file and compares what it states with what it holds: checksums, definitions in data and summary, log
/// times of chunks, message and chunk indexes, indexes of attachments and metadata, statistics, summary offsets.
/// `visit` gets every message of an intact chunk or record. Reading goes on after a damaged chunk and ends where
/// records do not follow each other.
///
/// What a file may leave out (summary, indexes, checksums) is no difference, but noted. Memory is taken for the
/// largest chunk and the summary.
///
/// # Errors
///
/// [`ContainerError::Read`], and [`ContainerError::Memory`] for a record beyond the memory limit.
pub fn audit(source: &mut Source<'_>, visit: &mut Visit<'_>) -> Result<Audit, ContainerError> {
    let mut found = Audit::default();
    let summary = Summary::read(source, &mut found.differences)?;
    let mut auditor = Auditor {
        found,
        summary,
        definitions: Definitions::default(),
        open: None,
        by_channel: BTreeMap::new(),
        span: None,
        undefined: BTreeMap::new(),
        outside: 0,
        without_index: 0,
        without_sum: 0,
        visit,
    };
    source.rewind()?;
    if auditor.walk(source)? {
        auditor.compare_summary();
    }
    Ok(auditor.finish())
}

struct Auditor<'v> {
    found: Audit,
    /// Entries are taken out as they are compared.
    summary: Summary,
    definitions: Definitions,
    open: Option<OpenChunk>,
    by_channel: BTreeMap<u16, u64>,
    span: Option<(u64, u64)>,
    /// Messages of channels that are not defined before them.
    undefined: BTreeMap<u16, u64>,
    /// Messages outside chunks.
    outside: u64,
    /// Chunks without message indexes, and without a checksum.
    without_index: u64,
    without_sum: u64,
    visit: &'v mut Visit<'v>,
}

impl Auditor<'_> {
    /// Visits all records; whether they follow each other to the end of the file.
    fn walk(&mut self, source: &mut Source<'_>) -> Result<bool, ContainerError> {
        let (mut in_summary, mut body, mut records) = (false, Vec::new(), Vec::new());
        loop {
            let at = source.next_offset();
            let head = match source.next_head() {
                Ok(Some(head)) => head,
                Ok(None) => return Ok(true),
                Err(error) => {
                    // The marks at the end of data and summary, whose checksum differs, are behind.
                    let goes_on = source.next_offset() > at;
                    // The checksum of the summary was compared before.
                    if !(goes_on && in_summary) {
                        self.found.differences.fault(error)?;
                    }
                    if !goes_on {
                        return Ok(false);
                    }
                    self.close_chunk();
                    in_summary = true;
                    continue;
                }
            };
            if head.opcode == op::ATTACHMENT && !in_summary {
                self.close_chunk();
                match check_whole(source, head) {
                    Ok(index) => self.attachment(&index),
                    Err(error) => self.found.differences.fault(error)?,
                }
                continue;
            }
            source.body(head, &mut body)?;
            if in_summary {
                continue;
            }
            if head.opcode != op::MESSAGE_INDEX {
                self.close_chunk();
            }
            let place = source.place(head.offset);
            match head.opcode {
                op::CHUNK => self.chunk(place, head, &body, &mut records)?,
                _ => match place.parse(head.opcode, &body) {
                    Ok(record) => self.record(head, record),
                    Err(error) => self.found.differences.fault(error)?,
                },
            }
            in_summary = head.opcode == op::DATA_END;
        }
    }

    fn chunk(
        &mut self,
        place: Place<'_>,
        head: Head,
        body: &[u8],
        records: &mut Vec<u8>,
    ) -> Result<(), ContainerError> {
        self.found.chunks += 1;
        let header = match unpack(place, body, records) {
            Ok(header) => header,
            Err(error) => {
                self.summary.chunks.remove(&head.offset);
                return self.found.differences.fault(error);
            }
        };
        self.without_sum += u64::from(header.uncompressed_crc == 0 && !records.is_empty());
        let mut open = OpenChunk::new(head, header);
        let mut offset = 0;
        for (opcode, data) in Records(records).flatten() {
            match place.parse(opcode, data) {
                Ok(Record::Message { header, data }) => {
                    open.message(&header, offset);
                    self.message(&header, &data);
                }
                Ok(record) => self.define(head.offset, &record),
                Err(error) => self.found.differences.fault(error)?,
            }
            offset += (PREFIX_BYTES + data.len()) as u64;
        }
        self.open = Some(open);
        Ok(())
    }

    fn close_chunk(&mut self) {
        if let Some(open) = self.open.take() {
            let entry = self.summary.chunks.remove(&open.offset());
            let differences = &mut self.found.differences;
            let has_index = open.close(entry, self.summary.has_chunks, differences);
            self.without_index += u64::from(!has_index);
        }
    }

    /// A record outside chunks.
    fn record(&mut self, head: Head, record: Record<'_>) {
        match record {
            Record::Message { header, data } => {
                self.outside += 1;
                self.message(&header, &data);
            }
            Record::MessageIndex(index) => {
                if let Some(open) = &mut self.open {
                    open.index(head, index, &mut self.found.differences);
                }
            }
            Record::Metadata(record) => {
                self.found.metadata += 1;
                let held = MetadataIndex {
                    offset: head.offset,
                    length: head.end() - head.offset,
                    name: record.name,
                };
                let entries = &mut self.summary.metadata;
                if let Some(stated) = entries.remove(&head.offset).filter(|own| *own != held) {
                    let place = format_args!("metadata index of byte {}", head.offset);
                    let differences = &mut self.found.differences;
                    differences.add(place, format!("{held:?}"), format!("{stated:?}"));
                }
            }
            Record::DataEnd(end) if end.data_section_crc == 0 => {
                let note = "no checksum of the data as a whole";
                self.found.notes.push(note.to_owned());
            }
            Record::Footer(_) => {
                let place = format_args!("byte {}: footer", head.offset);
                let differences = &mut self.found.differences;
                differences.add(place, "the end of the data before it", "none");
            }
            record => self.define(head.offset, &record),
        }
    }

    fn attachment(&mut self, held: &AttachmentIndex) {
        self.found.attachments += 1;
        let stated = self.summary.attachments.remove(&held.offset);
        if let Some(stated) = stated.filter(|own| own != held) {
            let place = format_args!("attachment index of byte {}", held.offset);
            let differences = &mut self.found.differences;
            differences.add(place, format!("{held:?}"), format!("{stated:?}"));
        }
    }

    /// Learns a schema or a channel; one that is repeated has to be the same.
    fn define(&mut self, offset: u64, record: &Record<'_>) {
        let known = &self.definitions;
        let same = match record {
            Record::Schema { header, data } => (known.schemas.get(&header.id)).is_none_or(|own| {
                (&*own.name, &*own.encoding, &*own.data)
                    == (&*header.name, &*header.encoding, &**data)
            }),
            Record::Channel(channel) => (known.channels.get(&channel.id)).is_none_or(|own| {
                (&own.topic, &own.message_encoding, &own.metadata)
                    == (&channel.topic, &channel.message_encoding, &channel.metadata)
                    && own.schema.as_ref() == known.schemas.get(&channel.schema_id)
            }),
            _ => return,
        };
        if !same {
            let place = format_args!("byte {offset}: {}", defined(record));
            let differences = &mut self.found.differences;
            differences.add(place, "its earlier definition", "another one");
        }
        self.definitions.add(record);
    }

    fn message(&mut self, header: &MessageHeader, data: &[u8]) {
        self.found.messages += 1;
        *self.by_channel.entry(header.channel_id).or_default() += 1;
        self.span = Some(spanned(self.span, header.log_time));
        match self.definitions.channels.get(&header.channel_id) {
            Some(channel) => (self.visit)(channel, header, data, &mut self.found.differences),
            None => *self.undefined.entry(header.channel_id).or_default() += 1,
        }
    }

    /// Compares what only the whole file tells.
    fn compare_summary(&mut self) {
        let (summary, found) = (&self.summary, &mut self.found.differences);
        for offset in summary.chunks.keys() {
            found.add(
                format_args!("chunk index of byte {offset}"),
                "a chunk",
                "none",
            );
        }
        for offset in summary.attachments.keys() {
            let place = format_args!("attachment index of byte {offset}");
            found.add(place, "an attachment", "none");
        }
        for offset in summary.metadata.keys() {
            let place = format_args!("metadata index of byte {offset}");
            found.add(place, "a metadata record", "none");
        }
        let (held, stated) = (&self.definitions, &summary.definitions);
        compare_definitions("schema", &held.schemas, &stated.schemas, found);
        let mut channels = held.channels.clone();
        if stated.schemas.is_empty() {
            // Without its schemas the summary only names their ids.
            channels
                .values_mut()
                .for_each(|channel| channel.schema = None);
        }
        compare_definitions("channel", &channels, &stated.channels, found);
        if let Some(statistics) = self.summary.statistics.take() {
            self.compare_statistics(&statistics);
        }
    }

    fn compare_statistics(&mut self, stated: &Statistics) {
        let (held, all) = (&self.definitions, &self.summary.definitions);
        // Some writers count what the summary alone lists.
        let counted = |held: usize, listed: usize, stated: u64| match stated == listed as u64 {
            true => stated,
            false => held as u64,
        };
        let (schemas, channels) = (stated.schema_count.into(), stated.channel_count.into());
        let counts = [
            ("messages", self.found.messages, stated.message_count),
            (
                "schemas",
                counted(held.schemas.len(), all.schemas.len(), schemas),
                schemas,
            ),
            (
                "channels",
                counted(held.channels.len(), all.channels.len(), channels),
                channels,
            ),
            (
                "attachments",
                self.found.attachments,
                stated.attachment_count.into(),
            ),
            (
                "metadata records",
                self.found.metadata,
                stated.metadata_count.into(),
            ),
            ("chunks", self.found.chunks, stated.chunk_count.into()),
        ];
        let found = &mut self.found.differences;
        for (what, held, stated) in counts {
            found.compare(format_args!("statistics, {what}"), held, stated);
        }
        if let Some((first, last)) = self.span {
            let place = |what: &str| format!("statistics, {what} log time in ns");
            // Some writers take a log time of 0 for none.
            if first > 0 {
                found.compare(place("first"), first, stated.message_start_time);
            }
            found.compare(place("last"), last, stated.message_end_time);
        }
        // An empty map says that they were not counted.
        let of_channels = &stated.channel_message_counts;
        if !of_channels.is_empty() {
            let mut channels: Vec<_> = self.by_channel.keys().chain(of_channels.keys()).collect();
            channels.sort_unstable();
            channels.dedup();
            for channel in channels {
                let of = |counts: &BTreeMap<u16, u64>| counts.get(channel).copied();
                let [held, stated] = [&self.by_channel, of_channels].map(of);
                let place = format_args!("statistics, messages of channel {channel}");
                found.compare(place, held.unwrap_or_default(), stated.unwrap_or_default());
            }
        }
    }

    fn finish(mut self) -> Audit {
        for (channel, messages) in &self.undefined {
            self.found.differences.add(
                format_args!("{messages} messages of channel {channel}"),
                "its definition before them",
                "none",
            );
        }
        let mut found = self.found;
        found.channels = self.definitions.channels.len() as u64;
        found.notes.extend(self.summary.notes(found.chunks));
        for (number, of, what) in [
            (
                self.without_index,
                found.chunks,
                "chunks have no message indexes",
            ),
            (self.without_sum, found.chunks, "chunks have no checksum"),
            (self.outside, found.messages, "messages are in no chunk"),
        ] {
            if number > 0 {
                found.notes.push(format!("{number} of {of} {what}"));
            }
        }
        found
    }
}

/// Definitions of the summary against those of the data.
fn compare_definitions<T: PartialEq>(
    what: impl Display,
    held: &BTreeMap<u16, T>,
    stated: &BTreeMap<u16, T>,
    found: &mut Differences,
) {
    for (id, own) in held {
        let place = format_args!("summary, {what} {id}");
        match stated.get(id) {
            Some(stated) if stated != own => found.add(place, "as in the data", "another one"),
            None if !stated.is_empty() => found.add(place, "as in the data", "none"),
            _ => {}
        }
    }
}

fn defined(record: &Record<'_>) -> String {
    match record {
        Record::Schema { header, .. } => format!("schema {}", header.id),
        Record::Channel(channel) => format!("channel {}", channel.id),
        _ => String::new(),
    }
}
