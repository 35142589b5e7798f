//! `inhand verify`: sound results have no difference, each change of one thing is named.

use inhand_channels::{ReadTake, TakeFile, Views, read_take, write_take};
use inhand_model::Position;
use serde_json::Value;

use crate::support::{Bench, SMALL, stderr};

const TAKE: &str = "out/cube_test_01.mcap";

fn verified(bench: &Bench, args: &[&str], code: i32) -> Value {
    let output = bench.inhand(&[&["verify"], args, &["--format", "json"]].concat());
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(
        output.status.code(),
        Some(code),
        "{text}{}",
        stderr(&output)
    );
    serde_json::from_str(&text).expect("the command prints JSON")
}

/// Places of the differences of all files.
fn places(found: &Value) -> Vec<String> {
    let files = found["files"].as_array().expect("a list of files").iter();
    let differences = files.flat_map(|file| file["differences"].as_array().into_iter().flatten());
    differences
        .map(|own| own["place"].as_str().unwrap_or_default().to_owned())
        .collect()
}

fn is_named(found: &Value, part: &str) {
    let places = places(found);
    assert!(
        places.iter().any(|own| own.contains(part)),
        "{part}: {places:?}"
    );
}

fn with_results() -> Bench {
    let bench = Bench::csv();
    bench.run("out", &["--takes", "all", "--views", "all"]);
    bench
}

#[test]
fn results_of_a_run_have_no_difference_and_each_change_is_named() {
    let bench = with_results();
    let inputs = ["--inputs", "session"];
    let found = verified(&bench, &[&["out"], &inputs[..]].concat(), 0);
    let files = found["files"].as_array().expect("a list of files");
    assert_eq!(files.len(), 6);
    for file in files {
        assert_eq!(file["equal"], true, "{file}");
        assert_eq!(file["absent_inputs"], serde_json::json!([]), "{file}");
    }
    let take = verified(&bench, &[TAKE], 0);
    let take = &take["files"][0];
    assert!(take["structure"]["errors"].as_u64() > Some(1000), "{take}");
    assert!(take["computed"][0]["number"].as_u64() > Some(100), "{take}");
    let absent = ["cube_test_01.csv", "cube_train_01.csv", "cube_train_02.csv"];
    assert_eq!(take["absent_inputs"], serde_json::json!(absent));

    // An input that was changed.
    let input = "session/test/cube_test_01.csv";
    let before = bench.bytes(input);
    bench.edit(input, |text| text + "\n");
    is_named(
        &verified(&bench, &[&[TAKE], &inputs[..]].concat(), 3),
        "input session/test",
    );
    bench.write(input, before);

    // Bytes of a result.
    let sound = bench.bytes(TAKE);
    let mut bytes = sound.clone();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    bench.write(TAKE, &bytes);
    is_named(&verified(&bench, &["out/run.json"], 3), "cube_test_01.mcap");
    is_named(&verified(&bench, &[TAKE], 3), "byte ");
    bench.write(TAKE, &sound);

    // Rows of another run beside the evaluation.
    bench.ok(&[
        &["run", "session", "-o", "other", "--ends-s", "0.1"],
        &SMALL[..],
    ]
    .concat());
    let own = bench.bytes("out/rows.parquet");
    bench.write("out/rows.parquet", bench.bytes("other/rows.parquet"));
    is_named(&verified(&bench, &["out/evaluation.json"], 3), "rows");
    for call in [
        &["report", "out", "-o", "r.html"][..],
        &["report", "merge", "out", "-o", "m.html"],
        &["compare", "out", "other"],
    ] {
        let refused = bench.inhand(call);
        assert_eq!(refused.status.code(), Some(1), "{call:?}");
        let text = stderr(&refused);
        assert!(
            text.contains("carries the key") && text.contains("together"),
            "{text}"
        );
    }
    bench.write("out/rows.parquet", own);
    // Results of before have no key, and are read.
    let named = bench.json("out/evaluation.json")["key"].clone();
    bench.edit("out/evaluation.json", |text| {
        text.replace(&format!("\"key\": {named},"), "")
    });
    bench.ok(&["report", "out", "-o", "r.html"]);
    bench.write("out/evaluation.json", "{}");
    assert_eq!(
        bench
            .inhand(&["verify", "out/evaluation.json"])
            .status
            .code(),
        Some(1)
    );
}

/// A file with correct checksums whose processed index fingertip is a millimetre off at one sample.
#[test]
fn a_processed_value_that_the_recording_does_not_give_is_named() {
    let bench = Bench::csv();
    bench.ok(&["process", "session/train/cube_train_01.csv", "-o", "p.mcap"]);
    assert_eq!(places(&verified(&bench, &["p.mcap"], 0)), [""; 0]);
    let ReadTake {
        recording,
        motion,
        roles,
        provenance,
        ..
    } = read_take(&bench.bytes("p.mcap"), "p.mcap").expect("the file holds a take");
    let mut motion = motion.expect("it was processed");
    let track = &motion.fingertips[inhand_model::Finger::Index];
    let moved = track.iter().enumerate().map(|(k, tip)| {
        let [x, y, z]: [f64; 3] = tip?.coords_m().into();
        let off = if k == 600 { 1e-3 } else { 0.0 };
        Some(Position::new(x + off, y, z))
    });
    motion.fingertips[inhand_model::Finger::Index] = inhand_model::PointTrack::from_measured(moved);
    let file = TakeFile {
        motion: Some(&motion),
        roles: roles.as_ref(),
        provenance: &provenance,
        ..TakeFile::new(&recording)
    };
    let mut bytes = std::io::Cursor::new(Vec::new());
    write_take(&mut bytes, &file, Views::None).expect("it can be written");
    bench.write("p.mcap", bytes.into_inner());
    let found = places(&verified(&bench, &["p.mcap"], 3));
    assert_eq!(found, ["/processed, index, sample 600"]);
}

#[test]
fn what_is_no_result_ends_with_1_or_2() {
    let bench = Bench::empty();
    bench.write("a.txt", "no result");
    std::fs::create_dir(bench.path("empty")).expect("folders can be made");
    for (args, code) in [
        (["verify", "a.txt"], 1),
        (["verify", "no.mcap"], 1),
        (["verify", "empty"], 2),
    ] {
        assert_eq!(bench.inhand(&args).status.code(), Some(code), "{args:?}");
    }
}
