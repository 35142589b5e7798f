//! Records taken apart, after the lengths that they declare are held against their bytes.
//!
//! mcap takes memory for a text as long as its length says before it looks for the text: four bytes
//! of a damaged file could ask for four gigabytes.

use std::io::Cursor;

use binrw::BinReaderExt as _;
use mcap::records::{AttachmentHeader, AttachmentIndex, ChunkHeader, Record, op};
use mcap::{McapError, McapResult};

/// What the body of a record consists of, as far as it matters how long it is.
#[derive(Clone, Copy)]
enum Field {
    /// So many bytes.
    Fixed(usize),
    /// A length in four bytes, and a text.
    Text,
    /// A length in four bytes, and pairs of texts.
    Texts,
    /// A length in four bytes, and pairs of a channel and a number of eight bytes.
    Numbers,
}

/// Bytes in front of an attachment's data, but for its texts: two times, three lengths.
const ATTACHMENT_HEADER_BYTES: u64 = 8 + 8 + 4 + 4 + 8;

/// Bytes of a pair of [`Field::Numbers`].
const NUMBERS_BYTES: usize = 2 + 8;

/// The fields of a record up to the last one whose length mcap trusts. Message indexes, statistics
/// and the data of schemas, chunks and attachments are not among them: mcap looks before it takes
/// memory for those.
fn fields(opcode: u8) -> &'static [Field] {
    use Field::{Fixed, Numbers, Text, Texts};
    match opcode {
        op::HEADER => &[Text, Text],
        op::SCHEMA => &[Fixed(2), Text, Text],
        op::CHANNEL => &[Fixed(4), Text, Text, Texts],
        op::CHUNK => &[Fixed(28), Text],
        op::CHUNK_INDEX => &[Fixed(32), Numbers, Fixed(8), Text],
        // Behind the texts the length of the data and a CRC, which mcap takes for granted.
        op::ATTACHMENT => &[Fixed(16), Text, Text, Fixed(8 + 4)],
        op::ATTACHMENT_INDEX => &[Fixed(40), Text, Text],
        op::METADATA => &[Text, Texts],
        op::METADATA_INDEX => &[Fixed(16), Text],
        _ => &[],
    }
}

/// Takes a record apart as mcap does, an attachment with its checksum compared, but takes no memory on the word of a
/// damaged length.
///
/// # Errors
///
/// [`McapError::UnexpectedEof`] where a length goes beyond the body, and what mcap says.
pub fn parse_record(opcode: u8, body: &[u8]) -> McapResult<Record<'_>> {
    if has_fields(opcode, body) {
        mcap::parse_record(opcode, body)
    } else {
        Err(McapError::UnexpectedEof)
    }
}

/// The header of a chunk from the start of its record's body; `None` where that is too short or no
/// text.
pub(crate) fn chunk_header(start: &[u8]) -> Option<ChunkHeader> {
    let whole = has_fields(op::CHUNK, start);
    whole.then(|| Cursor::new(start).read_le().ok())?
}

/// The index entry of an attachment, yet without a place, from the start of its record's body; `None`
/// where that is too short, no text, or the data and a checksum do not fit into `bytes` bytes of body.
pub(crate) fn attachment_index(start: &[u8], bytes: u64) -> Option<AttachmentIndex> {
    if !has_fields(op::ATTACHMENT, start) {
        return None;
    }
    let mut start = Cursor::new(start);
    let header: AttachmentHeader = start.read_le().ok()?;
    let index = AttachmentIndex {
        offset: 0,
        length: 0,
        log_time: header.log_time,
        create_time: header.create_time,
        data_size: start.read_le().ok()?,
        name: header.name,
        media_type: header.media_type,
    };
    (summed_bytes(&index).checked_add(4)? <= bytes).then_some(index)
}

/// Bytes of an attachment's body that its checksum covers; the sum follows, and after it there may be
/// more.
pub(crate) fn summed_bytes(index: &AttachmentIndex) -> u64 {
    let texts = (index.name.len() + index.media_type.len()) as u64;
    index
        .data_size
        .saturating_add(ATTACHMENT_HEADER_BYTES + texts)
}

/// Bytes of a record's body by the lengths in it, given the start of the body; `None` for kinds whose
/// content does not say it, and where the start is too short.
pub(crate) fn stated_bytes(opcode: u8, start: &[u8]) -> Option<u64> {
    use Field::{Fixed, Text};
    // The last field is a length with what it counts.
    let fields: &[Field] = match opcode {
        op::HEADER => &[Text],
        op::SCHEMA => &[Fixed(2), Text, Text],
        op::CHANNEL => &[Fixed(4), Text, Text],
        op::METADATA => &[Text],
        op::MESSAGE_INDEX => &[Fixed(2)],
        op::DATA_END => return Some(4),
        op::FOOTER => return Some(20),
        _ => return None,
    };
    let rest = (fields.iter()).try_fold(start, |rest, &field| after(field, rest))?;
    let last = u32::from_le_bytes(*rest.first_chunk()?);
    Some((start.len() - rest.len()) as u64 + 4 + u64::from(last))
}

/// Whether none of a record's lengths goes beyond the body.
fn has_fields(opcode: u8, body: &[u8]) -> bool {
    (fields(opcode).iter())
        .try_fold(body, |rest, &field| after(field, rest))
        .is_some()
}

/// What lies behind a field; `None` where it goes beyond the end.
fn after(field: Field, body: &[u8]) -> Option<&[u8]> {
    match field {
        Field::Fixed(bytes) => body.get(bytes..),
        Field::Text => {
            let (length, rest) = length(body)?;
            rest.get(length..)
        }
        Field::Texts => {
            let (length, mut rest) = length(body)?;
            let end = rest.len().checked_sub(length)?;
            while rest.len() > end {
                rest = after(Field::Text, after(Field::Text, rest)?)?;
            }
            Some(rest)
        }
        Field::Numbers => {
            let (length, rest) = length(body)?;
            rest.get(length.checked_next_multiple_of(NUMBERS_BYTES)?..)
        }
    }
}

fn length(body: &[u8]) -> Option<(usize, &[u8])> {
    let (length, rest) = body.split_first_chunk()?;
    Some((usize::try_from(u32::from_le_bytes(*length)).ok()?, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HUGE: [u8; 4] = [0xFF; 4];

    /// Parts of a body: bytes, or the place of a length with what belongs behind it.
    enum Part {
        Bytes(usize),
        Length(&'static [u8]),
    }

    fn body(parts: &[Part], huge: Option<usize>) -> Vec<u8> {
        let mut body = Vec::new();
        for (k, part) in parts.iter().enumerate() {
            match part {
                Part::Bytes(count) => body.extend(vec![0; *count]),
                Part::Length(content) => {
                    let length = (content.len() as u32).to_le_bytes();
                    body.extend(if huge == Some(k) { HUGE } else { length });
                    body.extend_from_slice(content);
                }
            }
        }
        body
    }

    #[test]
    fn lengths_beyond_the_body_are_refused_before_memory_is_taken() {
        use Part::{Bytes, Length};
        let pair = b"\x01\0\0\0k\x01\0\0\0v";
        let numbers = &[7_u8; NUMBERS_BYTES];
        let kinds: [(u8, Vec<Part>); 9] = [
            (op::HEADER, vec![Length(b"ros2"), Length(b"lib")]),
            (
                op::SCHEMA,
                vec![Bytes(2), Length(b"a"), Length(b"b"), Length(b"data")],
            ),
            (
                op::CHANNEL,
                vec![Bytes(4), Length(b"/a"), Length(b"cdr"), Length(pair)],
            ),
            (op::CHUNK, vec![Bytes(28), Length(b"zstd"), Bytes(8)]),
            (
                op::CHUNK_INDEX,
                vec![
                    Bytes(32),
                    Length(numbers),
                    Bytes(8),
                    Length(b"lz4"),
                    Bytes(16),
                ],
            ),
            (
                op::ATTACHMENT,
                vec![Bytes(16), Length(b"name"), Length(b"type"), Bytes(8 + 4)],
            ),
            (
                op::ATTACHMENT_INDEX,
                vec![Bytes(40), Length(b"a"), Length(b"b")],
            ),
            (op::METADATA, vec![Length(b"name"), Length(pair)]),
            (op::METADATA_INDEX, vec![Bytes(16), Length(b"name")]),
        ];
        for (opcode, parts) in &kinds {
            let sound = body(parts, None);
            parse_record(*opcode, &sound).expect("a sound record");
            for (k, part) in parts.iter().enumerate() {
                if matches!(part, Part::Length(_)) {
                    let damaged = body(parts, Some(k));
                    let found = parse_record(*opcode, &damaged);
                    assert!(found.is_err(), "{opcode:#x}, part {k}");
                }
            }
            for length in 0..sound.len() {
                assert!(
                    parse_record(*opcode, &sound[..length]).is_err(),
                    "{opcode:#x} cut to {length}"
                );
            }
        }
    }

    #[test]
    fn a_huge_text_within_a_map_is_refused() {
        let at_value = [b"\x01\0\0\0k".as_slice(), &HUGE, b"v"].concat();
        let at_key = [HUGE.as_slice(), b"k\x01\0\0\0v"].concat();
        for map in [at_value, at_key] {
            let length = (map.len() as u32).to_le_bytes();
            let body = [&[0; 4], length.as_slice(), &map].concat();
            let found = parse_record(op::METADATA, &body);
            assert!(matches!(found, Err(McapError::UnexpectedEof)), "{found:?}");
        }
    }
}
