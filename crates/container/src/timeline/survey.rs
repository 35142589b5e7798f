//! Survey of a file: from its summary, and by scanning what the summary leaves out.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read, Seek};

use mcap::records::{Record, op};

use crate::channel::ChannelFacts;
use crate::chunk::{Extent, unpack};
use crate::error::ContainerError;
use crate::fault::Place;
use crate::format::{MESSAGE_HEADER_BYTES, MessageFacts, Records};
use crate::index::spanned;
use crate::overview::{ListedChunk, Overview};
use crate::source::{Head, Source};
use crate::timeline::blocks::{Block, Kind, messages};
use crate::timeline::{SchemaFacts, TimelineChannel};
use crate::walk::{chunk_facts, chunk_fault, parse};

/// Messages outside chunks are read together up to this many bytes.
const LOOSE_BYTES: u64 = 1 << 20;

/// What a file holds.
pub(super) struct Survey {
    pub(super) channels: BTreeMap<u16, TimelineChannel>,
    /// In the order of the file.
    pub(super) blocks: Vec<Block>,
}

pub(super) fn survey<R: Read + Seek>(source: &mut Source<R>) -> Result<Survey, ContainerError> {
    let overview = Overview::read(source)?;
    let mut surveyor = Surveyor::default();
    if overview.complete {
        surveyor.define_all(source.place(0), op::SCHEMA, &overview.schemas)?;
        surveyor.define_all(source.place(0), op::CHANNEL, &overview.channels)?;
    }
    let mut body = Vec::new();
    while let Some(head) = source.next_head()? {
        match head.opcode {
            op::CHUNK => match listed(&overview, head) {
                Some((block, behind)) => {
                    surveyor.blocks.push(block);
                    source.jump(behind)?;
                }
                None => {
                    source.body(head, &mut body)?;
                    surveyor.chunk(source.place(head.offset), head, &body)?;
                }
            },
            op::MESSAGE => {
                let start = head.bytes.min(MESSAGE_HEADER_BYTES as u64);
                source.read_at(head.body(), start, &mut body)?;
                surveyor.loose(source.place(head.offset), head, &body)?;
            }
            op::SCHEMA | op::CHANNEL => {
                source.body(head, &mut body)?;
                surveyor.define(source.place(head.offset), head.opcode, &body)?;
            }
            op::DATA_END | op::FOOTER => break,
            _ => {}
        }
    }
    Ok(Survey {
        channels: surveyor.channels,
        blocks: surveyor.blocks,
    })
}

/// The chunk as the summary lists it, and where what follows its message indexes starts; `None` where
/// it has to be looked into.
fn listed(overview: &Overview, head: Head) -> Option<(Block, u64)> {
    let ListedChunk {
        channels,
        span,
        bytes,
        index_bytes,
    } = overview.chunks.get(&head.offset)?;
    let sound = overview.complete
        && !channels.is_empty()
        && span.0 <= span.1
        && *bytes == head.end() - head.offset;
    let block = || Block {
        kind: Kind::Chunk,
        offset: head.offset,
        bytes: *bytes,
        span: *span,
        channels: channels.iter().copied().collect(),
    };
    let behind = head.end().checked_add(*index_bytes)?;
    sound.then(|| (block(), behind))
}

#[derive(Default)]
struct Surveyor {
    schemas: BTreeMap<u16, SchemaFacts>,
    channels: BTreeMap<u16, TimelineChannel>,
    blocks: Vec<Block>,
    records: Vec<u8>,
}

impl Surveyor {
    fn define_all(
        &mut self,
        place: Place<'_>,
        opcode: u8,
        bodies: &BTreeMap<u16, Vec<u8>>,
    ) -> Result<(), ContainerError> {
        (bodies.values()).try_for_each(|body| self.define(place, opcode, body))
    }

    /// Learns a schema or a channel; the first of each number counts.
    fn define(&mut self, place: Place<'_>, opcode: u8, body: &[u8]) -> Result<(), ContainerError> {
        match parse(place, opcode, body)? {
            Record::Schema { header, data } => {
                self.schemas
                    .entry(header.id)
                    .or_insert_with(|| SchemaFacts {
                        name: header.name,
                        encoding: header.encoding,
                        data: data.into_owned(),
                    });
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).cloned();
                let facts = ChannelFacts {
                    id: channel.id,
                    topic: channel.topic,
                    schema: schema.as_ref().map(|schema| schema.name.clone()),
                    message_encoding: channel.message_encoding,
                    metadata: channel.metadata,
                };
                (self.channels.entry(channel.id)).or_insert(TimelineChannel { facts, schema });
            }
            _ => {}
        }
        Ok(())
    }

    /// Looks into a chunk.
    fn chunk(&mut self, place: Place<'_>, head: Head, body: &[u8]) -> Result<(), ContainerError> {
        let facts = chunk_facts(place, body)?;
        let mut records = std::mem::take(&mut self.records);
        unpack(&facts, body, Extent::Whole, &mut records)
            .map_err(|error| chunk_fault(place, &facts, body, error))?;
        for (opcode, body) in Records(&records).flatten() {
            if matches!(opcode, op::SCHEMA | op::CHANNEL) {
                self.define(place, opcode, body)?;
            }
        }
        let (mut span, mut channels) = (None, BTreeSet::new());
        for (facts, _) in messages(&records, place) {
            let facts = facts?;
            span = Some(spanned(span, facts.log_time));
            channels.insert(facts.channel);
        }
        self.records = records;
        self.blocks.extend(span.map(|span| Block {
            kind: Kind::Chunk,
            offset: head.offset,
            bytes: head.end() - head.offset,
            span,
            channels,
        }));
        Ok(())
    }

    /// Adds a message outside chunks, of which `start` is the first bytes.
    fn loose(&mut self, place: Place<'_>, head: Head, start: &[u8]) -> Result<(), ContainerError> {
        let facts = MessageFacts::of(start).ok_or_else(|| place.short(op::MESSAGE))?;
        let bytes = head.end() - head.offset;
        let joined = self.blocks.last_mut().filter(|last| {
            last.kind == Kind::Loose
                && last.offset + last.bytes == head.offset
                && last.bytes + bytes <= LOOSE_BYTES
        });
        match joined {
            Some(block) => {
                block.bytes += bytes;
                block.span = spanned(Some(block.span), facts.log_time);
                block.channels.insert(facts.channel);
            }
            None => self.blocks.push(Block {
                kind: Kind::Loose,
                offset: head.offset,
                bytes,
                span: (facts.log_time, facts.log_time),
                channels: BTreeSet::from([facts.channel]),
            }),
        }
        Ok(())
    }
}
