//! Every record of a file in turn, parsed.

use std::io::Cursor;

use mcap::records::{Record, op};

use crate::attachment::check_whole;
use crate::chunk::unpack;
use crate::error::{ContainerError, Place};
use crate::format::Records;
use crate::source::Source;

/// Which records a walk looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Those outside chunks: quick, since nothing is unpacked.
    Outside,
    /// All of them.
    Everything,
}

/// Whether the bytes start as an MCAP file does.
///
/// ```
/// assert!(inhand_container::is_mcap(b"\x89MCAP0\r\n..."));
/// assert!(!inhand_container::is_mcap(b"Format Version,1.23"));
/// ```
pub fn is_mcap(bytes: &[u8]) -> bool {
    bytes.starts_with(mcap::MAGIC)
}

/// Calls `visit` for the header, schemas, channels, messages, chunks (before what they hold),
/// metadata, attachments and the footer of the file, in the order in which they lie there. Attachments,
/// which may be larger than memory, come as [`Record::AttachmentIndex`] with their place.
///
/// Checksums of chunks are compared before their messages are visited, those of the data and the
/// summary at their ends. The summary itself is left out: it repeats and points into the file.
///
/// # Errors
///
/// [`ContainerError::NotMcap`], [`ContainerError::Truncated`], [`ContainerError::Damaged`] as what
/// `E` makes of them, and what `visit` returns.
pub fn walk<E: From<ContainerError>>(
    file: &str,
    bytes: &[u8],
    depth: Depth,
    mut visit: impl FnMut(Record<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let mut source = Source::open(file, Cursor::new(bytes))?;
    walk_source(&mut source, |record| visit(record).map(|()| depth))
}

/// As [`walk`] for a file of any size; it is read from where the source is. `visit` says after each record how deep to
/// go from there on: a chunk whose visit says [`Depth::Outside`] is not unpacked; the checksum of the data covers it
/// all the same. An error of `visit` ends the walk.
///
/// # Errors
///
/// As for [`walk`].
pub fn walk_source<E: From<ContainerError>>(
    source: &mut Source<'_>,
    mut visit: impl FnMut(Record<'_>) -> Result<Depth, E>,
) -> Result<(), E> {
    visit_all(source, &mut visit)
}

/// Built once for each kind of error, whoever visits.
fn visit_all<E: From<ContainerError>>(
    source: &mut Source<'_>,
    visit: &mut dyn FnMut(Record<'_>) -> Result<Depth, E>,
) -> Result<(), E> {
    let mut in_summary = false;
    let (mut body, mut records) = (Vec::new(), Vec::new());
    while let Some(head) = source.next_head()? {
        if head.opcode == op::ATTACHMENT && !in_summary {
            visit(Record::AttachmentIndex(check_whole(source, head)?))?;
            continue;
        }
        source.body(head, &mut body)?;
        let place = source.place(head.offset);
        match head.opcode {
            op::DATA_END => in_summary = true,
            op::FOOTER => {
                visit(place.parse(head.opcode, &body)?)?;
            }
            _ if in_summary => {}
            op::CHUNK => {
                let depth = visit(place.parse(head.opcode, &body)?)?;
                if depth == Depth::Everything {
                    walk_chunk(place, &body, &mut records, visit)?;
                }
            }
            op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA => {
                visit(place.parse(head.opcode, &body)?)?;
            }
            _ => {}
        }
    }
    Ok(())
}

/// Visits what a chunk holds, up to where it is damaged.
fn walk_chunk<E: From<ContainerError>>(
    place: Place,
    body: &[u8],
    records: &mut Vec<u8>,
    visit: &mut dyn FnMut(Record<'_>) -> Result<Depth, E>,
) -> Result<(), E> {
    let unpacked = unpack(place, body, records);
    for (opcode, data) in Records(records).flatten() {
        if matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
            visit(place.parse(opcode, data)?)?;
        }
    }
    unpacked?;
    Ok(())
}
