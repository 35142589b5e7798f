//! Recovery of intact data, and of nothing else.

mod damage;

use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use inhand_container::{ContainerError, Packing, Recovered, Writer, recover};
use mcap::records::op;
use proptest::prelude::*;

use crate::support::{Counting, PLAIN, Sent, Shape, check, file, messages, records, sent, shapes};

fn saved(bytes: &[u8]) -> (Vec<u8>, Recovered) {
    let mut out = Vec::new();
    let recovered = recover("damaged.mcap", Cursor::new(bytes), &mut out, false, |_| {
        None
    })
    .unwrap();
    check(&out, &recovered.written);
    (out, recovered)
}

fn counted(records: Vec<String>) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for record in records {
        *counts.entry(record).or_default() += 1;
    }
    counts
}

/// Where the records of a file start, with their opcodes.
fn places(bytes: &[u8]) -> Vec<(usize, u8)> {
    let (mut places, mut offset) = (Vec::new(), 8);
    while let Some(&[opcode, ref length @ ..]) = bytes[offset..].first_chunk::<9>() {
        places.push((offset, opcode));
        if opcode == op::FOOTER {
            break;
        }
        offset += 9 + u64::from_le_bytes(*length) as usize;
    }
    places
}

fn many() -> Vec<Sent> {
    (0..100).map(|k| ((k % 4) as u16, k * 10)).collect()
}

fn chunks(bytes: &[u8]) -> Vec<usize> {
    let places = places(bytes).into_iter();
    places
        .filter(|(_, opcode)| *opcode == op::CHUNK)
        .map(|(place, _)| place)
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(80) })]

    #[test]
    fn a_sound_file_loses_nothing(shape in shapes(), messages in messages()) {
        let bytes = file(&shape, &messages);
        let (out, recovered) = saved(&bytes);
        prop_assert!(!recovered.is_lossy(), "{recovered:#?}");
        prop_assert_eq!(records(&out), records(&bytes));
    }

    #[test]
    fn a_cut_file_gives_the_messages_before_the_cut(
        shape in shapes(),
        messages in messages(),
        share in 0.0..1.0_f64,
    ) {
        let bytes = file(&shape, &messages);
        let end = 40 + (share * (bytes.len() - 40) as f64) as usize;
        let (out, recovered) = saved(&bytes[..end]);
        let (all, kept) = (sent(&bytes), sent(&out));
        prop_assert_eq!(&all[..kept.len()], &kept[..]);
        prop_assert!(recovered.is_lossy() || !recovered.repaired.is_empty());
        // Not packed, every whole message before the cut is there.
        if shape.compression.is_none() || !shape.chunks {
            let whole = all.iter().enumerate().take_while(|(n, _)| {
                let content = crate::support::content(*n);
                bytes[..end].windows(content.len()).any(|window| window == content)
            });
            prop_assert!(kept.len() + 1 >= whole.count());
        }
    }

    #[test]
    fn changed_bytes_in_chunks_are_never_passed_on(
        messages in messages(),
        mut shape in shapes(),
        changes in prop::collection::vec((0.0..1.0_f64, 1..=255_u8), 1..4),
    ) {
        shape.sums = true;
        shape.chunks = true;
        let mut bytes = file(&shape, &messages);
        let original = counted(records(&bytes));
        let ranges: Vec<_> = chunks(&bytes).into_iter()
            .map(|at| {
                let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
                at..at + 9 + length as usize
            })
            .collect();
        for (share, change) in changes {
            let range = &ranges[(share * ranges.len() as f64) as usize];
            let inside = (share * ranges.len() as f64).fract();
            let place = range.start + (inside * range.len() as f64) as usize;
            bytes[place] ^= change;
        }
        let (out, recovered) = saved(&bytes);
        if recovered.unchecked {
            // The head of a chunk was hit: its records lie bare, and it is told.
            return Ok(());
        }
        for (record, count) in counted(records(&out)) {
            // A schema that is lost leaves its channels without one.
            let found = original.get(&record).copied().unwrap_or(0);
            prop_assert!(found >= count || record.contains("schema_id: 0"), "{record}");
        }
    }

    #[test]
    fn anything_at_all_is_survived(bytes in prop::collection::vec(any::<u8>(), 0..400), keep in 0..200_usize) {
        let mut hostile = file(&PLAIN, &[(1, 1)]);
        hostile.truncate(keep);
        hostile.extend(bytes);
        let mut out = Vec::new();
        if let Ok(recovered) = recover("x", Cursor::new(&hostile), &mut out, false, |_| None) {
            check(&out, &recovered.written);
        }
    }
}

#[test]
fn a_chunk_whose_checksum_differs_is_left_out_alone() {
    let mut bytes = file(&PLAIN, &many());
    let chunks = chunks(&bytes);
    bytes[chunks[3] + 200] ^= 1;
    let (out, recovered) = saved(&bytes);
    assert_eq!(recovered.losses.len(), 1);
    assert_eq!(recovered.losses[0].offset, chunks[3] as u64);
    assert!(recovered.losses[0].span.is_some() && recovered.is_lossy());
    let stated = recovered.stated_messages.unwrap();
    assert_eq!(stated, 100);
    assert!((80..100).contains(&recovered.written.messages));
    assert_eq!(sent(&out).len() as u64, recovered.written.messages);
    assert!(!recovered.unfinished && recovered.lost_bytes > 0);
}

#[test]
fn definitions_of_a_lost_chunk_come_from_the_summary() {
    let mut bytes = file(&PLAIN, &many());
    let first = chunks(&bytes)[0];
    bytes[first + 100] ^= 1;
    let (out, recovered) = saved(&bytes);
    assert!(recovered.without_channel.is_empty() && recovered.without_schema.is_empty());
    assert!(recovered.written.messages > 80 && sent(&out).len() > 80);
    // Without a summary the damaged chunk alone says what the messages are.
    let shape = Shape {
        summary: false,
        ..PLAIN
    };
    let mut bytes = file(&shape, &many());
    let first = chunks(&bytes)[0];
    bytes[first + 100] ^= 1;
    let (out, recovered) = saved(&bytes);
    assert!(recovered.written.messages > 80 && sent(&out).len() > 80);
    assert!(!recovered.doubtful.is_empty() && recovered.is_lossy());
}

#[test]
fn garbage_between_records_is_skipped() {
    for compression in [None, Some(mcap::Compression::Zstd)] {
        let shape = Shape {
            compression,
            ..PLAIN
        };
        let sound = file(&shape, &many());
        let at = chunks(&sound)[4];
        let mut bytes = sound.clone();
        let garbage: Vec<u8> = (0..333_u32).map(|k| (k * k % 239) as u8).collect();
        bytes.splice(at..at, garbage.iter().copied());
        let (out, recovered) = saved(&bytes);
        assert_eq!(sent(&out), sent(&sound));
        assert_eq!(recovered.lost_bytes, 333);
        assert_eq!(recovered.losses[0].offset, at as u64);
        assert_eq!(records(&out), records(&sound));
    }
}

#[test]
fn a_wrong_length_costs_nothing_where_the_chunk_knows_better() {
    for length in [0, 50, 400, 1 << 20, 1 << 40, u64::MAX] {
        for compression in [None, Some(mcap::Compression::Lz4)] {
            let sound = file(
                &Shape {
                    compression,
                    ..PLAIN
                },
                &many(),
            );
            let at = chunks(&sound)[2];
            let mut bytes = sound.clone();
            bytes[at + 1..at + 9].copy_from_slice(&length.to_le_bytes());
            let (out, recovered) = saved(&bytes);
            assert_eq!(sent(&out), sent(&sound), "length {length}: {recovered:#?}");
        }
    }
}

#[test]
fn a_writer_that_died_leaves_what_it_had_written() {
    let sound = file(&PLAIN, &many());
    let at = *chunks(&sound).last().unwrap();
    // As mcap's writer leaves a chunk that it has not closed.
    let mut bytes = sound[..at + 150].to_vec();
    bytes[at + 1..at + 9].copy_from_slice(&[0xff; 8]);
    bytes[at + 9..at + 9 + 16].copy_from_slice(&[0; 16]);
    bytes[at + 25..at + 25 + 12].copy_from_slice(&[0xff; 12]);
    bytes[at + 41..at + 49].copy_from_slice(&[0xff; 8]);
    let (out, recovered) = saved(&bytes);
    assert!(
        recovered.unfinished && recovered.is_lossy(),
        "{recovered:#?}"
    );
    let (kept, all) = (sent(&out), sent(&sound));
    assert_eq!(kept[..], all[..kept.len()]);
    assert!(kept.len() > 90, "{}", kept.len());
}

#[test]
fn a_damaged_summary_is_made_anew() {
    let sound = file(&PLAIN, &many());
    let (end, _) = places(&sound)
        .into_iter()
        .find(|(_, opcode)| *opcode == op::DATA_END)
        .unwrap();
    for place in [end + 20, end + 60, sound.len() - 20, sound.len() - 3] {
        let mut bytes = sound.clone();
        bytes[place] ^= 0xff;
        let (out, recovered) = saved(&bytes);
        assert_eq!(records(&out), records(&sound), "byte {place}");
        assert!(!recovered.is_lossy(), "byte {place}: {recovered:#?}");
    }
}

#[test]
fn a_damaged_start_costs_no_message() {
    let sound = file(&PLAIN, &many());
    for place in [0, 3, 8, 10, 20] {
        let mut bytes = sound.clone();
        bytes[place] ^= 0x55;
        let (out, _) = saved(&bytes);
        assert_eq!(sent(&out), sent(&sound), "byte {place}");
    }
}

#[test]
fn changed_bytes_outside_chunks_are_told() {
    let shape = Shape {
        chunks: false,
        ..PLAIN
    };
    let mut bytes = file(&shape, &many());
    let last = bytes.iter().rposition(|&byte| byte == op::MESSAGE).unwrap();
    let content = crate::support::content(50);
    let at = bytes
        .windows(content.len())
        .position(|window| window == content)
        .unwrap();
    assert!(at < last);
    bytes[at + 5] ^= 1;
    let (out, recovered) = saved(&bytes);
    assert_eq!(sent(&out).len(), 100);
    assert!(recovered.unchecked && recovered.is_lossy());
}

#[test]
fn what_is_no_such_file_is_refused() {
    for bytes in [
        &b""[..],
        b"Format Version,1.23",
        &[0; 5000],
        b"\x89PNG\r\n\x1a\n and so on",
    ] {
        let error = recover(
            "x.csv",
            Cursor::new(bytes),
            &mut std::io::sink(),
            false,
            |_| None,
        )
        .unwrap_err();
        assert!(matches!(error, ContainerError::NotMcap { .. }), "{error}");
    }
}

/// Our own lz4 blocks are small: those before the damage are had.
#[test]
fn a_chunk_packed_by_lz4_gives_what_lies_before_its_cut() {
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes, "", "test", Packing::Lz4).unwrap();
    let channel = writer
        .channel(0, "/a", "raw", &BTreeMap::default())
        .unwrap();
    let mut noise = 1_u64;
    for time in 0..2000 {
        let written = writer.message(channel, 0, time, |data| {
            for _ in 0..40 {
                noise = noise
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                data.extend((noise ^ (noise >> 29)).to_le_bytes());
            }
        });
        written.unwrap();
    }
    assert_eq!(writer.finish().unwrap().messages, 2000);
    let (out, _) = saved(&bytes[..bytes.len() / 2]);
    let kept = sent(&out).len();
    assert!((700..=1000).contains(&kept), "{kept}");
}

#[test]
fn what_is_read_does_not_grow_with_the_damages() {
    let shape = Shape {
        chunks: false,
        ..PLAIN
    };
    let messages: Vec<Sent> = (0..3000).map(|k| (1, k)).collect();
    let mut bytes = file(&shape, &messages);
    let messages = (places(&bytes).into_iter()).filter(|(_, opcode)| *opcode == op::MESSAGE);
    let damaged: Vec<usize> = messages.map(|(place, _)| place).step_by(20).collect();
    for place in &damaged {
        bytes[place + 1] ^= 0x40;
    }
    let read = Arc::new(AtomicU64::new(0));
    let input = Counting(Cursor::new(&bytes), read.clone());
    let mut out = Vec::new();
    recover("damaged.mcap", input, &mut out, false, |_| None).unwrap();
    let kept = sent(&out).len();
    assert!(kept >= 3000 - damaged.len(), "{kept}");
    let read = read.load(Relaxed);
    assert!(read < 100 * bytes.len() as u64, "{read} of {}", bytes.len());
}

/// A record as bytes.
fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

/// A file of these records, which has no summary.
fn of_records(records: &[Vec<u8>]) -> Vec<u8> {
    let end = [record(op::DATA_END, &[0; 4]), record(op::FOOTER, &[0; 20])];
    let all = [&records.concat()[..], &end.concat()];
    [mcap::MAGIC, &all.concat(), mcap::MAGIC].concat()
}

#[test]
fn private_records_in_a_row_are_no_damage() {
    let header = record(op::HEADER, &[0; 8]);
    let private = record(0x8c, b"private");
    let bytes = of_records(&[header, private.clone(), private.clone(), private]);
    let (out, recovered) = saved(&bytes);
    assert!(!recovered.is_lossy(), "{recovered:#?}");
    assert_eq!(records(&out), records(&bytes));
}

#[test]
fn records_within_a_header_are_not_copied_with_it() {
    // Both texts are empty; what follows them looks like another file.
    let inside = [mcap::MAGIC, &record(op::HEADER, &[0; 8])].concat();
    let header = record(op::HEADER, &[&[0; 8][..], &inside].concat());
    let (out, _) = saved(&of_records(&[header]));
    let (again, recovered) = saved(&out);
    assert!(!recovered.is_lossy(), "{recovered:#?}");
    assert_eq!(again, out);
}

#[test]
fn a_damaged_attachment_behind_the_data_costs_nothing_else() {
    let header = record(op::HEADER, &[0; 8]);
    let texts = [&[0; 16][..], &[0; 8], &3_u64.to_le_bytes(), b"abc"].concat();
    let attachment = record(op::ATTACHMENT, &[&texts[..], &[1; 4]].concat());
    let end = record(op::DATA_END, &[0; 4]);
    let footer = [record(op::FOOTER, &[0; 20]), mcap::MAGIC.to_vec()].concat();
    for behind in [footer, b"no record".to_vec()] {
        let records = [&header[..], &end, &attachment, &behind].concat();
        let (_, recovered) = saved(&[mcap::MAGIC, &records].concat());
        assert_eq!(recovered.written.attachments, 0);
    }
}

#[test]
fn a_schema_of_number_0_is_no_schema_of_channels_without_one() {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let schema = [&[0, 0][..], &text("S"), &text(""), &text("")].concat();
    let channel = [&[3, 0, 0, 0][..], &text("/b"), &text("json"), &text("")].concat();
    let message = [&[3, 0][..], &[0; 20], b"{}"].concat();
    let channel = record(op::CHANNEL, &channel);
    let bytes = of_records(&[
        record(op::HEADER, &[0; 8]),
        channel.clone(),
        record(op::MESSAGE, &message),
        record(op::SCHEMA, &schema),
        channel,
    ]);
    let (out, _) = saved(&bytes);
    assert_eq!(sent(&out).len(), 1, "others read the copy");
}

#[test]
fn what_is_left_over_of_a_zeroed_channel_is_not_written() {
    let channel = record(op::CHANNEL, &[0; 38]);
    let message = record(op::MESSAGE, &[0; 24]);
    let bytes = [
        mcap::MAGIC,
        &record(op::HEADER, &[0; 8]),
        &channel,
        &message,
        b"damage",
    ]
    .concat();
    let (out, _) = saved(&bytes);
    assert_eq!(sent(&out).len(), 1);
    // Two numbers and three lengths.
    let mut written = places(&out).into_iter();
    let (place, _) = written.find(|(_, opcode)| *opcode == op::CHANNEL).unwrap();
    assert_eq!(out[place + 1], 16);
}

#[test]
fn a_channel_whose_facts_go_beyond_their_length_costs_nothing_else() {
    // A topic and an encoding without text; facts of 8 bytes, of which the first text has 4 and the second 2.
    let facts = [4, 0, 0, 0, b'k', b'e', b'y', b's', 2, 0, 0, 0, b'a', b'b'];
    let channel = [&[0; 12][..], &8_u32.to_le_bytes(), &facts].concat();
    let channel = record(op::CHANNEL, &channel);
    let message = record(op::MESSAGE, &[0; 24]);
    let header = record(op::HEADER, &[0; 8]);
    let (out, _) = saved(&of_records(&[header, channel, message]));
    assert_eq!(sent(&out).len(), 1);
}
