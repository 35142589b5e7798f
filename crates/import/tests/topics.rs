//! Meaning of topics: by names, by messages, by settings.

use inhand_import::ImportSettings;
use inhand_model::{LengthUnit, MarkerKind, UpAxis};

use super::bag::{self, Bag, Seven};
use super::{
    assert_found, at, body, findings, marker, read, read_with, refusal, stamp, straight, topics,
    turned,
};

/// A recording of poses, five of each topic.
fn poses(of: &[(&str, Seven)]) -> Vec<u8> {
    let mut bag = Bag::new();
    for k in 0..5 {
        for (topic, pose) in of {
            bag.add(
                topic,
                bag::POSE,
                stamp(k),
                &bag::pose(stamp(k), "world", *pose),
            );
        }
    }
    bag.end()
}

#[test]
fn a_pose_that_never_turns_is_a_marker() {
    let recording = read(&poses(&[
        ("/natnet_ros/Hand/pose", turned(1.0, 2.0, 3.0)),
        ("/natnet_ros/Thumb/pose", straight(4.0, 5.0, 6.0)),
    ]));
    assert_eq!(recording.bodies.len(), 1);
    assert_eq!(body(&recording, "Hand").track.len(), 5);
    let thumb = marker(&recording, "Thumb");
    assert_eq!(
        (at(thumb, 0), thumb.kind),
        (Some([4.0, 5.0, 6.0]), MarkerKind::Labelled)
    );
    assert_found(&recording, "its rotation is none at all times");
}

#[test]
fn a_pose_that_turns_and_is_called_like_a_fingertip_is_both() {
    let settings = ImportSettings {
        is_point: |name| name == "Thumb",
        ..ImportSettings::default()
    };
    let bytes = poses(&[("/vrpn/Thumb/pose", turned(4.0, 5.0, 6.0))]);
    let recording = read_with(&bytes, &settings);
    assert_eq!(at(marker(&recording, "Thumb"), 0), Some([4.0, 5.0, 6.0]));
    assert_eq!(body(&recording, "Thumb").track.len(), 5);
    assert!(read(&bytes).markers.is_empty());
}

#[test]
fn users_say_what_topics_are() {
    let bytes = poses(&[
        ("/a/pose", turned(1.0, 2.0, 3.0)),
        ("/b/pose", straight(4.0, 5.0, 6.0)),
        ("/c/pose", turned(7.0, 8.0, 9.0)),
    ]);
    let recording = read_with(
        &bytes,
        &topics(&[
            ("/a/pose", "marker:Thumb"),
            ("/b/pose", "body:Hand"),
            ("/c/pose", "ignore"),
            ("/d/pose", "body:Cube"),
        ]),
    );
    assert_eq!((recording.markers.len(), recording.bodies.len()), (1, 1));
    assert_eq!(at(marker(&recording, "Thumb"), 0), Some([1.0, 2.0, 3.0]));
    let hand = body(&recording, "Hand").track.get(0).unwrap();
    assert_eq!(hand.origin().to_array(), [4.0, 5.0, 6.0]);
    assert_found(
        &recording,
        "/d/pose: set under [topics], but the file has no such topic",
    );
}

#[test]
fn users_name_things_by_place_and_by_name() {
    let mut bag = Bag::new();
    for k in 0..5 {
        let seen = [("", [1.0; 3]), ("", [2.0; 3]), ("", [3.0; 3])];
        bag.add(
            "/markers",
            bag::MARKERS,
            stamp(k),
            &bag::markers(true, stamp(k), &seen),
        );
        let moving = [
            ("world", "palm", turned(1.0, 0.0, 0.0)),
            ("world", "tip1", turned(2.0, 0.0, 0.0)),
            ("world", "camera", turned(3.0, 0.0, 0.0)),
        ];
        bag.add(
            "/tf",
            bag::TRANSFORMS,
            stamp(k),
            &bag::transforms(stamp(k), &moving),
        );
    }
    let bytes = bag.end();
    let settings = topics(&[
        ("/markers", "marker:Thumb,Index"),
        ("/tf", "ignore"),
        ("/tf#palm", "body:Hand"),
        ("/tf#tip1", "marker:Ring"),
    ]);
    let recording = read_with(&bytes, &settings);
    let names: Vec<_> = recording.markers.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["Thumb", "Index", "Ring"]);
    assert_eq!(at(marker(&recording, "Index"), 0), Some([2.0; 3]));
    assert_eq!(marker(&recording, "Index").kind, MarkerKind::Labelled);
    assert_eq!(at(marker(&recording, "Ring"), 0), Some([2.0, 0.0, 0.0]));
    assert_eq!(recording.bodies.len(), 1);
    assert_found(
        &recording,
        "1 things on the topic come after those that [topics] names",
    );

    let error = refusal(&bytes, &topics(&[("/tf", "body:Hand")]));
    assert!(error.contains("set \"/tf#palm\" instead"), "{error}");
}

#[test]
fn a_name_on_two_topics_is_read_from_the_more_telling_one() {
    let mut bag = Bag::new();
    for k in 0..5 {
        let pose = turned(1.0, 2.0, 3.0);
        bag.add(
            "/Hand/pose",
            bag::POSE,
            stamp(k),
            &bag::pose(stamp(k), "world", pose),
        );
        let other = [("world", "Hand", turned(9.0, 9.0, 9.0))];
        bag.add(
            "/tf",
            bag::TRANSFORMS,
            stamp(k),
            &bag::transforms(stamp(k), &other),
        );
    }
    let recording = read(&bag.end());
    assert_eq!(recording.bodies.len(), 1);
    let hand = body(&recording, "Hand").track.get(0).unwrap();
    assert_eq!(hand.origin().to_array(), [1.0, 2.0, 3.0]);
    assert_found(
        &recording,
        "it is on the topics /Hand/pose, /tf: read from the first",
    );
}

#[test]
fn names_that_topics_share_become_whole_topics() {
    let recording = read(&poses(&[
        ("/left/Hand/pose", turned(1.0, 2.0, 3.0)),
        ("/right/Hand/pose", turned(4.0, 5.0, 6.0)),
    ]));
    let names: Vec<_> = recording.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["/left/Hand/pose", "/right/Hand/pose"]);
    assert_found(&recording, "which have the same priority");
}

#[test]
fn units_and_axes_are_those_of_ros_unless_the_user_knows_better() {
    let bytes = poses(&[("/Hand/pose", turned(110.763, 250.0, 1000.0))]);
    let assumed = read(&bytes);
    assert_found(&assumed, "source.units = \"mm\"");
    assert_found(&assumed, "z is assumed, as ROS has it; `source.up` sets it");
    let settings = ImportSettings {
        length_unit: Some(LengthUnit::Millimetres),
        up_axis: Some(UpAxis::Y),
        ..ImportSettings::default()
    };
    let recording = read_with(&bytes, &settings);
    let hand = body(&recording, "Hand").track.get(0).unwrap();
    assert_eq!(hand.origin().to_array(), [0.110763, 0.25, 1.0]);
    assert_eq!(recording.source.up_axis, UpAxis::Y);
    assert!(
        !findings(&recording).contains("assumed"),
        "{}",
        findings(&recording)
    );
}

#[test]
fn what_is_at_the_origin_or_has_no_rotation_is_missing() {
    let mut bag = Bag::new();
    for k in 0..6 {
        let pose = match k {
            2 => turned(0.0, 0.0, 0.0),
            3 => [1.0, 2.0, 3.0, 0.5, 0.0, 0.0, 0.0],
            4 => [f64::NAN, 2.0, 3.0, 0.0, 0.0, 1.0, 0.0],
            _ => turned(1.0, 2.0, 3.0),
        };
        bag.add(
            "/Hand/pose",
            bag::POSE,
            stamp(k),
            &bag::pose(stamp(k), "world", pose),
        );
    }
    let recording = read(&bag.end());
    assert_eq!(body(&recording, "Hand").track.gaps(), vec![2..5]);
    assert_found(&recording, "it is exactly at the origin in 1 samples");
    assert_found(
        &recording,
        "its quaternion is not of unit length in 1 samples",
    );
}

#[test]
fn frames_that_differ_are_told() {
    let mut bag = Bag::new();
    for k in 0..5 {
        for (topic, frame) in [("/Hand/pose", "optitrack"), ("/Cube/pose", "map")] {
            let pose = bag::pose(stamp(k), frame, turned(1.0, 2.0, 3.0));
            bag.add(topic, bag::POSE, stamp(k), &pose);
        }
    }
    let recording = read(&bag.end());
    assert_found(&recording, "the frames \"map\", \"optitrack\"");
}
