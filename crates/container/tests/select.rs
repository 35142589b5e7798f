//! Cutting, filtering, packing anew.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use inhand_container::{
    ChannelFacts, ContainerError, Interval, Latch, MetadataRecord, Packing, Selection, Source,
    Writer, latch, select, span,
};
use mcap::Compression;
use proptest::prelude::*;

use crate::support::{
    Counting, PLAIN, Sent, Shape, file, messages, metadata_of, records, selected, sent, shapes,
};

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]

    #[test]
    fn everything_stays_as_it_was(shape in shapes(), messages in messages()) {
        let bytes = file(&shape, &messages);
        let (out, result) = selected(&bytes, &Selection::default());
        prop_assert_eq!(records(&out), records(&bytes));
        prop_assert_eq!((result.left_out, result.moved, result.chunks_skipped), (0, 0, 0));
        prop_assert_eq!(result.written.messages, messages.len() as u64);
        // A copy of a copy is the same to the last byte.
        let (again, _) = selected(&out, &Selection::default());
        prop_assert!(again == out);
    }

    #[test]
    fn a_cut_keeps_what_lies_inside_in_its_order(
        shape in shapes(),
        messages in messages(),
        from in 0..1000_u64,
        length in 0..600_u64,
    ) {
        let bytes = file(&shape, &messages);
        let keep = Interval::new(from, Some(from + length));
        let none = |_: &ChannelFacts| None;
        let selection = Selection { keep: vec![keep], latch: &none, ..Selection::default() };
        let (out, result) = selected(&bytes, &selection);
        let expected: Vec<_> = sent(&bytes).into_iter()
            .filter(|(_, _, time, _)| (from..from + length).contains(time))
            .collect();
        prop_assert_eq!(sent(&out), expected);
        prop_assert!(result.chunks_skipped == 0 || (shape.summary && shape.chunks));
        // Everything but messages is there, however the chunks of it were skipped.
        let rest = |bytes: &[u8]| -> std::collections::BTreeSet<String> {
            records(bytes).into_iter().filter(|r| !r.starts_with("Message") && !r.contains("144")).collect()
        };
        prop_assert_eq!(rest(&out), rest(&bytes));
    }

    #[test]
    fn topics_are_left_out_whole(shape in shapes(), messages in messages()) {
        let bytes = file(&shape, &messages);
        let keep = |channel: &ChannelFacts| channel.topic == "/a";
        let selection = Selection {
            channels: Some(&keep),
            metadata: false,
            attachments: false,
            packing: Some(Packing::Lz4),
            ..Selection::default()
        };
        let (out, _) = selected(&bytes, &selection);
        let expected: Vec<_> =
            sent(&bytes).into_iter().filter(|(topic, ..)| topic == "/a").collect();
        prop_assert_eq!(sent(&out), expected);
        let left_out = ["Metadata", "Attachment"];
        let stays = |record: &String| {
            !left_out.iter().any(|kind| record.starts_with(kind)) && !record.contains("\"/b\"")
        };
        prop_assert!(records(&out).iter().all(stays));
    }

    #[test]
    fn damage_is_an_error_and_never_a_panic(
        shape in shapes(),
        messages in messages(),
        places in prop::collection::vec((0.0..1.0_f64, 1..=255_u8), 1..4),
        end in 0.0..1.0_f64,
    ) {
        let mut bytes = file(&shape, &messages);
        for (place, change) in places {
            let place = 8 + (place * (bytes.len() - 8) as f64) as usize;
            bytes[place] ^= change;
        }
        bytes.truncate((bytes.len() as f64 * (0.5 + end)) as usize);
        if let Ok(mut source) = Source::open("x.mcap", Cursor::new(&bytes)) {
            let _ = select(&mut source, &mut std::io::sink(), &Selection::default());
            let _ = span(&mut source);
        }
    }
}

/// Messages on `/a` every 10 ns, `/tf_static` at three early times.
fn with_transforms() -> Vec<u8> {
    let mut messages: Vec<Sent> = vec![(0, 0), (0, 1), (0, 300)];
    messages.extend((0..100).map(|k| (1, k * 10)));
    file(&PLAIN, &messages)
}

#[test]
fn static_transforms_move_to_the_start_of_a_stretch() {
    let bytes = with_transforms();
    let keep = vec![Interval::new(205, Some(250)), Interval::new(705, None)];
    let selection = Selection {
        keep,
        ..Selection::default()
    };
    let (out, result) = selected(&bytes, &selection);
    let of_transforms: Vec<_> = (sent(&out).into_iter())
        .filter(|(topic, ..)| topic == "/tf_static")
        .map(|(_, sequence, time, _)| (sequence, time))
        .collect();
    assert_eq!(of_transforms, [(0, 210), (1, 210), (2, 710)]);
    assert_eq!(result.moved, 3);
    // Data, sequence and publish time are those of the source.
    let data = |bytes: &[u8], n| sent(bytes).into_iter().find(|m| m.1 == n).unwrap().3;
    assert_eq!(data(&out, 1), data(&bytes, 1));
}

#[test]
fn only_the_latest_of_equal_transforms_moves() {
    let mut bytes = Vec::new();
    let header = mcap::records::MessageHeader {
        channel_id: 0,
        sequence: 0,
        log_time: 0,
        publish_time: 0,
    };
    let mut writer = mcap::Writer::new(Cursor::new(&mut bytes)).unwrap();
    writer
        .add_channel_with_id(0, 0, "/robot/tf_static", "json", &BTreeMap::new())
        .unwrap();
    for (log_time, data) in [(1, b"A"), (2, b"B"), (3, b"A"), (9, b"C")] {
        let header = mcap::records::MessageHeader { log_time, ..header };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    let selection = Selection {
        keep: vec![Interval::new(5, None)],
        ..Selection::default()
    };
    let (out, result) = selected(&bytes, &selection);
    let data: Vec<_> = sent(&out)
        .into_iter()
        .map(|(_, _, time, data)| (time, data))
        .collect();
    assert_eq!(
        data,
        [(9, b"B".to_vec()), (9, b"A".to_vec()), (9, b"C".to_vec())]
    );
    assert_eq!((result.moved, result.left_out), (2, 1));
}

#[test]
fn what_holds_on_is_told_by_topic_and_durability() {
    let channel = |topic: &str, qos: &str| {
        let bytes = file(&PLAIN, &[]);
        let found: std::cell::RefCell<Option<ChannelFacts>> = None.into();
        let look = |channel: &ChannelFacts| {
            found.borrow_mut().get_or_insert_with(|| channel.clone());
            true
        };
        selected(
            &bytes,
            &Selection {
                channels: Some(&look),
                ..Selection::default()
            },
        );
        let mut channel = found.into_inner().unwrap();
        channel.topic = topic.to_owned();
        channel
            .metadata
            .insert("offered_qos_profiles".to_owned(), qos.to_owned());
        channel
    };
    assert_eq!(latch(&channel("/tf_static", "")), Some(Latch::All));
    assert_eq!(latch(&channel("/arm/tf_static", "")), Some(Latch::All));
    let old =
        "- history: 1\n  depth: 1\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9";
    assert_eq!(latch(&channel("/map", old)), Some(Latch::Last));
    let new = "- history: keep_last\n  durability: transient_local\n";
    assert_eq!(latch(&channel("/map", new)), Some(Latch::Last));
    assert_eq!(
        latch(&channel(
            "/map",
            &old.replace("durability: 1", "durability: 2")
        )),
        None
    );
    assert_eq!(latch(&channel("/tf", "")), None);
}

#[test]
fn chunks_outside_a_stretch_are_not_read() {
    let messages: Vec<Sent> = (0..20_000).map(|k| (1, k)).collect();
    let bytes = file(&PLAIN, &messages);
    let read = Arc::new(AtomicU64::new(0));
    let mut source = Source::open("x", Counting(Cursor::new(&bytes), read.clone())).unwrap();
    let keep = vec![Interval::new(10_000, Some(10_100))];
    let mut out = Vec::new();
    let result = select(
        &mut source,
        &mut out,
        &Selection {
            keep,
            ..Selection::default()
        },
    )
    .unwrap();
    assert_eq!(sent(&out).len(), 100);
    assert!(result.chunks_skipped > 2000, "{}", result.chunks_skipped);
    assert!(
        read.load(Relaxed) < bytes.len() as u64,
        "{} of {}",
        read.load(Relaxed),
        bytes.len()
    );
}

#[test]
fn metadata_are_replaced_by_name_and_added() {
    let bytes = file(&PLAIN, &[(1, 1)]);
    let facts = |text: &str| BTreeMap::from([("key".to_owned(), text.to_owned())]);
    let record = |name: &str, text: &str| MetadataRecord {
        name: name.to_owned(),
        facts: facts(text),
    };
    let selection = Selection {
        replace: BTreeMap::from([("notes".to_owned(), facts("other"))]),
        add: vec![record("more", "new")],
        ..Selection::default()
    };
    let (out, _) = selected(&bytes, &selection);
    let expected = [
        record("notes", "other"),
        record("notes", "other"),
        record("more", "new"),
    ];
    assert_eq!(metadata_of(&out), expected);
    assert_eq!(sent(&out), sent(&bytes));
}

#[test]
fn the_span_is_that_of_the_messages_with_and_without_summary() {
    for (summary, chunks) in [(true, true), (false, true), (false, false)] {
        let shape = Shape {
            summary,
            chunks,
            compression: Some(Compression::Zstd),
            ..PLAIN
        };
        let bytes = file(&shape, &[(1, 70), (2, 30), (1, 900), (3, 31)]);
        let mut source = Source::open("x", Cursor::new(&bytes)).unwrap();
        assert_eq!(span(&mut source).unwrap(), Some((30, 900)));
        let mut empty = Source::open("x", Cursor::new(file(&shape, &[]))).unwrap();
        assert_eq!(span(&mut empty).unwrap(), None);
    }
}

#[test]
fn a_chunk_that_claims_too_much_is_refused() {
    let bytes = file(&PLAIN, &[(1, 1)]);
    let place = bytes
        .windows(1)
        .position(|w| w == [mcap::records::op::CHUNK])
        .unwrap();
    // The first byte with this value may lie in a text; the chunk's is behind the first metadata.
    let chunk = (place..bytes.len())
        .find(|&at| {
            bytes[at] == mcap::records::op::CHUNK
                && bytes.get(at + 1..at + 9).is_some_and(|l| {
                    let length = u64::from_le_bytes(l.try_into().unwrap()) as usize;
                    (50..bytes.len() - at).contains(&length)
                })
        })
        .unwrap();
    let mut hostile = bytes.clone();
    hostile[chunk + 9 + 16..chunk + 9 + 24].copy_from_slice(&(1_u64 << 60).to_le_bytes());
    hostile[chunk + 1..chunk + 9].copy_from_slice(&(1_u64 << 60).to_le_bytes());
    let mut source = Source::open("x", Cursor::new(&hostile)).unwrap();
    let error = select(&mut source, &mut std::io::sink(), &Selection::default()).unwrap_err();
    assert!(
        matches!(error, ContainerError::Truncated { offset, .. } if offset == chunk as u64),
        "{error}"
    );
}

#[test]
fn messages_of_a_second_file_are_appended() {
    let messages: Vec<Sent> = (0..100).map(|k| (1 + (k % 3) as u16, k * 10)).collect();
    let bytes = file(&PLAIN, &messages);
    let mut added = Vec::new();
    let mut writer = Writer::new(&mut added, "", "test", Packing::Zstd).unwrap();
    let schema = writer.schema("other", "jsonschema", b"{}").unwrap();
    let new = writer
        .channel(schema, "/new", "json", &BTreeMap::new())
        .unwrap();
    let known = BTreeMap::from([("key".to_owned(), "channel 2".to_owned())]);
    let known = writer.channel(0, "/b", "json", &known).unwrap();
    for (channel, log_time) in [(new, 5), (known, 505), (new, 5000)] {
        let sequence = 1000 + log_time as u32;
        writer
            .message(channel, sequence, log_time, |data| data.extend(b"{}"))
            .unwrap();
    }
    writer.finish().unwrap();
    let selection = Selection {
        append: Some(&added),
        ..Selection::default()
    };
    let (out, result) = selected(&bytes, &selection);
    assert_eq!((result.appended, result.left_out), (3, 0));
    let counts = &result.written.messages_by_channel;
    // Equal channels become one, new ones get ids that are free.
    assert_eq!(
        counts[&2],
        sent(&bytes).iter().filter(|m| m.0 == "/b").count() as u64 + 1
    );
    assert_eq!((counts.len(), result.written.channels), (4, 5));
    let (new, old): (Vec<_>, Vec<_>) = sent(&out).into_iter().partition(|m| m.1 >= 1000);
    assert_eq!(old, sent(&bytes));
    let topics: Vec<_> = new.iter().map(|m| (m.0.as_str(), m.2)).collect();
    assert_eq!(topics, [("/new", 5), ("/b", 505), ("/new", 5000)]);
    // What was there stays byte for byte, chunk by chunk.
    let kept = records(&out);
    assert!(records(&bytes).iter().all(|record| kept.contains(record)));
}
