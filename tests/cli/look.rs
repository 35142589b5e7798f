//! Inspection by `run` before it learns: exit codes, and where findings are shown.

use serde_json::Value;

use crate::support::{Bench, SMALL, stderr};

const TRAIN: &str = "session/train/cube_train_01.csv";
const TAKES: [&str; 3] = [
    TRAIN,
    "session/train/cube_train_02.csv",
    "session/test/cube_test_01.csv",
];
const CUBE: [&str; 2] = ["--object", "cube:0.05"];

/// Runs the session; exit code and stderr.
fn run(bench: &Bench, options: &[&str]) -> (Option<i32>, String) {
    let small = match options.contains(&"--rank") {
        true => &[][..],
        false => &SMALL,
    };
    let output = bench.inhand(&[&["run", "session", "-o", "out"], small, options].concat());
    (output.status.code(), stderr(&output))
}

/// A session whose settings do not state the object's shape.
fn without_shape() -> Bench {
    let bench = Bench::csv();
    std::fs::remove_file(bench.path("session/inhand.toml")).expect("the settings are there");
    bench
}

/// The run must be refused for this finding alone; accepted, it must go through and still say it.
fn refused(bench: &Bench, id: &str, options: &[&str]) {
    let (code, message) = run(bench, options);
    assert_eq!(code, Some(1), "{message}");
    for words in [format!("\n{id}"), format!("--accept {id}\n")] {
        assert!(message.contains(&words), "{words} in {message}");
    }
    assert_eq!(
        bench.files("out"),
        Vec::<String>::new(),
        "nothing is written"
    );
    let (code, message) = run(bench, &[options, &["--accept", id]].concat());
    assert_eq!(code, Some(0), "{message}");
    assert!(message.contains(&format!("\nfail     {id}")), "{message}");
    let found = finding(bench, id);
    assert_eq!(found["level"], "fail");
    assert_eq!(found["accepted"], true);
}

/// The run must warn of this and go through.
fn warned(bench: &Bench, id: &str, options: &[&str]) {
    let (code, message) = run(bench, options);
    assert_eq!(code, Some(0), "{message}");
    let line = format!("warn     {id}");
    assert!(message.contains(&line), "{line} in {message}");
    assert_eq!(finding(bench, id)["level"], "warn");
}

fn finding(bench: &Bench, id: &str) -> Value {
    let evaluation = bench.json("out/evaluation.json");
    let findings = evaluation["inspection"]["findings"].as_array().cloned();
    let mut findings = findings.unwrap_or_default().into_iter();
    let found = findings.find(|finding| finding["id"] == id);
    found.unwrap_or_else(|| panic!("no {id}"))
}

#[test]
fn millimetres_in_a_header_over_metres() {
    let bench = Bench::csv();
    for take in TAKES {
        bench.edit(take, |text| {
            text.replacen("Units,Meters", "Units,Millimeters", 1)
        });
    }
    refused(&bench, "units", &CUBE);
}

#[test]
fn a_take_twice_under_two_names() {
    let bench = Bench::csv();
    bench.write("session/train/again.csv", bench.bytes(TRAIN));
    refused(&bench, "same-take", &CUBE);
}

#[test]
fn sizes_and_windows_beyond_a_hand_and_a_segment() {
    refused(&Bench::csv(), "object-size", &["--object", "cube:50"]);
    let window = [&CUBE[..], &["--window", "150"]].concat();
    refused(&Bench::csv(), "filter-window", &window);
}

#[test]
fn settings_that_make_numbers_doubtful() {
    let bench = without_shape();
    warned(&bench, "no-shape", &[]);
    warned(&bench, "contact-share", &["--object", "cube:0.075"]);
    for (id, option, value) in [
        ("filter-window", "--window", "80"),
        ("margin", "--margin", "0.3"),
        ("tau", "--tau-mm", "20"),
        ("primitives", "--rank", "22"),
    ] {
        warned(&bench, id, &[&CUBE[..], &[option, value]].concat());
    }
    // A line through most of a segment is far from where the fingertips were.
    let line = "--filter savitzky-golay --window 95 --filter-order 1";
    let line: Vec<_> = CUBE.into_iter().chain(line.split(' ')).collect();
    warned(&bench, "filter-moves", &line);
}

#[test]
fn swapped_fingertips_and_flipped_bodies_are_under_the_verdict() {
    let bench = Bench::simulated(&["--format", "csv", "--faults"]);
    let (code, message) = run(&bench, &[&CUBE[..], &["--fail-on", "warn"]].concat());
    assert_eq!(code, Some(3), "{message}");
    for id in ["swaps", "flips"] {
        let line = format!("warn     {id}");
        assert!(message.contains(&line), "{line} in {message}");
        assert_eq!(finding(&bench, id)["level"], "warn");
    }
    let page = String::from_utf8(bench.bytes("out/report.html")).unwrap();
    let (first_screen, _) = page.split_once("<summary>Contents").unwrap();
    assert!(first_screen.contains("swaps (cube_"), "{first_screen}");
}

#[test]
fn labels_exchanged_in_whole_takes() {
    let bench = Bench::csv();
    for take in TAKES {
        bench.edit(take, |text| {
            let text = text.replace("Ring", "Rest").replace("Little", "Ring");
            text.replace("Rest", "Little")
        });
    }
    warned(&bench, "finger-order", &CUBE);
}

#[test]
fn a_second_run_says_the_same_and_only_what_was_looked_at_is_fine() {
    let bench = without_shape();
    let looked_at = |id: &str| {
        let checks = &bench.json("out/evaluation.json")["inspection"]["checks"];
        let checks = checks.as_array().expect("the checks are a list");
        checks.iter().any(|check| check == id)
    };
    for _ in 0..2 {
        let (code, message) = run(&bench, &[&CUBE[..], &["--fail-on", "warn"]].concat());
        assert_eq!(code, Some(0), "{message}");
        for id in ["units", "swaps", "object-size", "filter-moves"] {
            assert!(looked_at(id), "{id}");
        }
        // The number alone: names are in the evaluation and on the page.
        let line = message.lines().find(|line| line.contains("Nothing odd"));
        let line = line.unwrap_or_else(|| panic!("{message}"));
        assert!(
            line.ends_with(" checks.") && !line.contains("units"),
            "{line}"
        );
        assert!(!message.contains("warn  "), "{message}");
    }
    for _ in 0..2 {
        let (code, message) = run(&bench, &["--fail-on", "warn"]);
        assert_eq!(code, Some(3), "{message}");
        assert!(message.contains("warn     no-shape"), "{message}");
        assert!(message.contains("Nothing odd was found in "), "{message}");
        for id in ["object-size", "contact-share"] {
            assert!(!looked_at(id), "{id}");
        }
    }
    let (code, message) = run(&bench, &["--fail-on", "warn", "--accept", "no-shape"]);
    assert_eq!(code, Some(0), "{message}");
}

#[test]
fn identifiers_are_those_of_checks() {
    let bench = without_shape();
    // A finding of no take is not accepted in one.
    let elsewhere = [
        "--object",
        "cube:50",
        "--accept",
        "object-size:cube_test_01",
    ];
    let (code, message) = run(&bench, &elsewhere);
    assert_eq!(code, Some(1), "{message}");
    let (code, message) = run(&bench, &["--accept", "unit"]);
    assert_eq!(code, Some(2), "{message}");
    assert!(message.contains("units, finger-place"), "{message}");
    // Nor does a take that there is not accept anything: in a run, in learning, in all sessions of a batch.
    let typo = ["--accept", "units:cube_train_1"];
    for call in [
        &["run", "session", "-o", "out"][..],
        &["run", TRAIN, "-o", "out"],
        &["learn", TAKES[0], TAKES[1], "-o", "d.mcap"],
        &["batch", "session", TAKES[1], "-o", "all"],
    ] {
        let output = bench.inhand(&[call, &typo].concat());
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{call:?}: {message}");
        assert!(
            message.contains("units:cube_train_1 (look.accept)"),
            "{message}"
        );
        assert!(message.contains("one of cube_t"), "{message}");
    }
    bench.write("session/inhand.toml", "look.accept = [\"units:other\"]\n");
    let (code, message) = run(&bench, &[]);
    assert_eq!(code, Some(2), "{message}");
    std::fs::remove_file(bench.path("session/inhand.toml")).expect("the settings are there");
    bench.write("accept.toml", "[look]\naccept = [\"no-shape\"]\n");
    let accepted = ["--fail-on", "warn", "--settings", "accept.toml"];
    let (code, message) = run(&bench, &accepted);
    assert_eq!(code, Some(0), "{message}");
}

#[test]
fn a_batch_shows_findings_and_keeps_the_reason_of_a_refusal() {
    let bench = without_shape();
    let args = [&["batch", "session", "-o", "all"], &SMALL[..]].concat();
    let output = bench.inhand(&[&args[..], &["--fail-on", "warn"]].concat());
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    assert!(stderr(&output).contains("warn     no-shape"));
    let output = bench.inhand(&[&args[..], &["--object", "cube:50"]].concat());
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let error = bench.json("all/batch.json")["sessions"][0]["error"].to_string();
    assert!(error.contains("object-size"), "{error}");
}

#[test]
fn learning_refuses_what_a_run_refuses_and_a_take_is_accepted_alone() {
    let bench = Bench::csv();
    let takes = &TAKES[..2];
    for take in takes {
        bench.edit(take, |text| {
            text.replacen("Units,Meters", "Units,Millimeters", 1)
        });
    }
    let learn = |options: &[&str]| {
        let output = bench.inhand(&[&["learn"], options].concat());
        (output.status.code(), stderr(&output))
    };
    let whole = [takes, &["-o", "d.mcap"], &SMALL].concat();
    let ranks = [takes, &["-o", "d.mcap", "--rank", "4..8"]].concat();
    let init = [&["init"], takes, &["-o", "work"], &SMALL].concat();
    let one = [&whole[..], &["--accept", "units:cube_train_01"]].concat();
    for options in [&whole, &ranks, &init, &one] {
        let (code, message) = learn(options);
        assert_eq!(code, Some(1), "{message}");
        assert!(message.contains("\nunits (cube_train_0"), "{message}");
        assert!(!bench.path("d.mcap").exists() && !bench.path("work").exists());
    }
    let (_, message) = learn(&one);
    assert!(message.contains("\nunits (cube_train_02): "), "{message}");
    let both = [&one[..], &["--accept", "units:cube_train_02"]].concat();
    let (code, message) = learn(&both);
    assert_eq!(code, Some(0), "{message}");
    let accepted = "fail     units (cube_train_01 and cube_train_02)";
    assert!(message.contains(accepted), "{message}");
}
