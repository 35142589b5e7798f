//! One recording for training and testing: split by time, in ranges, in pieces; copies that pass for others.

use crate::support::{Bench, SMALL, stderr};

const TRAIN: &str = "session/train/cube_train_01.csv";
const TEST: &str = "session/test/cube_test_01.csv";

/// A bench whose only take is `take.csv`, of 12 s.
fn one_take() -> Bench {
    let bench = Bench::csv();
    std::fs::rename(bench.path(TEST), bench.path("take.csv")).expect("the take moves");
    bench
}

/// Runs a session with the options for small ones; its exit code and stderr.
fn run(bench: &Bench, session: &str, options: &[&str]) -> (Option<i32>, String) {
    let output = bench.inhand(&[&["run", session, "-o", "out"], &SMALL[..], options].concat());
    (output.status.code(), stderr(&output))
}

/// Role, name and samples of the takes of an evaluation.
fn takes(bench: &Bench, evaluation: &str) -> String {
    let session = &bench.json(evaluation)["session"];
    let takes = ["train", "test"].map(|role| {
        let takes = session[role].as_array().expect("a list of takes").iter();
        let takes = takes.map(|take| format!("{role} {} {}", take["name"], take["samples"]));
        takes.collect::<Vec<_>>().join(", ")
    });
    takes.join(", ").replace('"', "")
}

#[test]
fn one_take_is_split_by_time() {
    let bench = one_take();
    let (code, said) = run(&bench, "take.csv", &["--object", "cube:0.05"]);
    assert_eq!(code, Some(0), "{said}");
    for word in ["take.csv", "80 %", "20 %", "--test-share"] {
        assert!(said.contains(word), "{word}: {said}");
    }
    let split = "train take.train 960, test take.test 240";
    assert_eq!(takes(&bench, "out/evaluation.json"), split);
    assert_eq!(bench.json("out/evaluation.json")["session"]["name"], "take");
    // Again it is up to date; with another share it is another run.
    let (_, said) = run(&bench, "take.csv", &["--object", "cube:0.05"]);
    assert!(said.contains("up to date"), "{said}");
    let (_, said) = run(
        &bench,
        "take.csv",
        &["--object", "cube:0.05", "--test-share", "0.5"],
    );
    assert!(!said.contains("up to date"), "{said}");
    let (code, said) = run(&bench, "take.csv", &["--force", "--test-share", "0.05"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("a larger segments.test_share"), "{said}");
    let (code, said) = run(&bench, "take.csv", &["--test-share", "1"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("segments.test_share"), "{said}");
}

#[test]
fn a_take_of_a_session_is_run_by_the_settings_of_the_session() {
    let bench = Bench::csv();
    bench.write(
        "session/inhand.toml",
        "name = \"several\"\nobject.shape = \"cube:0.05\"\nevaluate.draws = 200\n",
    );
    let quick = ["--methods", "line,hermite"];
    for verb in ["run", "batch"] {
        let call = [&[verb, TEST, "-o", verb][..], &SMALL, &quick].concat();
        let output = bench.inhand(&call);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert!(said.contains("settings  session/inhand.toml\n"), "{said}");
        let folder = if verb == "run" {
            "run"
        } else {
            "batch/cube_test_01"
        };
        let evaluation = bench.json(&format!("{folder}/evaluation.json"));
        assert_eq!(evaluation["session"]["name"], "cube_test_01");
        let made = evaluation["provenance"].as_array().and_then(|p| p.last());
        let made = made.expect("a step made it").to_string();
        for part in ["cube:0.05", "draws"] {
            assert!(made.contains(part), "{part}: {made}");
        }
        assert!(!evaluation["contacts"].is_null(), "{verb}");
    }
    // Nothing of the session where that is asked for.
    let none = [
        &["run", TEST, "-o", "none", "--settings", "none"][..],
        &SMALL,
        &quick,
    ]
    .concat();
    let output = bench.inhand(&none);
    assert!(
        !stderr(&output).contains("inhand.toml"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn ranges_of_one_recording_are_takes() {
    let bench = one_take();
    let ranges = |ranges: &[(&str, f64, f64)]| {
        let entry = |&(role, from, to): &(&str, f64, f64)| {
            format!("[[takes]]\npath = \"take.csv\"\n{role}\nfrom_s = {from:?}\nto_s = {to:?}\n")
        };
        bench.write("inhand.toml", ranges.iter().map(entry).collect::<String>());
        run(&bench, "inhand.toml", &["--force"])
    };
    let (train, test) = ("role = \"train\"", "role = \"test\"");
    let (code, said) = ranges(&[(train, 0.0, 3.5), (train, 4.0, 8.0), (test, 8.0, 12.0)]);
    assert_eq!(code, Some(0), "{said}");
    let named = "train take.train 350, train take.train.2 400, test take.test 400";
    assert_eq!(takes(&bench, "out/evaluation.json"), named);
    // Ranges of both roles that overlap share samples.
    let (code, said) = ranges(&[(train, 0.0, 8.0), (test, 7.0, 12.0)]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("also the training take"), "{said}");
    // Without a role the range itself is split.
    let (code, said) = ranges(&[("", 2.0, 12.0)]);
    assert_eq!(code, Some(0), "{said}");
    let split = "train take.train 800, test take.test 200";
    assert_eq!(takes(&bench, "out/evaluation.json"), split);
}

#[test]
fn pieces_of_one_recording_are_used_together_where_they_do_not_overlap() {
    let bench = one_take();
    std::fs::remove_dir_all(bench.path("session")).expect("the session goes");
    bench.ok(&["convert", "take.csv", "-o", "take.mcap"]);
    for folder in ["session/train", "session/test"] {
        std::fs::create_dir_all(bench.path(folder)).expect("folders can be made");
    }
    let cut = |from: &str, to: &str, piece: &str| {
        bench.ok(&[
            "cut",
            "take.mcap",
            "-o",
            piece,
            "--from",
            from,
            "--to",
            to,
            "--force",
        ]);
    };
    cut("0", "8", "session/train/begin.mcap");
    cut("8", "12", "session/test/end.mcap");
    let (code, said) = run(&bench, "session", &[]);
    assert_eq!(code, Some(0), "{said}");
    // Half a second of both is not most of either.
    cut("7.5", "12", "session/test/end.mcap");
    let (code, said) = run(&bench, "session", &["--force"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("also the training take"), "{said}");
}

#[test]
fn a_copy_that_was_trimmed_or_shifted_is_the_same_take() {
    let bench = Bench::csv();
    let rows = |text: &str, left_out: std::ops::Range<usize>| -> String {
        let lines = text.split_inclusive('\n').enumerate();
        lines
            .filter(|(n, _)| !left_out.contains(n))
            .map(|(_, line)| line)
            .collect()
    };
    let train = String::from_utf8(bench.bytes(TRAIN)).expect("a CSV file is text");
    // The first row is gone, or the first three seconds.
    for left_out in [7..8, 7..307] {
        bench.write(TEST, rows(&train, left_out.clone()));
        let (code, said) = run(&bench, "session", &[]);
        assert_eq!(code, Some(1), "{left_out:?}: {said}");
        assert!(said.contains("also the training take"), "{said}");
    }
}

#[test]
fn files_that_are_no_takes_get_a_line() {
    let bench = Bench::csv();
    for name in ["train/notes.txt", "train/.hidden", "test/a/b.txt"] {
        bench.write(&format!("session/{name}"), "");
    }
    let (code, said) = run(&bench, "session", &[]);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("not takes, left out: test/a, train/notes.txt\n"),
        "{said}"
    );
    let output = bench.inhand(&[&["batch", "session", "-o", "all"], &SMALL[..]].concat());
    assert!(
        stderr(&output).contains("train/notes.txt"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_session_without_test_takes_names_the_way_with_one() {
    let bench = Bench::csv();
    std::fs::remove_dir_all(bench.path("session/test")).expect("the takes go");
    let (code, said) = run(&bench, "session", &[]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("no test take") && said.contains("name it in place of the folder"),
        "{said}"
    );
    let output = bench.inhand(&[&["batch", TRAIN, "-o", "all"], &SMALL[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(bench.path("all/cube_train_01/report.html").is_file());
}
