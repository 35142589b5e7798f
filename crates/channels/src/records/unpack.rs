//! The bytes inside a chunk.

use std::io::Read;

use super::fields::Fields;
use crate::error::ChannelError;

/// Chunks are meant to be a few MiB; a limit keeps a few hostile bytes from filling the memory.
const MAX_CHUNK_BYTES: u64 = 4 << 30;

/// A chunk, still packed.
#[derive(Clone, Debug)]
pub(crate) struct Chunk<'a> {
    pub(crate) compression: String,
    pub(crate) uncompressed_bytes: u64,
    pub(crate) packed: &'a [u8],
    crc: u32,
}

impl<'a> Chunk<'a> {
    pub(super) fn parse(mut fields: Fields<'a, '_>) -> Result<Self, ChannelError> {
        fields.u64("start time")?;
        fields.u64("end time")?;
        Ok(Self {
            uncompressed_bytes: fields.u64("uncompressed size")?,
            crc: fields.u32("CRC")?,
            compression: fields.string("compression")?,
            packed: fields.bytes("records")?,
        })
    }
}

/// The chunk's records, checked against its size and CRC; `buffer` is reused where they are
/// compressed.
pub(super) fn unpack<'a>(
    file: &str,
    offset: u64,
    chunk: &Chunk<'a>,
    buffer: &'a mut Vec<u8>,
) -> Result<&'a [u8], ChannelError> {
    let damaged = |expected: String, found: String| ChannelError::Damaged {
        file: file.to_owned(),
        offset,
        record: "chunk".to_owned(),
        expected,
        found,
    };
    let records = match chunk.compression.as_str() {
        "" => chunk.packed,
        compression => {
            if chunk.uncompressed_bytes > MAX_CHUNK_BYTES {
                return Err(damaged(
                    format!("at most {MAX_CHUNK_BYTES} bytes in a chunk"),
                    chunk.uncompressed_bytes.to_string(),
                ));
            }
            buffer.clear();
            decompress(compression, chunk, buffer)
                .map_err(|error| damaged(format!("{compression} data"), error.to_string()))?;
            buffer.as_slice()
        }
    };
    if records.len() as u64 != chunk.uncompressed_bytes {
        let found = match records.len() as u64 {
            more if more > chunk.uncompressed_bytes => "more".to_owned(),
            less => less.to_string(),
        };
        return Err(damaged(
            format!("{} bytes", chunk.uncompressed_bytes),
            found,
        ));
    }
    // A checksum of zero means that there is none.
    if chunk.crc != 0 {
        let calculated = crc32fast::hash(records);
        if calculated != chunk.crc {
            return Err(damaged(
                format!("CRC {:08x}", chunk.crc),
                format!("CRC {calculated:08x}"),
            ));
        }
    }
    Ok(records)
}

/// Reads as many bytes as the chunk announces and one more to notice that there are too many. The
/// buffer grows with what comes out, not with what was announced.
fn decompress(compression: &str, chunk: &Chunk, buffer: &mut Vec<u8>) -> std::io::Result<()> {
    let limit = chunk.uncompressed_bytes + 1;
    match compression {
        "zstd" => {
            zstd::Decoder::with_buffer(chunk.packed)?
                .take(limit)
                .read_to_end(buffer)?;
        }
        "lz4" => {
            lz4::Decoder::new(chunk.packed)?
                .take(limit)
                .read_to_end(buffer)?;
        }
        other => {
            return Err(std::io::Error::other(format!(
                "the unknown compression \"{other}\""
            )));
        }
    }
    Ok(())
}
