//! Content of chunks: packed, and unpacked within bounds.

use std::io::{self, BufRead, Read, Write as _};

use lz4_flex::frame::{BlockSize, FrameDecoder, FrameEncoder, FrameInfo};
use mcap::records::{ChunkHeader, Record, op};
use zstd::bulk::Compressor;

use crate::error::{ContainerError, Place};
use crate::format::{PREFIX_BYTES, Records, name_of};
use crate::limit::memory_limit;

/// Room that is made for what a chunk unpacks to before any of it is there.
const FIRST_BYTES: u64 = 4 << 20;

/// Largest window of zstd, as a power of two, that its decoders allow unless told otherwise: 128 MiB.
const ZSTD_WINDOW_LOG: u32 = 27;

/// Bytes in front of a chunk's packed records, but for the name of the compression: start and end time,
/// size, CRC, two lengths.
const CHUNK_HEADER_BYTES: usize = 40;

/// Level 1: higher ones take several times as long for a few per cent, since most bytes of samples are
/// mantissas that no level can shrink.
pub(crate) const ZSTD_LEVEL: i32 = 1;

/// How chunks are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// Not at all.
    None,
    /// By lz4.
    Lz4,
    /// By zstd.
    Zstd,
}

impl Packing {
    /// What a chunk record calls it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Packing::None => "",
            Packing::Lz4 => "lz4",
            Packing::Zstd => "zstd",
        }
    }

    /// By its name in a chunk record.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        [Packing::None, Packing::Lz4, Packing::Zstd]
            .into_iter()
            .find(|packing| packing.name() == name)
    }

    /// Packs the records of a chunk.
    pub(crate) fn pack(
        self,
        records: &[u8],
        zstd: &mut Compressor<'static>,
    ) -> io::Result<Vec<u8>> {
        match self {
            Packing::None => Ok(records.to_vec()),
            Packing::Zstd => zstd.compress(records),
            Packing::Lz4 => {
                // Small blocks: whole ones are what can be had of a damaged chunk.
                let blocks = FrameInfo::new().block_size(BlockSize::Max64KB);
                let mut encoder = FrameEncoder::with_frame_info(blocks, Vec::new());
                encoder.write_all(records)?;
                Ok(encoder.finish()?)
            }
        }
    }
}

/// Bytes in front of a chunk's packed records.
pub(crate) fn header_bytes(header: &ChunkHeader) -> usize {
    CHUNK_HEADER_BYTES + header.compression.len()
}

/// How many of these packed bytes any reader unpacks to the records: a single frame. Ours reads past a
/// missing end mark and surplus bytes, others refuse them. `None` where there is no whole frame.
pub(crate) fn frame_bytes(compression: &str, packed: &[u8], records: &[u8]) -> Option<usize> {
    let bytes = match Packing::from_name(compression)? {
        Packing::None => Some(records.len()),
        Packing::Lz4 => lz4_frame_bytes(packed),
        Packing::Zstd => zstd::zstd_safe::find_frame_compressed_size(packed).ok(),
    };
    bytes.filter(|&bytes| bytes <= packed.len())
}

/// Length of the lz4 frame that these bytes start with, up to and with its end mark.
fn lz4_frame_bytes(packed: &[u8]) -> Option<usize> {
    let flags = *packed.get(4)?;
    let of_flag = |flag: u8, bytes: usize| if flags & flag == 0 { 0 } else { bytes };
    // Magic, flags, block size; content size, number of a dictionary; checksum of the header.
    let mut end = 4 + 2 + of_flag(0x08, 8) + of_flag(0x01, 4) + 1;
    loop {
        let block = u32::from_le_bytes(*packed.get(end..)?.first_chunk()?);
        end += 4;
        if block == 0 {
            return Some(end + of_flag(0x04, 4));
        }
        // The highest bit marks a block that is not packed.
        end += (block & 0x7FFF_FFFF) as usize + of_flag(0x10, 4);
    }
}

/// Unpacks a chunk, given the body of its record. `records` are whole records: all of them, after an
/// error those before it, unless a checksum would have to vouch for them.
pub(crate) fn unpack(
    place: Place<'_>,
    body: &[u8],
    records: &mut Vec<u8>,
) -> Result<ChunkHeader, ContainerError> {
    records.clear();
    let Record::Chunk { header, data } = place.parse(op::CHUNK, body)? else {
        return Err(place.short(op::CHUNK));
    };
    let fault = |expected: String, found: String| place.error(name_of(op::CHUNK), expected, found);
    let size = match Packing::from_name(&header.compression) {
        // What is not packed is all there, whatever is stated.
        Some(Packing::None) => data.len() as u64,
        _ => header.uncompressed_size,
    };
    place.check_memory(op::CHUNK, size)?;
    let unpacked = decompress(&header.compression, &data, size + 1, records);
    let found = records.len() as u64;
    let calculated = match header.uncompressed_crc {
        0 => 0,
        _ => crc32fast::hash(records),
    };
    let sound = calculated == header.uncompressed_crc;
    records.truncate(if sound { whole_bytes(records) } else { 0 });
    let ends_early = || {
        let expected = format!("{size} bytes of whole records");
        fault(expected, "an end before that".to_owned())
    };
    match unpacked {
        Err(error) if error.kind() == io::ErrorKind::Unsupported => {
            let expected = "compression by zstd, lz4 or none".to_owned();
            Err(fault(expected, format!("\"{}\"", header.compression)))
        }
        Err(error) if error.kind() != io::ErrorKind::UnexpectedEof => {
            let expected = format!("{} data", header.compression);
            Err(fault(expected, error.to_string()))
        }
        Err(_) => Err(ends_early()),
        Ok(()) if found < size => Err(ends_early()),
        Ok(()) if found > size => {
            let expected = format!("{size} bytes, as stated");
            Err(fault(expected, "more".to_owned()))
        }
        Ok(()) if !sound => {
            let stated = header.uncompressed_crc;
            Err(place.bad_sum(name_of(op::CHUNK), stated, calculated))
        }
        Ok(()) if (records.len() as u64) < size => Err(ends_early()),
        Ok(()) => Ok(header),
    }
}

/// What a chunk unpacks to, whatever it says of its size and checksum.
pub(crate) struct Unpacked {
    /// Whether unpacking ended without an error.
    pub(crate) is_ok: bool,
    /// Bytes, with those behind the last whole record.
    pub(crate) bytes: u64,
    /// Checksum of all of them, and of the whole records alone.
    pub(crate) sums: [u32; 2],
}

/// Unpacks as many whole records as there are; after an error those before it.
pub(crate) fn unpack_start(header: &ChunkHeader, packed: &[u8], records: &mut Vec<u8>) -> Unpacked {
    records.clear();
    let unpacked = decompress(&header.compression, packed, memory_limit(), records);
    let (bytes, sum) = (records.len() as u64, crc32fast::hash(records));
    records.truncate(whole_bytes(records));
    let whole_sum = match records.len() as u64 == bytes {
        true => sum,
        false => crc32fast::hash(records),
    };
    Unpacked {
        is_ok: unpacked.is_ok(),
        bytes,
        sums: [sum, whole_sum],
    }
}

/// Whether the bytes begin as those that zstd packed.
pub fn is_zstd(bytes: &[u8]) -> bool {
    bytes.starts_with(&zstd::zstd_safe::MAGICNUMBER.to_le_bytes())
}

/// Bytes that zstd packs these to, as chunks are packed; all of them where it cannot.
pub fn zstd_size(bytes: &[u8]) -> u64 {
    zstd::bulk::compress(bytes, ZSTD_LEVEL).map_or(bytes.len(), |packed| packed.len()) as u64
}

/// Unpacks what zstd packed as it is read. Memory is taken for a window of at most 128 MiB, and never more than the
/// [`memory_limit`].
///
/// # Errors
///
/// Those of making a decoder; reading fails for a frame that needs a larger window.
pub fn zstd_reader<'a>(packed: impl BufRead + Send + 'a) -> io::Result<impl Read + Send + 'a> {
    let mut decoder = zstd::Decoder::with_buffer(packed)?;
    // The least window that zstd knows has 1 KiB.
    let log = memory_limit().checked_ilog2().unwrap_or_default();
    decoder.window_log_max(log.clamp(10, ZSTD_WINDOW_LOG))?;
    Ok(decoder)
}

/// Unpacks a file or a message that zstd packed, within the [`memory_limit`].
///
/// # Errors
///
/// Bytes that zstd did not pack, that end early or unpack to more.
pub fn unpack_zstd(packed: &[u8]) -> io::Result<Vec<u8>> {
    let (most, mut bytes) = (memory_limit(), Vec::new());
    decompress(
        Packing::Zstd.name(),
        packed,
        most.saturating_add(1),
        &mut bytes,
    )?;
    if bytes.len() as u64 > most {
        return Err(io::Error::other(format!(
            "it unpacks to more than the memory limit of {most} bytes (--memory-limit)"
        )));
    }
    Ok(bytes)
}

/// Bytes of the whole records at the start of these.
fn whole_bytes(records: &[u8]) -> usize {
    (Records(records).flatten())
        .map(|(_, body)| PREFIX_BYTES + body.len())
        .sum()
}

/// Unpacks at most so many bytes; after an error those before it.
fn decompress(compression: &str, packed: &[u8], most: u64, out: &mut Vec<u8>) -> io::Result<()> {
    let unpacked: Box<dyn Read + '_> = match Packing::from_name(compression) {
        Some(Packing::None) => Box::new(packed),
        Some(Packing::Zstd) => Box::new(zstd_reader(packed)?),
        Some(Packing::Lz4) => Box::new(FrameDecoder::new(packed)),
        None => return Err(io::ErrorKind::Unsupported.into()),
    };
    out.reserve(usize::try_from(most.min(FIRST_BYTES)).unwrap_or_default());
    unpacked.take(most).read_to_end(out).map(drop)
}
