//! Files damaged at random, with a ledger of what is intact in them.
//!
//! `INHAND_DAMAGED_FILES` sets how many files are tried (400 unless set), `INHAND_DAMAGE_FROM` the number of
//! the first one: a failure names the number of its file. `INHAND_KEEP_RECOVERED` names a folder that recovered files are
//! left in, with the number and sum of their messages, for `tests/reference/read_recovered.py`.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{Cursor, Write as _};
use std::ops::Range;
use std::path::Path;

use inhand_container::{ContainerError, recover};
use lz4_flex::frame::FrameEncoder;
use mcap::records::op;

use crate::support::check;

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

/// Topic, sequence, log time and data.
type Message = (String, u32, u64, Vec<u8>);

/// What a record of the file, outside chunks, holds.
#[derive(Default)]
struct Holds {
    /// With the number of the channel.
    messages: Vec<(u16, Message)>,
    channels: BTreeSet<u16>,
}

/// A file with what each of its records holds.
#[derive(Default)]
struct Made {
    bytes: Vec<u8>,
    pieces: Vec<(Range<usize>, Holds)>,
    /// Whether a checksum covers all data.
    summed: bool,
}

impl Made {
    /// The schema and all channels.
    fn define(&mut self) {
        self.push(op::SCHEMA, &schema(), Holds::default());
        for id in 1..=CHANNELS {
            let channels = BTreeSet::from([id]);
            let holds = Holds {
                channels,
                ..Holds::default()
            };
            self.push(op::CHANNEL, &channel(id), holds);
        }
    }

    fn push(&mut self, opcode: u8, body: &[u8], holds: Holds) {
        let start = self.bytes.len();
        self.bytes.extend(record(opcode, body));
        self.pieces.push((start..self.bytes.len(), holds));
    }
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

const CHANNELS: u16 = 4;

/// Channels 1 and 2 are of one topic.
fn topic(channel: u16) -> String {
    format!("/t{}", channel.max(2))
}

fn schema() -> Vec<u8> {
    [
        &[1, 0][..],
        &text("S"),
        &text("jsonschema"),
        &text("{\"type\": \"object\"}"),
    ]
    .concat()
}

fn channel(id: u16) -> Vec<u8> {
    let said = [text("number"), text(&id.to_string())].concat();
    let said = [&(said.len() as u32).to_le_bytes()[..], &said].concat();
    let ids = [id.to_le_bytes(), [1, 0]].concat();
    [ids, text(&topic(id)), text("json"), said].concat()
}

fn message(dice: &mut Dice, sequence: u32) -> (Vec<u8>, Message) {
    let id = 1 + dice.below(CHANNELS.into()) as u16;
    let time = 1_700_000_000_000_000_000 + u64::from(sequence) * 10_000_000;
    let data: Vec<u8> = match dice.below(4) {
        // A record of 64 bytes: a flipped bit of its length may lead to another record.
        0 => (0..33).map(|_| dice.next() as u8).collect(),
        // Like numbers, full of zeros.
        1 => (0..dice.below(12))
            .flat_map(|_| (dice.below(16) as u64).to_le_bytes())
            .collect(),
        2 => format!("{{\"n\": {sequence}, \"text\": \"some text that repeats, repeats\"}}").into(),
        _ => (0..dice.below(200)).map(|_| dice.next() as u8).collect(),
    };
    let body = [
        &id.to_le_bytes()[..],
        &sequence.to_le_bytes(),
        &time.to_le_bytes(),
        &(time - 5).to_le_bytes(),
        &data,
    ];
    (body.concat(), (topic(id), sequence, time, data))
}

fn chunk(dice: &mut Dice, records: &[u8], span: (u64, u64)) -> Vec<u8> {
    let (name, packed) = match dice.below(3) {
        0 => ("", records.to_vec()),
        1 => {
            let mut encoder = FrameEncoder::new(Vec::new());
            encoder.write_all(records).unwrap();
            ("lz4", encoder.finish().unwrap())
        }
        _ => ("zstd", zstd::bulk::compress(records, 1).unwrap()),
    };
    [
        &span.0.to_le_bytes()[..],
        &span.1.to_le_bytes(),
        &(records.len() as u64).to_le_bytes(),
        &crc32fast::hash(records).to_le_bytes(),
        &text(name),
        &(packed.len() as u64).to_le_bytes(),
        &packed,
    ]
    .concat()
}

/// A file in any layout: chunked, not chunked or both; definitions once, in every chunk or in the summary
/// alone; with indexes, checksums and a summary or without.
fn make(dice: &mut Dice) -> Made {
    let mut made = Made {
        bytes: mcap::MAGIC.to_vec(),
        summed: !dice.one_in(4),
        ..Made::default()
    };
    made.push(
        op::HEADER,
        &[text("x"), text("test")].concat(),
        Holds::default(),
    );
    let layout = dice.below(3);
    let definitions = dice.below(3);
    let (indexed, with_summary) = (!dice.one_in(4), definitions == 2 || !dice.one_in(4));
    let defining: Vec<Vec<u8>> = std::iter::once(record(op::SCHEMA, &schema()))
        .chain((1..=CHANNELS).map(|id| record(op::CHANNEL, &channel(id))))
        .collect();
    let (mut sequence, mut counts) = (0, BTreeMap::<u16, u64>::new());
    for n in 0..4 + dice.below(6) {
        if dice.one_in(6) {
            let body = [text("notes"), text("")].concat();
            made.push(op::METADATA, &body, Holds::default());
        }
        let chunked = layout == 0 || (layout == 2 && dice.one_in(2));
        let defines = definitions == 1 || (definitions == 0 && n == 0);
        if defines && !chunked {
            made.define();
        }
        let mut records = if defines {
            defining.concat()
        } else {
            Vec::new()
        };
        let mut holds = Holds::default();
        if defines {
            holds.channels = (1..=CHANNELS).collect();
        }
        let mut entries = BTreeMap::<u16, Vec<u8>>::new();
        for _ in 0..1 + dice.below(20) {
            let (body, sent) = message(dice, sequence);
            sequence += 1;
            let id = u16::from_le_bytes([body[0], body[1]]);
            *counts.entry(id).or_default() += 1;
            if chunked {
                let entry = [sent.2.to_le_bytes(), (records.len() as u64).to_le_bytes()].concat();
                entries.entry(id).or_default().extend(entry);
                records.extend(record(op::MESSAGE, &body));
                holds.messages.push((id, sent));
            } else {
                let messages = vec![(id, sent)];
                made.push(
                    op::MESSAGE,
                    &body,
                    Holds {
                        messages,
                        ..Holds::default()
                    },
                );
            }
        }
        if chunked {
            let span = (
                holds.messages[0].1.2,
                holds.messages[holds.messages.len() - 1].1.2,
            );
            let body = chunk(dice, &records, span);
            made.push(op::CHUNK, &body, holds);
            for (id, entries) in entries.into_iter().filter(|_| indexed) {
                let length = (entries.len() as u32).to_le_bytes();
                let body = [&id.to_le_bytes()[..], &length, &entries].concat();
                made.push(op::MESSAGE_INDEX, &body, Holds::default());
            }
        }
    }
    let sum = if made.summed {
        crc32fast::hash(&made.bytes)
    } else {
        0
    };
    made.push(op::DATA_END, &sum.to_le_bytes(), Holds::default());
    let summary_start = made.bytes.len();
    if with_summary {
        made.define();
        let mut by_channel = Vec::new();
        for (id, count) in &counts {
            by_channel.extend(id.to_le_bytes());
            by_channel.extend(count.to_le_bytes());
        }
        let statistics = [
            &u64::from(sequence).to_le_bytes()[..],
            &[1, 0],
            &u32::from(CHANNELS).to_le_bytes(),
            &[0; 12],
            &[0; 16],
            &(by_channel.len() as u32).to_le_bytes(),
            &by_channel,
        ];
        made.push(op::STATISTICS, &statistics.concat(), Holds::default());
    }
    let start = if with_summary {
        summary_start as u64
    } else {
        0
    };
    let covered = [&start.to_le_bytes()[..], &[0; 8]].concat();
    let mut sum = crc32fast::hash(
        &[
            &made.bytes[summary_start..],
            &record(op::FOOTER, &[0; 20])[..9],
            &covered,
        ]
        .concat(),
    );
    if !made.summed || !with_summary {
        sum = 0;
    }
    made.push(
        op::FOOTER,
        &[&covered[..], &sum.to_le_bytes()].concat(),
        Holds::default(),
    );
    made.bytes.extend(mcap::MAGIC);
    made
}

/// Bytes with the place in the undamaged file that each comes from.
type Traced = Vec<(u8, Option<usize>)>;

/// Damages a file once; says how.
fn damage(dice: &mut Dice, bytes: &mut Traced, made: &Made) -> String {
    let at = dice.below(bytes.len());
    let most = [4, 64, 2000][dice.below(3)];
    let length = 1 + dice.below(most);
    let range = at..(at + length).min(bytes.len());
    match dice.below(8) {
        0 | 1 => {
            let bit = dice.below(8);
            bytes[at] = (bytes[at].0 ^ (1 << bit), None);
            format!("bit {bit} of byte {at} flipped")
        }
        2 => {
            let new = (0..range.len())
                .map(|_| (dice.next() as u8, None))
                .collect::<Vec<_>>();
            bytes.splice(at..at, new);
            format!("{} bytes inserted at {at}", range.len())
        }
        3 => {
            bytes.drain(range.clone());
            format!("{range:?} removed")
        }
        4 => {
            bytes[range.clone()].fill((0, None));
            format!("{range:?} zeroed")
        }
        5 => {
            for byte in &mut bytes[range.clone()] {
                *byte = (dice.next() as u8, None);
            }
            format!("{range:?} overwritten")
        }
        6 if dice.one_in(3) => {
            bytes.truncate(at.max(20));
            format!("cut at {at}")
        }
        // A bit of the length of a record, where it still stands there.
        6 => {
            let piece = &made.pieces[dice.below(made.pieces.len())].0;
            let at = bytes
                .iter()
                .position(|byte| byte.1 == Some(piece.start + 1))
                .unwrap_or(at);
            let bit = dice.below(12);
            let place = (at + bit / 8).min(bytes.len() - 1);
            bytes[place] = (bytes[place].0 ^ (1 << (bit % 8)), None);
            format!("bit {bit} of the length at byte {at} flipped")
        }
        // A run of records moved elsewhere between records.
        _ => {
            let place = |bytes: &Traced, n: usize| {
                let start = made.pieces[n].0.start;
                bytes
                    .iter()
                    .position(|byte| byte.1 == Some(start))
                    .unwrap_or(bytes.len())
            };
            let count = made.pieces.len();
            let first = dice.below(count);
            let (a, b) = (
                place(bytes, first),
                place(bytes, (first + 1 + dice.below(3)).min(count - 1)),
            );
            let moved: Traced = bytes.drain(a.min(b)..a.max(b)).collect();
            let to = place(bytes, dice.below(count));
            let described = format!("{} bytes moved from {} to {to}", moved.len(), a.min(b));
            bytes.splice(to..to, moved);
            described
        }
    }
}

/// Whether these bytes of the undamaged file are there in one run.
fn is_intact(bytes: &Traced, places: &BTreeMap<usize, usize>, range: &Range<usize>) -> bool {
    places.get(&range.start).is_some_and(|&start| {
        bytes.get(start..start + range.len()).is_some_and(|run| {
            run.iter()
                .zip(range.clone())
                .all(|(byte, from)| byte.1 == Some(from))
        })
    })
}

/// The messages of a file as a reader of the stream and one of the indexes give them.
fn read_both_ways(bytes: &[u8]) -> [Vec<Message>; 2] {
    let plain = |message: mcap::Message<'_>| {
        let topic = message.channel.topic.clone();
        (
            topic,
            message.sequence,
            message.log_time,
            message.data.to_vec(),
        )
    };
    let stream = mcap::MessageStream::new(bytes).unwrap();
    let mut streamed: Vec<_> = stream.map(|message| plain(message.unwrap())).collect();
    let summary = mcap::Summary::read(bytes).unwrap().unwrap();
    let mut indexed = Vec::new();
    let chunks = summary.chunk_indexes.iter();
    for chunk in chunks.filter(|chunk| !chunk.message_index_offsets.is_empty()) {
        let entries = summary.read_message_indexes(bytes, chunk).unwrap();
        // Sorted below.
        indexed.extend(
            entries
                .into_values()
                .flatten()
                .map(|entry| plain(summary.seek_message(bytes, chunk, &entry).unwrap())),
        );
    }
    streamed.sort();
    indexed.sort();
    [streamed, indexed]
}

/// Leaves a recovered file in a folder with the number of its messages and the sum of their checksums.
fn keep(folder: &Path, number: u64, bytes: &[u8], messages: &[Message]) {
    let sum = messages
        .iter()
        .fold(0_u32, |sum, (topic, sequence, time, data)| {
            let start = [&sequence.to_le_bytes()[..], &time.to_le_bytes()].concat();
            sum.wrapping_add(crc32fast::hash(
                &[topic.as_bytes(), b"\0", &start, data].concat(),
            ))
        });
    std::fs::write(folder.join(format!("{number}.mcap")), bytes).unwrap();
    let facts = format!("{} {sum}\n", messages.len());
    std::fs::write(folder.join(format!("{number}.sum")), facts).unwrap();
}

/// Messages in intact records and how many of them are there, of the file with this number.
fn tried(number: u64) -> (usize, usize) {
    let mut dice = Dice(number.wrapping_mul(0x1000_0001));
    let made = make(&mut dice);
    let mut traced: Traced = made.bytes.iter().copied().zip((0..).map(Some)).collect();
    let times = 1 + dice.below(3);
    let done: Vec<_> = (0..times)
        .map(|_| damage(&mut dice, &mut traced, &made))
        .collect();
    let places = traced
        .iter()
        .enumerate()
        .filter_map(|(at, byte)| Some((byte.1?, at)))
        .collect();
    let intact: Vec<&Holds> = (made.pieces.iter())
        .filter(|(range, _)| is_intact(&traced, &places, range))
        .map(|(_, holds)| holds)
        .collect();
    let defined: BTreeSet<u16> = (intact.iter())
        .flat_map(|holds| holds.channels.iter().copied())
        .collect();
    let expected: BTreeSet<&Message> = (intact.iter().flat_map(|holds| &holds.messages))
        .filter(|(channel, _)| defined.contains(channel))
        .map(|(_, message)| message)
        .collect();
    let bytes: Vec<u8> = traced.iter().map(|byte| byte.0).collect();
    let mut out = Vec::new();
    let context = format!("file {number}: {done:?}");
    let recovered = match recover("x.mcap", Cursor::new(&bytes), &mut out, false, |_| None) {
        Ok(recovered) => recovered,
        Err(ContainerError::NotMcap { .. }) if expected.is_empty() => return (0, 0),
        Err(error) => panic!("{context}: {error}"),
    };
    check(&out, &recovered.written);
    let [streamed, indexed] = read_both_ways(&out);
    assert_eq!(streamed, indexed, "{context}");
    assert_eq!(
        streamed.len() as u64,
        recovered.written.messages,
        "{context}"
    );
    if let Some(folder) = std::env::var_os("INHAND_KEEP_RECOVERED") {
        keep(Path::new(&folder), number, &out, &streamed);
    }
    let saved: BTreeSet<&Message> = streamed.iter().collect();
    // Of two definitions without a checksum nobody knows which one is right.
    let in_doubt = !made.summed && recovered.contradictions > 0;
    let data = |message: &&Message| (message.1, message.2, message.3.clone());
    let saved_data: BTreeSet<_> = saved.iter().map(data).collect();
    let missing: Vec<_> = (expected.difference(&saved))
        .filter(|message| !(in_doubt && saved_data.contains(&data(message))))
        .map(|message| message.1)
        .collect();
    assert!(
        missing.is_empty(),
        "{context}: messages {missing:?} are not saved: {recovered:#?}"
    );
    let all: BTreeSet<&Message> = (made.pieces.iter())
        .flat_map(|(_, holds)| holds.messages.iter().map(|(_, message)| message))
        .collect();
    if made.summed && !recovered.is_lossy() {
        assert_eq!(saved, all, "{context}: said to be all: {recovered:#?}");
    }
    (expected.len(), all.len())
}

#[test]
fn every_message_in_an_intact_record_is_saved() {
    let number = |name: &str, otherwise: u64| {
        let set = std::env::var(name).ok();
        set.map_or(otherwise, |set| set.parse().expect("a number of files"))
    };
    let first = number("INHAND_DAMAGE_FROM", 0);
    let files = number("INHAND_DAMAGED_FILES", 400);
    let (mut intact, mut all) = (0, 0);
    for file in first..first + files {
        let (expected, of) = tried(file);
        intact += expected;
        all += of;
    }
    println!("{files} files, {all} messages, {intact} in intact records, all of those saved");
    assert!(
        intact * 2 > all,
        "the damage leaves {intact} of {all} messages"
    );
}
