//! Survey of a file: from its summary, and by scanning what the summary leaves out.

use std::collections::BTreeSet;

use mcap::records::op;

use crate::channel::Definitions;
use crate::error::{ContainerError, Place};
use crate::format::{MESSAGE_HEADER_BYTES, MessageFacts, Records};
use crate::overview::Overview;
use crate::source::{Head, Source};
use crate::timeline::blocks::{Block, Kind, messages};

/// Messages outside chunks are read together up to this many bytes.
const LOOSE_BYTES: u64 = 1 << 20;

/// The channels of a file, and its blocks in the order of the file.
pub(super) fn survey(source: &mut Source<'_>) -> Result<(Definitions, Vec<Block>), ContainerError> {
    let overview = Overview::read(source)?;
    let mut definitions = Definitions::default();
    for (opcode, body) in overview.definitions() {
        definitions.add(&source.place(0).parse(opcode, body)?);
    }
    let (mut body, mut records, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(head) = source.next_head()? {
        match head.opcode {
            op::CHUNK => match listed(&overview, head) {
                Some((block, behind)) => {
                    blocks.push(block);
                    source.jump(behind)?;
                }
                None => {
                    source.chunk(head, &mut body, &mut records)?;
                    let place = source.place(head.offset);
                    blocks.extend(scanned(place, head, &records, &mut definitions)?);
                }
            },
            op::MESSAGE => {
                let start = head.bytes.min(MESSAGE_HEADER_BYTES as u64);
                source.read_at(head.body(), start, &mut body)?;
                let message = MessageFacts::read(&body);
                let message = message.ok_or_else(|| source.place(head.offset).short(op::MESSAGE));
                add_loose(&mut blocks, head, message?);
            }
            op::SCHEMA | op::CHANNEL => {
                source.body(head, &mut body)?;
                definitions.add(&source.place(head.offset).parse(head.opcode, &body)?);
            }
            op::DATA_END | op::FOOTER => break,
            _ => {}
        }
    }
    Ok((definitions, blocks))
}

/// The chunk as the summary lists it, and where what follows its message indexes starts; `None` where
/// it has to be looked into.
fn listed(overview: &Overview, head: Head) -> Option<(Block, u64)> {
    let chunk = overview.chunks.get(&head.offset)?;
    let span = (chunk.message_start_time, chunk.message_end_time);
    let sound = overview.complete
        && !chunk.message_index_offsets.is_empty()
        // Some writers leave the times out.
        && span.1 != 0
        && span.0 <= span.1
        && chunk.chunk_length == head.end() - head.offset;
    let behind = head.end().checked_add(chunk.message_index_length)?;
    sound.then(|| {
        let channels = chunk.message_index_offsets.keys().copied().collect();
        (block(Kind::Chunk, head, span, channels), behind)
    })
}

fn block(kind: Kind, head: Head, span: (u64, u64), channels: BTreeSet<u16>) -> Block {
    Block {
        kind,
        offset: head.offset,
        bytes: head.end() - head.offset,
        span,
        channels,
    }
}

/// A block of a single message.
fn first_of(kind: Kind, head: Head, message: MessageFacts) -> Block {
    let span = (message.log_time, message.log_time);
    block(kind, head, span, BTreeSet::from([message.channel]))
}

/// Looks into a chunk; `None` for one without messages.
fn scanned(
    place: Place<'_>,
    head: Head,
    records: &[u8],
    definitions: &mut Definitions,
) -> Result<Option<Block>, ContainerError> {
    for (opcode, body) in Records(records).flatten() {
        if matches!(opcode, op::SCHEMA | op::CHANNEL) {
            definitions.add(&place.parse(opcode, body)?);
        }
    }
    let mut block: Option<Block> = None;
    for (message, _) in messages(records, place) {
        let message = message?;
        (block.get_or_insert_with(|| first_of(Kind::Chunk, head, message))).add(message);
    }
    Ok(block)
}

/// Adds a message outside chunks, to the block before it where that is not too large.
fn add_loose(blocks: &mut Vec<Block>, head: Head, message: MessageFacts) {
    let bytes = head.end() - head.offset;
    let joined = blocks.last_mut().filter(|last| {
        last.kind == Kind::Loose
            && last.offset + last.bytes == head.offset
            && last.bytes + bytes <= LOOSE_BYTES
    });
    match joined {
        Some(block) => {
            block.bytes += bytes;
            block.add(message);
        }
        None => blocks.push(first_of(Kind::Loose, head, message)),
    }
}
