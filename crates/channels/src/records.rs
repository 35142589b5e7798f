//! The records of an MCAP file, from bytes that may be cut, damaged or hostile.
//!
//! The mcap crate's readers copy every message, check chunk CRCs only on request and do not say at
//! which byte a file is wrong; this one borrows, always checks, and names the place. It follows the
//! format's specification (<https://mcap.dev/spec>): unknown opcodes and extra bytes at the end of
//! a record are skipped. Lengths are compared with what is there before anything is allocated.

mod fields;
mod unpack;

use std::collections::BTreeMap;

use mcap::records::op;

use crate::error::ChannelError;
use fields::Fields;
pub(crate) use unpack::Chunk;
use unpack::unpack;

/// Opcode and length in front of each record.
const PREFIX_BYTES: usize = 9;

/// What a file consists of, in the order in which it lies there.
#[derive(Debug)]
pub(crate) enum Item<'a> {
    Header {
        profile: String,
        library: String,
    },
    Schema {
        id: u16,
        name: String,
        encoding: String,
    },
    Channel {
        id: u16,
        schema: u16,
        topic: String,
        encoding: String,
        metadata: BTreeMap<String, String>,
    },
    Message {
        channel: u16,
        log_time: u64,
        data: &'a [u8],
    },
    /// Comes before what the chunk holds.
    Chunk(Chunk<'a>),
    Metadata {
        name: String,
        facts: BTreeMap<String, String>,
    },
    Attachment {
        name: String,
        media_type: String,
        bytes: u64,
    },
    /// The end of the data; what follows repeats it.
    DataEnd,
    /// A summary follows the data.
    Summary,
}

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

/// Calls `visit` for each item of the file, to its end.
pub(crate) fn walk(
    file: &str,
    bytes: &[u8],
    depth: Depth,
    mut visit: impl FnMut(Item<'_>) -> Result<(), ChannelError>,
) -> Result<(), ChannelError> {
    if !is_mcap(bytes) {
        return Err(not_mcap(file, bytes));
    }
    let mut unpacked = Vec::new();
    let mut offset = mcap::MAGIC.len();
    let mut data_end = false;
    loop {
        let record =
            next_record(file, bytes, offset, 0)?.ok_or_else(|| ChannelError::Truncated {
                file: file.to_owned(),
                offset: bytes.len() as u64,
                record: "the footer".to_owned(),
                expected: (PREFIX_BYTES + 20 + mcap::MAGIC.len()) as u64,
                found: 0,
            })?;
        offset += PREFIX_BYTES + record.body.len();
        match record.opcode {
            op::FOOTER => {
                let summary_start = record.fields(file).u64("start of the summary")?;
                if summary_start != 0 {
                    visit(Item::Summary)?;
                }
                return end_magic(file, bytes, offset);
            }
            op::DATA_END => {
                check_data_crc(file, bytes, &record)?;
                data_end = true;
                visit(Item::DataEnd)?;
            }
            // What follows the data repeats schemas and channels and points into the file.
            _ if data_end => {}
            op::CHUNK => {
                let chunk = Chunk::parse(record.fields(file))?;
                visit(Item::Chunk(chunk.clone()))?;
                if depth == Depth::Everything {
                    let inside = unpack(file, record.offset, &chunk, &mut unpacked)?;
                    walk_chunk(file, inside, record.offset, &mut visit)?;
                }
            }
            _ => {
                if let Some(item) = item(file, &record)? {
                    visit(item)?;
                }
            }
        }
    }
}

fn walk_chunk(
    file: &str,
    bytes: &[u8],
    chunk_offset: u64,
    visit: &mut impl FnMut(Item<'_>) -> Result<(), ChannelError>,
) -> Result<(), ChannelError> {
    let mut offset = 0;
    while let Some(record) = next_record(file, bytes, offset, chunk_offset)? {
        offset += PREFIX_BYTES + record.body.len();
        if matches!(record.opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE)
            && let Some(item) = item(file, &record)?
        {
            visit(item)?;
        }
    }
    Ok(())
}

/// A record whose body is all there.
struct Record<'a> {
    opcode: u8,
    /// Byte of the file at which it starts, or at which its chunk does.
    offset: u64,
    body: &'a [u8],
}

impl<'a> Record<'a> {
    fn fields<'f>(&self, file: &'f str) -> Fields<'a, 'f> {
        Fields::new(file, name_of(self.opcode), self.offset, self.body)
    }
}

/// The record at `offset`; `None` at the end. `inside` is the offset of the chunk, 0 outside one.
fn next_record<'a>(
    file: &str,
    bytes: &'a [u8],
    offset: usize,
    inside: u64,
) -> Result<Option<Record<'a>>, ChannelError> {
    let rest = &bytes[offset..];
    if rest.is_empty() {
        return Ok(None);
    }
    let place = if inside == 0 { offset as u64 } else { inside };
    let cut = |record: String, expected: u64| {
        if inside == 0 {
            ChannelError::Truncated {
                file: file.to_owned(),
                offset: place,
                record,
                expected,
                found: rest.len() as u64,
            }
        } else {
            ChannelError::Damaged {
                file: file.to_owned(),
                offset: place,
                record: format!("chunk, {record} at its byte {offset}"),
                expected: format!("{expected} bytes"),
                found: format!("{} left in the chunk", rest.len()),
            }
        }
    };
    let Some((prefix, after)) = rest.split_first_chunk::<PREFIX_BYTES>() else {
        return Err(cut("a record".to_owned(), PREFIX_BYTES as u64));
    };
    let [opcode, length @ ..] = *prefix;
    let length = u64::from_le_bytes(length);
    let body = usize::try_from(length).ok().and_then(|n| after.get(..n));
    let Some(body) = body else {
        // Writers leave this length in place until they know the true one.
        if opcode == op::CHUNK && length == u64::MAX {
            return Err(cut(
                "a chunk that its writer never closed".to_owned(),
                length,
            ));
        }
        let expected = length.saturating_add(PREFIX_BYTES as u64);
        return Err(cut(name_of(opcode).to_owned(), expected));
    };
    Ok(Some(Record {
        opcode,
        offset: place,
        body,
    }))
}

fn item<'a>(file: &str, record: &Record<'a>) -> Result<Option<Item<'a>>, ChannelError> {
    let mut fields = record.fields(file);
    Ok(Some(match record.opcode {
        op::HEADER => Item::Header {
            profile: fields.string("profile")?,
            library: fields.string("library")?,
        },
        op::SCHEMA => Item::Schema {
            id: fields.u16("id")?,
            name: fields.string("name")?,
            encoding: fields.string("encoding")?,
        },
        op::CHANNEL => Item::Channel {
            id: fields.u16("id")?,
            schema: fields.u16("schema id")?,
            topic: fields.string("topic")?,
            encoding: fields.string("message encoding")?,
            metadata: fields.string_map("metadata")?,
        },
        op::MESSAGE => {
            let channel = fields.u16("channel id")?;
            fields.u32("sequence")?;
            let log_time = fields.u64("log time")?;
            fields.u64("publish time")?;
            Item::Message {
                channel,
                log_time,
                data: fields.rest(),
            }
        }
        op::METADATA => Item::Metadata {
            name: fields.string("name")?,
            facts: fields.string_map("metadata")?,
        },
        op::ATTACHMENT => {
            fields.u64("log time")?;
            fields.u64("create time")?;
            let (name, media_type) = (fields.string("name")?, fields.string("media type")?);
            let bytes = fields.u64("length of the data")?;
            fields.skip(bytes, "data")?;
            let checked = record.body.len() - fields.rest().len();
            let saved = fields.u32("CRC")?;
            check_crc(file, record, saved, &record.body[..checked])?;
            Item::Attachment {
                name,
                media_type,
                bytes,
            }
        }
        _ => return Ok(None),
    }))
}

/// A checksum of zero means that there is none.
fn check_crc(file: &str, record: &Record, saved: u32, bytes: &[u8]) -> Result<(), ChannelError> {
    if saved == 0 {
        return Ok(());
    }
    let calculated = crc32fast::hash(bytes);
    if saved == calculated {
        return Ok(());
    }
    Err(ChannelError::Damaged {
        file: file.to_owned(),
        offset: record.offset,
        record: name_of(record.opcode).to_owned(),
        expected: format!("CRC {saved:08x}"),
        found: format!("CRC {calculated:08x}"),
    })
}

/// The checksum of everything up to the record.
fn check_data_crc(file: &str, bytes: &[u8], record: &Record) -> Result<(), ChannelError> {
    let saved = record.fields(file).u32("CRC of the data")?;
    // The offset comes from a position in `bytes`.
    let data = &bytes[..record.offset as usize];
    check_crc(file, record, saved, data).map_err(|error| match error {
        ChannelError::Damaged {
            file,
            offset,
            expected,
            found,
            ..
        } => ChannelError::Damaged {
            file,
            offset,
            record: "checksum of everything before it".to_owned(),
            expected,
            found,
        },
        other => other,
    })
}

fn end_magic(file: &str, bytes: &[u8], offset: usize) -> Result<(), ChannelError> {
    let rest = &bytes[offset..];
    if rest == mcap::MAGIC {
        return Ok(());
    }
    if mcap::MAGIC.starts_with(rest) {
        return Err(ChannelError::Truncated {
            file: file.to_owned(),
            offset: offset as u64,
            record: "the mark at the end".to_owned(),
            expected: mcap::MAGIC.len() as u64,
            found: rest.len() as u64,
        });
    }
    Err(ChannelError::Damaged {
        file: file.to_owned(),
        offset: offset as u64,
        record: "end of the file".to_owned(),
        expected: "\\x89MCAP0\\r\\n and nothing after it".to_owned(),
        found: describe(rest),
    })
}

fn not_mcap(file: &str, bytes: &[u8]) -> ChannelError {
    ChannelError::NotMcap {
        file: file.to_owned(),
        found: describe(bytes),
    }
}

fn describe(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "nothing".to_owned();
    }
    let start: String = (bytes.iter().take(12))
        .flat_map(|byte| byte.escape_ascii())
        .map(char::from)
        .collect();
    format!("\"{start}\" ({} bytes)", bytes.len())
}

fn name_of(opcode: u8) -> &'static str {
    match opcode {
        op::HEADER => "header",
        op::FOOTER => "footer",
        op::SCHEMA => "schema",
        op::CHANNEL => "channel",
        op::MESSAGE => "message",
        op::CHUNK => "chunk",
        op::MESSAGE_INDEX => "message index",
        op::CHUNK_INDEX => "chunk index",
        op::ATTACHMENT => "attachment",
        op::ATTACHMENT_INDEX => "attachment index",
        op::STATISTICS => "statistics",
        op::METADATA => "metadata",
        op::METADATA_INDEX => "metadata index",
        op::SUMMARY_OFFSET => "summary offset",
        op::DATA_END => "end of the data",
        _ => "record of unknown kind",
    }
}
