//! Outputs appear whole or not at all, and never over something else.

use crate::support::{Bench, SMALL, stderr};

#[test]
fn an_output_that_is_an_input_is_refused() {
    let bench = Bench::csv();
    bench.ok(&["convert", "session/train/cube_train_01.csv", "-o", "a.mcap"]);
    let before = bench.bytes("a.mcap");
    let output = bench.inhand(&["process", "a.mcap", "-o", "./a.mcap", "--force"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("also an input"),
        "{}",
        stderr(&output)
    );
    assert_eq!(bench.bytes("a.mcap"), before);
}

#[test]
fn what_others_wrote_needs_force() {
    let bench = Bench::csv();
    bench.write("a.mcap", "somebody's notes");
    let convert = ["convert", "session/train/cube_train_01.csv", "-o", "a.mcap"];
    let output = bench.inhand(&convert);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--force"), "{}", stderr(&output));
    assert_eq!(bench.bytes("a.mcap"), b"somebody's notes");
    bench.ok(&[&convert[..], &["--force"]].concat());
    // Made from the same input: replaced without asking. Made from another: not.
    bench.ok(&convert);
    let other = ["convert", "session/train/cube_train_02.csv", "-o", "a.mcap"];
    assert_eq!(bench.inhand(&other).status.code(), Some(2));
}

#[test]
fn run_replaces_its_own_results_only() {
    let bench = Bench::csv();
    bench.write("out/report.html", "my thesis");
    let args = [&["run", "session", "-o", "out"], &SMALL[..]].concat();
    let output = bench.inhand(&args);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert_eq!(bench.files("out"), ["report.html"]);
    assert_eq!(bench.bytes("out/report.html"), b"my thesis");
    bench.ok(&[&args[..], &["--force"]].concat());
    bench.run("out", &["--tau-mm", "4"]);
}
