//! Single steps, one file after the other.

use crate::support::{Bench, SMALL, without_provenance};

#[test]
fn single_steps_give_the_numbers_of_a_run() {
    let bench = Bench::csv();
    let train = ["recorded/cube_train_01.mcap", "recorded/cube_train_02.mcap"];
    let csv = [
        "session/train/cube_train_01.csv",
        "session/train/cube_train_02.csv",
    ];
    bench.ok(&[
        &["convert"],
        &csv[..],
        &["session/test/cube_test_01.csv", "-o", "recorded"],
    ]
    .concat());
    let cube = ["--object", "cube:0.05"];
    let test = "recorded/cube_test_01.mcap";
    bench.ok(&[&["process"], &train[..], &[test, "-o", "processed"], &cube].concat());
    let processed = [
        "processed/cube_train_01.mcap",
        "processed/cube_train_02.mcap",
    ];
    let learned = bench.ok(&[
        &["learn"],
        &processed[..],
        &["-o", "d.mcap", "--format", "json"],
        &SMALL,
    ]
    .concat());
    let learned: serde_json::Value = serde_json::from_str(&learned).expect("learn prints JSON");
    for key in ["rms_mm", "relative_error", "iterations"] {
        assert!(
            learned[key].as_f64().is_some_and(|v| v > 0.0),
            "{key}: {learned}"
        );
    }
    let test = "processed/cube_test_01.mcap";
    bench.ok(&[
        &["generate", test, "-d", "d.mcap", "-o", "generated.mcap"],
        &cube[..],
    ]
    .concat());
    bench.ok(&[
        &[
            "evaluate",
            "generated.mcap",
            "-d",
            "d.mcap",
            "-o",
            "evaluation.json",
            "--rows",
            "rows.csv",
        ],
        &cube[..],
    ]
    .concat());
    let rows = String::from_utf8(bench.bytes("rows.csv")).expect("a table is text");
    rows_give_the_numbers(&rows, &bench.json("evaluation.json"));
    let rows = String::from_utf8(bench.bytes("rows.held_out.csv")).expect("a table is text");
    rows_give_the_numbers(&rows, &bench.json("evaluation.json")["held_out"]);
    bench.ok(&["report", "evaluation.json", "-o", "report.html"]);

    bench.run("out", &[]);
    let mut run = without_provenance(bench.json("out/evaluation.json"));
    // The single steps do not inspect the session.
    run["inspection"] = serde_json::Value::Null;
    let steps = without_provenance(bench.json("evaluation.json"));
    for key in [
        "dictionary",
        "methods",
        "default_method",
        "held_out",
        "filter_moves_mm",
    ] {
        assert_eq!(steps[key], run[key], "{key}");
    }
    assert_eq!(learned["rms_mm"], run["dictionary"]["rms_mm"]);
    assert!(
        String::from_utf8(bench.bytes("report.html"))
            .unwrap()
            .contains("hermite")
    );
}

#[test]
fn lines_of_boundary_conditions_are_a_setting() {
    let bench = Bench::csv();
    bench.run("out", &["--ends-s", "0.12"]);
    let evaluation = bench.json("out/evaluation.json");
    let held_out = &evaluation["held_out"];
    assert_eq!(
        (&held_out["ends_s"], &held_out["ends_samples"]),
        (&0.12.into(), &12.into())
    );
    assert!(
        held_out["segments"].as_u64().is_some_and(|n| n > 0),
        "{held_out}"
    );
    assert!(evaluation["filter_moves_mm"]["all"]["max"].as_f64() > Some(0.0));
    // Without a filter there is one reference, and still two ways to boundary conditions.
    bench.run("plain", &["--filter", "none"]);
    let plain = bench.json("plain/evaluation.json");
    assert!(plain["filter_moves_mm"].is_null());
    let mean = |methods: &serde_json::Value| methods[3]["error_mm"]["all"]["mean"].clone();
    assert_ne!(mean(&plain["methods"]), mean(&plain["held_out"]["methods"]));
}

/// What an evaluation says of each method and finger, computed anew from the exported rows.
fn rows_give_the_numbers(csv: &str, evaluation: &serde_json::Value) {
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let headings = lines.next().expect("a table has headings");
    let column = |name: &str| {
        let place = headings.iter().position(|heading| *heading == name);
        place.unwrap_or_else(|| panic!("no column {name} in {headings:?}"))
    };
    let rows: Vec<_> = lines.collect();
    let mut compared = 0;
    for method in evaluation["methods"].as_array().expect("methods") {
        let name = method["name"].as_str().expect("a name");
        let of_method = || rows.iter().filter(|row| row[column("method")] == name);
        for finger in ["thumb", "index", "middle", "ring", "little"] {
            let (error, filled) = (
                column(&format!("{finger}.error_m")),
                column(&format!("{finger}.filled")),
            );
            let mut errors_mm: Vec<f64> = (of_method().filter(|row| !row[error].is_empty()))
                .map(|row| row[error].parse::<f64>().expect("a number") * 1000.0)
                .collect();
            errors_mm.sort_by(f64::total_cmp);
            let stated = &method["error_mm"][finger];
            assert_eq!(stated["n"], errors_mm.len());
            let filled = of_method().filter(|row| row[filled] == "1").count();
            assert_eq!(stated["n_filled"], filled);
            for (key, q) in [("p5", 0.05), ("p50", 0.5), ("p75", 0.75), ("max", 1.0)] {
                // Type 7: linear between the order statistics around q (n - 1).
                let place = q * (errors_mm.len() - 1) as f64;
                let (low, high) = (place.floor() as usize, place.ceil() as usize);
                let share = place - place.floor();
                let expected = errors_mm[low] * (1.0 - share) + errors_mm[high] * share;
                let found = stated[key].as_f64().expect("a number");
                assert!((found - expected).abs() < 1e-6, "{name} {finger} {key}");
                compared += 1;
            }
            let contact = |kind: &str| {
                let place = column(&format!("{finger}.{kind}"));
                let touching = of_method().filter(|row| {
                    row[place]
                        .parse::<f64>()
                        .is_ok_and(|d| d.abs() <= 0.005 + 1e-12)
                });
                touching.count() as f64 / of_method().count() as f64
            };
            for (kind, key) in [
                ("distance_m", "by_finger"),
                ("recorded_distance_m", "recorded_by_finger"),
            ] {
                let found = method["contact"][key][finger].as_f64().expect("a share");
                assert!(
                    (found - contact(kind)).abs() < 1e-12,
                    "{name} {finger} {key}"
                );
            }
        }
    }
    assert_eq!(compared, 7 * 5 * 4);
}

#[test]
fn rows_need_a_form_and_a_place_of_their_own() {
    let bench = Bench::empty();
    bench.write("d.mcap", "");
    for (evaluation, rows, said) in [
        (
            "e.json",
            "rows.txt",
            "expected a file that ends in .parquet or .csv",
        ),
        (
            "e.csv",
            "e.csv",
            "-o e.csv: expected a file that ends in .json",
        ),
    ] {
        let output = bench.inhand(&[
            "evaluate", "x", "-d", "d.mcap", "-o", evaluation, "--rows", rows,
        ]);
        assert_eq!(output.status.code(), Some(2));
        assert!(crate::support::stderr(&output).contains(said));
    }
}

#[test]
fn an_explicit_filter_is_not_ignored() {
    let bench = Bench::csv();
    let csv = [
        "session/train/cube_train_01.csv",
        "session/train/cube_train_02.csv",
    ];
    bench.ok(&[&["process"], &csv[..], &["-o", "processed"]].concat());
    let processed = [
        "processed/cube_train_01.mcap",
        "processed/cube_train_02.mcap",
    ];
    let learned = |inputs: &[&str], output: &str, filter: &[&str]| {
        let format = ["-o", output, "--format", "json"];
        let printed = bench.ok(&[&["learn"], inputs, &format[..], filter, &SMALL].concat());
        let outcome: serde_json::Value = serde_json::from_str(&printed).expect("JSON");
        outcome["rms_mm"].clone()
    };
    let raw = learned(&csv, "a.mcap", &["--filter", "none"]);
    assert_eq!(learned(&processed, "b.mcap", &["--filter", "none"]), raw);
    assert_ne!(learned(&processed, "c.mcap", &[]), raw);
}

#[test]
fn another_dictionary_is_no_judge() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    bench.run("out2", &["--seed", "5"]);
    let test = "session/test/cube_test_01.csv";
    bench.ok(&[
        "generate",
        test,
        "-d",
        "out/dictionary.mcap",
        "-o",
        "g.mcap",
    ]);
    let args = [
        "evaluate",
        "g.mcap",
        "-d",
        "out2/dictionary.mcap",
        "-o",
        "e.json",
    ];
    let output = bench.inhand(&args);
    assert_eq!(output.status.code(), Some(1));
    assert!(crate::support::stderr(&output).contains("another dictionary"));
}

#[test]
fn recordings_go_back_to_motive_csv() {
    let bench = Bench::simulated(&["--gaps", "0.02", "--format", "csv"]);
    let source = "session/train/cube_train_01.csv";
    bench.ok(&["convert", source, "-o", "a.mcap"]);
    bench.ok(&["convert", "a.mcap", "-o", "a.csv"]);
    bench.ok(&["convert", "a.csv", "-o", "b.mcap"]);
    let info = |file: &str| -> serde_json::Value {
        serde_json::from_str(&bench.ok(&["info", file, "--format", "json"])).unwrap()
    };
    assert_eq!(info("a.mcap")["channels"], info("b.mcap")["channels"]);
    assert_eq!(info("a.mcap")["fingertips"], info("b.mcap")["fingertips"]);
}

#[test]
fn info_lists_channels() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let info = bench.ok(&["info", "out/cube_test_01.mcap", "--format", "json"]);
    let info: serde_json::Value = serde_json::from_str(&info).unwrap();
    let topics: Vec<_> = info["channels"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["topic"].as_str().unwrap())
        .collect();
    for topic in [
        "/recording/fingertips",
        "/recording/bodies",
        "/recording/markers",
        "/processed/fingertips",
        "/processed/object",
        "/generated/residual/fingertips",
        "/generated/residual/plan",
        "/evaluation/residual/error",
        "/evaluation/residual/contact",
        "/tf",
        "/tf_static",
    ] {
        assert!(topics.contains(&topic), "{topic} in {topics:?}");
    }
    assert!(topics.iter().any(|topic| topic.starts_with("/view/")));
    let (views, bytes) = (info["views_bytes"].as_u64(), info["bytes"].as_u64());
    assert!(views > Some(0) && views < bytes, "{views:?} of {bytes:?}");
    let packed = info["channels"].as_array().unwrap().iter();
    let packed: u64 = packed.map(|c| c["packed_bytes"].as_u64().unwrap()).sum();
    assert!(
        Some(packed) < bytes && 10 * packed > 9 * bytes.unwrap(),
        "{packed}"
    );
    let text = bench.ok(&["info", "out/cube_test_01.mcap"]);
    assert!(text.contains("\nviews "), "{text}");
    assert!(text.contains("/processed/fingertips"));

    bench.run("plain", &["--views=none"]);
    let text = bench.ok(&["info", "plain/cube_test_01.mcap"]);
    assert!(!text.contains("/view/"), "{text}");
}

#[test]
fn settings_print_what_they_read() {
    let bench = Bench::empty();
    let defaults = bench.ok(&["settings"]);
    bench.write("s/inhand.toml", &defaults);
    assert_eq!(bench.ok(&["settings", "s"]), defaults);
    bench.write("s/inhand.toml", "[learn]\nrank = 77\n");
    assert!(bench.ok(&["settings", "s"]).contains("rank = 77"));
}
