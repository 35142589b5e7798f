//! Takes and methods over each other.

use std::collections::{BTreeMap, BTreeSet};

use inhand_channels::TakeFile;
use inhand_container::{ContainerError, Depth, Record, walk};
use inhand_model::{Finger, PointTrack};
use serde_json::Value;

use crate::support::{Bench, stderr};

const TAKE: &str = "session/test/cube_test_01.csv";

fn overlay(bench: &Bench, args: &[&str]) -> Value {
    let fixed = ["-o", "o.mcap", "--force", "--format", "json"];
    let printed = bench.ok(&[&["overlay"][..], args, &fixed].concat());
    serde_json::from_str(&printed).expect("the command prints JSON")
}

fn names(overlaid: &Value) -> Vec<&str> {
    let layers = overlaid["layers"].as_array().expect("there are layers");
    (layers.iter())
        .map(|layer| layer["name"].as_str().expect("layers have names"))
        .collect()
}

/// n, median and p95 of each finger.
fn distances(layer: &Value) -> Vec<(u64, f64, f64)> {
    (Finger::ALL.iter())
        .map(|finger| {
            let of = &layer["distance"][finger.name()];
            let number = |key: &str| of[key].as_f64().unwrap_or(f64::NAN);
            let n = of["n"].as_u64().expect("n is a number");
            (n, number("median_mm"), number("p95_mm"))
        })
        .collect()
}

/// Topics of the overlay. Every frame that a channel names hangs at one root.
fn topics(bench: &Bench, name: &str) -> Vec<String> {
    let info = inhand_channels::info(&bench.bytes(name), name).expect("the file is sound");
    assert!(info.problem.is_none() && info.has_summary);
    let edges: Vec<(String, String)> = (info.frames.iter())
        .map(|edge| (edge.parent.clone(), edge.child.clone()))
        .collect();
    let roots: BTreeSet<&String> = (edges.iter())
        .map(|(parent, _)| parent)
        .filter(|parent| !edges.iter().any(|(_, child)| child == *parent))
        .collect();
    assert_eq!(roots.len(), 1, "{edges:?}");
    for channel in &info.channels {
        let Some(frame) = channel.metadata.get("frame") else {
            continue;
        };
        let known = edges.iter().any(|(_, child)| child == frame);
        assert!(known, "{}: {frame} is not in {edges:?}", channel.topic);
    }
    info.channels
        .into_iter()
        .map(|channel| channel.topic)
        .collect()
}

fn refused(bench: &Bench, args: &[&str], code: i32, expected: &str) {
    let output = bench.inhand(&[&["overlay"], args, &["-o", "no.mcap"]].concat());
    assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
    assert!(stderr(&output).contains(expected), "{}", stderr(&output));
    assert!(!bench.path("no.mcap").exists());
}

/// Bytes of messages that are there for viewers, and of all others.
fn view_bytes(bytes: &[u8]) -> (usize, usize) {
    let (mut views, mut data) = (0, 0);
    let mut topics = BTreeMap::new();
    walk("o.mcap", bytes, Depth::Everything, |record| {
        match record {
            Record::Channel(channel) => {
                topics.insert(channel.id, channel.topic);
            }
            Record::Message {
                header,
                data: message,
            } => {
                let topic = &topics[&header.channel_id];
                let drawn = topic.starts_with("/view/") || topic.starts_with("/tf");
                *(if drawn { &mut views } else { &mut data }) += message.len();
            }
            _ => {}
        }
        Ok::<(), ContainerError>(())
    })
    .expect("the output is sound");
    (views, data)
}

/// Two processed takes, and a stretch of the first.
fn processed() -> Bench {
    let bench = Bench::csv();
    for (source, take) in [
        (TAKE, "a.mcap"),
        ("session/train/cube_train_01.csv", "b.mcap"),
    ] {
        bench.ok(&["process", source, "-o", take, "--object", "cube:0.05"]);
    }
    bench.ok(&[
        "cut", "a.mcap", "--from", "2", "--to", "9", "-o", "cut.mcap",
    ]);
    bench
}

#[test]
fn methods_of_a_run_are_as_far_from_the_recording_as_its_evaluation_says() {
    let bench = Bench::csv();
    bench.run("run", &["--take-methods", "all"]);
    let take = "run/cube_test_01.mcap";
    let overlaid = overlay(&bench, &[take, "--methods", "prior,hermite"]);
    assert_eq!(names(&overlaid), ["recorded", "prior", "hermite"]);
    assert_eq!(overlaid["frame"], "hand");
    let judged = inhand_channels::read_evaluated(&bench.bytes(take), take).expect("it is judged");
    for layer in &overlaid["layers"].as_array().expect("layers")[1..] {
        let method = judged.iter().find(|m| layer["name"] == m.name.as_str());
        let method = method.expect("the method was judged");
        for (finger, (n, median_mm, _)) in Finger::ALL.into_iter().zip(distances(layer)) {
            let mut errors: Vec<f64> = (method.samples.iter())
                .filter_map(|sample| Some(sample.error_m?[finger] * 1e3))
                .collect();
            errors.sort_by(f64::total_cmp);
            assert_eq!(n as usize, errors.len());
            let middle = [errors[(errors.len() - 1) / 2], errors[errors.len() / 2]];
            let expected = f64::midpoint(middle[0], middle[1]);
            assert!((median_mm - expected).abs() < 1e-6, "{finger}: {median_mm}");
        }
    }
    let topics = topics(&bench, "o.mcap");
    for topic in [
        "/tf",
        "/tf_static",
        "/view/object",
        "/overlay/recorded/fingertips",
        "/overlay/prior/distance",
        "/view/overlay/legend",
        "/view/overlay/hermite/fingertips",
        "/view/overlay/hermite/fingertip_balls",
        "/view/overlay/hermite/fingertips_scene",
    ] {
        assert!(topics.iter().any(|t| t == topic), "{topic}: {topics:?}");
    }
    assert!(!topics.contains(&"/overlay/recorded/distance".to_owned()));
    let colours: BTreeSet<String> = (overlaid["layers"].as_array().expect("layers").iter())
        .map(|layer| layer["colour"].to_string())
        .collect();
    assert_eq!(colours.len(), 3);

    let (views, data) = view_bytes(&bench.bytes("o.mcap"));
    assert!(views <= 2 * data, "{views} bytes of views, {data} of data");

    // Another setting on the same take: what was recorded is shown once.
    bench.run("other", &["--sigma-mm", "2", "--take-methods", "all"]);
    let other = "other/cube_test_01.mcap";
    let two = overlay(&bench, &[take, other, "--methods", "prior"]);
    assert_eq!(two["align"], "clock");
    assert_eq!(
        names(&two),
        [
            "run_cube_test_01",
            "run_cube_test_01_prior",
            "other_cube_test_01_prior"
        ]
    );
    let all = overlay(&bench, &[take, "--methods", "all"]);
    assert!(names(&all).len() > 5);
    refused(&bench, &[take, other, "--methods", "magic"], 2, "prior");
    refused(&bench, &[take], 2, "--methods");
    refused(&bench, &[take, "run/dictionary.mcap"], 1, "a dictionary");
}

#[test]
fn a_stretch_of_a_take_lies_where_it_was_cut() {
    let bench = processed();
    let by_clock = overlay(&bench, &["a.mcap", "cut.mcap"]);
    assert_eq!(
        (&by_clock["align"], &by_clock["frame"]),
        (&"clock".into(), &"hand".into())
    );
    for (n, median_mm, p95_mm) in distances(&by_clock["layers"][1]) {
        assert!(
            n > 600 && median_mm < 1e-9 && p95_mm < 1e-9,
            "{n} {median_mm}"
        );
    }
    let object = "/view/overlay/cut/object".to_owned();
    let shown = topics(&bench, "o.mcap");
    assert!(shown.contains(&object) && shown.contains(&"/view/overlay/cut/tf".to_owned()));

    let by_start = overlay(&bench, &["a.mcap", "cut.mcap", "--align", "start"]);
    assert_eq!(by_start["layers"][1]["offset_s"], -2.0);
    assert!(distances(&by_start["layers"][1])[0].1 > 0.1);

    // The same event in both puts the stretch back, wherever its clock is.
    for take in ["a", "cut"] {
        let (from, to) = (format!("{take}.mcap"), format!("{take}_e.mcap"));
        let at = if take == "a" { "4" } else { "2" };
        bench.ok(&[
            "annotate",
            "add",
            &from,
            "-o",
            &to,
            "--at",
            at,
            "--label",
            "task=turn",
        ]);
    }
    let by_event = overlay(&bench, &["a_e.mcap", "cut_e.mcap", "--event", "task=turn"]);
    assert_eq!(by_event["align"], "event task=turn");
    assert!(distances(&by_event["layers"][1])[0].1 < 1e-9);
    let args = ["a_e.mcap", "b.mcap", "--event", "task=turn"];
    refused(&bench, &args, 1, "b.mcap: no event task=turn");
    let metadata = inhand_channels::read_metadata(&bench.bytes("o.mcap"), "o").expect("sound");
    let about = &metadata.0["inhand.overlay"];
    assert_eq!(about["align"], "event task=turn");
    let layers: Value = serde_json::from_str(&about["layers"]).expect("JSON");
    assert_eq!(layers[1]["offset_nanos"], "0");
}

#[test]
fn different_takes_begin_together_and_unprocessed_ones_are_in_the_world() {
    let bench = processed();
    let output = bench.inhand(&["overlay", "a.mcap", "b.mcap", "-o", "o.mcap"]);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("by the start"), "{said}");
    let printed = String::from_utf8(output.stdout).expect("text");
    assert!(
        printed.contains("distance to a (mm)") && printed.contains("little"),
        "{printed}"
    );

    let mixed = overlay(
        &bench,
        &["a.mcap", TAKE, "--name", "processed", "--name", "measured"],
    );
    assert_eq!(mixed["frame"], "world");
    assert_eq!(names(&mixed), ["processed", "measured"]);
    for (n, median_mm, _) in distances(&mixed["layers"][1]) {
        assert!(n > 1000 && median_mm == 0.0, "{n} {median_mm}");
    }
    let shown = topics(&bench, "o.mcap");
    assert!(shown.contains(&"/tf".to_owned()), "{shown:?}");

    refused(&bench, &["a.mcap", "./a.mcap"], 2, "twice");
    refused(&bench, &["a.mcap", "b.mcap", "--name", "a b"], 2, "letters");
    refused(&bench, &["a.mcap", "gone.mcap"], 1, "gone.mcap");
    let onto = bench.inhand(&["overlay", "a.mcap", "b.mcap", "-o", "a.mcap", "--force"]);
    assert_eq!(onto.status.code(), Some(2), "{}", stderr(&onto));
    // Cuts of one take that share no instant.
    bench.ok(&["cut", "a.mcap", "--to", "1.5", "-o", "before.mcap"]);
    refused(&bench, &["cut.mcap", "before.mcap"], 1, "--align start");
    overlay(&bench, &["cut.mcap", "before.mcap", "--align", "start"]);
}

#[test]
fn one_finger_is_compared_and_nothing_at_all_is_refused() {
    let bench = Bench::csv();
    bench.ok(&["convert", TAKE, "-o", "a.mcap"]);
    let read = inhand_channels::read_take(&bench.bytes("a.mcap"), "a").expect("a take");
    let roles = read.roles.clone().expect("fingers are known");
    let with = |fingers: &[Finger], samples: usize, name: &str| {
        let mut recording = read.recording.slice(0..samples);
        for (finger, marker) in roles.fingers.iter() {
            let mut markers = recording.markers.iter_mut();
            let marker = markers
                .find(|m| m.name == *marker)
                .expect("the marker is there");
            if !fingers.contains(&finger) {
                marker.track = PointTrack::missing(samples);
            }
        }
        let file = TakeFile {
            roles: Some(&roles),
            ..TakeFile::new(&recording)
        };
        let mut bytes = Vec::new();
        inhand_channels::write_take(&mut bytes, &file, inhand_channels::Views::All)
            .expect("it is written");
        bench.write(name, bytes);
    };
    with(&[Finger::Ring], 900, "ring.mcap");
    with(&[], 900, "none.mcap");
    with(&Finger::ALL, 0, "empty.mcap");
    let ring = overlay(&bench, &["a.mcap", "ring.mcap", "--align", "clock"]);
    let counts: Vec<u64> = (distances(&ring["layers"][1]).iter())
        .map(|(n, ..)| *n)
        .collect();
    assert!(
        counts[3] > 800 && counts.iter().sum::<u64>() == counts[3],
        "{counts:?}"
    );
    assert_eq!(
        ring["layers"][1]["distance"]["thumb"]["median_mm"],
        Value::Null
    );
    topics(&bench, "o.mcap");
    refused(&bench, &["a.mcap", "none.mcap"], 1, "no fingertip");
    refused(&bench, &["a.mcap", "empty.mcap"], 1, "no samples");
}
