//! Changes to MCAP files that keep their framing, so that they get past lengths and checksums.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::Write as _;

use libfuzzer_sys::fuzzer_mutate;
use lz4_flex::frame::FrameEncoder;
use mcap::records::op;
use zstd::bulk::Compressor;

use crate::files::{PACKINGS, Plain, Unpacked, split, unpack};

thread_local! {
    /// One for all chunks, since making it takes longer than packing.
    static ZSTD: RefCell<Compressor<'static>> = RefCell::new(Compressor::new(1).expect("memory takes all"));
}

/// SplitMix64.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

#[derive(Clone)]
enum Piece {
    Record(Plain),
    Chunk {
        packing: &'static str,
        records: Vec<Plain>,
        indexed: bool,
    },
}

/// Changes a file: its records, their order, what chunks hold and how they are packed; one time in four its bytes.
/// Checksums, indexes and lengths are made to fit what they cover, but not always.
pub fn mutate(data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    let mut dice = Dice(seed.into());
    if dice.one_in(4) {
        return fuzzer_mutate(data, size, max_size);
    }
    let Some((mut pieces, tail)) = parse(&data[..size]) else {
        return fuzzer_mutate(data, size, max_size);
    };
    for _ in 0..1 + dice.below(3) {
        change(&mut pieces, &mut dice);
    }
    let mut bytes = assemble(&pieces, &mut dice);
    bytes.extend(tail);
    if bytes.len() > max_size {
        return fuzzer_mutate(data, size, max_size);
    }
    data[..bytes.len()].copy_from_slice(&bytes);
    bytes.len()
}

/// The pieces of a file, and bytes behind the last whole record. Message indexes are left out.
fn parse(bytes: &[u8]) -> Option<(Vec<Piece>, &[u8])> {
    let mut pieces = Vec::new();
    let (records, tail) = split(bytes.strip_prefix(mcap::MAGIC)?);
    for (opcode, body) in records {
        match (opcode, pieces.last_mut()) {
            (op::MESSAGE_INDEX, Some(Piece::Chunk { indexed, .. })) => *indexed = true,
            (op::CHUNK, _) => pieces.push(match unpack(&body) {
                Some(Unpacked {
                    packing, records, ..
                }) => Piece::Chunk {
                    packing,
                    records,
                    indexed: false,
                },
                None => Piece::Record((opcode, body)),
            }),
            _ => pieces.push(Piece::Record((opcode, body))),
        }
    }
    Some((pieces, tail))
}

/// Every record that is changed as such: those outside chunks and those inside.
fn plain(pieces: &mut [Piece]) -> Vec<&mut Plain> {
    let each = pieces.iter_mut().flat_map(|piece| match piece {
        Piece::Record(record) => std::slice::from_mut(record),
        Piece::Chunk { records, .. } => &mut records[..],
    });
    each.collect()
}

fn change(pieces: &mut Vec<Piece>, dice: &mut Dice) {
    let (at, to) = (dice.below(pieces.len()), dice.below(pieces.len()));
    if pieces.is_empty() {
        return;
    }
    match dice.below(14) {
        0 => pieces.insert(to, pieces[at].clone()),
        1 => drop(pieces.remove(at)),
        2 => pieces.swap(at, to),
        3 => {
            if let Piece::Chunk {
                packing, indexed, ..
            } = &mut pieces[at]
            {
                *packing = PACKINGS[dice.below(3)];
                *indexed = dice.one_in(2);
            }
        }
        4 => rechunk(pieces, at, dice),
        5 => {
            let mut records = plain(pieces);
            let (from, to) = (dice.below(records.len()), dice.below(records.len()));
            if let Some(record) = records.get(from).map(|record| (*record).clone()) {
                *records[to] = record;
            }
        }
        6 => {
            let mut records = plain(pieces);
            let to = dice.below(records.len());
            // The number of a schema or channel.
            if let Some(id) = records.get_mut(to).and_then(|record| record.1.first_mut()) {
                *id = dice.below(6) as u8;
            }
        }
        7 => {
            let mut records = plain(pieces);
            let to = dice.below(records.len());
            if let Some(record) = records.get_mut(to) {
                record.0 = [dice.below(17) as u8, dice.next() as u8][dice.below(2)];
            }
        }
        _ => {
            let mut records = plain(pieces);
            let to = dice.below(records.len());
            if let Some((opcode, body)) = records.get_mut(to).map(|record| &mut **record) {
                match *opcode {
                    op::METADATA | op::CHANNEL | op::SCHEMA => change_text(body, dice),
                    _ => change_bytes(body),
                }
            }
        }
    }
}

/// Unpacks a chunk in its place, or puts some records into one.
fn rechunk(pieces: &mut Vec<Piece>, at: usize, dice: &mut Dice) {
    if let Piece::Chunk { records, .. } = &mut pieces[at] {
        let records = std::mem::take(records).into_iter().map(Piece::Record);
        pieces.splice(at..=at, records);
        return;
    }
    let inside = |piece: &&Piece| {
        matches!(
            piece,
            Piece::Record((op::SCHEMA | op::CHANNEL | op::MESSAGE, _))
        )
    };
    let run = pieces[at..]
        .iter()
        .take(1 + dice.below(8))
        .take_while(inside)
        .count();
    let records = pieces.drain(at..at + run).filter_map(|piece| match piece {
        Piece::Record(record) => Some(record),
        Piece::Chunk { .. } => None,
    });
    let chunk = Piece::Chunk {
        packing: PACKINGS[dice.below(3)],
        records: records.collect(),
        indexed: dice.one_in(2),
    };
    pieces.insert(at, chunk);
}

fn change_bytes(body: &mut Vec<u8>) {
    let size = body.len();
    body.resize(size + 64, 0);
    let size = fuzzer_mutate(body, size, size + 64);
    body.truncate(size);
}

/// Changes a text in a record, with its length and that of a map around it.
fn change_text(body: &mut Vec<u8>, dice: &mut Dice) {
    let number = |body: &[u8], at: usize| {
        let bytes = body.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_le_bytes(bytes) as usize)
    };
    // Where any length of four bytes fits: the first texts of the record and those of its map.
    let fits = |at: &usize| number(body, *at).is_some_and(|n| n > 0 && at + 4 + n <= body.len());
    let places: Vec<usize> = (0..body.len()).filter(fits).collect();
    let Some(&at) = places
        .get(dice.below(places.len()))
        .filter(|_| !dice.one_in(8))
    else {
        return change_bytes(body);
    };
    let length = number(body, at).unwrap_or_default();
    let mut text = body[at + 4..at + 4 + length].to_vec();
    change_bytes(&mut text);
    let around = places
        .iter()
        .copied()
        .find(|&map| map < at && number(body, map).is_some_and(|n| map + 4 + n == body.len()));
    body.splice(at + 4..at + 4 + length, text.iter().copied());
    body[at..at + 4].copy_from_slice(&(text.len() as u32).to_le_bytes());
    if let Some(map) = around {
        let length = (body.len() - map - 4) as u32;
        body[map..map + 4].copy_from_slice(&length.to_le_bytes());
    }
}

fn push(bytes: &mut Vec<u8>, opcode: u8, body: &[u8]) {
    bytes.push(opcode);
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(body);
}

/// Joins fields.
fn joined(fields: &[&[u8]]) -> Vec<u8> {
    fields.concat()
}

/// The file of these pieces.
fn assemble(pieces: &[Piece], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = mcap::MAGIC.to_vec();
    let mut indexes = Vec::new();
    let mut summary = None;
    let exact = !dice.one_in(8);
    let mut write_indexes = dice.one_in(2);
    for piece in pieces {
        match piece {
            Piece::Chunk {
                packing,
                records,
                indexed,
            } => {
                indexes.push(push_chunk(&mut bytes, packing, records, *indexed));
            }
            Piece::Record((op::DATA_END, body)) if exact && body.len() == 4 => {
                let sum = if dice.one_in(2) {
                    crc32fast::hash(&bytes)
                } else {
                    0
                };
                push(&mut bytes, op::DATA_END, &sum.to_le_bytes());
                summary = Some(bytes.len());
            }
            Piece::Record((op::CHUNK_INDEX, _)) if exact && write_indexes => {
                write_indexes = false;
                for index in &indexes {
                    push(&mut bytes, op::CHUNK_INDEX, index);
                }
            }
            Piece::Record((op::FOOTER, body)) if exact && body.len() == 20 => {
                let start = summary.filter(|&start| start < bytes.len()).unwrap_or(0);
                let covered = joined(&[&(start as u64).to_le_bytes(), &[0; 8]]);
                let head = joined(&[&[op::FOOTER], &20_u64.to_le_bytes(), &covered]);
                let sum = match start > 0 && dice.one_in(2) {
                    true => crc32fast::hash(&joined(&[&bytes[start..], &head])),
                    false => 0,
                };
                push(
                    &mut bytes,
                    op::FOOTER,
                    &joined(&[&covered, &sum.to_le_bytes()]),
                );
            }
            Piece::Record((opcode, body)) => push(&mut bytes, *opcode, body),
        }
    }
    bytes
}

/// Writes a chunk and its message indexes; gives the body of its index in the summary.
fn push_chunk(bytes: &mut Vec<u8>, packing: &str, inside: &[Plain], indexed: bool) -> Vec<u8> {
    let mut records = Vec::new();
    let mut entries = BTreeMap::<[u8; 2], Vec<u8>>::new();
    let (mut first, mut last) = (u64::MAX, 0);
    for (opcode, body) in inside {
        if *opcode == op::MESSAGE
            && let (Some(id), Some(time)) = (body.first_chunk(), body.get(6..14))
        {
            let time = u64::from_le_bytes(std::array::from_fn(|k| time[k]));
            (first, last) = (first.min(time), last.max(time));
            let entry = joined(&[&time.to_le_bytes(), &(records.len() as u64).to_le_bytes()]);
            entries.entry(*id).or_default().extend(entry);
        }
        push(&mut records, *opcode, body);
    }
    let packed = match packing {
        "" => records.clone(),
        "lz4" => {
            let mut encoder = FrameEncoder::new(Vec::new());
            encoder.write_all(&records).expect("memory takes all");
            encoder.finish().expect("memory takes all")
        }
        _ => ZSTD.with_borrow_mut(|zstd| zstd.compress(&records).expect("memory takes all")),
    };
    let span = joined(&[&first.min(last).to_le_bytes(), &last.to_le_bytes()]);
    let name = joined(&[&(packing.len() as u32).to_le_bytes(), packing.as_bytes()]);
    let (packed_bytes, records_bytes) = (packed.len() as u64, records.len() as u64);
    let sum = crc32fast::hash(&records);
    let body = joined(&[
        &span,
        &records_bytes.to_le_bytes(),
        &sum.to_le_bytes(),
        &name,
        &packed_bytes.to_le_bytes(),
        &packed,
    ]);
    let start = bytes.len() as u64;
    push(bytes, op::CHUNK, &body);
    let chunk_bytes = bytes.len() as u64 - start;
    let (indexes_start, mut offsets) = (bytes.len(), Vec::new());
    for (id, entries) in entries.iter().filter(|_| indexed) {
        offsets.extend(joined(&[id, &(bytes.len() as u64).to_le_bytes()]));
        let length = (entries.len() as u32).to_le_bytes();
        push(bytes, op::MESSAGE_INDEX, &joined(&[id, &length, entries]));
    }
    joined(&[
        &span,
        &start.to_le_bytes(),
        &chunk_bytes.to_le_bytes(),
        &(offsets.len() as u32).to_le_bytes(),
        &offsets,
        &((bytes.len() - indexes_start) as u64).to_le_bytes(),
        &name,
        &packed_bytes.to_le_bytes(),
        &records_bytes.to_le_bytes(),
    ])
}
