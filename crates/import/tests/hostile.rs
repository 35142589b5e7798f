//! Bytes that lie: an error or a finding with the topic and the message, bounded memory, no panic.

use inhand_import::{ImportSettings, read_recording, read_take};
use proptest::prelude::*;

use super::bag::{self, Bag, Cdr};
use super::{START, assert_found, marker, read, refusal, stamp, turned};
use crate::common;

const KINDS: [(&str, &str); 17] = [
    bag::MARKERS,
    bag::BODIES,
    bag::POSE,
    bag::POINT,
    bag::TRANSFORMS,
    ("geometry_msgs/msg/PoseArray", "cdr"),
    ("geometry_msgs/msg/TransformStamped", "cdr"),
    ("foxglove.PoseInFrame", "protobuf"),
    ("foxglove.PosesInFrame", "protobuf"),
    ("foxglove.FrameTransform", "protobuf"),
    ("foxglove.FrameTransforms", "protobuf"),
    ("foxglove.PointCloud", "protobuf"),
    ("foxglove.PoseInFrame", "json"),
    ("foxglove.PosesInFrame", "json"),
    ("foxglove.FrameTransform", "json"),
    ("foxglove.FrameTransforms", "json"),
    ("foxglove.PointCloud", "json"),
];

#[test]
fn a_file_with_nothing_to_read_lists_what_it_has() {
    let mut bag = Bag::new();
    bag.add("/chatter", ("std_msgs/msg/String", "cdr"), START, b"hello");
    bag.add(
        "/old/pose",
        ("geometry_msgs/PoseStamped", "cdr2"),
        START,
        b"hello",
    );
    let error = refusal(&bag.end(), &ImportSettings::default());
    for words in [
        "/chatter (std_msgs/msg/String, cdr)",
        "/old/pose",
        "PoseStamped",
        "[topics]",
    ] {
        assert!(error.contains(words), "{words}: {error}");
    }
    let error = refusal(&Bag::new().end(), &ImportSettings::default());
    assert!(error.contains("no channel"), "{error}");
}

#[test]
fn topics_that_are_all_ignored_are_nothing_to_read() {
    let mut bag = Bag::new();
    bag.add(
        "/Hand/pose",
        bag::POSE,
        START,
        &bag::pose(START, "world", turned(1.0, 2.0, 3.0)),
    );
    let error = refusal(&bag.end(), &super::topics(&[("/Hand/pose", "ignore")]));
    assert!(error.contains("/Hand/pose"), "{error}");
}

#[test]
fn one_bad_message_is_told_and_the_others_are_kept() {
    let mut bag = Bag::new();
    for k in 0..20 {
        let mut message = bag::markers(true, stamp(k), &[("Thumb", [1.0, 2.0, 3.0])]);
        if k == 13 {
            message.truncate(40);
        }
        bag.add("/markers", bag::MARKERS, stamp(k), &message);
    }
    let recording = read(&bag.end());
    assert_eq!(marker(&recording, "Thumb").track.gaps(), vec![13..14]);
    assert_found(&recording, "/markers: 1 of 20 messages cannot be read");
    assert_found(&recording, "the first is message 13: expected");
}

#[test]
fn messages_that_are_all_bad_are_an_error_with_topic_and_number() {
    let layout = Cdr::new(true).header(START, "world").f64s(&[0.0; 12]).end();
    let count = Cdr::new(true)
        .header(START, "world")
        .u32(0)
        .u32(u32::MAX)
        .end();
    let text = Cdr::new(true).u32(1).u32(2).u32(u32::MAX).end();
    for (kind, message, words) in [
        (bag::POSE, &layout[..], "another layout"),
        (bag::MARKERS, &count, "4294967295 elements"),
        (bag::POSE, &text, "4294967295 bytes"),
        (bag::POSE, b"\x00\x07\x00\x00", "header 00 07"),
        (bag::POSE, b"", "0 bytes"),
        (
            ("foxglove.PoseInFrame", "protobuf"),
            b"\xff\xff",
            "protobuf",
        ),
        (("foxglove.PoseInFrame", "json"), b"{", "JSON"),
        (("foxglove.PoseInFrame", "json"), b"{}", "frame_id"),
    ] {
        let mut bag = Bag::new();
        bag.add("/x", kind, START, message);
        let error = refusal(&bag.end(), &ImportSettings::default());
        assert!(error.contains("/x, message 0: expected"), "{error}");
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn one_message_is_no_take() {
    let mut bag = Bag::new();
    bag.add(
        "/Hand/pose",
        bag::POSE,
        START,
        &bag::pose(START, "world", turned(1.0, 2.0, 3.0)),
    );
    let error = refusal(&bag.end(), &ImportSettings::default());
    assert!(
        error.contains("at least two messages at different times"),
        "{error}"
    );
}

#[test]
fn jumps_of_the_clock_ask_for_no_memory() {
    let mut bag = Bag::new();
    for k in 0..100_u64 {
        // A week later after half of the messages, by both clocks.
        let time = stamp(k) + if k < 50 { 0 } else { 604_800_000_000_000 };
        let message = bag::pose(time, "world", turned(1.0, 2.0, 3.0));
        bag.add("/Hand/pose", bag::POSE, time, &message);
    }
    let error = refusal(&bag.end(), &ImportSettings::default());
    assert!(
        error.contains("found jumps") && error.contains("100 of them"),
        "{error}"
    );
}

#[test]
fn names_that_change_all_the_time_are_refused() {
    let mut bag = Bag::new();
    for k in 0..101_u64 {
        let names: Vec<String> = (0..100).map(|n| format!("m{}", 100 * k + n)).collect();
        let seen: Vec<(&str, [f64; 3])> = names.iter().map(|n| (n.as_str(), [1.0; 3])).collect();
        bag.add(
            "/markers",
            bag::MARKERS,
            stamp(k),
            &bag::markers(true, stamp(k), &seen),
        );
    }
    let error = refusal(&bag.end(), &ImportSettings::default());
    assert!(
        error.contains("at most 10000 markers and bodies"),
        "{error}"
    );
}

#[test]
fn names_that_name_nothing_are_refused() {
    let long = "x".repeat(1001);
    for seen in [
        vec![("tip", [1.0; 3]); 101],
        vec![(long.as_str(), [1.0; 3])],
    ] {
        let mut bag = Bag::new();
        for k in 0..3 {
            bag.add(
                "/markers",
                bag::MARKERS,
                stamp(k),
                &bag::markers(true, stamp(k), &seen),
            );
        }
        let error = refusal(&bag.end(), &ImportSettings::default());
        assert!(error.contains("names of at most 1000 bytes"), "{error}");
    }
}

#[test]
fn two_programs_on_one_topic_are_told() {
    let mut bag = Bag::new();
    for k in 0..50 {
        for program in [0, 1] {
            let at = turned(f64::from(program), 2.0, 3.0);
            let message = bag::pose(stamp(k), "world", at);
            bag.add_by(program, "/Hand/pose", bag::POSE, [stamp(k); 2], &message);
        }
    }
    let recording = read(&bag.end());
    assert_eq!((recording.len(), recording.bodies.len()), (50, 1));
    assert_found(&recording, "2 channels have this topic");
    assert_found(&recording, "50 values come again for a sample and differ");
}

#[test]
fn a_scan_is_no_set_of_markers() {
    use foxglove::messages::packed_element_field::NumericType;
    use foxglove::messages::{PackedElementField, PointCloud, Timestamp};
    use prost::Message;

    let field = |name: &str, offset| PackedElementField {
        name: name.to_owned(),
        offset,
        r#type: NumericType::Float32.into(),
    };
    let mut bag = Bag::new();
    for k in 0..5_u32 {
        let cloud = PointCloud {
            timestamp: Some(Timestamp::new(1_700_000_000, k * 10_000_000)),
            frame_id: "world".to_owned(),
            pose: None,
            point_stride: 12,
            fields: vec![field("x", 0), field("y", 4), field("z", 8)],
            data: vec![0x3f; 12 * 2000].into(),
        };
        let kind = ("foxglove.PointCloud", "protobuf");
        bag.add("/lidar", kind, stamp(k.into()), &cloud.encode_to_vec());
        let pose = bag::pose(stamp(k.into()), "world", turned(1.0, 2.0, 3.0));
        bag.add("/Hand/pose", bag::POSE, stamp(k.into()), &pose);
    }
    let bytes = bag.end();
    let recording = read(&bytes);
    assert!(recording.markers.is_empty());
    assert_found(&recording, "2000 points in a message are a scan");
    let recording = super::read_with(&bytes, &super::topics(&[("/lidar", "marker")]));
    assert_eq!(recording.markers.len(), 2000);
}

#[test]
fn our_own_files_are_read_as_such() {
    let take = common::take(50, 100.0);
    let mut bytes = std::io::Cursor::new(Vec::new());
    let file = common::take_file(&take, &[], &[]);
    inhand_channels::write_take(&mut bytes, &file, inhand_channels::Views::All).unwrap();
    let settings = ImportSettings::default();
    let take = read_take(bytes.get_ref(), "own.mcap", &settings).unwrap();
    assert_eq!((take.recording.len(), take.motion.is_some()), (50, true));
    assert!(take.roles.is_some());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn any_message_is_read_or_refused(
        kind in 0..KINDS.len(),
        little_endian in any::<bool>(),
        payload in prop::collection::vec(any::<u8>(), 0..300),
        behind_header in any::<bool>(),
    ) {
        let mut message = Vec::new();
        if behind_header {
            message.extend([0, u8::from(little_endian), 0, 0]);
        }
        message.extend(payload);
        let mut bag = Bag::new();
        for k in 0..3 {
            bag.add("/x", KINDS[kind], stamp(k), &message);
        }
        let _ = read_recording(&bag.end(), "x.mcap", &ImportSettings::default());
    }

    #[test]
    fn any_change_of_a_sound_message_is_read_or_refused(
        place in 0..260_usize,
        value in any::<u8>(),
        length in 0..260_usize,
    ) {
        let sound = [
            (bag::MARKERS, bag::markers(true, START, &[("Thumb", [1.0; 3]), ("", [2.0; 3])])),
            (bag::BODIES, bag::bodies(false, START, &[("Hand", turned(1.0, 2.0, 3.0))])),
            (bag::TRANSFORMS, bag::transforms(START, &[("a", "b", turned(1.0, 2.0, 3.0))])),
        ];
        for (kind, message) in sound {
            let mut bag = Bag::new();
            for k in 0..3 {
                let mut changed = message.clone();
                if let Some(byte) = changed.get_mut(place).filter(|_| k == 1) {
                    *byte = value;
                }
                if k == 2 {
                    changed.truncate(length);
                }
                bag.add("/x", kind, stamp(k), &changed);
            }
            let _ = read_recording(&bag.end(), "x.mcap", &ImportSettings::default());
        }
    }
}
