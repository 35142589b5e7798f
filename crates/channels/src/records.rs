//! The records of an MCAP file as the mcap crate reads them, from bytes that may be cut, damaged
//! or hostile.
//!
//! The crate takes files and chunks apart, unpacks, parses and compares checksums. What it leaves
//! to its caller is here: the byte at which a file is wrong, and limits on what it may allocate.

mod fault;
mod quick;

use mcap::parse_record;
use mcap::records::{ChunkHeader, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::error::ChannelError;
use fault::{PREFIX_BYTES, Place};
pub(crate) use quick::walk_in_place;

/// Chunks are meant to be a few MiB; any may unpack to this much.
const ANY_CHUNK_BYTES: usize = 64 << 20;

/// A chunk beyond [`ANY_CHUNK_BYTES`] may unpack to this many times its packed size, far more than
/// samples do; without a limit a few hostile bytes could fill the memory.
const MAX_COMPRESSION_RATIO: usize = 1024;

/// Bytes of a chunk record in front of its packed records, but for the name of the compression:
/// start and end time, size, CRC, two lengths.
const CHUNK_HEADER_BYTES: usize = 40;

/// Which records a walk looks at.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Depth {
    /// Those outside chunks: quick, since nothing is unpacked.
    Outside,
    /// All of them.
    Everything,
}

/// Whether the bytes start as an MCAP file does.
///
/// ```
/// assert!(inhand_channels::is_mcap(b"\x89MCAP0\r\n..."));
/// assert!(!inhand_channels::is_mcap(b"Format Version,1.23"));
/// ```
pub fn is_mcap(bytes: &[u8]) -> bool {
    bytes.starts_with(mcap::MAGIC)
}

/// Calls `visit` for the header, schemas, channels, messages, chunks (before what they hold),
/// metadata, attachments and the footer of the file, in the order in which they lie there.
///
/// Checksums of chunks are compared before their messages are visited, those of the data and the
/// summary at their ends. The summary itself is left out: it repeats and points into the file.
pub(crate) fn walk(
    file: &str,
    bytes: &[u8],
    depth: Depth,
    mut visit: impl FnMut(Record<'_>) -> Result<(), ChannelError>,
) -> Result<(), ChannelError> {
    walk_while(file, bytes, |record| visit(record).map(|()| depth))
}

/// As [`walk`], but `visit` says after each record how deep to go from there on. A chunk whose
/// visit says [`Depth::Outside`] is not unpacked; the checksum of the data covers it all the same.
pub(crate) fn walk_while(
    file: &str,
    bytes: &[u8],
    mut visit: impl FnMut(Record<'_>) -> Result<Depth, ChannelError>,
) -> Result<(), ChannelError> {
    let mut place = Place::start(file, bytes)?;
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_check_finishes_after_end_magic(true)
            // No record is longer than the file.
            .with_record_length_limit(bytes.len()),
    );
    let mut rest = bytes;
    let mut in_summary = false;
    while let Some(event) = reader.next_event() {
        let (opcode, body) = match event.map_err(|error| place.fault(error))? {
            LinearReadEvent::ReadRequest(want) => {
                feed(&mut reader, &mut rest, want);
                continue;
            }
            LinearReadEvent::Record { opcode, data } => (opcode, data),
        };
        match opcode {
            op::DATA_END => in_summary = true,
            op::FOOTER => {
                visit(parse(&place, opcode, body)?)?;
            }
            _ if in_summary => {}
            op::CHUNK => {
                let record = parse(&place, opcode, body)?;
                let whole = match &record {
                    Record::Chunk { header, data } => Some((header.clone(), data.len())),
                    _ => None,
                };
                let depth = visit(record)?;
                if let Some((header, packed)) = whole
                    && depth == Depth::Everything
                {
                    walk_chunk(&place, &header, packed, body, &mut visit)?;
                }
            }
            op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA | op::ATTACHMENT => {
                visit(parse(&place, opcode, body)?)?;
            }
            _ => {}
        }
        place.advance(opcode, body);
    }
    Ok(())
}

/// Visits what a chunk holds: `packed` bytes behind the header in the record's body.
fn walk_chunk(
    place: &Place,
    header: &ChunkHeader,
    packed: usize,
    body: &[u8],
    visit: &mut impl FnMut(Record<'_>) -> Result<Depth, ChannelError>,
) -> Result<(), ChannelError> {
    let limit = (packed.saturating_mul(MAX_COMPRESSION_RATIO)).max(ANY_CHUNK_BYTES);
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(limit),
    );
    // The reader gets the chunk as a file of its own, without bytes that may follow the packed
    // ones: it would read on into them where a record claims to be longer than the chunk.
    let length = CHUNK_HEADER_BYTES + header.compression.len() + packed;
    let mut prefix = [op::CHUNK; PREFIX_BYTES];
    prefix[1..].copy_from_slice(&(length as u64).to_le_bytes());
    feed(&mut reader, &mut prefix.as_slice(), PREFIX_BYTES);
    let mut rest = &body[..length];
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| place.chunk_fault(header, limit, error))? {
            LinearReadEvent::ReadRequest(want) => feed(&mut reader, &mut rest, want),
            LinearReadEvent::Record { opcode, data } => {
                if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
                    visit(parse(place, opcode, data)?)?;
                }
            }
        }
    }
    Ok(())
}

/// Gives the reader as many bytes as it wants; none tells it that there are no more.
fn feed(reader: &mut LinearReader, rest: &mut &[u8], want: usize) {
    let (now, later) = rest.split_at(want.min(rest.len()));
    reader.insert(now.len()).copy_from_slice(now);
    reader.notify_read(now.len());
    *rest = later;
}

fn parse<'a>(place: &Place, opcode: u8, body: &'a [u8]) -> Result<Record<'a>, ChannelError> {
    if opcode == op::ATTACHMENT && !has_room_for_crc(body) {
        return Err(place.short(opcode));
    }
    parse_record(opcode, body).map_err(|error| place.damaged(opcode, error))
}

/// Whether an attachment is long enough for what has to be in it, which mcap takes for granted.
fn has_room_for_crc(body: &[u8]) -> bool {
    let text_end = |start: usize| {
        let length = body.get(start..)?.first_chunk()?;
        (start + 4).checked_add(usize::try_from(u32::from_le_bytes(*length)).ok()?)
    };
    // Log time and create time, name, media type, length of the data, CRC.
    let end = text_end(16).and_then(text_end);
    end.is_some_and(|end| body.len() >= end.saturating_add(8 + 4))
}
