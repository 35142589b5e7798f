//! Every vendor file of the corpus against what another reader found in it: see
//! `tests/reference/real_files.py`.

use std::path::Path;

use inhand_channels::{ReadTake, read_take};
use inhand_model::{Sample, Status, Track};
use serde_json::Value;

use crate::{corpus, inhand, ok, stderr, text};

const REFERENCE: &str = include_str!("../reference/real_files.json");

/// Files that cannot be read as they are: what is missing, as the message must say it.
const REFUSED: [(&str, &[&str]); 2] = [
    (
        "motive/v1.22_euler_rigid-body-motion.csv",
        &[
            "\"Rotation Type\"",
            "--rotation-order",
            "\"Length Units\"",
            "--units",
        ],
    ),
    (
        "motive/LICENSE.olin.txt",
        &["not a capture file", "found \""],
    ),
];

/// Words of findings that a file must have.
const DOUBTS: [(&str, &[&str]); 8] = [
    (
        "motive/v1_olin.csv",
        &[
            "250 Hz by its time stamps",
            "nothing identifies",
            "no start time",
        ],
    ),
    (
        "motive/v1.1_olin.csv",
        &["120 Hz by its time stamps", "mean errors"],
    ),
    ("motive/v1.22_euler_rigid-body-motion.csv", &[]),
    ("motive/v1.23_empty_ha5dzs.csv", &[]),
    ("motive/v1.23_gaps_aolab.csv", &[]),
    (
        "motive/v1.23_quality_parse_optitrack_csv.csv",
        &["no half of the day"],
    ),
    (
        "motive/v1.23_trimmed_aolab.csv",
        &["the time column says 0.500000 s"],
    ),
    ("hand/recording.tsv", &["filled samples of middle_tip"]),
];

/// Twelve digits are recorded; sums of rotations may differ in the last bits.
const TOLERANCE: f64 = 1e-11;

fn reference() -> serde_json::Map<String, Value> {
    match serde_json::from_str(REFERENCE) {
        Ok(Value::Object(files)) => files,
        other => panic!("the reference is no object: {other:?}"),
    }
}

#[test]
fn every_file_holds_what_another_reader_found() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().unwrap();
    for (file, expected) in reference() {
        let output = folder.path().join("take.mcap");
        let options = expected["options"].as_array().expect("options are a list");
        let options = options
            .iter()
            .map(|option| option.as_str().expect("options are text"));
        let input = corpus.join("real").join(&file);
        let mut args = vec!["convert", text(&input), "-o", text(&output), "--force"];
        args.extend(options);
        ok(&args);
        let take = read_take(&std::fs::read(&output).unwrap(), &file).unwrap();
        assert_take(&file, &take, &expected);
    }
}

fn assert_take(file: &str, take: &ReadTake, expected: &Value) {
    let recording = &take.recording;
    assert_eq!(expected["samples"], recording.len(), "{file}");
    assert_eq!(expected["rate_hz"], recording.clock.rate_hz(), "{file}");
    let start = expected["start_unix_nanos"].as_u64().expect("nanoseconds");
    assert_eq!(start, recording.clock.start_unix_nanos(), "{file}: start");

    let list = |key: &str| {
        expected[key]
            .as_array()
            .expect("a list of entities")
            .clone()
    };
    let (markers, bodies) = (list("markers"), list("bodies"));
    assert_eq!(markers.len(), recording.markers.len(), "{file}: markers");
    for (expected, found) in markers.iter().zip(&recording.markers) {
        let place = format!("{file}: marker {} {}", found.name, found.kind.name());
        assert_eq!(expected["name"], found.name, "{place}");
        assert_eq!(expected["kind"], found.kind.name(), "{place}");
        assert_track(&place, expected, &found.track, |p| p.to_array().to_vec());
    }
    assert_eq!(bodies.len(), recording.bodies.len(), "{file}: bodies");
    for (expected, found) in bodies.iter().zip(&recording.bodies) {
        let place = format!("{file}: body {}", found.name);
        assert_eq!(expected["name"], found.name, "{place}");
        assert_eq!(expected["kind"], found.kind.name(), "{place}");
        assert_track(&place, expected, &found.track, |pose| {
            [&pose.origin().to_array()[..], &pose.quaternion_xyzw()].concat()
        });
    }
}

fn assert_track<T: Sample>(
    place: &str,
    expected: &Value,
    track: &Track<T>,
    numbers: impl Fn(T) -> Vec<f64>,
) {
    let gaps = track.gaps();
    assert_eq!(
        expected["present"],
        track.counts().measured,
        "{place}: present"
    );
    assert_eq!(expected["gaps"], gaps.len(), "{place}: gaps");
    let longest = gaps.iter().map(ExactSizeIterator::len).max().unwrap_or(0);
    assert_eq!(expected["longest_gap"], longest, "{place}: longest gap");
    let statuses = track.statuses();
    let is_there = |status: &Status| status.is_present();
    for (key, at) in [
        ("first", statuses.iter().position(is_there)),
        ("last", statuses.iter().rposition(is_there)),
    ] {
        let Some(k) = at else {
            assert!(expected[key].is_null(), "{place}: {key}");
            continue;
        };
        assert_eq!(expected[key][0], k, "{place}: {key}");
        let found = numbers(track.get(k).expect("the sample is there"));
        let expected: Vec<f64> = (expected[key][1].as_array().expect("a list").iter())
            .map(|number| number.as_f64().expect("a number"))
            .collect();
        assert_eq!(found.len(), expected.len(), "{place}: {key}");
        let off = |sign: f64, range: std::ops::Range<usize>| {
            range
                .map(|n| (found[n] - sign * expected[n]).abs())
                .fold(0.0, f64::max)
        };
        // A quaternion and its negative are one rotation.
        let rotation = 3..found.len();
        let turned = off(1.0, rotation.clone()).min(off(-1.0, rotation));
        assert!(
            off(1.0, 0..3) < TOLERANCE && turned < TOLERANCE,
            "{place}: {key}: {found:?} for {expected:?}"
        );
    }
}

#[test]
fn no_file_is_forgotten() {
    let Some(corpus) = corpus() else { return };
    let known = reference();
    let real = corpus.join("real");
    for folder in ["motive", "hand"] {
        for entry in std::fs::read_dir(real.join(folder)).unwrap() {
            let name = entry.unwrap().file_name().to_string_lossy().into_owned();
            let file = format!("{folder}/{name}");
            assert!(
                name.starts_with("LICENSE") || known.contains_key(&file),
                "{file}"
            );
        }
    }
}

#[test]
fn what_cannot_be_read_says_why_and_leaves_nothing() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("out.mcap");
    for (file, words) in REFUSED {
        let input = corpus.join("real").join(file);
        let output = inhand(&["convert", text(&input), "-o", text(&target)]);
        assert_eq!(output.status.code(), Some(1), "{file}");
        let message = stderr(&output);
        for word in words {
            assert!(message.contains(word), "{file}: {message}");
        }
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            0,
            "{file}"
        );
    }
}

#[test]
fn doubts_are_said() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().unwrap();
    let known = reference();
    for (file, words) in DOUBTS {
        let findings = findings(&corpus, folder.path(), file, &known[file]);
        for word in words {
            assert!(findings.contains(word), "{file}: {findings}");
        }
        assert_eq!(words.is_empty(), findings.is_empty(), "{file}: {findings}");
    }
}

fn findings(corpus: &Path, folder: &Path, file: &str, expected: &Value) -> String {
    let output = folder.join("take.mcap");
    let input = corpus.join("real").join(file);
    let mut args = vec![
        "convert",
        text(&input),
        "-o",
        text(&output),
        "--force",
        "--views=none",
    ];
    let options = expected["options"].as_array().expect("options are a list");
    args.extend(options.iter().filter_map(Value::as_str));
    ok(&args);
    let take = read_take(&std::fs::read(&output).unwrap(), file).unwrap();
    let findings: Vec<String> = take
        .recording
        .findings
        .iter()
        .map(ToString::to_string)
        .collect();
    findings.join("\n")
}
