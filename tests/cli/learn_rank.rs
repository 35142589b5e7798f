//! Choosing the rank: `inhand learn --rank FROM..TO`.

use serde_json::Value;

use crate::support::{Bench, stderr};

const TAKES: [&str; 2] = [
    "session/train/cube_train_01.csv",
    "session/train/cube_train_02.csv",
];

/// Options that make learning quick on the small session, without a rank.
const QUICK: [&str; 4] = ["--stride", "10", "--max-iterations", "5"];

fn learn(takes: &[&str], options: &[&str]) -> Vec<String> {
    let args = [&["learn"], takes, &["-o", "d.mcap"], &QUICK, options].concat();
    args.into_iter().map(str::to_owned).collect()
}

fn run(bench: &Bench, takes: &[&str], options: &[&str]) -> std::process::Output {
    let args = learn(takes, options);
    bench.inhand(&args.iter().map(String::as_str).collect::<Vec<_>>())
}

fn outcome(output: &std::process::Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    serde_json::from_slice(&output.stdout).expect("learn prints JSON alone")
}

#[test]
fn a_rank_is_chosen_drawn_and_learned() {
    let bench = Bench::csv();
    let range = ["--rank", "4..24:10", "--format", "json"];
    let output = run(&bench, &TAKES, &range);
    let found = outcome(&output);
    let written: Vec<_> = (bench.files(".").into_iter())
        .filter(|file| !file.starts_with("session"))
        .collect();
    assert_eq!(written, ["d.mcap", "d.rank.svg"]);
    let choice = &found["rank_choice"];
    let ranks: Vec<_> = choice["points"]
        .as_array()
        .expect("points are a list")
        .iter()
        .map(|point| point["rank"].as_u64().expect("ranks are numbers"))
        .collect();
    assert_eq!(ranks, [4, 14, 24]);
    assert_eq!(found["rank"], choice["suggested"]);
    assert_eq!(
        (&choice["groups"], &choice["left_out_by"]),
        (&2.into(), &"takes".into())
    );
    let progress = stderr(&output);
    assert!(progress.contains("(3 of 3)"), "{progress}");
    assert!(progress.contains("d.rank.svg"), "{progress}");

    let svg = String::from_utf8(bench.bytes("d.rank.svg")).expect("a figure is text");
    let suggested = format!("suggested: {}", choice["suggested"]);
    assert!(svg.starts_with("<svg") && svg.contains(&suggested), "{svg}");
    let info = bench.ok(&["info", "d.mcap", "--format", "json"]);
    assert!(info.contains("rank_choice"), "{info}");

    // The dictionary is that of the rank by itself.
    let rank = choice["suggested"].to_string();
    let again = ["--rank", &rank, "--format", "json", "--force"];
    let plain = outcome(&run(&bench, &TAKES, &again));
    assert_eq!(plain["rms_mm"], found["rms_mm"]);
    assert_eq!(plain["rank_choice"], Value::Null);
}

#[test]
fn the_table_has_a_row_for_each_rank_and_says_why() {
    let bench = Bench::csv();
    let options = ["--kind", "pca", "--rank", "3..6", "--quiet"];
    let output = run(&bench, &TAKES, &options);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(output.stderr.is_empty());
    let text = String::from_utf8(output.stdout).expect("output is UTF-8");
    for words in ["explained %", "\n   3  ", "\n   6  ", " is suggested: "] {
        assert!(text.contains(words), "{words} in {text}");
    }
    assert_eq!(text.matches("<- suggested").count(), 1, "{text}");
    assert!(text.contains("2 takes are few"), "{text}");
}

#[test]
fn ranks_that_are_too_large_are_left_out_and_named() {
    let bench = Bench::csv();
    let options = ["--rank", "10..5000:2495", "--format", "json"];
    let output = run(&bench, &TAKES, &options);
    let choice = &outcome(&output)["rank_choice"];
    assert_eq!(choice["too_large"], serde_json::json!([2505, 5000]));
    assert!(
        stderr(&output).contains("left out: rank 2505, 5000"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn a_single_take_is_evaluated_by_its_ranges() {
    let bench = Bench::csv();
    let options = ["--rank", "4..8:4", "--format", "json"];
    let choice = outcome(&run(&bench, &TAKES[..1], &options))["rank_choice"].clone();
    assert_eq!(choice["left_out_by"], "ranges of one take");
}

#[test]
fn ranges_that_make_no_sense_are_refused() {
    let bench = Bench::csv();
    for (rank, code, word) in [
        ("24..4", 2, "4..24"),
        ("0..4", 2, "starts at 1"),
        ("4..8:0", 2, "step"),
        ("4..", 2, "FROM..TO"),
        ("0", 2, "at least 1"),
        ("4000..5000", 1, "support ranks up to"),
    ] {
        let output = run(&bench, &TAKES, &["--rank", rank]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{rank}: {message}");
        assert!(message.contains(word), "{rank}: {message}");
        assert!(!bench.path("d.mcap").exists() && !bench.path("d.rank.svg").exists());
    }
    let output = bench.inhand(&["run", "session", "-o", "out", "--rank", "20..240"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("inhand learn"),
        "{}",
        stderr(&output)
    );
    assert!(!bench.path("out").exists());
}

#[test]
fn a_figure_that_is_there_is_not_replaced_by_accident() {
    let bench = Bench::csv();
    bench.write("d.rank.svg", "mine");
    let output = run(&bench, &TAKES, &["--rank", "4..8:4"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert_eq!(bench.bytes("d.rank.svg"), b"mine");
    assert!(!bench.path("d.mcap").exists());
}
