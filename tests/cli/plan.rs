//! `inhand plan`: one motion from a start to a goal.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::support::{Bench, stderr};

const TAKE: &str = "out/cube_test_01.mcap";
const PLAN: [&str; 5] = [
    "plan",
    "--dictionary",
    "out/dictionary.mcap",
    "-o",
    "plan.mcap",
];

fn planned(bench: &Bench, options: &[&str]) -> Value {
    let args = [&PLAN[..], &["--format", "json", "--force"], options].concat();
    serde_json::from_str(&bench.ok(&args)).expect("the outcome is JSON")
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Number(number) => vec![number.as_f64().expect("a JSON number is one")],
        Value::Array(items) => items.iter().flat_map(numbers).collect(),
        // By name, so in one order for all.
        Value::Object(items) => items.values().flat_map(numbers).collect(),
        _ => Vec::new(),
    }
}

fn distance(a: &Value, b: &Value) -> f64 {
    let (a, b) = (numbers(a), numbers(b));
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(&b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

#[test]
fn from_a_take_to_a_take() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let (start, goal) = (format!("{TAKE}@2.0"), format!("{TAKE}@2.99"));
    let outcome = planned(&bench, &["--from", &start, "--to", &goal]);
    assert_eq!(outcome["method"], "residual");
    assert_eq!(outcome["plans"][0]["status"], "solved");
    let trajectory = outcome["trajectory_m"].as_array().unwrap();
    assert_eq!(trajectory.len(), 100);
    let info = bench.ok(&["info", "plan.mcap"]);
    assert!(info.contains("/generated/residual/fingertips"), "{info}");
    assert!(
        info.contains("/view/generated/residual/fingertips"),
        "{info}"
    );

    // The states as JSON instead, from the motion itself: reached exactly.
    let state = |configuration: &Value| serde_json::json!({ "fingertips_m": configuration });
    bench.write("start.json", state(&trajectory[0]).to_string());
    bench.write("touch.json", state(&trajectory[40]).to_string());
    bench.write("goal.json", state(&trajectory[99]).to_string());
    let hard = [
        "--from",
        "start.json",
        "--to",
        "goal.json",
        "--ends",
        "hard",
    ];
    let again = planned(&bench, &[&hard[..], &["--via", "0.4=touch.json"]].concat());
    for (k, sample) in [(0, 0), (40, 40), (99, 99)] {
        assert!(
            distance(&again["trajectory_m"][k], &trajectory[sample]) < 1e-9,
            "{k}"
        );
    }

    // Some fingers only: the others follow, and need not be there.
    let thumb = ["--fingers", "thumb,index"];
    let some = planned(&bench, &[&hard[..], &thumb].concat());
    let last = &some["trajectory_m"][99];
    assert!(distance(&last["thumb"], &trajectory[99]["thumb"]) < 1e-9);
    assert!(distance(&last["ring"], &trajectory[99]["ring"]) > 1e-6);
}

#[test]
fn longer_motion_is_a_chain_without_a_jump() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let at = |seconds: f64| format!("{TAKE}@{seconds}");
    let via = [format!("1.5={}", at(3.5)), format!("2.0={}", at(4.0))];
    let outcome = planned(
        &bench,
        &[
            "--from",
            &at(2.0),
            "--to",
            &at(4.5),
            "--via",
            &via[0],
            "--via",
            &via[1],
            "--duration",
            "2.5",
            // Training of 24 s shows few velocities.
            "--velocity-factor",
            "3",
        ],
    );
    assert_eq!(outcome["plans"].as_array().unwrap().len(), 3);
    let trajectory = outcome["trajectory_m"].as_array().unwrap();
    assert_eq!(trajectory.len(), 251);
    let steps: Vec<f64> = trajectory
        .windows(2)
        .map(|pair| distance(&pair[0], &pair[1]))
        .collect();
    let longest = steps.iter().copied().fold(0.0, f64::max);
    assert!(longest < 5e-3, "a step of {longest} m");
}

#[test]
fn what_cannot_be_is_explained() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let ends = [format!("{TAKE}@2.0"), format!("{TAKE}@6.0")];
    let hard = [
        "--from",
        &ends[0],
        "--to",
        &ends[1],
        "--ends",
        "hard",
        "--velocity-m-s",
        "0.0001",
    ];
    let output = bench.inhand(&[&PLAN[..], &hard].concat());
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        text.contains("velocity would have to be relaxed by"),
        "{text}"
    );
    assert!(text.contains("m/s alone"), "{text}");
    assert!(!bench.path("plan.mcap").exists());
}

#[test]
fn bad_states_name_the_value_and_the_limit() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let start = format!("{TAKE}@2.0");
    let tips = r#"{"fingertips_m": {"thumb": [0.01, 0.02, 0.03]}}"#;
    bench.write("goal.json", tips);
    bench.write("other.json", tips.replace("0.01", "0.02"));
    bench.write("pinkie.json", tips.replace("thumb", "pinkie"));
    bench.write("mm.json", tips.replace("0.03", "30"));
    bench.write("nan.json", tips.replace("0.03", "NaN"));
    for (options, words) in [
        (vec!["--to", "pinkie.json"], vec!["pinkie", "thumb, index"]),
        (vec!["--to", "mm.json"], vec!["thumb", "30", "10"]),
        (vec!["--to", "nan.json"], vec!["nan.json", "line 1"]),
        (
            vec!["--to", "out/cube_test_01.mcap@99"],
            vec!["99", "11.99"],
        ),
        (
            vec!["--to", "goal.json", "--fingers", "pinkie"],
            vec!["pinkie"],
        ),
        (
            vec!["--to", "goal.json", "--via", "1.7=other.json"],
            vec!["1.7", "0.99"],
        ),
        (
            vec![
                "--to",
                "goal.json",
                "--via",
                "0.5=goal.json",
                "--via",
                "0.5=other.json",
            ],
            vec!["thumb", "0.5"],
        ),
        (
            vec!["--to", "goal.json", "--method", "line"],
            vec!["line", "residual"],
        ),
        (vec!["--to", "goal.json", "--method", "auto"], vec!["auto"]),
        (
            vec!["--to", "goal.json", "--holding", "--object", "cube:0.05"],
            vec!["goal"],
        ),
    ] {
        let output = bench.inhand(&[&PLAN[..], &["--from", &start], &options].concat());
        let message = stderr(&output);
        assert!(
            matches!(output.status.code(), Some(1 | 2)),
            "{options:?}: {message}"
        );
        for word in words {
            assert!(
                message.contains(word),
                "{options:?}: \"{word}\" in: {message}"
            );
        }
        assert!(!message.contains("panicked"), "{message}");
        assert!(!bench.path("plan.mcap").exists(), "{options:?}");
    }
}

#[test]
fn a_dictionary_of_another_rate_is_refused() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    bench.ok(&[
        "simulate",
        "-o",
        "faster",
        "--takes",
        "1",
        "--duration",
        "6",
        "--rate",
        "120",
    ]);
    let output = bench.inhand(&[
        "generate",
        "--dictionary",
        "out/dictionary.mcap",
        "faster/test/cube_test_01.csv",
        "-o",
        "generated.mcap",
    ]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("100 samples at 100 Hz"), "{message}");
    assert!(message.contains("120 samples at 120 Hz"), "{message}");
    assert!(!bench.path("generated.mcap").exists());
}

#[test]
fn auto_says_what_it_chose_and_the_dictionary_remembers() {
    let bench = Bench::csv();
    let table = bench.run("out", &["--methods", "auto,hermite,line"]);
    assert!(table.contains("auto chose"), "{table}");
    let evaluation = bench.json("out/evaluation.json");
    let choice = &evaluation["choice"];
    assert_eq!(evaluation["default_method"], choice["method"]);
    let errors: Vec<f64> = (choice["candidates"].as_array().unwrap().iter())
        .map(|candidate| candidate["mean_error_mm"].as_f64().unwrap())
        .collect();
    assert_eq!(errors.len(), 7);
    assert!(choice["segments"].as_u64().unwrap() > 10, "{choice}");
    let ends = [format!("{TAKE}@2.0"), format!("{TAKE}@2.99")];
    let args = ["--from", &ends[0], "--to", &ends[1], "--method", "auto"];
    if ["residual", "prior", "paper"].contains(&choice["method"].as_str().unwrap()) {
        assert_eq!(planned(&bench, &args)["method"], choice["method"]);
    }
}

#[test]
fn a_missed_goal_is_not_solved() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let start = format!("{TAKE}@2.0");
    bench.write(
        "goal.json",
        r#"{"fingertips_m": {"thumb": [0.3, 0.0, 0.0]}}"#,
    );
    let far = ["--from", &start, "--to", "goal.json", "--force"];
    let call = [&PLAN[..], &far, &["--format", "json"]].concat();
    let output = bench.inhand(&call);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(
        message.contains("warning  target of thumb at 0.99 s is"),
        "{message}"
    );
    assert!(
        message.contains("mm outside its training hull"),
        "{message}"
    );
    let outcome: Value = serde_json::from_slice(&output.stdout).expect("the outcome is JSON");
    assert_eq!(outcome["status"], "missed");
    assert_eq!(outcome["plans"][0]["status"], "solved");
    let miss_m = outcome["worst_miss_m"].as_f64().unwrap();
    assert!((0.01..0.4).contains(&miss_m), "{miss_m}");
    let targets = outcome["targets"].as_array().unwrap();
    // Five fingers at the start, one at the goal.
    assert_eq!(targets.len(), 6);
    assert_eq!(targets[5]["finger"], "thumb");
    assert_eq!(targets[5]["miss_m"], miss_m);
    assert!(bench.path("plan.mcap").is_file());

    let text = bench.ok(&[&PLAN[..], &far, &["--allow-miss"]].concat());
    assert!(text.contains(" · missed by "), "{text}");
    assert!(text.contains(" mm (thumb at 0.99 s)"), "{text}");
    let met = format!("{TAKE}@2.99");
    let outcome = planned(&bench, &["--from", &start, "--to", &met]);
    assert_eq!(outcome["status"], "solved");
}

/// Rows of a table without quotes, each by heading.
fn rows(bench: &Bench, name: &str) -> Vec<BTreeMap<String, f64>> {
    let text = String::from_utf8(bench.bytes(name)).expect("tables are text");
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned));
    let heading: Vec<String> = lines.next().expect("a heading").collect();
    let numbers = |cells: &mut dyn Iterator<Item = String>| {
        let cells = heading.iter().cloned().zip(cells);
        cells
            .filter_map(|(name, cell)| Some((name, cell.parse().ok()?)))
            .collect()
    };
    lines.map(|mut cells| numbers(&mut cells)).collect()
}

#[test]
fn a_plan_is_a_table_of_times_positions_and_velocities() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let ends = [format!("{TAKE}@2.0"), format!("{TAKE}@4.5")];
    let ends = [
        "--from",
        &ends[0],
        "--to",
        &ends[1],
        "--duration",
        "2.5",
        "--velocity-factor",
        "3",
    ];
    let outcome = planned(&bench, &ends);
    let table = ["plan", "-d", "out/dictionary.mcap", "-o", "plan.csv"];
    bench.ok(&[&table[..], &ends].concat());
    let trajectory = outcome["trajectory_m"].as_array().unwrap();
    let found = rows(&bench, "plan.csv");
    assert_eq!(found.len(), trajectory.len());
    for (k, row) in found.iter().enumerate() {
        assert_eq!(row["time_s"], k as f64 / 100.0);
        let thumb = ["x", "y", "z"].map(|axis| row[&format!("thumb.{axis}_m")]);
        assert_eq!(thumb.to_vec(), numbers(&trajectory[k]["thumb"]));
    }
    // Across the joints of the chain too.
    for k in 1..found.len() - 1 {
        let velocity = (found[k + 1]["ring.y_m"] - found[k - 1]["ring.y_m"]) * 50.0;
        assert!((found[k]["ring.vy_m_s"] - velocity).abs() < 1e-12, "{k}");
    }
    let first = (found[1]["ring.y_m"] - found[0]["ring.y_m"]) * 100.0;
    assert!((found[0]["ring.vy_m_s"] - first).abs() < 1e-12);

    // The file of the same plan gives the same table, without being asked what of it.
    bench.ok(&["export", "plan.mcap", "-o", "exported.csv"]);
    assert_eq!(
        String::from_utf8(bench.bytes("plan.csv")),
        String::from_utf8(bench.bytes("exported.csv"))
    );
    bench.ok(&[&table[..4], &["plan.parquet"], &ends].concat());
    assert!(bench.bytes("plan.parquet").starts_with(b"PAR1"));
    let refused = bench.inhand(&[&table[..4], &["plan.json"], &ends].concat());
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        stderr(&refused).contains(".mcap, .csv, .parquet"),
        "{}",
        stderr(&refused)
    );
}

#[test]
fn states_of_the_fixtures_are_those_of_their_take_and_can_be_planned_between() {
    let bench = Bench::empty();
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let path = |name: &str| fixtures.join(name).display().to_string();
    let test = path("cube/test/cube_test_01.csv");
    bench.ok(&["process", &test, "-o", "hand.mcap"]);
    bench.ok(&[
        "export",
        "hand.mcap",
        "--what",
        "processed",
        "-o",
        "hand.csv",
    ]);
    let hand = rows(&bench, "hand.csv");
    for (name, sample) in [("start.json", 100), ("goal.json", 199)] {
        let state: Value = serde_json::from_slice(&std::fs::read(path(name)).unwrap()).unwrap();
        for finger in ["thumb", "index", "middle", "ring", "little"] {
            for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
                let stated = state["fingertips_m"][finger][axis].as_f64().unwrap();
                assert!((stated - hand[sample][&format!("{finger}.{letter}_m")]).abs() < 1e-6);
            }
        }
    }
    let train = [
        path("cube/train/cube_train_01.csv"),
        path("cube/train/cube_train_02.csv"),
    ];
    bench.ok(&[
        "learn", &train[0], &train[1], "-o", "d.mcap", "--rank", "20", "--stride", "10",
    ]);
    let (start, goal) = (path("start.json"), path("goal.json"));
    let plan = [
        "plan", "-d", "d.mcap", "--from", &start, "--to", &goal, "-o", "plan.csv",
    ];
    let text = bench.ok(&plan);
    assert!(text.contains(" solved · targets met within "), "{text}");
    let help = bench.ok(&["plan", "--help"]);
    assert!(help.contains("fixtures/goal.json"), "{help}");
}
