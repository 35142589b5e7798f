//! Capture files as laboratories report them: what each must give, from the folder `hard/capture` of the corpus.

use std::path::{Path, PathBuf};
use std::process::Command;

use inhand_capture::ReadSettings;
use inhand_import::ImportSettings;
use inhand_model::{Position, Recording, Severity};

use crate::{corpus, inhand, ok, stderr, text};

fn file(corpus: &Path, name: &str) -> PathBuf {
    corpus.join("hard/capture").join(name)
}

fn read_file(path: &Path) -> Recording {
    let bytes = std::fs::read(path).expect("it is there");
    let name = path.file_name().expect("it has a name").to_string_lossy();
    inhand_capture::read(&bytes, &name, &ReadSettings::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

fn read(corpus: &Path, name: &str) -> Recording {
    read_file(&file(corpus, name))
}

fn import_with(corpus: &Path, name: &str, settings: &ImportSettings) -> Result<Recording, String> {
    let bytes = std::fs::read(file(corpus, name)).expect("it is there");
    inhand_import::read_recording(&bytes, name, settings).map_err(|error| error.to_string())
}

fn import(corpus: &Path, name: &str) -> Recording {
    import_with(corpus, name, &ImportSettings::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn findings(recording: &Recording) -> String {
    let lines = recording.findings.iter();
    lines.map(|finding| format!("{finding}\n")).collect()
}

fn has_warning(recording: &Recording) -> bool {
    let mut findings = recording.findings.iter();
    findings.any(|finding| finding.severity == Severity::Warning)
}

/// Labels, and seconds after the first sample.
fn events(recording: &Recording) -> Vec<(String, f64)> {
    let start = recording.clock.start_unix_nanos();
    let events = recording.annotations.events.iter();
    events
        .map(|event| {
            let after_s = (event.start_unix_nanos - start) as f64 / 1e9;
            (event.labels["label"].clone(), after_s)
        })
        .collect()
}

/// The verdict of `check` on a take of which a warning is too much.
#[track_caller]
fn assert_good(path: &Path) {
    ok(&["check", "--fail-on", "warn", text(path)]);
}

#[test]
fn model_outputs_of_a_c3d_file_are_no_markers() {
    let Some(corpus) = corpus() else { return };
    let recording = read(&corpus, "c3d_model_outputs.c3d");
    assert_eq!((recording.markers.len(), recording.len()), (8, 300));
    let found = findings(&recording);
    let outputs: Vec<&str> = found.lines().filter(|f| f.contains("model")).collect();
    let [finding] = outputs[..] else {
        panic!("{found}");
    };
    for name in [
        "RWristAngles",
        "RIndexAngles",
        "RWristForce",
        "RWristMoment",
        "RWristPower",
        "GripScalar",
    ] {
        assert!(finding.contains(name), "{finding}");
        assert!(recording.marker(name).is_none());
    }
    assert_good(&file(&corpus, "c3d_model_outputs.c3d"));
}

#[test]
fn frames_of_a_c3d_file_are_counted_beyond_a_word() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let made = Command::new("python3")
        .arg("-B")
        .arg(corpus.join("hard/make/c3d_long_frames.py"))
        .current_dir(folder.path())
        .status();
    assert!(made.expect("python3 is there").success());
    for name in ["a_long_frames", "b_trial", "c_float_frames"] {
        let recording = read_file(&folder.path().join(name).with_extension("c3d"));
        assert_eq!(recording.len(), 70_000, "{name}");
        assert!(!has_warning(&recording), "{}", findings(&recording));
        let last = recording.markers[0]
            .track
            .get(69_999)
            .map(Position::to_array);
        let x = last.expect("it is measured")[0];
        assert!((x - (0.1 + 69_999e-6)).abs() < 1e-6, "{x}");
    }
    let recording = read_file(&folder.path().join("d_full_word_alone.c3d"));
    assert_eq!(recording.len(), 65_535);
    let found = findings(&recording);
    assert!(
        found.contains("counts 65535 frames of 2 points and has room for 70000"),
        "{found}"
    );
}

#[test]
fn points_without_labels_can_be_chosen_by_number() {
    let Some(corpus) = corpus() else { return };
    let path = file(&corpus, "c3d_no_labels.c3d");
    let refused = inhand(&["check", text(&path)]);
    assert_eq!(refused.status.code(), Some(3));
    let said = String::from_utf8_lossy(&refused.stdout).into_owned();
    assert!(
        said.contains("the markers: 1, 2, 3, 4, 5, 6, 7, 8"),
        "{said}"
    );
    let fingers = ["thumb=1", "index=2", "middle=3", "ring=4", "little=5"];
    let fingers = fingers.iter().flat_map(|finger| ["--finger", finger]);
    let args = ["check", text(&path), "--hand", "6,7,8"]
        .into_iter()
        .chain(fingers);
    let said = ok(&args.collect::<Vec<_>>());
    assert!(said.contains("usable segments: 1 of 1"), "{said}");
}

#[test]
fn events_of_vendor_files_are_events_of_the_take() {
    let Some(corpus) = corpus() else { return };
    let expected = [("grasp".to_owned(), 0.5), ("release".to_owned(), 1.5)];
    for name in ["qualisys_events.tsv", "qualisys_spreadsheet.tsv"] {
        let recording = read(&corpus, name);
        assert_eq!(events(&recording), expected, "{name}");
        assert_eq!(
            (recording.markers.len(), recording.len()),
            (8, 200),
            "{name}"
        );
        assert!(!has_warning(&recording), "{}", findings(&recording));
        assert_good(&file(&corpus, name));
    }
    // At 4 and 5.5 s of a trial whose first frame here is at 184 / 60 s.
    let recording = read(&corpus, "c3d_first_frame_185.c3d");
    let expected = [("Grasp", 4.0), ("Release", 5.5)];
    for ((name, time_s), (expected, at_s)) in events(&recording).iter().zip(expected) {
        assert_eq!(name, expected);
        assert!((time_s - (at_s - 184.0 / 60.0)).abs() < 1e-6, "{time_s}");
    }
    assert_eq!(recording.annotations.events[0].labels["context"], "Right");
    // They are in the file that is made of it.
    let folder = tempfile::tempdir().expect("a folder");
    let take = folder.path().join("take.mcap");
    for (name, first) in [
        ("qualisys_events.tsv", "label=grasp"),
        ("c3d_first_frame_185.c3d", "label=Grasp"),
    ] {
        ok(&[
            "convert",
            text(&file(&corpus, name)),
            "--force",
            "-o",
            text(&take),
        ]);
        let listed = ok(&["annotate", "list", text(&take)]);
        assert!(listed.contains(first), "{listed}");
    }
}

#[test]
fn columns_that_motive_documents_are_no_warning() {
    let Some(corpus) = corpus() else { return };
    let recording = read(&corpus, "motive_timecode.csv");
    assert_eq!((recording.markers.len(), recording.bodies.len()), (5, 1));
    assert_eq!(recording.len(), 200);
    assert!(!has_warning(&recording), "{}", findings(&recording));
    assert_good(&file(&corpus, "motive_timecode.csv"));
}

#[test]
fn a_first_frame_within_its_trial_is_told_alike() {
    let Some(corpus) = corpus() else { return };
    let recording = read(&corpus, "motive_first_frame_1000.csv");
    assert_eq!(
        recording.clock.start_unix_nanos(),
        1_741_079_421_500_000_000
    );
    assert_eq!(recording.len(), 2);
    for name in ["trc_first_frame_185.trc", "c3d_first_frame_185.c3d"] {
        let found = findings(&read(&corpus, name));
        let words = "the first frame is number 185 of its trial: it is at 0 s here";
        assert!(
            found.lines().any(|finding| finding == words),
            "{name}: {found}"
        );
    }
}

#[test]
fn ros_1_messages_in_mcap_are_read() {
    let Some(corpus) = corpus() else { return };
    let recording = import(&corpus, "ros1_poses.mcap");
    assert_eq!((recording.clock.rate_hz(), recording.len()), (100.0, 200));
    assert_eq!(
        recording.clock.start_unix_nanos(),
        1_750_000_000_000_000_000
    );
    assert_eq!((recording.bodies.len(), recording.markers.len()), (1, 5));
    assert_good(&file(&corpus, "ros1_poses.mcap"));
}

/// The positions of `/vrpn_mocap/Hand/pose` in the order in which they were sent, one for each frame: three numbers
/// behind header, stamp and the name "world".
fn sent(corpus: &Path, name: &str) -> Vec<[f64; 3]> {
    let bytes = std::fs::read(file(corpus, name)).expect("it is there");
    let messages = mcap::MessageStream::new(&bytes).expect("the file is sound");
    let messages = messages.map(|message| message.expect("the file is sound"));
    messages
        .filter(|message| message.channel.topic == "/vrpn_mocap/Hand/pose")
        .map(|message| {
            [28, 36, 44].map(|at| {
                let number = message.data[at..at + 8].try_into().expect("eight bytes");
                f64::from_le_bytes(number)
            })
        })
        .collect()
}

fn hand(recording: &Recording) -> Vec<Option<[f64; 3]>> {
    let track = &recording.body("Hand").expect("it is there").track;
    let poses = (0..recording.len()).map(|k| track.get(k));
    poses
        .map(|pose| pose.map(|pose| pose.origin().to_array()))
        .collect()
}

#[test]
fn messages_that_wait_for_the_next_one_are_at_their_own_samples() {
    let Some(corpus) = corpus() else { return };
    let name = "stamps_sometimes_in_pairs_250hz.mcap";
    let recording = import(&corpus, name);
    assert_eq!((recording.clock.rate_hz(), recording.len()), (250.0, 500));
    let sent: Vec<_> = sent(&corpus, name).into_iter().map(Some).collect();
    assert_eq!(hand(&recording), sent);
}

#[test]
fn a_clock_without_samples_is_refused_and_its_remedy_helps() {
    let Some(corpus) = corpus() else { return };
    let name = "stamps_in_pairs_250hz.mcap";
    for verb in ["check", "convert"] {
        let folder = tempfile::tempdir().expect("a folder");
        let (path, take) = (file(&corpus, name), folder.path().join("take.mcap"));
        let args = match verb {
            "check" => vec![verb, text(&path)],
            _ => vec![verb, text(&path), "-o", text(&take)],
        };
        let output = inhand(&args);
        assert_ne!(output.status.code(), Some(0), "{verb}");
        let said = format!(
            "{}{}",
            String::from_utf8_lossy(&output.stdout),
            stderr(&output)
        );
        assert!(said.contains("set source.rate_hz"), "{said}");
        assert!(!take.exists());
    }
    let settings = ImportSettings {
        rate_hz: Some(250.0),
        ..ImportSettings::default()
    };
    let recording = import_with(&corpus, name, &settings).unwrap_or_else(|error| panic!("{error}"));
    // The very first message waited for a sample that is before the take.
    let sent = sent(&corpus, name);
    let expected: Vec<_> = sent[1..].iter().copied().map(Some).collect();
    assert_eq!(hand(&recording), expected);
}

#[test]
fn a_message_for_each_marker_of_a_frame_is_a_frame() {
    let Some(corpus) = corpus() else { return };
    for name in ["message_per_marker.mcap", "message_per_marker_20us.mcap"] {
        let recording = import(&corpus, name);
        assert_eq!(
            (recording.clock.rate_hz(), recording.len()),
            (100.0, 300),
            "{name}"
        );
        assert_eq!(
            recording.clock.start_unix_nanos(),
            1_750_000_000_000_000_000,
            "{name}"
        );
        assert_eq!(recording.markers.len(), 8);
        for marker in &recording.markers {
            assert_eq!(
                marker.track.counts().measured,
                300,
                "{name}: {}",
                marker.name
            );
        }
        assert!(findings(&recording).contains("times are capture times"));
        assert_good(&file(&corpus, name));
    }
}
