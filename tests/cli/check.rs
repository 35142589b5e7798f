//! `inhand check`: what is planted is found, and nothing else is complained about.

use serde_json::Value;

use crate::support::{Bench, stderr};

const GOOD: &str = "session/train/cube_train_01.csv";
const OTHER: &str = "session/train/cube_train_02.csv";

/// A take as results call it.
fn name(take: &str) -> &str {
    take.trim_start_matches("session/")
}

/// Blanks the cells of an entity in some samples of a Motive CSV.
fn blank(csv: &str, name: &str, samples: std::ops::Range<usize>) -> String {
    const FIRST_ROW: usize = 7;
    let lines: Vec<&str> = csv.split_inclusive('\n').collect();
    let names: Vec<&str> = lines[3].trim_end().split(',').collect();
    assert!(names.contains(&name), "{names:?}");
    let changed = lines.iter().enumerate().map(|(row, line)| {
        if row < FIRST_ROW || !samples.contains(&(row - FIRST_ROW)) {
            return (*line).to_owned();
        }
        let cells = line.trim_end().split(',').zip(&names);
        let cells = cells.map(|(cell, of)| if *of == name { "" } else { cell });
        cells.collect::<Vec<_>>().join(",") + "\r\n"
    });
    changed.collect()
}

fn checked(bench: &Bench, file: &str) -> Value {
    let printed = bench.ok(&["check", file, "--format", "json", "--fail-on", "never"]);
    let document: Value = serde_json::from_str(&printed).expect("check prints JSON");
    let schema = include_str!("../../schemas/check.schema.json");
    let schema = serde_json::from_str(schema).expect("the schema is JSON");
    jsonschema::validate(&schema, &document).expect("the document follows the schema");
    document["takes"][0].clone()
}

/// `id entity` of every result that is worse than worth knowing.
fn complaints(take: &Value) -> Vec<String> {
    let results = take["checkup"]["results"]
        .as_array()
        .expect("results are listed");
    let word = |result: &Value, key: &str| result[key].as_str().unwrap_or_default().to_owned();
    let odd = results
        .iter()
        .filter(|r| ["warn", "fail"].contains(&word(r, "level").as_str()));
    odd.map(|r| {
        format!("{} {}", word(r, "id"), word(r, "entity"))
            .trim_end()
            .to_owned()
    })
    .collect()
}

#[test]
fn a_good_take_passes_in_every_format_it_is_stored_in() {
    let bench = Bench::csv();
    bench.ok(&["convert", GOOD, "-o", "take.mcap"]);
    bench.ok(&["process", "take.mcap", "-o", "processed.mcap"]);
    for file in [GOOD, "take.mcap", "processed.mcap"] {
        let text = bench.ok(&["check", file, "--fail-on", "warn"]);
        assert!(
            text.contains("metres agree with a hand of 1"),
            "{file}: {text}"
        );
        assert!(
            text.ends_with("usable segments: 11 of 11\n"),
            "{file}: {text}"
        );
    }
}

#[test]
fn planted_gaps_are_found_and_decide_the_exit() {
    let bench = Bench::csv();
    bench.edit(GOOD, |csv| blank(&csv, "Ring", 400..430));
    let text = bench.ok(&["check", GOOD]);
    assert!(
        text.starts_with("warn  ring: 1 gap longer than 0.10 s (4.00 s) stays open; 2.5 % missing"),
        "{text}"
    );
    assert!(text.ends_with("usable segments: 10 of 11\n"), "{text}");
    assert_eq!(
        bench
            .inhand(&["check", GOOD, "--fail-on", "warn"])
            .status
            .code(),
        Some(3)
    );
    let text = bench.ok(&["check", GOOD, "--fail-on", "warn", "--max-gap", "0.3"]);
    assert!(text.contains("ring: 1 gap, 2.5 % of the take"), "{text}");
}

#[test]
fn a_header_that_disagrees_with_the_data_is_found() {
    let bench = Bench::csv();
    let good = String::from_utf8(bench.bytes(GOOD)).expect("the take is text");
    assert_eq!(complaints(&checked(&bench, GOOD)), Vec::<String>::new());
    bench.write(
        "units.csv",
        good.replace("Length Units,Meters", "Length Units,Millimeters"),
    );
    assert_eq!(complaints(&checked(&bench, "units.csv")), ["units"]);
    let text = bench.ok(&["check", "units.csv"]);
    assert!(
        text.contains("in millimetres; it would be 1") && text.contains("in metres"),
        "{text}"
    );

    // W, X, Y, Z under a header that says X, Y, Z, W.
    let mut rows: Vec<String> = good.split_inclusive('\n').map(str::to_owned).collect();
    for row in &mut rows[7..] {
        let mut cells: Vec<_> = row.trim_end().split(',').map(str::to_owned).collect();
        cells[2..6].rotate_right(1);
        *row = cells.join(",") + "\r\n";
    }
    bench.write("scalar_first.csv", rows.concat());
    assert!(complaints(&checked(&bench, "scalar_first.csv")).contains(&"axes Hand".to_owned()));

    // Positions with y and z swapped, rotations left as they are.
    let mut rows: Vec<String> = good.split_inclusive('\n').map(str::to_owned).collect();
    let kinds: Vec<String> = rows[5].trim_end().split(',').map(str::to_owned).collect();
    let axes: Vec<String> = rows[6].trim_end().split(',').map(str::to_owned).collect();
    for row in &mut rows[7..] {
        let mut cells: Vec<_> = row.trim_end().split(',').map(str::to_owned).collect();
        for column in 2..cells.len() - 1 {
            if kinds[column] == "Position" && axes[column] == "Y" {
                cells.swap(column, column + 1);
            }
        }
        *row = cells.join(",") + "\r\n";
    }
    bench.write("swapped.csv", rows.concat());
    let text = bench.ok(&["check", "swapped.csv"]);
    assert!(text.contains("axes (x, z, y)"), "{text}");
}

#[test]
fn several_takes_are_ranked_and_one_that_cannot_be_read_does_not_end_it() {
    let bench = Bench::csv();
    bench.edit(GOOD, |csv| blank(&csv, "Little", 0..1200));
    bench.write("broken.csv", "Format Version,1.23\nnothing else\n");
    let output = bench.inhand(&["check", OTHER, GOOD, "broken.csv", "missing.csv"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).expect("output is UTF-8");
    let place = |words: &str| {
        text.find(words)
            .unwrap_or_else(|| panic!("{words}: {text}"))
    };
    assert!(
        text.starts_with("4 takes: 2 cannot be read, 1 fails, 1 OK"),
        "{text}"
    );
    assert!(place("broken.csv") < place("missing.csv") && place("missing.csv") < place(name(GOOD)));
    assert!(place("fail  little: never seen") < place(&format!("OK: {}", name(OTHER))));
    let all = ["check", OTHER, GOOD, "broken.csv", "--fail-on", "never"];
    bench.ok(&all);
}

#[test]
fn outputs_follow_the_rules_of_all_commands() {
    let bench = Bench::csv();
    bench.ok(&["check", GOOD, "--format", "markdown", "-o", "check.md"]);
    let markdown = String::from_utf8(bench.bytes("check.md")).expect("Markdown is text");
    assert!(
        markdown.starts_with("### train/cube\\_train\\_01.csv"),
        "{markdown}"
    );
    for (target, force) in [("check.md", false), (GOOD, true)] {
        let mut args = vec!["check", GOOD, "-o", target];
        args.extend(force.then_some("--force"));
        let before = bench.bytes(target);
        assert_eq!(bench.inhand(&args).status.code(), Some(2), "{target}");
        assert_eq!(bench.bytes(target), before, "{target}");
    }
    bench.ok(&["check", GOOD, "-o", "check.md", "--force"]);
    assert_eq!(bench.inhand(&["check"]).status.code(), Some(2));
    assert_eq!(
        bench
            .inhand(&["check", GOOD, "--up", "north"])
            .status
            .code(),
        Some(2)
    );
}
