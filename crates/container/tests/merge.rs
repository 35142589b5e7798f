//! Several files as one.

use std::io::Cursor;

use inhand_container::{ContainerError, Merge, Merged, MetadataRecord, Packing, Source, merge};
use proptest::prelude::*;

use crate::support::{PLAIN, check, file, messages, metadata_of, sent, shapes};

fn merged(files: &[&[u8]], keep_both: bool) -> Result<(Vec<u8>, Merged), ContainerError> {
    let sources: Vec<_> = (files.iter().enumerate())
        .map(|(n, bytes)| Source::open(&format!("{n}.mcap"), Cursor::new(*bytes)).unwrap())
        .collect();
    let mut out = Vec::new();
    let settings = Merge {
        library: "merged",
        keep_both,
        metadata: &|_, record: MetadataRecord| record,
        packing: Packing::Zstd,
    };
    let merged = merge(sources, &mut out, &settings)?;
    check(&out, &merged.written);
    Ok((out, merged))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]

    #[test]
    fn messages_of_all_files_come_by_time(
        shape in shapes(),
        mut first in messages(),
        mut second in messages(),
    ) {
        first.sort_by_key(|(_, time)| *time);
        second.sort_by_key(|(_, time)| *time);
        let (a, b) = (file(&shape, &first), file(&PLAIN, &second));
        let (out, result) = merged(&[&a, &b], false).unwrap();
        let mut expected = sent(&a);
        expected.extend(sent(&b));
        // Stable: of equal times the first file's come first.
        expected.sort_by_key(|(_, _, time, _)| *time);
        let pauses = expected.windows(2).map(|pair| pair[1].2 - pair[0].2);
        prop_assert_eq!(result.longest_pause, pauses.max().unwrap_or(0));
        prop_assert_eq!(sent(&out), expected);
        // All four channels are the same in both.
        prop_assert_eq!(result.written.channels, 4);
        prop_assert_eq!(result.metadata_once, 2);
        prop_assert_eq!(metadata_of(&out).len(), 2);
        let attachments = u64::from(!first.is_empty()) + u64::from(!second.is_empty());
        prop_assert_eq!(result.written.attachments, attachments);
    }

    #[test]
    fn each_file_keeps_its_own_order(first in messages(), second in messages()) {
        let (a, b) = (file(&PLAIN, &first), file(&PLAIN, &second));
        let (out, _) = merged(&[&a, &b], false).unwrap();
        prop_assert_eq!(sent(&out).len(), first.len() + second.len());
        for of_one in [sent(&a), sent(&b)] {
            let all = sent(&out);
            let mut place = all.iter();
            prop_assert!(of_one.iter().all(|message| place.any(|other| other == message)));
        }
    }
}

/// A file with one message on `/a`, whose schema has this content.
fn one(schema: &[u8], encoding: &str, channel: u16) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut out).unwrap();
    writer
        .add_schema_with_id(1, "thing", "jsonschema", schema)
        .unwrap();
    writer
        .add_channel_with_id(channel, 1, "/a", encoding, &Default::default())
        .unwrap();
    let header = mcap::records::MessageHeader {
        channel_id: channel,
        sequence: u32::from(channel),
        log_time: 10,
        publish_time: 10,
    };
    writer.write_to_known_channel(&header, schema).unwrap();
    writer.finish().unwrap();
    drop(writer);
    out.into_inner()
}

#[test]
fn a_topic_with_another_schema_is_refused_unless_both_are_wanted() {
    let (a, b, c) = (
        one(b"{}", "json", 3),
        one(b"{ }", "json", 3),
        one(b"{}", "cbor", 3),
    );
    for other in [&b, &c] {
        let error = merged(&[&a, other], false).unwrap_err();
        let text = error.to_string();
        assert!(matches!(error, ContainerError::Collision { .. }));
        assert!(
            text.contains("/a") && text.contains("--keep-both"),
            "{text}"
        );
    }
    let (out, result) = merged(&[&a, &b, &c], true).unwrap();
    assert_eq!((result.written.channels, result.written.schemas), (3, 2));
    assert_eq!(result.side_by_side.into_iter().collect::<Vec<_>>(), ["/a"]);
    // Ids are free for one of them only; each message still has its own schema.
    for message in mcap::MessageStream::new(&out).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.clone().unwrap();
        assert_eq!(schema.data, message.data);
    }
}

#[test]
fn equal_channels_with_other_ids_become_one() {
    let (a, b) = (one(b"{}", "json", 3), one(b"{}", "json", 9));
    let (out, result) = merged(&[&a, &b], false).unwrap();
    assert_eq!(result.written.channels, 1);
    assert_eq!(result.joined.into_iter().collect::<Vec<_>>(), ["/a"]);
    let sequences: Vec<_> = sent(&out)
        .into_iter()
        .map(|(_, sequence, ..)| sequence)
        .collect();
    assert_eq!(sequences, [3, 9]);
}

#[test]
fn a_damaged_file_is_named() {
    let (a, b) = (one(b"{}", "json", 3), one(b"{}", "json", 3));
    let error = merged(&[&a, &b[..b.len() / 2]], false).unwrap_err();
    assert!(error.to_string().starts_with("1.mcap: "), "{error}");
}

/// A file with two equal channels that differ in nothing but their ids.
fn twins() -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut out).unwrap();
    for id in [4, 6] {
        (writer.add_channel_with_id(id, 0, "/a", "json", &Default::default())).unwrap();
    }
    for (channel_id, sequence) in [(4, 40), (6, 60)] {
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence,
            log_time: 10,
            publish_time: 10,
        };
        writer.write_to_known_channel(&header, b"{}").unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    out.into_inner()
}

#[test]
fn equal_channels_of_one_file_stay_apart() {
    let twins = twins();
    let (_, result) = merged(&[&twins, &twins], false).unwrap();
    let by_channel = result.written.messages_by_channel;
    assert_eq!(by_channel.into_iter().collect::<Vec<_>>(), [(4, 2), (6, 2)]);
}
