//! Recordings of others: a session whose test take is a ROS 2 bag.

mod bag;
mod folders;
mod large;
mod ros2;

use inhand_capture::ReadSettings;
use inhand_model::{Marker, MarkerKind, Recording};

use crate::support::{Bench, SMALL, stderr};
use bag::Bag;

/// The simulated test take.
const TAKE: &str = "session/test/cube_test_01.csv";

pub(crate) fn recorded(bench: &Bench) -> Recording {
    let bytes = bench.bytes(TAKE);
    inhand_capture::read(&bytes, "take.csv", &ReadSettings::default()).expect("the take is read")
}

/// The take as a motion-capture driver sends it: what is missing is left out, messages are logged
/// 2 to 12 ms after their stamps.
pub(crate) fn as_mocap4r2(recording: &Recording) -> Vec<u8> {
    as_stored(recording, <[u8]>::to_vec)
}

/// The same where the recorder makes of each message what it stores.
fn as_stored(recording: &Recording, stored: fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut bag = Bag::new();
    let markers = bag.channel("/markers", "mocap4r2_msgs/msg/Markers");
    let bodies = bag.channel("/rigid_bodies", "mocap4r2_msgs/msg/RigidBodies");
    for k in 0..recording.len() {
        let stamp = recording.clock.unix_nanos(k);
        let log = stamp + 2_000_000 + (k as u64 * 7_919_431) % 10_000_000;
        let seen: Vec<_> = (recording.markers.iter())
            .filter_map(|m| Some((m.name.as_str(), m.track.get(k)?.to_array())))
            .collect();
        bag.message(markers, log, &stored(&bag::markers(stamp, &seen)));
        let seen: Vec<_> = (recording.bodies.iter())
            .filter_map(|b| {
                let pose = b.track.get(k)?;
                let position = pose.origin().to_array();
                Some((b.name.as_str(), position, pose.quaternion_xyzw()))
            })
            .collect();
        bag.message(bodies, log, &stored(&bag::rigid_bodies(stamp, &seen)));
    }
    bag.end()
}

/// The take as poses, one topic for each marker and body.
fn as_poses(recording: &Recording, topic: impl Fn(&str) -> String) -> Vec<u8> {
    let mut bag = Bag::new();
    let kind = "geometry_msgs/msg/PoseStamped";
    let named = |marker: &&Marker| marker.kind == MarkerKind::Labelled;
    let markers: Vec<&Marker> = recording.markers.iter().filter(named).collect();
    let of_markers: Vec<u16> = (markers.iter())
        .map(|marker| bag.channel(&topic(&marker.name), kind))
        .collect();
    let of_bodies: Vec<u16> = (recording.bodies.iter())
        .map(|body| bag.channel(&topic(&body.name), kind))
        .collect();
    for k in 0..recording.len() {
        let stamp = recording.clock.unix_nanos(k);
        for (marker, &channel) in markers.iter().zip(&of_markers) {
            if let Some(at) = marker.track.get(k) {
                // A rotation that means nothing but is one.
                let pose = bag::pose(stamp, at.to_array(), [0.0, 1.0, 0.0, 0.0]);
                bag.message(channel, stamp, &pose);
            }
        }
        for (body, &channel) in recording.bodies.iter().zip(&of_bodies) {
            if let Some(pose) = body.track.get(k) {
                let at = pose.origin().to_array();
                let pose = bag::pose(stamp, at, pose.quaternion_xyzw());
                bag.message(channel, stamp, &pose);
            }
        }
    }
    bag.end()
}

/// Puts a bag in the place of the session's test take.
fn replace_test_take(bench: &Bench, bag: &[u8]) {
    std::fs::remove_file(bench.path(TAKE)).expect("the take can go");
    bench.write("session/test/cube_test_01.mcap", bag);
}

#[test]
fn a_bag_as_test_take_gives_the_numbers_of_the_take_it_holds() {
    let bench = Bench::csv();
    bench.run("csv", &[]);
    let recording = recorded(&bench);
    replace_test_take(&bench, &as_mocap4r2(&recording));
    bench.run("bag", &[]);
    let [csv, mut bag] =
        ["csv/evaluation.json", "bag/evaluation.json"].map(|name| bench.json(name));
    // Only how the file was written differs.
    let source = &mut bag["session"]["test"][0]["source"];
    let format = source["format"].as_str();
    assert!(format.is_some_and(|format| format.contains("mocap4r2")));
    source.clone_from(&csv["session"]["test"][0]["source"]);
    assert_eq!(csv["methods"], bag["methods"]);
    assert_eq!(csv["session"]["test"], bag["session"]["test"]);
}

#[test]
fn poses_under_any_name_are_mapped_by_settings() {
    let bench = Bench::csv();
    bench.run("csv", &[]);
    let recording = recorded(&bench);
    let topic = |name: &str| format!("/mocap/{}/pose", name.to_lowercase().replace(':', "_"));
    replace_test_take(
        &bench,
        &as_poses(&recording, |name| topic(name).replace("hand/", "dorsum/")),
    );
    let output = bench.inhand(&[&["run", "session", "-o", "bag"], &SMALL[..]].concat());
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("dorsum"), "{}", stderr(&output));

    let mut settings = String::from("[topics]\n");
    settings.push_str("\"/mocap/dorsum/pose\" = \"body:Hand\"\n");
    bench.edit("session/inhand.toml", |text| text + "\n" + &settings);
    let output = bench.inhand(&[&["run", "session", "-o", "bag"], &SMALL[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let [csv, bag] = ["csv/evaluation.json", "bag/evaluation.json"].map(|name| bench.json(name));
    assert_eq!(csv["methods"], bag["methods"]);
}

#[test]
fn a_bag_converts_and_says_what_was_read() {
    let bench = Bench::csv();
    bench.write("bag.mcap", as_mocap4r2(&recorded(&bench)));
    let args = [
        "convert",
        "bag.mcap",
        "-o",
        "take.mcap",
        "--topic",
        "/markers#Ring=ignore",
    ];
    let output = bench.inhand(&args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    for words in ["capture times", "100 Hz", "mocap4r2_msgs/msg/Markers"] {
        assert!(
            stderr(&output).contains(words),
            "{words}: {}",
            stderr(&output)
        );
    }
    let info: serde_json::Value =
        serde_json::from_str(&bench.ok(&["info", "take.mcap", "--format", "json"])).expect("JSON");
    let about = &info["metadata"]["inhand.recording"];
    assert_eq!(
        (&about["rate_hz"], &about["samples"]),
        (&"100".into(), &"1200".into())
    );
    let markers = about["markers"].as_str().expect("a text");
    assert!(
        markers.contains("Thumb") && !markers.contains("Ring"),
        "{markers}"
    );
}

#[test]
fn words_that_say_nothing_about_a_topic_are_refused() {
    let bench = Bench::empty();
    bench.write("bag.mcap", Bag::new().end());
    for (word, expected) in [("/a=cheese", "body:NAME"), ("/a", "TOPIC=WORD")] {
        let output = bench.inhand(&["convert", "bag.mcap", "-o", "t.mcap", "--topic", word]);
        assert!(
            matches!(output.status.code(), Some(1 | 2)),
            "{}",
            stderr(&output)
        );
        assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    }
    let output = bench.inhand(&["convert", "bag.mcap", "-o", "t.mcap"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("[topics]"), "{}", stderr(&output));
}
