//! Content of chunks: unpacked within bounds, packed again.

use std::io::{self, Write as _};

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::format::{ChunkFacts, PREFIX_BYTES, push_record};

/// Chunks are meant to be a few MiB; any may unpack to this much.
const ANY_CHUNK_BYTES: usize = 64 << 20;

/// A chunk beyond [`ANY_CHUNK_BYTES`] may unpack to this many times its packed size, far more than
/// samples do; without a limit a few hostile bytes could fill the memory.
const MAX_COMPRESSION_RATIO: usize = 1024;

/// Level 1: higher ones take several times as long for a few per cent on samples.
const ZSTD_LEVEL: i32 = 1;

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
    pub(crate) fn of(name: &str) -> Option<Self> {
        [Packing::None, Packing::Lz4, Packing::Zstd]
            .into_iter()
            .find(|packing| packing.name() == name)
    }

    /// Packs the records of a chunk.
    pub(crate) fn pack(self, records: &[u8]) -> io::Result<Vec<u8>> {
        match self {
            Packing::None => Ok(records.to_vec()),
            Packing::Zstd => zstd::bulk::compress(records, ZSTD_LEVEL),
            Packing::Lz4 => {
                let mut encoder = lz4::EncoderBuilder::new()
                    // Some readers get these checksums wrong; the chunk has one of its own.
                    .block_checksum(lz4::liblz4::BlockChecksum::NoBlockChecksum)
                    .build(Vec::with_capacity(records.len() / 2))?;
                encoder.write_all(records)?;
                let (packed, result) = encoder.finish();
                result.map(|()| packed)
            }
        }
    }
}

/// Which bytes of a chunk there are.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extent {
    /// All of them; the checksum is compared before anything is given out.
    Whole,
    /// As many as there are, whatever the chunk says of its size and checksum.
    Start,
}

/// No chunk may unpack to more than this.
const MOST_CHUNK_BYTES: usize = (1 << 31) - 1;

/// How many bytes a chunk of this packed size may unpack to.
pub(crate) fn limit(packed: usize) -> usize {
    (packed.saturating_mul(MAX_COMPRESSION_RATIO)).clamp(ANY_CHUNK_BYTES, MOST_CHUNK_BYTES)
}

/// Unpacks what a chunk holds, given the body of its record. `records` are whole records, after an
/// error those from before it.
pub(crate) fn unpack(
    facts: &ChunkFacts,
    body: &[u8],
    extent: Extent,
    records: &mut Vec<u8>,
) -> Result<(), McapError> {
    records.clear();
    let packed = body.get(facts.header_bytes()..).unwrap_or_default();
    // The reader gets the chunk as a file of its own, without bytes that may follow the packed
    // ones: it would read on into them where a record claims to be longer than the chunk.
    let there = usize::try_from(facts.packed_bytes).unwrap_or(usize::MAX);
    let packed = &packed[..packed.len().min(there)];
    let limit = limit(packed.len());
    let mut facts = facts.clone();
    if extent == Extent::Start {
        facts.packed_bytes = packed.len() as u64;
        facts.unpacked_bytes = u64::MAX;
    }
    let header = facts.to_bytes();
    let mut prefix = [op::CHUNK; PREFIX_BYTES];
    prefix[1..].copy_from_slice(&((header.len() + packed.len()) as u64).to_le_bytes());
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(extent == Extent::Whole)
            .with_record_length_limit(limit),
    );
    let mut parts = [&prefix[..], &header, packed];
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(want) => feed(&mut reader, &mut parts, want),
            LinearReadEvent::Record { opcode, data } => {
                if records.len() + data.len() > limit {
                    return Err(McapError::ChunkTooLarge(facts.unpacked_bytes));
                }
                push_record(records, opcode, data);
            }
        }
    }
    Ok(())
}

/// Gives the reader as many bytes as it wants; none tells it that there are no more.
fn feed(reader: &mut LinearReader, parts: &mut [&[u8]], want: usize) {
    let mut left = want;
    for part in parts {
        let (now, later) = part.split_at(left.min(part.len()));
        if now.is_empty() {
            continue;
        }
        reader.insert(now.len()).copy_from_slice(now);
        reader.notify_read(now.len());
        *part = later;
        left -= now.len();
        if left == 0 {
            return;
        }
    }
    if left == want {
        reader.insert(0);
        reader.notify_read(0);
    }
}
