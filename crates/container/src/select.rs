//! Part of a file: a stretch of time, some topics, another packing. All else byte for byte.

mod latched;

use std::collections::BTreeMap;
use std::io::{Read, Seek, Write};

use mcap::records::op;

use crate::attachment::pass_attachment;
use crate::channel::{ChannelFacts, Definitions, Latch, latch};
use crate::chunk::{Extent, Packing, unpack};
use crate::error::ContainerError;
use crate::format::{ChunkFacts, MessageFacts, Records, push_record};
use crate::index::Written;
use crate::interval::Interval;
use crate::overview::{CHUNK_START_BYTES, MetadataRecord, Overview};
use crate::source::{Head, Source};
use crate::walk::{chunk_facts, chunk_fault, parse};
use crate::writer::Writer;
use latched::Latched;

/// What is kept of a file.
pub struct Selection<'a> {
    /// Stretches of log time; messages of others are left out.
    pub keep: Vec<Interval>,
    /// Which channels stay; a message whose channel the file does not define stays only where this
    /// is `None`.
    pub channels: Option<&'a dyn Fn(&ChannelFacts) -> bool>,
    /// Which messages from before a stretch are moved to its start.
    pub latch: &'a dyn Fn(&ChannelFacts) -> Option<Latch>,
    /// Whether metadata records stay.
    pub metadata: bool,
    /// Whether attachments stay.
    pub attachments: bool,
    /// What metadata records of these names say instead.
    pub replace: BTreeMap<String, BTreeMap<String, String>>,
    /// Metadata records to add at the end of the data.
    pub add: Vec<MetadataRecord>,
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
    /// Messages that were read and left out.
    pub left_out: u64,
    /// Chunks that were not even read, since their times are outside all stretches.
    pub chunks_skipped: u64,
    /// Messages whose log time is now that of the first message of a stretch.
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
/// wrong; [`ContainerError::Read`], [`ContainerError::Write`]. What was written then is no file.
pub fn select<R: Read + Seek, W: Write>(
    source: &mut Source<R>,
    out: W,
    selection: &Selection<'_>,
) -> Result<Selected, ContainerError> {
    let overview = Overview::read(source)?;
    let mut body = Vec::new();
    let header = header(source, &mut body)?;
    let mut copy = Copy {
        overview,
        selection,
        writer: Writer::create(out, &header, selection.packing.unwrap_or(Packing::Zstd))?,
        definitions: Definitions::default(),
        channels: BTreeMap::new(),
        latched: Latched::default(),
        result: Selected::default(),
        records: Vec::new(),
        kept: Vec::new(),
    };
    copy.learn_from_overview(source)?;
    while let Some(head) = source.next_head()? {
        if matches!(head.opcode, op::DATA_END | op::FOOTER) {
            // To the end, for its checksums.
            source.body(head, &mut body)?;
            while let Some(head) = source.next_head()? {
                source.body(head, &mut body)?;
            }
            break;
        }
        copy.record(source, head, &mut body)?;
    }
    copy.finish()
}

/// The body of the header record; that of an empty one where the file does not start with one.
pub(crate) fn header<R: Read + Seek>(
    source: &mut Source<R>,
    body: &mut Vec<u8>,
) -> Result<Vec<u8>, ContainerError> {
    if let Some(head) = source.next_head()?
        && head.opcode == op::HEADER
    {
        source.body(head, body)?;
        parse(source.place(head.offset), head.opcode, body)?;
        return Ok(body.clone());
    }
    source.rewind()?;
    Ok(vec![0; 8])
}

/// What is decided about a channel.
#[derive(Clone, Copy)]
struct Fate {
    kept: bool,
    latch: Option<Latch>,
}

struct Copy<'a, W> {
    overview: Overview,
    selection: &'a Selection<'a>,
    writer: Writer<W>,
    definitions: Definitions,
    channels: BTreeMap<u16, Fate>,
    latched: Latched,
    result: Selected,
    /// Records of the chunk at hand.
    records: Vec<u8>,
    /// Those of them that stay.
    kept: Vec<u8>,
}

impl<W: Write> Copy<'_, W> {
    /// Channels are known from the summary before chunks are skipped.
    fn learn_from_overview<R: Read + Seek>(
        &mut self,
        source: &Source<R>,
    ) -> Result<(), ContainerError> {
        let overview = &self.overview;
        let bodies = (overview.schemas.values().map(|body| (op::SCHEMA, body)))
            .chain(overview.channels.values().map(|body| (op::CHANNEL, body)));
        let bodies: Vec<_> = bodies
            .map(|(opcode, body)| (opcode, body.clone()))
            .collect();
        for (opcode, body) in bodies {
            self.define(source, source.bytes(), opcode, &body)?;
        }
        Ok(())
    }

    /// Learns a schema or channel; gives whether it stays.
    fn define<R: Read + Seek>(
        &mut self,
        source: &Source<R>,
        offset: u64,
        opcode: u8,
        body: &[u8],
    ) -> Result<bool, ContainerError> {
        let record = parse(source.place(offset), opcode, body)?;
        let Some(channel) = self.definitions.add(record) else {
            return Ok(true);
        };
        let fate = Fate {
            kept: self.selection.channels.is_none_or(|keep| keep(&channel)),
            latch: (self.selection.latch)(&channel),
        };
        self.channels.insert(channel.id, fate);
        Ok(fate.kept)
    }

    fn record<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
        head: Head,
        body: &mut Vec<u8>,
    ) -> Result<(), ContainerError> {
        match head.opcode {
            op::CHUNK if self.skips(source, head)? => self.skipped(),
            op::CHUNK => {
                source.body(head, body)?;
                self.chunk(source, head, body)
            }
            op::ATTACHMENT if self.selection.attachments => {
                pass_attachment(source, head, &mut self.writer)
            }
            op::ATTACHMENT => Ok(()),
            op::MESSAGE_INDEX
            | op::CHUNK_INDEX
            | op::ATTACHMENT_INDEX
            | op::METADATA_INDEX
            | op::STATISTICS
            | op::SUMMARY_OFFSET
            | op::HEADER => source.body(head, body),
            op::METADATA => {
                source.body(head, body)?;
                self.metadata(source, head, body)
            }
            opcode => {
                source.body(head, body)?;
                if !self.stays(source, head.offset, opcode, body)? {
                    return Ok(());
                }
                let mut moved = std::mem::take(&mut self.kept);
                moved.clear();
                self.moved_before(opcode, body, &mut moved);
                for (opcode, body) in Records(&moved).flatten() {
                    self.alone(opcode, body)?;
                }
                self.kept = moved;
                self.alone(opcode, body)
            }
        }
    }

    /// Writes a record that lies outside chunks.
    fn alone(&mut self, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        let chunked = matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE);
        match self.selection.packing {
            Some(_) if chunked => self.writer.inside(opcode, body),
            _ => self.writer.outside(opcode, body),
        }
    }

    fn metadata<R: Read + Seek>(
        &mut self,
        source: &Source<R>,
        head: Head,
        body: &[u8],
    ) -> Result<(), ContainerError> {
        parse(source.place(head.offset), head.opcode, body)?;
        if !self.selection.metadata {
            return Ok(());
        }
        let replaced = MetadataRecord::parse(body).and_then(|record| {
            let facts = self.selection.replace.get(&record.name)?.clone();
            Some(MetadataRecord { facts, ..record }.to_bytes())
        });
        let body = replaced.as_deref().unwrap_or(body);
        self.writer.outside(op::METADATA, body)
    }

    /// Whether a record that may lie in a chunk stays where it is.
    fn stays<R: Read + Seek>(
        &mut self,
        source: &Source<R>,
        offset: u64,
        opcode: u8,
        body: &[u8],
    ) -> Result<bool, ContainerError> {
        if matches!(opcode, op::SCHEMA | op::CHANNEL) {
            return self.define(source, offset, opcode, body);
        }
        if opcode != op::MESSAGE {
            return Ok(true);
        }
        let facts =
            MessageFacts::of(body).ok_or_else(|| source.place(offset).short(op::MESSAGE))?;
        let fate = self.channels.get(&facts.channel).copied().unwrap_or(Fate {
            kept: self.selection.channels.is_none(),
            latch: None,
        });
        let inside = (self.selection.keep.iter()).any(|stretch| stretch.contains(facts.log_time));
        if fate.kept && inside {
            return Ok(true);
        }
        match fate.latch {
            Some(latch) if fate.kept => {
                let forgotten = (self.latched).hold(&self.selection.keep, facts, latch, body);
                self.result.left_out += forgotten;
            }
            _ => self.result.left_out += 1,
        }
        Ok(false)
    }

    /// Adds the messages that a stretch starts with, if this is its first.
    fn moved_before(&mut self, opcode: u8, body: &[u8], records: &mut Vec<u8>) {
        let time = crate::writer::message_facts(opcode, body).map(|facts| facts.log_time);
        let stretch = time.and_then(|time| {
            let mut stretches = self.selection.keep.iter();
            Some((stretches.position(|stretch| stretch.contains(time))?, time))
        });
        if let Some((stretch, time)) = stretch {
            self.result.moved += self.latched.release(stretch, time, records);
        }
    }

    fn chunk<R: Read + Seek>(
        &mut self,
        source: &Source<R>,
        head: Head,
        body: &[u8],
    ) -> Result<(), ContainerError> {
        let place = source.place(head.offset);
        let facts = chunk_facts(place, body)?;
        let mut records = std::mem::take(&mut self.records);
        let mut kept = std::mem::take(&mut self.kept);
        unpack(&facts, body, Extent::Whole, &mut records)
            .map_err(|error| chunk_fault(place, &facts, body, error))?;
        kept.clear();
        for (opcode, data) in Records(&records).flatten() {
            if self.stays(source, head.offset, opcode, data)? {
                self.moved_before(opcode, data, &mut kept);
                push_record(&mut kept, opcode, data);
            }
        }
        let own = Packing::of(&facts.compression);
        let packing = self.selection.packing.or(own).unwrap_or(Packing::Zstd);
        if kept == records && Some(packing) == own {
            let start = facts.header_bytes();
            // As long as the chunk's parsing made sure of.
            let packed = &body[start..start + facts.packed_bytes as usize];
            self.writer.packed_chunk(&records, packing.name(), packed)?;
        } else if !kept.is_empty() {
            self.writer.chunk(&kept, packing)?;
        }
        self.records = records;
        self.kept = kept;
        Ok(())
    }

    /// Whether nothing of a chunk can be of use, by its times and what the summary says of it.
    fn skips<R: Read + Seek>(
        &mut self,
        source: &mut Source<R>,
        head: Head,
    ) -> Result<bool, ContainerError> {
        if !self.overview.complete || self.selection.keep == [Interval::ALL] {
            return Ok(false);
        }
        let mut start = Vec::new();
        source.read_at(head.body(), head.bytes.min(CHUNK_START_BYTES), &mut start)?;
        source.back_to(head)?;
        let (Some(facts), Some(listed)) = (
            ChunkFacts::of(&start),
            self.overview.chunks.get(&head.offset),
        ) else {
            return Ok(false);
        };
        let used =
            (self.selection.keep.iter()).any(|stretch| stretch.meets(facts.start, facts.end));
        let latched = listed.channels.iter().any(|id| {
            self.channels
                .get(id)
                .is_none_or(|fate| fate.latch.is_some())
        });
        // Without a single channel it may be that its writer made no message indexes.
        let skips = !used && !latched && !listed.channels.is_empty();
        if skips && let Some(packing) = Packing::of(&facts.compression) {
            self.writer
                .set_packing(self.selection.packing.unwrap_or(packing));
        }
        Ok(skips)
    }

    /// What a skipped chunk may have defined comes from the summary.
    fn skipped(&mut self) -> Result<(), ContainerError> {
        self.result.chunks_skipped += 1;
        for (&id, body) in &self.overview.schemas {
            if !self.writer.index().schemas.contains_key(&id) {
                self.writer.inside(op::SCHEMA, body)?;
            }
        }
        for (&id, body) in &self.overview.channels {
            let kept = self.channels.get(&id).is_none_or(|fate| fate.kept);
            let known = self.writer.index().channels.contains_key(&id);
            if kept && !known {
                self.writer.inside(op::CHANNEL, body)?;
            }
        }
        self.writer.close_chunk()
    }

    fn finish(mut self) -> Result<Selected, ContainerError> {
        let mut rest = Vec::new();
        for (n, stretch) in self.selection.keep.iter().enumerate() {
            let start = stretch.from_unix_nanos();
            self.result.moved += self.latched.release(n, start, &mut rest);
        }
        if !rest.is_empty() {
            self.writer
                .chunk(&rest, self.selection.packing.unwrap_or(Packing::Zstd))?;
        }
        for record in &self.selection.add {
            self.writer.outside(op::METADATA, &record.to_bytes())?;
        }
        self.result.written = self.writer.finish()?;
        Ok(self.result)
    }
}
