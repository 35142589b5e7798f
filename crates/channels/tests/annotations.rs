//! Events on the time line, written and read.

use std::collections::BTreeMap;
use std::io::Cursor;

use inhand_channels::{TakeFile, info, read_annotations, read_take};
use inhand_model::{Annotations, Event};
use mcap::records::MessageHeader;

use crate::common;
use crate::round_trip::written;

fn labels(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
    let owned = pairs
        .iter()
        .map(|(k, v)| ((*k).to_owned(), (*v).to_owned()));
    owned.collect()
}

fn event(start_unix_nanos: u64, end_unix_nanos: u64, pairs: &[(&str, &str)]) -> Event {
    Event {
        start_unix_nanos,
        end_unix_nanos,
        labels: labels(pairs),
    }
}

#[test]
fn annotations_come_back_in_the_order_given() {
    let take = common::take(450, 120.0);
    let start = take.recording.clock.start_unix_nanos();
    let annotations = Annotations {
        events: vec![
            // The later one first, one before the take, one after its end, two at one instant.
            event(
                start + 2_000_000_001,
                start + 2_500_000_000,
                &[("task", "rotate"), ("by", "é\"\n,")],
            ),
            event(start - 7, start + 5, &[("label", "slip")]),
            event(
                start + 99_000_000_000,
                start + 99_000_000_000,
                &[("note", "later")],
            ),
            event(start + 2_000_000_001, start + 2_000_000_001, &[]),
        ],
        keys: vec!["task".to_owned(), "label".to_owned()],
        about: labels(&[("subject", "s01"), ("object", "cube")]),
    };
    let file = TakeFile {
        annotations: Some(&annotations),
        ..TakeFile::new(&take.recording)
    };
    let bytes = written(&file, true);

    let expected = Annotations {
        keys: ["task", "label", "by", "note"].map(str::to_owned).to_vec(),
        ..annotations.clone()
    };
    assert_eq!(read_take(&bytes, "a.mcap").unwrap().annotations, expected);
    assert_eq!(read_annotations(&bytes, "a.mcap").unwrap(), expected);

    // Messages lie in the file in time order, each at its start.
    let summary = info(&bytes, "a.mcap").unwrap();
    let channel = summary
        .channels
        .iter()
        .find(|c| c.topic == "/annotations")
        .unwrap();
    assert_eq!(channel.schema.as_deref(), Some("foxglove.Event"));
    assert_eq!(channel.messages, 4);
    let times: Vec<u64> = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(|message| message.unwrap().log_time)
        .filter(|&log_time| log_time > start)
        .collect();
    assert!(times.is_sorted());

    // The same nouns give the same bytes.
    assert_eq!(written(&file, true), bytes);
}

#[test]
fn a_take_without_annotations_has_no_channel_for_them() {
    let take = common::take(10, 100.0);
    let nothing = Annotations::default();
    let bytes = written(
        &TakeFile {
            annotations: Some(&nothing),
            ..TakeFile::new(&take.recording)
        },
        false,
    );
    assert_eq!(bytes, written(&TakeFile::new(&take.recording), false));
    assert_eq!(read_annotations(&bytes, "a.mcap").unwrap(), nothing);
}

/// A file with one channel of `foxglove.Event` as another tool may write it.
fn foreign(topic: &str, encoding: &str, messages: &[&[u8]]) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut out).unwrap();
    let schema_encoding = if encoding == "json" {
        "jsonschema"
    } else {
        "protobuf"
    };
    let schema = writer
        .add_schema("foxglove.Event", schema_encoding, b"{}")
        .unwrap();
    let channel = writer
        .add_channel(schema, topic, encoding, &BTreeMap::new())
        .unwrap();
    for data in messages {
        let header = MessageHeader {
            channel_id: channel,
            sequence: 0,
            log_time: 1,
            publish_time: 1,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    out.into_inner()
}

#[test]
fn events_of_other_tools_are_read_from_any_topic() {
    let first = br#"{"start_time":{"sec":3,"nsec":4},"end_time":{"sec":5,"nsec":0},
        "metadata":[{"key":"z","value":"1"},{"key":"a","value":"2"},{"key":"empty","value":""}]}"#;
    let second = br#"{"start_time":{"sec":1,"nanosec":0},"end_time":{"sec":1,"nanosec":0}}"#;
    let annotations =
        read_annotations(&foreign("/labels", "json", &[first, second]), "a.mcap").unwrap();
    assert_eq!(
        annotations.events,
        [
            event(3_000_000_004, 5_000_000_000, &[("a", "2"), ("z", "1")]),
            event(1_000_000_000, 1_000_000_000, &[]),
        ]
    );
    // Tables show labels in the order in which they first appear.
    assert_eq!(annotations.keys, ["z", "a"]);
}

#[test]
fn events_that_are_none_are_refused_with_their_place() {
    let good = br#"{"start_time":{"sec":1,"nsec":0},"end_time":{"sec":1,"nsec":0}}"#;
    let backwards = br#"{"start_time":{"sec":2,"nsec":0},"end_time":{"sec":1,"nsec":0}}"#;
    let endless =
        br#"{"start_time":{"sec":18446744073709551615,"nsec":0},"end_time":{"sec":1,"nsec":0}}"#;
    let cases: [(&str, &[u8]); 5] = [
        ("json", b"{"),
        ("json", b"{\"start_time\":3}"),
        ("json", backwards),
        ("json", endless),
        ("protobuf", b"\x0a\x7f"),
    ];
    for (encoding, bad) in cases {
        let messages: Vec<&[u8]> = match encoding {
            "json" => vec![good, bad],
            _ => vec![b"", bad],
        };
        let error =
            read_annotations(&foreign("/annotations", encoding, &messages), "a.mcap").unwrap_err();
        let place = "a.mcap: /annotations, message 1: expected ";
        assert!(error.to_string().starts_with(place), "{error}");
        // What another tool means is its own: its good events count, the others are left out.
        let others = read_annotations(&foreign("/labels", encoding, &messages), "a.mcap").unwrap();
        assert_eq!(others.events.len(), 1);
    }
}
