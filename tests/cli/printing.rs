//! Help, data on stdout, everything else on stderr.

use std::io::Read as _;
use std::process::{Command, Stdio};

use crate::support::{Bench, SMALL};

const COMMANDS: [&str; 12] = [
    "check", "run", "demo", "info", "convert", "process", "learn", "generate", "evaluate",
    "report", "simulate", "settings",
];

#[test]
fn every_command_has_help() {
    let bench = Bench::empty();
    let overview = bench.ok(&["--help"]);
    assert!(overview.contains("Exit codes"), "{overview}");
    for command in COMMANDS {
        assert!(overview.contains(command), "{command} in the overview");
        let help = bench.ok(&[command, "--help"]);
        assert!(help.contains("Usage: inhand"), "{help}");
    }
}

#[test]
fn json_alone_is_on_stdout() {
    let bench = Bench::csv();
    let args = [
        &["run", "session", "-o", "out", "--format", "json"],
        &SMALL[..],
    ]
    .concat();
    let printed: serde_json::Value =
        serde_json::from_str(&bench.ok(&args)).expect("stdout is JSON");
    assert_eq!(printed, bench.json("out/evaluation.json"));
}

#[test]
fn quiet_is_quiet() {
    let bench = Bench::csv();
    let output = bench.inhand(&[
        "convert",
        "session/train/cube_train_01.csv",
        "-o",
        "a.mcap",
        "--quiet",
    ]);
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
    let output = bench.inhand(&["info", "missing.mcap", "--quiet"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(!output.stderr.is_empty(), "errors are shown even then");
}

#[test]
fn a_closed_pipe_is_no_failure() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let mut child = Command::new(env!("CARGO_BIN_EXE_inhand"))
        .args(["run", "session", "-o", "out", "--format", "json"])
        .args(SMALL)
        .current_dir(bench.folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary under test runs");
    drop(child.stdout.take());
    let mut messages = String::new();
    child
        .stderr
        .take()
        .expect("stderr is piped")
        .read_to_string(&mut messages)
        .expect("UTF-8");
    assert_eq!(child.wait().expect("it ends").code(), Some(0), "{messages}");
    assert!(!messages.contains("error:"), "{messages}");
}
