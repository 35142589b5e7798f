//! Sound files have no difference; each kind of damage is named where it is.

use std::io::Cursor;

use inhand_container::{Audit, Source, audit};
use mcap::records::op;
use proptest::prelude::*;

use crate::support::{PLAIN, Shape, file, messages, shapes};

const MESSAGES: [(u16, u64); 6] = [(0, 5), (1, 7), (2, 9), (1, 20), (3, 21), (0, 30)];

fn audited(bytes: &[u8]) -> Audit {
    let mut source = Source::open("a.mcap", Cursor::new(bytes)).unwrap();
    audit(&mut source, &mut |_, _, _, _| ()).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn sound_files_of_every_shape_have_no_difference(shape in shapes(), sent in messages()) {
        let found = audited(&file(&shape, &sent));
        prop_assert!(found.differences.is_empty(), "{:#?}", found.differences);
        prop_assert_eq!(found.messages, sent.len() as u64);
        // Without messages there may be nothing to lack a checksum or a chunk.
        let is_strict = shape.summary && shape.sums && shape.chunks;
        prop_assert!(found.notes.is_empty() == is_strict || sent.is_empty(), "{:#?}", found.notes);
    }
}

/// First byte of the body of the n-th record of a kind, outside chunks.
fn body_of(bytes: &[u8], opcode: u8, n: usize) -> usize {
    let (mut at, mut seen) = (8, 0);
    loop {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        if bytes[at] == opcode {
            if seen == n {
                return at + 9;
            }
            seen += 1;
        }
        at += 9 + usize::try_from(length).unwrap();
    }
}

/// A change of one byte, by what it is in: kind of record, its number, byte in its body, and what the difference names.
const CHANGES: [(u8, usize, usize, &str); 14] = [
    (op::CHUNK, 0, 100, "schema"),
    (op::CHUNK, 0, 0, "log times"),
    (op::MESSAGE_INDEX, 0, 14, "message index of channel"),
    (op::MESSAGE_INDEX, 0, 6, "message index of channel"),
    (op::MESSAGE_INDEX, 0, 0, "message index of channel"),
    (op::CHUNK_INDEX, 0, 0, "first log time"),
    (op::CHUNK_INDEX, 0, 16, "chunk index"),
    (op::CHUNK_INDEX, 0, 24, "length"),
    (op::STATISTICS, 0, 0, "statistics, messages"),
    (op::STATISTICS, 0, 26, "statistics, first log time"),
    (op::STATISTICS, 0, 48, "statistics, messages of channel"),
    (op::ATTACHMENT_INDEX, 0, 16, "attachment index"),
    (op::METADATA_INDEX, 0, 8, "metadata index"),
    (op::SUMMARY_OFFSET, 0, 1, "summary offset"),
];

#[test]
fn each_change_of_a_byte_is_named() {
    let shape = Shape {
        sums: false,
        ..PLAIN
    };
    let sound = file(&shape, &MESSAGES);
    assert_eq!(audited(&sound).differences.listed(), []);
    for (opcode, n, byte, named) in CHANGES {
        let mut bytes = sound.clone();
        bytes[body_of(&sound, opcode, n) + byte] ^= 1;
        let found = audited(&bytes).differences;
        let is_named = |part: &str| found.listed().iter().any(|own| own.place.contains(part));
        assert!(is_named(named), "{opcode:#x} {byte} {named}: {found:#?}");
    }
}

#[test]
fn definitions_of_the_summary_are_those_of_the_data() {
    let shape = Shape {
        sums: false,
        ..PLAIN
    };
    let sound = file(&shape, &MESSAGES);
    // Behind the data there are the definitions of the summary alone.
    let end = body_of(&sound, op::DATA_END, 0);
    for (opcode, byte, named) in [(op::CHANNEL, 9, "channel"), (op::SCHEMA, 7, "schema")] {
        let mut n = 0;
        while body_of(&sound, opcode, n) < end {
            n += 1;
        }
        let mut bytes = sound.clone();
        bytes[body_of(&sound, opcode, n) + byte] ^= 1;
        let found = audited(&bytes).differences;
        let [only] = found.listed() else {
            panic!("{named}: {found:#?}");
        };
        assert!(
            only.place.starts_with(&format!("summary, {named}")),
            "{only:?}"
        );
    }
}

#[test]
fn checksums_are_compared_and_reading_goes_on() {
    let sound = file(&PLAIN, &MESSAGES);
    let places = |bytes: &[u8]| -> Vec<String> {
        let found = audited(bytes).differences;
        found.listed().iter().map(|own| own.place.clone()).collect()
    };
    assert_eq!(places(&sound), [""; 0]);
    for (opcode, byte, expected) in [
        (op::CHUNK, 100, &["chunk", "everything before it"][..]),
        (
            op::STATISTICS,
            0,
            &["checksum of the summary", "statistics"],
        ),
        (op::METADATA, 5, &["everything before it"]),
    ] {
        let mut bytes = sound.clone();
        bytes[body_of(&sound, opcode, 0) + byte] ^= 1;
        let found = places(&bytes);
        for part in expected {
            assert!(
                found.iter().any(|own| own.contains(part)),
                "{part}: {found:?}"
            );
        }
    }
    let cut = places(&sound[..sound.len() - 40]);
    assert_eq!(cut.len(), 1, "{cut:?}");
}
