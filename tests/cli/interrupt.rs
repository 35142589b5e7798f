//! Ctrl-C and SIGTERM in the middle of a command: what is said, what is left, how to go on.

use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::support::{Bench, SMALL};

const INT: i32 = 2;
const TERM: i32 = 15;

/// A command that is interrupted once it has printed a line with these words; what it prints after that.
fn interrupted(bench: &Bench, args: &[&str], after: &str, signal: i32) -> String {
    let mut child = Command::new(env!("CARGO_BIN_EXE_inhand"))
        .args(args)
        .current_dir(bench.folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary under test runs");
    let mut stderr = BufReader::new(child.stderr.take().expect("stderr is a pipe"));
    let mut line = String::new();
    while !line.contains(after) {
        line.clear();
        let read = stderr.read_line(&mut line).expect("it prints text");
        assert!(read > 0, "it ended without \"{after}\"");
    }
    let mut rest = String::new();
    kill(&child, signal);
    stderr.read_to_string(&mut rest).expect("it prints text");
    let status = child.wait().expect("it ends");
    assert_eq!(status.signal(), Some(signal), "{status} {rest}");
    // The last words, and no error about what was removed.
    assert!(
        !rest.contains("error") && !rest.contains("failed"),
        "{rest}"
    );
    rest
}

fn kill(child: &Child, signal: i32) {
    let killed = Command::new("kill")
        .args([format!("-{signal}"), child.id().to_string()])
        .status()
        .expect("the system can send signals");
    assert!(killed.success());
}

fn unfinished(bench: &Bench) -> Vec<String> {
    let files = bench.files(".").into_iter();
    files
        .filter(|file| file.contains(".inhand-unfinished"))
        .collect()
}

#[test]
fn a_batch_keeps_its_sessions_and_goes_on() {
    let bench = Bench::empty();
    for (session, seed) in [("a", "1"), ("b", "2"), ("c", "3")] {
        let sizes = ["--takes", "2", "--duration", "12", "--seed", seed];
        bench.ok(&[&["simulate", "-o", session], &sizes[..]].concat());
    }
    let batch = [&["batch", "a", "b", "c", "-o", "out"], &SMALL[..]].concat();
    let said = interrupted(&bench, &batch, "done     a", INT);
    let words = "interrupted: 1 of 3 sessions are done and kept in out; the same command goes on with the others\n";
    assert!(said.ends_with(words), "{said}");
    assert_eq!(unfinished(&bench), [""; 0]);
    bench.ok(&batch);
    let record = bench.json("out/batch.json");
    let states = [0, 1, 2].map(|n| record["sessions"][n]["state"].clone());
    assert_eq!(states, ["up_to_date", "done", "done"]);
    bench.ok(&[&["run", "b", "-o", "alone"], &SMALL[..]].concat());
    for file in ["evaluation.json", "dictionary.mcap", "report.html"] {
        let [batch, alone] = ["out/b", "alone"].map(|out| bench.bytes(&format!("{out}/{file}")));
        assert!(batch == alone, "{file}");
    }
}

#[test]
fn a_run_goes_on_from_its_dictionary() {
    let bench = Bench::csv();
    let run = [&["run", "session", "-o", "out"], &SMALL[..]].concat();
    let said = interrupted(&bench, &run, "generate", TERM);
    let words = "interrupted: out is unfinished; its dictionary is kept, and the same command goes on from there\n";
    assert!(said.ends_with(words), "{said}");
    assert_eq!(unfinished(&bench), [""; 0]);
    let dictionary = bench.bytes("out/dictionary.mcap");
    bench.ok(&run);
    bench.run("alone", &[]);
    assert!(dictionary == bench.bytes("alone/dictionary.mcap"));
    for file in bench
        .files("alone")
        .iter()
        .filter(|file| *file != "run.json")
    {
        let [out, alone] = ["out", "alone"].map(|out| bench.bytes(&format!("{out}/{file}")));
        assert!(out == alone, "{file}");
    }
}

#[test]
fn a_run_before_its_dictionary_leaves_nothing() {
    let bench = Bench::csv();
    let run = [&["run", "session", "-o", "out"], &SMALL[..]].concat();
    let said = interrupted(&bench, &run, "read", INT);
    assert!(
        said.ends_with("interrupted: nothing was written; run the same command again\n"),
        "{said}"
    );
    assert_eq!(bench.files("out"), [""; 0]);
}

#[test]
fn a_search_of_ranks_says_which_are_left() {
    let bench = Bench::csv();
    let takes = [
        "session/train/cube_train_01.csv",
        "session/train/cube_train_02.csv",
    ];
    let options = ["-o", "d.mcap", "--stride", "10", "--max-iterations", "40"];
    let search = [&["learn"], &takes[..], &options, &["--rank", "8..40:8"]].concat();
    let said = interrupted(&bench, &search, "(1 of 5)", INT);
    // The next rank may be done before the signal arrives.
    let words = |next: usize| {
        format!(
            "no dictionary was written, the ranks printed are lost; run the same command again, or with a range \
             from {next} for the other ranks alone\n"
        )
    };
    let next = 8 * (said.matches(" of 5)").count() + 2);
    assert!(next < 40 && said.ends_with(&words(next)), "{said}");
    assert_eq!(unfinished(&bench), [""; 0]);
    assert!(!bench.path("d.mcap").exists());
}

#[test]
fn rounds_of_learning_are_kept() {
    let bench = Bench::csv();
    let takes = [
        "session/train/cube_train_01.csv",
        "session/train/cube_train_02.csv",
    ];
    let learn = |output: &'static str, options: &[&'static str]| {
        let quick = ["--stride", "2", "--rank", "20", "--max-iterations", "12"];
        [&["learn"], &takes[..], &["-o", output], &quick, options].concat()
    };
    let in_folder = learn("a.mcap", &["--work", "rounds"]);
    let said = interrupted(&bench, &in_folder, "round 1", INT);
    let words = "interrupted: the rounds in rounds are kept; the same command goes on from there\n";
    assert!(said.ends_with(words), "{said}");
    assert_eq!(unfinished(&bench), [""; 0]);
    bench.ok(&in_folder);
    bench.ok(&learn("b.mcap", &[]));
    assert!(bench.bytes("a.mcap") == bench.bytes("b.mcap"));
}

#[test]
fn converted_files_are_kept() {
    let bench = Bench::empty();
    let sizes = ["--takes", "5", "--duration", "60", "--seed", "7"];
    bench.ok(&[&["simulate", "-o", "session"], &sizes[..]].concat());
    let train: Vec<_> = (1..=5)
        .map(|n| format!("session/train/cube_train_0{n}.csv"))
        .collect();
    let train: Vec<_> = train.iter().map(String::as_str).collect();
    let convert = [
        &["convert"],
        &train[..],
        &["session/test/cube_test_01.csv", "-o", "out"],
    ]
    .concat();
    let said = interrupted(&bench, &convert, "wrote", INT);
    // Another may be done before the signal arrives.
    let files = match bench.files("out").len() {
        1 => "1 file is".to_owned(),
        more => format!("{more} files are"),
    };
    let words = format!("interrupted: {files} written and kept; run the same command again\n");
    assert!(said.ends_with(&words), "{said}");
    let first = bench.bytes("out/cube_train_01.mcap");
    bench.ok(&convert);
    assert_eq!(bench.files("out").len(), 6);
    assert!(first == bench.bytes("out/cube_train_01.mcap"));
}

#[test]
fn what_waits_for_a_pipe_is_removed() {
    let bench = Bench::csv();
    let made = Command::new("mkfifo").arg(bench.path("pipe")).status();
    assert!(made.expect("the system has pipes").success());
    std::fs::create_dir(bench.path("tmp")).expect("folders can be made");
    let child = Command::new(env!("CARGO_BIN_EXE_inhand"))
        .args(["convert", "session/test/cube_test_01.csv", "-o", "pipe"])
        .current_dir(bench.folder.path())
        .env("TMPDIR", bench.path("tmp"))
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary under test runs");
    while bench.files("tmp").is_empty() {
        std::thread::sleep(Duration::from_millis(10));
    }
    kill(&child, TERM);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.signal(), Some(TERM));
    assert_eq!(bench.files("tmp"), [""; 0]);
}
