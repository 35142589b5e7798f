//! ROS 2 recordings of motion-capture drivers as test takes, against what the readers of others
//! found in them (`reference/ros2.py`).

use std::path::Path;

use inhand_channels::read_take;
use inhand_import::{ImportSettings, read_recording};
use inhand_model::Recording;
use serde_json::Value;

use crate::{corpus, json, ok, text};

const FILES: [&str; 2] = ["mocap4r2.mcap", "pose_stamped.mcap"];

fn reference(file: &str) -> Value {
    let all: Value = serde_json::from_str(include_str!("reference/ros2.json")).expect("JSON");
    all[file].clone()
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list");
    list.iter().map(|n| n.as_f64().expect("a number")).collect()
}

/// Rate, start, samples, which of them are missing, first and last values.
fn assert_as_others_read_it(recording: &Recording, expected: &Value) {
    let clock = recording.clock;
    assert_eq!(numbers(&expected["step_nanos"]), [1e9 / clock.rate_hz()]);
    assert_eq!(
        Some(clock.start_unix_nanos()),
        expected["start_unix_nanos"].as_u64()
    );
    assert_eq!(Some(recording.len() as u64), expected["samples"].as_u64());
    let (markers, bodies) = (&expected["markers"], &expected["bodies"]);
    assert_eq!(
        Some(recording.markers.len()),
        markers.as_object().map(serde_json::Map::len)
    );
    assert_eq!(
        Some(recording.bodies.len()),
        bodies.as_object().map(serde_json::Map::len)
    );
    for marker in &recording.markers {
        let values = marker
            .track
            .iter()
            .map(|at| at.map(|at| at.to_array().to_vec()));
        assert_track(
            &values.collect::<Vec<_>>(),
            &markers[&marker.name],
            &marker.name,
        );
    }
    for body in &recording.bodies {
        let values = body.track.iter().map(|pose| {
            let pose = pose?;
            Some([&pose.origin().to_array()[..], &pose.quaternion_xyzw()].concat())
        });
        assert_track(&values.collect::<Vec<_>>(), &bodies[&body.name], &body.name);
    }
}

fn assert_track(values: &[Option<Vec<f64>>], expected: &Value, name: &str) {
    let missing = (0..values.len()).filter(|&k| values[k].is_none());
    let missing: Vec<f64> = missing.map(|k| k as f64).collect();
    assert_eq!(missing, numbers(&expected["missing"]), "{name}");
    let mut present = values.iter().flatten();
    let (first, last) = (present.next(), present.next_back());
    for (found, key) in [(first, "first"), (last, "last")] {
        let found = found.unwrap_or_else(|| panic!("{name} is never there"));
        let expected = numbers(&expected[key]);
        let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs());
        // Quaternions are normalised.
        assert!(
            off.fold(0.0, f64::max) < 1e-15,
            "{name}: {found:?} {expected:?}"
        );
    }
}

#[test]
fn recordings_of_drivers_are_read_as_others_read_them() {
    let Some(corpus) = corpus() else { return };
    for file in FILES {
        let bytes = std::fs::read(corpus.join("mcap/ros2_mocap").join(file)).expect("it is there");
        let recording = read_recording(&bytes, file, &ImportSettings::default())
            .unwrap_or_else(|error| panic!("{error}"));
        let expected = reference(file);
        assert_as_others_read_it(&recording, &expected);
        let delay = numbers(&expected["delay_nanos"]);
        let told = format!(
            "logged {:.1} to {:.1} ms later",
            delay[0] / 1e6,
            delay[1] / 1e6
        );
        let findings: Vec<String> = recording.findings.iter().map(ToString::to_string).collect();
        assert!(
            findings.iter().any(|f| f.contains(&told)),
            "{told}: {findings:?}"
        );
    }
}

fn session(corpus: &Path, file: &str) -> String {
    let takes = corpus.join("sessions/cube/train");
    let mut settings = String::from("[segments]\nstride = 40\n[learn]\nrank = 30\n");
    settings.push_str("[source]\nup = \"y\"\n[object]\nshape = \"cube:0.05\"\n");
    let mut take = |path: &Path, role: &str| {
        let entry = format!(
            "[[takes]]\npath = \"{}\"\nrole = \"{role}\"\n",
            path.display()
        );
        settings.push_str(&entry);
    };
    for number in 1..=3 {
        take(&takes.join(format!("cube_train_0{number}.csv")), "train");
    }
    take(&corpus.join("mcap/ros2_mocap").join(file), "test");
    settings
}

#[test]
fn they_run_as_test_takes() {
    let Some(corpus) = corpus() else { return };
    for file in FILES {
        let folder = tempfile::tempdir().expect("a folder for temporary files");
        let out = folder.path().join("out");
        let settings = folder.path().join("inhand.toml");
        std::fs::write(&settings, session(&corpus, file)).expect("files can be written");
        ok(&["run", text(folder.path()), "-o", text(&out)]);

        let bytes = std::fs::read(out.join(file)).expect("the take is written");
        let take = read_take(&bytes, file).unwrap_or_else(|error| panic!("{error}"));
        assert_as_others_read_it(&take.recording, &reference(file));

        let evaluation = json(&out.join("evaluation.json"));
        let test = &evaluation["session"]["test"][0];
        assert_eq!(
            (&test["samples"], &test["left_out"]),
            (&2000.into(), &0.into()),
            "{test}"
        );
        assert!(test["segments"].as_u64().is_some_and(|n| n >= 15), "{test}");
        let p50 = |name: &str| {
            let methods = evaluation["methods"].as_array().expect("a list of methods");
            let method = methods
                .iter()
                .find(|m| m["name"] == name)
                .expect("the method");
            method["error_mm"]["all"]["p50"].as_f64().expect("a number")
        };
        // The take moves as the training takes do: what learns is nearer than a straight line, and
        // no error is larger than motion within a second.
        let (line, learned) = (p50("line"), p50("residual"));
        assert!(
            learned < 0.8 * line && learned > 0.01 && line < 3.0,
            "{learned} {line}"
        );
    }
}
