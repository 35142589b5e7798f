//! Exit codes: one fault has one code, in every command.

use crate::support::{Bench, SMALL, stderr};

/// A call of a command.
type Call = Vec<&'static str>;

/// Commands that read a file and write another, without both.
const COMMANDS: [&[&str]; 11] = [
    &["convert", "INPUT"],
    &["process", "INPUT"],
    &["clean", "INPUT", "--repair"],
    &["learn", "INPUT", "--stride", "10", "--rank", "5"],
    &["cut", "INPUT", "--from", "1", "--to", "2"],
    &["filter", "INPUT"],
    &["merge", "INPUT", "session/test/other.mcap", "--keep-both"],
    &["recover", "INPUT"],
    &["view", "INPUT"],
    &["overlay", "INPUT", "session/test/other.mcap"],
    &["annotate", "about", "INPUT", "--set", "a=b"],
];

/// The commands on an input, with an output and more options.
fn calls(input: &'static str, options: &[&'static str]) -> Vec<Call> {
    let call = |command: &&[&'static str]| {
        let words = command
            .iter()
            .map(|&word| if word == "INPUT" { input } else { word });
        words.chain(options.iter().copied()).collect()
    };
    COMMANDS.iter().map(call).collect()
}

/// A session of MCAP takes and files that are wrong in their own way.
fn bench() -> Bench {
    let bench = Bench::simulated(&["--format", "mcap"]);
    let [train, test] = [
        "session/train/cube_train_01.mcap",
        "session/test/cube_test_01.mcap",
    ];
    std::fs::copy(bench.path(train), bench.path("take.mcap")).expect("a take was simulated");
    std::fs::rename(bench.path(test), bench.path("session/test/other.mcap")).expect("so was this");
    let whole = bench.bytes("take.mcap");
    bench.write("part.mcap", &whole[..whole.len() / 2]);
    bench.write("noise.mcap", "nothing that any reader knows");
    bench.write("other.mcap", "results of others");
    bench.write("wrong.toml", "[learn]\nrnak = 3\n");
    bench
}

/// The calls end with the code that the page has for the fault.
fn all_end(bench: &Bench, fault: &str, code: i32, calls: &[Call]) {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/cli.md");
    let page = std::fs::read_to_string(page).expect("docs/cli.md is there");
    let row = format!("| {fault} | {code} |");
    assert!(page.contains(&row), "docs/cli.md has no row {row}");
    for call in calls {
        let output = bench.inhand(call);
        assert_eq!(
            output.status.code(),
            Some(code),
            "{fault}: {call:?}: {}",
            stderr(&output)
        );
    }
}

#[test]
fn inputs() {
    let bench = bench();
    let out = ["-o", "out.mcap"];
    for (fault, take) in [
        ("an input is missing", "gone.mcap"),
        ("an input cannot be read", "noise.mcap"),
    ] {
        let mut all = calls(take, &out);
        // Salvage is what recover is for: of noise there is none.
        all.retain(|call| fault != "an input cannot be read" || call[0] != "recover");
        all.extend([
            vec!["info", take],
            vec!["layout", take],
            vec!["play", take],
            vec!["annotate", "list", take],
            vec!["compare", take, take],
            vec!["report", take, "-o", "out.html"],
            vec!["export", take, "-o", "out.csv"],
            vec!["evaluate", "-d", take, take, "-o", "out.json"],
            vec!["generate", "-d", take, take, "-o", "out.mcap"],
            vec![
                "plan",
                "-d",
                take,
                "--from",
                "take.mcap@0",
                "--to",
                "take.mcap@1",
                "-o",
                "out.mcap",
            ],
        ]);
        all_end(&bench, fault, 1, &all);
    }
    all_end(
        &bench,
        "an input is missing",
        1,
        &[
            vec!["run", "gone", "-o", "out"],
            vec!["check", "gone.csv"],
            vec!["check", "gone.csv", "--fail-on", "never"],
            vec!["settings", "gone"],
        ],
    );
    // A copy that broke off: within a row, and behind one.
    let csv = Bench::simulated(&[]);
    let take = csv.bytes("session/test/cube_test_01.csv");
    let half = &take[..take.len() / 2];
    csv.write("session/test/cube_test_01.csv", half);
    let rows = half.iter().rposition(|&byte| byte == b'\n').expect("rows");
    csv.write("rows.csv", &half[..=rows]);
    for cut in ["rows.csv", "session/test/cube_test_01.csv"] {
        let mut lossy = calls(cut, &["-o", "out.mcap", "-q", "--force"]);
        lossy.retain(|call| ["convert", "process", "learn"].contains(&call[0]));
        lossy.push(vec!["check", cut, "-q"]);
        lossy.push(vec!["export", cut, "-o", "out.csv", "-q", "--force"]);
        all_end(&csv, "data was lost", 3, &lossy);
    }
    let run = [&["run", "session", "-o", "out", "-q"], &SMALL[..]].concat();
    let accepted = [&run[..], &["--accept", "cut-short"]].concat();
    all_end(&csv, "data was lost", 3, &[run.clone(), run]);
    assert_eq!(csv.inhand(&accepted).status.code(), Some(0));
    let mut lossy = calls("part.mcap", &out);
    lossy.retain(|call| call[0] == "recover");
    lossy.push(vec!["info", "part.mcap"]);
    all_end(&bench, "data was lost", 3, &lossy);
}

#[test]
fn calls_and_settings() {
    let bench = bench();
    let mut all = calls("take.mcap", &["-o", "out.mcap", "--no-such-option"]);
    all.extend(calls("take.mcap", &["-o", "out.mcap", "--threads", "many"]));
    all_end(&bench, "unknown option or value", 2, &all);

    let takes_settings = ["convert", "process", "clean", "learn", "view"];
    let mut all = calls("take.mcap", &["-o", "out.mcap", "--settings", "wrong.toml"]);
    all.retain(|call| takes_settings.contains(&call[0]));
    all.extend([
        vec!["check", "take.mcap", "--settings", "wrong.toml"],
        vec!["run", "session", "-o", "out", "--settings", "wrong.toml"],
        vec!["settings", "wrong.toml"],
    ]);
    all_end(&bench, "a settings file cannot be used", 2, &all);

    all_end(
        &bench,
        "the output exists",
        2,
        &calls("take.mcap", &["-o", "other.mcap"]),
    );
    all_end(
        &bench,
        "the output is an input",
        2,
        &calls("take.mcap", &["-o", "take.mcap", "--force"]),
    );
    all_end(
        &bench,
        "the output has another ending",
        2,
        &calls("take.mcap", &["-o", "out.xyz"]),
    );

    let out = ["-o", "out.mcap"];
    let mut all = vec![
        vec!["cut", "take.mcap", "--event", "fly"],
        vec!["learn", "take.mcap", "--event", "fly"],
        vec!["annotate", "remove", "take.mcap", "--label", "fly"],
        vec!["annotate", "remove", "take.mcap", "--event", "9"],
        vec![
            "annotate",
            "edit",
            "take.mcap",
            "--event",
            "9",
            "--label",
            "fly",
        ],
    ];
    all.iter_mut().for_each(|call| call.extend(out));
    all.push(vec!["run", "session", "-o", "out", "--event", "fly"]);
    all_end(
        &bench,
        "an event or label that a file does not have",
        2,
        &all,
    );
}

#[test]
fn results() {
    let bench = bench();
    let mut all = calls("take.mcap", &["-o", "out.mcap", "--hand", "nope"]);
    all.retain(|call| ["process", "clean", "learn"].contains(&call[0]));
    all.push(vec!["run", "session", "-o", "out", "--hand", "nope"]);
    all_end(
        &bench,
        "a role (hand, object, finger) is not identified",
        1,
        &all,
    );

    let huge = vec!["run", "session", "-o", "out", "--object", "cube:50"];
    all_end(
        &bench,
        "a finding of level fail is not accepted",
        1,
        &[huge],
    );

    all_end(
        &bench,
        "nothing was selected",
        3,
        &[vec![
            "filter",
            "take.mcap",
            "-y",
            "/nothing",
            "-o",
            "none.mcap",
        ]],
    );

    bench.run("out", &[]);
    bench.write(
        "far.json",
        r#"{ "fingertips_m": { "thumb": [3.0, 0.0, 0.0] } }"#,
    );
    let plan = [
        "plan",
        "-d",
        "out/dictionary.mcap",
        "--from",
        "take.mcap@1",
        "--to",
        "far.json",
    ];
    all_end(
        &bench,
        "a plan misses its targets",
        3,
        &[[&plan[..], &["-o", "plan.mcap"]].concat()],
    );
    all_end(
        &bench,
        "a check did not pass",
        3,
        &[
            vec!["check", "noise.mcap"],
            vec!["check", "take.mcap", "--hand", "nope"],
            vec![
                "compare",
                "out",
                "--method",
                "hold",
                "--against",
                "hermite",
                "--fail-if",
                "p75 > 1%",
            ],
        ],
    );
}
