//! Part of a file: a time range, some topics, another packing. All else byte for byte.

mod latched;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Write};

use mcap::records::{Record, op};

use crate::attachment::pass_attachment;
use crate::channel::{ChannelFacts, Definitions, Latch, latch};
use crate::chunk::{Packing, frame_bytes, header_bytes};
use crate::error::{ContainerError, Place};
use crate::feed::{Feed, Outside};
use crate::fields::chunk_header;
use crate::format::{MessageFacts, Records, id_of, is_made_anew, push_record};
use crate::ids::Ids;
use crate::interval::Interval;
use crate::merge::set_channel;
use crate::overview::{CHUNK_START_BYTES, MetadataRecord, Overview, walk_definitions};
use crate::source::{Head, Source};
use crate::writer::{CHUNK_BYTES, Writer, Written};
use latched::Latched;

/// What is kept of a file.
pub struct Selection<'a> {
    /// Ranges of log time; messages of others are left out.
    pub keep: Vec<Interval>,
    /// Which channels stay; a message whose channel the file does not define stays only where this
    /// is `None`.
    pub channels: Option<&'a dyn Fn(&ChannelFacts) -> bool>,
    /// Which messages from before an interval are moved to its start.
    pub latch: &'a dyn Fn(&ChannelFacts) -> Option<Latch>,
    /// Whether metadata records stay.
    pub metadata: bool,
    /// Whether attachments stay.
    pub attachments: bool,
    /// What metadata records of these names say instead.
    pub replace: BTreeMap<String, BTreeMap<String, String>>,
    /// Metadata records to add at the end of the data.
    pub add: Vec<MetadataRecord>,
    /// An MCAP file whose messages come between those that stay, by log time, chunk by chunk; its other
    /// records are left out. Its channels become one with equal ones that stay, and get new ids where
    /// theirs are taken.
    pub append: Option<&'a [u8]>,
    /// How chunks are packed [as they were]. Messages that lie outside chunks are put into some.
    pub packing: Option<Packing>,
}

impl Default for Selection<'_> {
    /// Everything as it is.
    fn default() -> Self {
        Self {
            keep: vec![Interval::ALL],
            channels: None,
            latch: &latch,
            metadata: true,
            attachments: true,
            replace: BTreeMap::new(),
            add: Vec::new(),
            append: None,
            packing: None,
        }
    }
}

impl std::fmt::Debug for Selection<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (f.debug_struct("Selection"))
            .field("keep", &self.keep)
            .field("metadata", &self.metadata)
            .field("attachments", &self.attachments)
            .field("packing", &self.packing)
            .finish_non_exhaustive()
    }
}

/// What became of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Selected {
    /// What the output holds.
    pub written: Written,
    /// Messages that were appended.
    pub appended: u64,
    /// Messages that were read and left out.
    pub left_out: u64,
    /// Chunks that were not even read, since their times are outside all intervals.
    pub chunks_skipped: u64,
    /// Messages whose log time is now that of the first message of an interval.
    pub moved: u64,
}

/// Copies what `selection` keeps of a file.
///
/// What is kept stays byte for byte and in its order: the header, schemas (also unused ones), channels
/// with their ids, messages, attachments, metadata records, private records. Chunks of which
/// everything stays are not even packed again. Indexes, the summary and checksums are made anew.
/// Memory is taken for the largest record and for what the summary says.
///
/// # Errors
///
/// [`ContainerError::Truncated`] and [`ContainerError::Damaged`] with the byte at which the file is
/// wrong; [`ContainerError::Memory`] for a record beyond the memory limit; [`ContainerError::Collision`]
/// where ids of appended channels run out; [`ContainerError::Read`], [`ContainerError::Write`]. What was written then is no file.
pub fn select(
    source: &mut Source<'_>,
    out: &mut dyn Write,
    selection: &Selection<'_>,
) -> Result<Selected, ContainerError> {
    let overview = Overview::read(source)?;
    let appended = (selection.append)
        .map(|bytes| Appended::open(source, &overview, selection, bytes))
        .transpose()?;
    let header = source.header()?.unwrap_or_else(|| vec![0; 8]);
    let packing = selection.packing.unwrap_or(Packing::Zstd);
    let mut copy = Copy {
        source,
        overview,
        selection,
        writer: Writer::with_header(out, &header, packing)?,
        appended,
        definitions: Definitions::default(),
        fates: BTreeMap::new(),
        defined: BTreeSet::new(),
        latched: Latched::default(),
        result: Selected::default(),
        body: Vec::new(),
        records: Vec::new(),
        kept: Vec::new(),
    };
    copy.learn_from_overview()?;
    while let Some(head) = copy.source.next_head()? {
        if matches!(head.opcode, op::DATA_END | op::FOOTER) {
            copy.source.read_to_end(head)?;
            break;
        }
        copy.record(head)?;
    }
    copy.finish()
}

/// What is decided about a channel.
#[derive(Clone, Copy)]
struct Fate {
    kept: bool,
    latch: Option<Latch>,
}

struct Copy<'a, 's> {
    source: &'a mut Source<'s>,
    overview: Overview,
    selection: &'a Selection<'a>,
    writer: Writer<'a>,
    appended: Option<Appended<'a>>,
    definitions: Definitions,
    fates: BTreeMap<u16, Fate>,
    /// Channels that the data have defined so far.
    defined: BTreeSet<u16>,
    latched: Latched,
    result: Selected,
    /// Body of the record at hand.
    body: Vec<u8>,
    /// Records of the chunk at hand.
    records: Vec<u8>,
    /// Those of them that stay.
    kept: Vec<u8>,
}

impl Copy<'_, '_> {
    /// Channels are known from the summary before chunks are skipped.
    fn learn_from_overview(&mut self) -> Result<(), ContainerError> {
        let overview = std::mem::take(&mut self.overview);
        for (opcode, body) in overview.definitions() {
            self.define(self.source.bytes(), opcode, body)?;
        }
        self.overview = overview;
        Ok(())
    }

    /// Learns a schema or channel; gives whether it stays.
    fn define(&mut self, offset: u64, opcode: u8, body: &[u8]) -> Result<bool, ContainerError> {
        let record = self.source.place(offset).parse(opcode, body)?;
        let Some(id) = self.definitions.add(&record) else {
            return Ok(true);
        };
        let channel = &self.definitions.channels[&id];
        // As it was defined last, where a file uses an id again.
        let fate = Fate {
            kept: self.selection.keeps(channel),
            latch: (self.selection.latch)(channel),
        };
        self.fates.insert(id, fate);
        Ok(fate.kept)
    }

    fn record(&mut self, head: Head) -> Result<(), ContainerError> {
        match head.opcode {
            op::CHUNK if self.skips(head)? => return self.skipped(),
            op::CHUNK => return self.chunk(head),
            op::ATTACHMENT if self.selection.attachments => {
                return pass_attachment(self.source, head, &mut self.writer);
            }
            op::ATTACHMENT => return Ok(()),
            _ => {}
        }
        let mut body = std::mem::take(&mut self.body);
        self.source.body(head, &mut body)?;
        match head.opcode {
            opcode if is_made_anew(opcode) => {}
            op::METADATA => self.metadata(head, &body)?,
            opcode if self.stays(head.offset, opcode, &body)? => {
                let mut moved = std::mem::take(&mut self.kept);
                moved.clear();
                self.defined_before(opcode, &body, &mut moved);
                let time = self.moved_before(opcode, &body, &mut moved);
                if time.is_some() {
                    self.append_before(time)?;
                }
                for (opcode, body) in Records(&moved).flatten() {
                    self.alone(opcode, body)?;
                }
                self.kept = moved;
                self.alone(opcode, &body)?;
            }
            _ => {}
        }
        self.body = body;
        Ok(())
    }

    /// Writes a record that lies outside chunks.
    fn alone(&mut self, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        let chunked = matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE);
        match self.selection.packing {
            Some(_) if chunked => self.writer.inside(opcode, body),
            _ => self.writer.outside(opcode, body),
        }
    }

    fn metadata(&mut self, head: Head, body: &[u8]) -> Result<(), ContainerError> {
        let record = self.source.place(head.offset).parse(head.opcode, body)?;
        let Record::Metadata(record) = record else {
            return Ok(());
        };
        if !self.selection.metadata {
            return Ok(());
        }
        match self.selection.replace.get(&record.name) {
            Some(facts) => self.writer.metadata(&record.name, facts),
            None => self.writer.outside(op::METADATA, body),
        }
    }

    /// Whether a record that may lie in a chunk stays where it is.
    fn stays(&mut self, offset: u64, opcode: u8, body: &[u8]) -> Result<bool, ContainerError> {
        if matches!(opcode, op::SCHEMA | op::CHANNEL) {
            self.defined
                .extend(id_of(body).filter(|_| opcode == op::CHANNEL));
            return self.define(offset, opcode, body);
        }
        if opcode != op::MESSAGE {
            return Ok(true);
        }
        let place = self.source.place(offset);
        let message = MessageFacts::read(body).ok_or_else(|| place.short(op::MESSAGE))?;
        let fate = self.fates.get(&message.channel).copied();
        let fate = fate.unwrap_or(Fate {
            kept: self.selection.channels.is_none(),
            latch: None,
        });
        let keep = &self.selection.keep;
        if fate.kept && keep.iter().any(|range| range.contains(message.log_time)) {
            return Ok(true);
        }
        self.result.left_out += match fate.latch {
            Some(latch) if fate.kept => self.latched.hold(keep, message, latch, body),
            _ => 1,
        };
        Ok(false)
    }

    /// Adds the channel of a message, after its schema, where the summary alone defines it.
    fn defined_before(&mut self, opcode: u8, body: &[u8], records: &mut Vec<u8>) {
        let id = id_of(body).filter(|_| opcode == op::MESSAGE);
        let Some(id) = id.filter(|id| !self.defined.contains(id)) else {
            return;
        };
        self.defined.insert(id);
        if let Some(channel) = self.overview.channels.get(&id) {
            let schema = channel.get(2..).and_then(id_of);
            if let Some(schema) = schema.and_then(|id| self.overview.schemas.get(&id)) {
                push_record(records, op::SCHEMA, schema);
            }
            push_record(records, op::CHANNEL, channel);
        }
    }

    /// Adds the messages that an interval starts with, if this is its first one; gives the log time of a
    /// message.
    fn moved_before(&mut self, opcode: u8, body: &[u8], records: &mut Vec<u8>) -> Option<u64> {
        let message = (opcode == op::MESSAGE).then(|| MessageFacts::read(body));
        let time = message.flatten()?.log_time;
        let mut keep = self.selection.keep.iter();
        if let Some(interval) = keep.position(|interval| interval.contains(time)) {
            self.result.moved += self.latched.release(interval, time, records);
        }
        Some(time)
    }

    fn chunk(&mut self, head: Head) -> Result<(), ContainerError> {
        let mut body = std::mem::take(&mut self.body);
        let mut records = std::mem::take(&mut self.records);
        let mut kept = std::mem::take(&mut self.kept);
        let header = self.source.chunk(head, &mut body, &mut records)?;
        kept.clear();
        for (opcode, data) in Records(&records).flatten() {
            if self.stays(head.offset, opcode, data)? {
                self.defined_before(opcode, data, &mut kept);
                self.moved_before(opcode, data, &mut kept);
                push_record(&mut kept, opcode, data);
            }
        }
        self.append_before(Some(header.message_start_time))?;
        let own = Packing::from_name(&header.compression);
        let packing = self.selection.packing.or(own).unwrap_or(Packing::Zstd);
        if kept == records && Some(packing) == own {
            let start = header_bytes(&header);
            // As long as the chunk's parsing made sure of.
            let packed = &body[start..start + header.compressed_size as usize];
            match frame_bytes(packing.name(), packed, &records) == Some(packed.len()) {
                true => (self.writer).packed_chunk(&records, packing.name(), packed)?,
                false => self.writer.chunk(&records, packing)?,
            }
        } else if !kept.is_empty() {
            self.writer.chunk(&kept, packing)?;
        }
        (self.body, self.records, self.kept) = (body, records, kept);
        Ok(())
    }

    /// Whether nothing of a chunk can be of use, by its times and what the summary says of it.
    fn skips(&mut self, head: Head) -> Result<bool, ContainerError> {
        let keep = &self.selection.keep;
        if !self.overview.complete || keep == &[Interval::ALL] {
            return Ok(false);
        }
        let mut start = Vec::new();
        let bytes = head.bytes.min(CHUNK_START_BYTES);
        self.source.read_at(head.body(), bytes, &mut start)?;
        self.source.back_to(head)?;
        let (Some(header), Some(listed)) =
            (chunk_header(&start), self.overview.chunks.get(&head.offset))
        else {
            return Ok(false);
        };
        let (first, last) = (header.message_start_time, header.message_end_time);
        let used = keep.iter().any(|interval| interval.meets(first, last));
        let mut channels = listed.message_index_offsets.keys();
        let latched = channels.any(|id| {
            let fate = self.fates.get(id);
            fate.is_none_or(|fate| fate.latch.is_some())
        });
        // Without a single channel it may be that its writer made no message indexes.
        let skips = !used
            && !latched
            && !listed.message_index_offsets.is_empty()
            && self.overview.agrees(self.source, head, (first, last))?;
        self.source.back_to(head)?;
        if skips && let Some(packing) = Packing::from_name(&header.compression) {
            self.writer
                .set_packing(self.selection.packing.unwrap_or(packing));
        }
        Ok(skips)
    }

    /// What a skipped chunk may have defined comes from the summary.
    fn skipped(&mut self) -> Result<(), ContainerError> {
        self.result.chunks_skipped += 1;
        self.defined.extend(self.overview.channels.keys());
        for (opcode, body) in self.overview.definitions() {
            let fate = id_of(body).filter(|_| opcode == op::CHANNEL);
            let fate = fate.and_then(|id| self.fates.get(&id));
            if fate.is_none_or(|fate| fate.kept) {
                self.writer.inside_once(opcode, body)?;
            }
        }
        self.writer.close_chunk()
    }

    /// Writes appended messages up to this time; without one all that are left.
    fn append_before(&mut self, time: Option<u64>) -> Result<(), ContainerError> {
        let packing = self.selection.packing.unwrap_or(Packing::Zstd);
        match &mut self.appended {
            Some(appended) => appended.write_before(time, &mut self.writer, packing),
            None => Ok(()),
        }
    }

    /// Writes the schemas and channels that the summary alone defines.
    fn define_rest(&mut self) -> Result<(), ContainerError> {
        for (opcode, body) in self.overview.definitions() {
            let Some(id) = id_of(body).filter(|id| !self.writer.has(opcode, *id)) else {
                continue;
            };
            let fate = self.fates.get(&id).filter(|_| opcode == op::CHANNEL);
            if fate.is_none_or(|fate| fate.kept) {
                self.writer.outside(opcode, body)?;
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Selected, ContainerError> {
        let mut rest = Vec::new();
        for (n, interval) in self.selection.keep.iter().enumerate() {
            let start = interval.from_unix_nanos();
            self.result.moved += self.latched.release(n, start, &mut rest);
        }
        if !rest.is_empty() {
            let packing = self.selection.packing.unwrap_or(Packing::Zstd);
            self.writer.chunk(&rest, packing)?;
        }
        self.define_rest()?;
        self.append_before(None)?;
        self.result.appended = self.appended.map_or(0, |appended| appended.messages);
        for record in &self.selection.add {
            self.writer.metadata(&record.name, &record.facts)?;
        }
        self.result.written = self.writer.finish()?;
        Ok(self.result)
    }
}

impl Selection<'_> {
    fn keeps(&self, channel: &ChannelFacts) -> bool {
        self.channels.is_none_or(|keep| keep(channel))
    }
}

/// Messages of a second file, on their way into the copy of the first.
struct Appended<'a> {
    feed: Feed<'a>,
    ids: Ids,
    /// Records that are not written yet.
    records: Vec<u8>,
    messages: u64,
}

impl<'a> Appended<'a> {
    /// Leaves the ids alone that the first file has for what stays of it.
    fn open(
        source: &mut Source<'_>,
        overview: &Overview,
        selection: &Selection<'_>,
        bytes: &'a [u8],
    ) -> Result<Self, ContainerError> {
        // The first file may have several channels on a topic.
        let (mut ids, mut known) = (Ids::new(true), Definitions::default());
        let file = source.file().to_owned();
        let place = Place {
            file: &file,
            offset: 0,
        };
        walk_definitions(source, overview, |record| {
            let id = known.add(&record);
            if id.is_none_or(|id| selection.keeps(&known.channels[&id])) {
                ids.learn(0, place, &record)?;
            }
            Ok(())
        })?;
        let added = format!("what is added to {file}");
        let mut appended = Self {
            feed: Feed::start(Source::open(&added, Cursor::new(bytes))?)?,
            ids,
            records: Vec::new(),
            messages: 0,
        };
        appended.advance()?;
        Ok(appended)
    }

    /// Goes on to the next message.
    fn advance(&mut self) -> Result<(), ContainerError> {
        let feed = &mut self.feed;
        while let Some(outside) = feed.next()? {
            if let Outside::Record(opcode @ (op::SCHEMA | op::CHANNEL)) = outside {
                let body = (self.ids).define(1, feed.place(), opcode, feed.body())?;
                push_record(&mut self.records, opcode, &body);
            }
        }
        Ok(())
    }

    /// Writes messages up to this time as far as they fill chunks; without one all that are left.
    fn write_before(
        &mut self,
        time: Option<u64>,
        writer: &mut Writer<'_>,
        packing: Packing,
    ) -> Result<(), ContainerError> {
        while let Some(next) = self.feed.message_time()
            && time.is_none_or(|time| next < time)
        {
            set_channel(&self.ids, 1, &mut self.feed)?;
            push_record(&mut self.records, op::MESSAGE, self.feed.body());
            self.messages += 1;
            self.advance()?;
            if self.records.len() > CHUNK_BYTES {
                writer.chunk(&self.records, packing)?;
                self.records.clear();
            }
        }
        if time.is_none() && !self.records.is_empty() {
            writer.chunk(&self.records, packing)?;
            self.records.clear();
        }
        Ok(())
    }
}
