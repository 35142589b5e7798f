//! MCAP files as the `mcap` crate reads them.

use std::collections::BTreeMap;
use std::io::Read as _;

use inhand_container::parse_record;
use lz4_flex::frame::FrameDecoder;
use mcap::McapError;
use mcap::read::ChunkFlattener;
use mcap::records::{Record, op};

/// Most bytes that a chunk is unpacked to.
const MOST_UNPACKED: usize = 1 << 18;

/// Names of packings of chunks.
pub const PACKINGS: [&str; 3] = ["", "lz4", "zstd"];

/// A record: opcode and body.
pub type Plain = (u8, Vec<u8>);

/// The whole records of some bytes, and the bytes behind the last one.
pub fn split(mut bytes: &[u8]) -> (Vec<Plain>, &[u8]) {
    let mut records = Vec::new();
    while let Some((head, rest)) = bytes.split_first_chunk::<9>() {
        let length = u64::from_le_bytes(std::array::from_fn(|k| head[1 + k]));
        let body = usize::try_from(length).ok().and_then(|n| rest.get(..n));
        let Some(body) = body else { break };
        records.push((head[0], body.to_vec()));
        bytes = &rest[body.len()..];
    }
    (records, bytes)
}

/// A chunk that was unpacked.
pub struct Unpacked {
    /// Its packing.
    pub packing: &'static str,
    /// Whether its lengths are right, its checksum if it has one, and it ends with a record.
    pub sound: bool,
    /// The records in it.
    pub records: Vec<Plain>,
}

/// Unpacks a chunk, given its body.
pub fn unpack(body: &[u8]) -> Option<Unpacked> {
    let stated_bytes = u64::from_le_bytes(body.get(16..24)?.try_into().ok()?);
    let sum = u32::from_le_bytes(body.get(24..28)?.try_into().ok()?);
    let name_bytes = u32::from_le_bytes(body.get(28..32)?.try_into().ok()?) as usize;
    let rest = body.get(32..)?;
    let name = rest.get(..name_bytes)?;
    let packed_bytes = u64::from_le_bytes(rest.get(name_bytes..name_bytes + 8)?.try_into().ok()?);
    let packed = rest.get(name_bytes + 8..)?;
    let packing = PACKINGS.into_iter().find(|p| p.as_bytes() == name)?;
    let records = match packing {
        "" => packed.to_vec(),
        "lz4" => {
            let mut records = Vec::new();
            let decoder = FrameDecoder::new(packed);
            // What comes before damage stays.
            let _ = decoder.take(MOST_UNPACKED as u64).read_to_end(&mut records);
            records
        }
        _ => zstd::bulk::decompress(packed, MOST_UNPACKED).ok()?,
    };
    let (inside, tail) = split(&records);
    Some(Unpacked {
        packing,
        sound: tail.is_empty()
            && packed_bytes == packed.len() as u64
            && stated_bytes == records.len() as u64
            && (sum == 0 || sum == crc32fast::hash(&records)),
        records: inside,
    })
}

/// The file up to the first record with a length that goes beyond it, for which the `mcap` crate would take memory,
/// and the first chunk whose checksum differs, which it compares after the messages were read.
pub fn bounded(bytes: &[u8]) -> &[u8] {
    let (pieces, tail) = split(bytes.strip_prefix(mcap::MAGIC).unwrap_or_default());
    let parses = |(opcode, body): &Plain| {
        !matches!(parse_record(*opcode, body), Err(McapError::UnexpectedEof))
    };
    let mut end = mcap::MAGIC.len().min(bytes.len());
    for piece in pieces {
        let intact = |chunk: Unpacked| chunk.sound && chunk.records.iter().all(parses);
        if !parses(&piece) || (piece.0 == op::CHUNK && !unpack(&piece.1).is_some_and(intact)) {
            return &bytes[..end];
        }
        end += 9 + piece.1.len();
    }
    if tail == mcap::MAGIC {
        bytes
    } else {
        &bytes[..end]
    }
}

/// Whether data come before the summary, and each number stands for one schema or channel wherever it is defined, 0 for
/// no schema.
pub fn is_orderly(bytes: &[u8]) -> bool {
    let (pieces, _) = split(bytes.strip_prefix(mcap::MAGIC).unwrap_or_default());
    let (mut known, mut ended) = (BTreeMap::new(), false);
    for (opcode, body) in pieces {
        let data = matches!(
            opcode,
            op::MESSAGE | op::CHUNK | op::ATTACHMENT | op::METADATA | op::DATA_END
        );
        if ended && data {
            return false;
        }
        ended |= opcode == op::DATA_END;
        let inside = match unpack(&body).filter(|_| opcode == op::CHUNK) {
            Some(chunk) => chunk.records,
            None => vec![(opcode, body)],
        };
        for (opcode, body) in inside
            .into_iter()
            .filter(|record| matches!(record.0, op::SCHEMA | op::CHANNEL))
        {
            let number = (opcode, body.first_chunk::<2>().copied());
            if number == (op::SCHEMA, Some([0, 0]))
                || *known.entry(number).or_insert_with(|| body.clone()) != body
            {
                return false;
            }
        }
    }
    ended
}

/// Topic, sequence, log time, publish time and data.
pub type Message = (String, u32, u64, u64, Vec<u8>);

/// The messages of a file in its order, up to the first error of the `mcap` crate, which compares all checksums.
pub fn messages(bytes: &[u8]) -> (Vec<Message>, Result<(), McapError>) {
    let mut messages = Vec::new();
    let stream = match mcap::MessageStream::new(bounded(bytes)) {
        Ok(stream) => stream,
        Err(error) => return (messages, Err(error)),
    };
    for message in stream {
        match message {
            Ok(message) => messages.push(facts(message)),
            Err(error) => return (messages, Err(error)),
        }
    }
    (messages, Ok(()))
}

fn facts(m: mcap::Message<'_>) -> Message {
    let topic = m.channel.topic.clone();
    (
        topic,
        m.sequence,
        m.log_time,
        m.publish_time,
        m.data.into_owned(),
    )
}

/// The messages of a file by its indexes, sorted.
///
/// # Errors
///
/// What the `mcap` crate finds.
pub fn indexed(bytes: &[u8]) -> Result<Vec<Message>, McapError> {
    let summary = mcap::Summary::read(bytes)?.unwrap_or_default();
    let mut messages = Vec::new();
    for chunk in &summary.chunk_indexes {
        if chunk.message_index_offsets.is_empty() {
            continue;
        }
        let entries = summary.read_message_indexes(bytes, chunk)?;
        for entry in entries.into_values().flatten() {
            messages.push(facts(summary.seek_message(bytes, chunk, &entry)?));
        }
    }
    messages.sort();
    Ok(messages)
}

/// Records of the data in order, each in words: chunks are looked into, and what points into the file is left out.
///
/// # Errors
///
/// What the `mcap` crate finds.
pub fn records(bytes: &[u8]) -> Result<Vec<String>, McapError> {
    let mut records = Vec::new();
    for record in ChunkFlattener::new(bounded(bytes))? {
        match record? {
            Record::DataEnd(_) | Record::Footer(_) => break,
            Record::MessageIndex(_)
            | Record::ChunkIndex(_)
            | Record::AttachmentIndex(_)
            | Record::MetadataIndex(_)
            | Record::Statistics(_)
            | Record::SummaryOffset(_) => {}
            // Copies have exactly one, wherever the file has how many.
            Record::Header(_) => {}
            record => records.push(format!("{record:?}")),
        }
    }
    Ok(records)
}
