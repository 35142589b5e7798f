//! ROS 2 bags as outputs: of `convert --ros2`, and of what adds to a bag.

use std::collections::BTreeMap;

use inhand_import::{ImportSettings, read_recording, read_take};
use inhand_model::{Pose, Recording, Status};
use serde_json::Value;

use super::bag::Bag;
use super::{as_poses, recorded};
use crate::support::{Bench, stderr};

/// Topics with their messages of a file in which everything is as ROS 2 tools need it.
fn ros2_topics(bench: &Bench, name: &str) -> BTreeMap<String, u64> {
    let bytes = bench.bytes(name);
    let mut source =
        inhand_container::Source::open(name, std::io::Cursor::new(&bytes)).expect("MCAP");
    assert!(
        inhand_channels::is_ros2(&mut source).expect("sound"),
        "{name}: profile"
    );
    let summary = mcap::Summary::read(&bytes)
        .expect("a file")
        .expect("a summary");
    let counts = summary.stats.expect("statistics").channel_message_counts;
    let topic = |(id, channel): (&u16, &std::sync::Arc<mcap::Channel<'_>>)| {
        assert_eq!(channel.message_encoding, "cdr", "{name}: {}", channel.topic);
        let schema = channel.schema.as_ref().expect("a schema");
        assert_eq!(schema.encoding, "ros2msg", "{name}: {}", channel.topic);
        (channel.topic.clone(), counts.get(id).copied().unwrap_or(0))
    };
    summary.channels.iter().map(topic).collect()
}

/// The take with a hole in its first marker and its first body.
fn with_holes(bench: &Bench) -> Recording {
    let mut take = recorded(bench);
    for k in 300..340 {
        take.markers[0].track.set(k, None, Status::Missing);
        take.bodies[0].track.set(k + 7, None, Status::Missing);
    }
    let mut csv = Vec::new();
    inhand_capture::motive::write(&take, &mut csv).expect("a take can be written");
    bench.write("take.csv", csv);
    take
}

#[test]
fn a_take_becomes_a_bag_and_comes_back() {
    let bench = Bench::csv();
    let take = with_holes(&bench);
    let output = bench.inhand(&["convert", "take.csv", "--ros2", "-o", "bag"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("ROS 2 bag"), "{}", stderr(&output));

    let topics = ros2_topics(&bench, "bag/take_0.mcap");
    let yaml = String::from_utf8(bench.bytes("bag/metadata.yaml")).expect("text");
    let messages: u64 = topics.values().sum();
    for words in [
        "storage_identifier: mcap",
        "- \"take_0.mcap\"",
        &format!("message_count: {messages}\n"),
    ] {
        assert!(yaml.contains(words), "{words}: {yaml}");
    }

    let bag = bench.bytes("bag/take_0.mcap");
    let back = read_recording(&bag, "bag.mcap", &ImportSettings::default()).expect("a take");
    assert_eq!((back.clock, back.len()), (take.clock, take.len()));
    let name = |name: &str| name.replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    assert_eq!(back.markers.len(), take.markers.len());
    assert_eq!(back.bodies.len(), take.bodies.len());
    for marker in &take.markers {
        let found = back.marker(&name(&marker.name)).expect("the marker");
        assert!(
            marker.track.iter().eq(found.track.iter()),
            "{}",
            marker.name
        );
        let seen = marker.track.iter().flatten().count() as u64;
        assert_eq!(topics[&format!("/{}/point", name(&marker.name))], seen);
    }
    for body in &take.bodies {
        let found = back.body(&name(&body.name)).expect("the body");
        for (a, b) in body.track.iter().zip(found.track.iter()) {
            assert_eq!(a.map(Pose::origin), b.map(Pose::origin), "{}", body.name);
            let turned = a
                .zip(b)
                .map(|(a, b)| a.isometry().rotation.angle_to(&b.isometry().rotation));
            assert!(turned.is_none_or(|angle| angle < 1e-7), "{}", body.name);
        }
    }
    // Roles are found as in the take itself, and the identical call may be repeated.
    bench.ok(&["process", "bag/take_0.mcap", "-o", "processed.mcap"]);
    bench.ok(&["convert", "take.csv", "--ros2", "-o", "bag"]);
    let output = bench.inhand(&["convert", "take.csv", "--ros2", "--views=none", "-o", "bag"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
}

#[test]
fn generated_motion_leaves_as_trajectories() {
    let bench = Bench::csv();
    bench.run("out", &["--methods", "residual,line"]);
    bench.ok(&[
        "convert",
        "out/cube_test_01.mcap",
        "--ros2",
        "-o",
        "bag.mcap",
    ]);
    let topics = ros2_topics(&bench, "bag.mcap");
    let evaluation = bench.json("out/evaluation.json");
    let segments = evaluation["session"]["test"][0]["segments"].as_u64();
    for method in ["residual", "line"] {
        let trajectories = topics[&format!("/generated/{method}/trajectory")];
        assert_eq!(Some(trajectories), segments, "{method}");
    }
    // The steps of the take stay, and the bag is one that is read.
    let steps = |name: &str| {
        let metadata = inhand_channels::read_metadata(&bench.bytes(name), name).expect("sound");
        let steps = metadata.provenance(name).expect("ours").into_iter();
        steps.map(|step| step.step).collect::<Vec<_>>()
    };
    let earlier = steps("out/cube_test_01.mcap");
    assert!(!earlier.is_empty());
    assert_eq!(
        steps("bag.mcap"),
        [&earlier[..], &["ros2".to_owned()]].concat()
    );
    bench.ok(&["convert", "bag.mcap", "-o", "back.mcap"]);
    let chain = [&earlier[..], &["ros2", "convert"].map(str::to_owned)].concat();
    assert_eq!(steps("back.mcap"), chain);
    let plan = [
        "plan",
        "--dictionary",
        "out/dictionary.mcap",
        "--from",
        "out/cube_test_01.mcap@2.0",
        "--to",
        "out/cube_test_01.mcap@3.5",
        "--duration",
        "2",
        "--allow-miss",
        "-o",
        "plan.mcap",
    ];
    bench.ok(&plan);
    for what in ["recorded", "measured"] {
        let call = ["export", "plan.mcap", "-o", "plan.csv", "--what", what];
        let output = bench.inhand(&call);
        assert_eq!(output.status.code(), Some(1), "{what}");
        let said = stderr(&output);
        assert!(
            said.contains("nothing was recorded in it: --what generated"),
            "{said}"
        );
        assert!(!bench.path("plan.csv").exists(), "{what}");
    }
    bench.ok(&["convert", "plan.mcap", "--ros2", "-o", "plan"]);
    let topics = ros2_topics(&bench, "plan/plan_0.mcap");
    let mut generated = topics
        .iter()
        .filter(|(topic, _)| topic.starts_with("/generated/"));
    // Several segments of a plan are one motion.
    assert_eq!(
        generated.next().map(|(_, &messages)| messages),
        Some(1),
        "{topics:?}"
    );
    assert!(
        topics["/markers"] > 50 && topics["/tf_static"] == 1,
        "{topics:?}"
    );
}

#[test]
fn a_bag_with_views_and_events_is_a_bag() {
    let bench = Bench::csv();
    let bag = as_poses(&recorded(&bench), |name| {
        format!("/mocap/{}/pose", name.replace(':', "_"))
    });
    bench.write("bag.mcap", &bag);
    let said = |args: &[&str]| {
        let output = bench.inhand(args);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stderr(&output)
    };
    let event = ["--at", "1..2", "--label", "slip", "--label", "finger=index"];
    let text = said(&[&["annotate", "add", "bag.mcap", "-o", "a.mcap"], &event[..]].concat());
    assert!(text.contains("std_msgs/msg/String"), "{text}");
    let text = said(&["view", "a.mcap", "-o", "v.mcap", "--object", "cube:0.05"]);
    assert!(
        text.contains("visualization_msgs/msg/MarkerArray"),
        "{text}"
    );
    said(&[
        "view",
        "v.mcap",
        "-o",
        "again.mcap",
        "--object",
        "cube:0.05",
    ]);
    said(&[
        "cut",
        "v.mcap",
        "--from",
        "1.5",
        "--to",
        "4",
        "-o",
        "part.mcap",
    ]);
    for name in ["a.mcap", "v.mcap", "again.mcap", "part.mcap"] {
        let topics = ros2_topics(&bench, name);
        assert_eq!(topics["/annotations"], 1, "{name}");
        let listed = bench.ok(&["annotate", "list", name, "--format", "json"]);
        let listed: Value = serde_json::from_str(&listed).expect("JSON");
        assert_eq!(listed["events"][0]["labels"]["finger"], "index", "{name}");
        assert_eq!(listed["events"].as_array().map(Vec::len), Some(1), "{name}");
    }
    let views = |name| ros2_topics(&bench, name)["/view/markers"];
    assert_eq!((views("v.mcap"), views("again.mcap")), (600, 600));

    let read =
        |bytes: &[u8]| read_take(bytes, "bag.mcap", &ImportSettings::default()).expect("a take");
    let (before, after) = (read(&bag), read(&bench.bytes("again.mcap")));
    assert_eq!(after.annotations.events.len(), 1);
    let tracks = |recording: &Recording| {
        let tracks = recording
            .markers
            .iter()
            .map(|marker| format!("{:?}", marker.track));
        tracks.collect::<Vec<_>>()
    };
    assert_eq!(tracks(&before.recording), tracks(&after.recording));
    said(&[
        "annotate",
        "remove",
        "again.mcap",
        "--event",
        "1",
        "-o",
        "none.mcap",
    ]);
    assert!(!ros2_topics(&bench, "none.mcap").contains_key("/annotations"));
}

#[test]
fn third_party_texts_on_the_topic_of_events_are_kept() {
    let bench = Bench::empty();
    let mut bag = Bag::new();
    let pose = bag.channel("/Hand/pose", "geometry_msgs/msg/PoseStamped");
    for k in 0..200 {
        let at = 1_700_000_000_000_000_000 + k * 10_000_000;
        bag.message(
            pose,
            at,
            &super::bag::pose(at, [0.1, 0.2, k as f64 / 1e3], [1.0, 0.0, 0.0, 0.0]),
        );
    }
    let text = bag.channel("/annotations", "std_msgs/msg/String");
    bag.message(
        text,
        1_700_000_000_000_000_000,
        b"\0\x01\0\0\x06\0\0\0hello\0",
    );
    bench.write("bag.mcap", bag.end());
    let output = bench.inhand(&["convert", "bag.mcap", "-o", "take.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let output = bench.inhand(&[
        "annotate", "add", "bag.mcap", "--at", "1", "--label", "a", "-o", "b.mcap",
    ]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("/annotations"),
        "{}",
        stderr(&output)
    );
}

/// A call that is refused as wrong, with these words.
fn refused(bench: &Bench, call: &[&str], words: &str) {
    let output = bench.inhand(call);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{call:?}: {said}");
    assert!(said.contains(words), "{call:?}: {said}");
}

#[test]
fn no_bag_is_written_over() {
    let bench = Bench::csv();
    with_holes(&bench);
    bench.ok(&["convert", "take.csv", "--ros2", "-o", "own"]);
    let facts = bench.bytes("own/metadata.yaml");
    bench.write("other.csv", bench.bytes("take.csv"));
    let other = ["convert", "other.csv", "--ros2", "-o", "own"];
    refused(
        &bench,
        &other,
        "own/metadata.yaml: already exists; use --force",
    );
    assert_eq!(bench.files("own"), ["metadata.yaml", "take_0.mcap"]);
    assert_eq!(bench.bytes("own/metadata.yaml"), facts);
    bench.ok(&[&other[..], &["--force"]].concat());
    assert_ne!(bench.bytes("own/metadata.yaml"), facts);

    // A bag that is read stays whole, whichever of its files an output would be.
    bench.ok(&["convert", "take.csv", "--ros2", "-o", "take"]);
    let [facts, bag] = ["take/metadata.yaml", "take/take_0.mcap"].map(|name| bench.bytes(name));
    bench.write("bag/metadata.yaml", &facts);
    bench.write("bag/take_0.mcap", &bag);
    for call in [
        &["convert", "take", "--ros2", "-o", "take"][..],
        &["convert", "take", "--ros2", "-o", "take/take_0.mcap"],
        &["convert", "bag", "--ros2", "-o", "bag"],
        &["convert", "take", "-o", "take/take_0.mcap"],
        &["process", "take", "-o", "take/take_0.mcap"],
    ] {
        refused(&bench, &[call, &["--force"]].concat(), "also an input");
    }
    for folder in ["bag", "take"] {
        assert_eq!(bench.files(folder), ["metadata.yaml", "take_0.mcap"]);
        assert!(bench.bytes(&format!("{folder}/metadata.yaml")) == facts);
        assert!(bench.bytes(&format!("{folder}/take_0.mcap")) == bag);
    }
}

#[test]
fn outputs_of_bags_are_named_as_takes_are() {
    let bench = Bench::csv();
    with_holes(&bench);
    bench.ok(&["convert", "take.csv", "--ros2", "-o", "BAG.MCAP"]);
    assert!(bench.path("BAG.MCAP").is_file());
    refused(
        &bench,
        &["convert", "take.csv", "--ros2", "-o", "q.foo"],
        "ends in .mcap, or a folder",
    );
    assert!(!bench.path("q.foo").exists());
    std::fs::create_dir(bench.path("q.foo")).expect("a folder can be made");
    bench.ok(&["convert", "take.csv", "--ros2", "-o", "q.foo"]);
    assert_eq!(bench.files("q.foo"), ["metadata.yaml", "take_0.mcap"]);
    bench.write(
        "packed.mcap.zstd",
        super::folders::zstd(&bench.bytes("BAG.MCAP")),
    );
    bench.ok(&["convert", "packed.mcap.zstd", "--ros2", "-o", "unpacked"]);
    assert_eq!(bench.files("unpacked"), ["metadata.yaml", "packed_0.mcap"]);
    bench.ok(&["convert", "q.foo", "--ros2", "-o", "again"]);
    assert_eq!(bench.files("again"), ["metadata.yaml", "q.foo_0.mcap"]);
}
