//! Many sessions: `batch`, `report merge`, `compare`.

use std::sync::LazyLock;

use serde_json::Value;

use crate::support::{Bench, SMALL, stderr};

/// Two small sessions of different seeds, run; `b_other` is `b` with another threshold of contacts, `b_window` with
/// another filter.
static SESSIONS: LazyLock<Bench> = LazyLock::new(|| {
    let bench = Bench::empty();
    for (name, seed) in [("a", "7"), ("b", "8")] {
        simulate(&bench, name, seed);
        run(&bench, name, &format!("out/{name}"), &[]);
    }
    run(&bench, "b", "out/b_other", &["--tau-mm", "4"]);
    run(&bench, "b", "out/b_window", &["--window", "30"]);
    bench
});

const METHODS: [&str; 4] = ["--methods", "prior,hermite,line", "--take-methods", "all"];

fn simulate(bench: &Bench, name: &str, seed: &str) {
    let sizes = ["--takes", "2", "--duration", "12", "--seed", seed];
    bench.ok(&[&["simulate", "-o", name][..], &sizes].concat());
}

fn run(bench: &Bench, session: &str, out: &str, options: &[&str]) -> String {
    bench.ok(&[&["run", session, "-o", out], &SMALL[..], &METHODS, options].concat())
}

/// A folder of its own with a copy of a part.
fn copy_of(part: &str) -> Bench {
    let bench = Bench::empty();
    for file in ["evaluation.json", "rows.parquet"] {
        bench.write(
            &format!("part/{file}"),
            SESSIONS.bytes(&format!("{part}/{file}")),
        );
    }
    bench
}

/// Errors of all fingers of a method, millimetres, from rows as CSV.
fn errors_mm(csv: &str, method: &str) -> Vec<f64> {
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().expect("a line of names");
    let column = |name: &str| head.iter().position(|own| *own == name).expect("a column");
    let of_method = column("method");
    let fingers = ["thumb", "index", "middle", "ring", "little"];
    let columns = fingers.map(|finger| column(&format!("{finger}.error_m")));
    lines
        .filter(|cells| cells[of_method] == method)
        .flat_map(|cells| {
            columns.map(|column| cells[column].parse::<f64>().expect("a number") * 1e3)
        })
        .collect()
}

/// Type 7.
fn quantile(values: &mut [f64], q: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let h = (values.len() - 1) as f64 * q;
    let (below, share) = (h.floor() as usize, h.fract());
    let above = values[(below + 1).min(values.len() - 1)];
    values[below] + share * (above - values[below])
}

#[test]
fn quantiles_over_sessions_are_those_of_all_their_rows() {
    let bench = &*SESSIONS;
    bench.ok(&[
        "report", "merge", "out/a", "out/b", "-o", "all.json", "-o", "all.html", "-o", "all.csv",
    ]);
    let summary = bench.json("all.json");
    let mut rows = Vec::new();
    for name in ["a", "b"] {
        let take = format!("out/{name}/cube_test_01.mcap");
        let dictionary = format!("out/{name}/dictionary.mcap");
        let (json, csv) = (format!("{name}.json"), format!("{name}.csv"));
        bench.ok(&[
            "evaluate",
            &take,
            "-d",
            &dictionary,
            "-o",
            &json,
            "--rows",
            &csv,
        ]);
        rows.push(String::from_utf8(bench.bytes(&csv)).expect("a table is text"));
    }
    let close = |found: &Value, expected: f64, what: &str| {
        let found = found.as_f64().expect("a number");
        assert!(
            (found - expected).abs() <= 1e-6,
            "{what}: {found}, {expected}"
        );
    };
    for method in summary["methods"].as_array().expect("methods") {
        let name = method["name"].as_str().expect("a name");
        let mut pooled: Vec<f64> = rows.iter().flat_map(|csv| errors_mm(csv, name)).collect();
        let found = &method["error_mm"]["all"];
        assert_eq!(found["n"], pooled.len());
        close(
            &found["mean"],
            pooled.iter().sum::<f64>() / pooled.len() as f64,
            name,
        );
        for (key, q) in [
            ("p5", 0.05),
            ("p50", 0.5),
            ("p75", 0.75),
            ("p95", 0.95),
            ("max", 1.0),
        ] {
            close(&found[key], quantile(&mut pooled, q), key);
        }
        let intervals = summary["intervals"]["methods"].as_array().expect("methods");
        let own = intervals
            .iter()
            .find(|own| own["name"] == name)
            .expect("the same methods");
        let p75 = &own["error_mm"]["all"]["p75"];
        close(&p75["value"], quantile(&mut pooled, 0.75), "value");
        // Two sessions show how far apart two sessions are, not what others would do.
        assert_eq!((&p75["low"], &p75["high"]), (&Value::Null, &Value::Null));
        assert_eq!(
            (&p75["clusters"], &summary["intervals"]["cluster"]),
            (&2.into(), &"session".into())
        );
    }
    let table = String::from_utf8(bench.bytes("all.csv")).expect("a table is text");
    assert_eq!(table.lines().count(), 1 + 2 * 3 * 6);
    let page = String::from_utf8(bench.bytes("all.html")).expect("a page is text");
    assert!(page.contains("2 sessions") && !page.contains("NaN"));
}

#[test]
fn sessions_of_different_settings_are_joined_only_if_asked() {
    let bench = &*SESSIONS;
    let merge = [
        "report",
        "merge",
        "out/a",
        "out/b_other",
        "-o",
        "unlike.html",
    ];
    let refused = bench.inhand(&merge);
    assert_eq!(refused.status.code(), Some(1));
    let message = stderr(&refused);
    for words in ["b_other", "evaluate.tau_mm is 4", "--allow-different"] {
        assert!(message.contains(words), "{message}");
    }
    assert!(!bench.path("unlike.html").exists());
    bench.ok(&[&merge[..], &["--allow-different"]].concat());
    let page = String::from_utf8(bench.bytes("unlike.html")).expect("a page is text");
    assert!(page.contains("evaluate.tau_mm"));
}

/// What is wrong, how it comes about, and words of the error.
type Damage<'a> = (&'a str, &'a dyn Fn(&Bench), &'a str);

#[test]
fn parts_that_are_cut_or_of_another_run_are_refused_by_name() {
    let cases: [Damage<'_>; 6] = [
        (
            "another version",
            &|bench| {
                bench.edit("part/evaluation.json", |text| {
                    text.replacen("\"schema_version\": 1", "\"schema_version\": 9", 1)
                });
            },
            "schema_version is 9",
        ),
        (
            "a cut evaluation",
            &|bench| {
                bench.edit("part/evaluation.json", |text| {
                    text[..text.len() / 2].to_owned()
                });
            },
            "not an evaluation",
        ),
        (
            "cut rows",
            &|bench| {
                let bytes = bench.bytes("part/rows.parquet");
                bench.write("part/rows.parquet", &bytes[..bytes.len() * 2 / 3]);
            },
            "a whole Parquet file",
        ),
        (
            "rows of another run",
            &|bench| bench.write("part/rows.parquet", SESSIONS.bytes("out/a/rows.parquet")),
            "different runs",
        ),
        (
            "no rows",
            &|bench| std::fs::remove_file(bench.path("part/rows.parquet")).expect("it is there"),
            "no rows.parquet",
        ),
        (
            "no rows of ours",
            &|bench| {
                bench.write(
                    "part/rows.parquet",
                    SESSIONS.bytes("out/a/segments.parquet"),
                );
            },
            "other content",
        ),
    ];
    for (what, change, words) in cases {
        let bench = copy_of("out/b");
        change(&bench);
        let refused = bench.inhand(&["report", "merge", "part", "-o", "x.html"]);
        let message = stderr(&refused);
        assert_eq!(refused.status.code(), Some(1), "{what}: {message}");
        assert!(
            message.contains("part/") && message.contains(words),
            "{what}: {message}"
        );
        assert!(!bench.path("x.html").exists(), "{what}");
    }
    let twice = SESSIONS.inhand(&[
        "report",
        "merge",
        "out/a",
        "out/a/evaluation.json",
        "-o",
        "x.html",
    ]);
    assert!(stderr(&twice).contains("given twice"), "{}", stderr(&twice));
}

#[test]
fn names_of_sessions_stay_text() {
    let bench = copy_of("out/a");
    let hostile = "</title><script>alert(1)</script>";
    bench.edit("part/evaluation.json", |text| {
        text.replacen(
            "\"participant\": null",
            &format!("\"participant\": \"{hostile}\""),
            1,
        )
    });
    bench.ok(&["report", "merge", "part", "-o", "x.html", "-o", "x.md"]);
    // However the part is named, the page is the same.
    let other = bench.path("part/evaluation.json");
    let other = other.to_str().expect("a path in UTF-8");
    bench.ok(&["report", "merge", other, "-o", "other.html"]);
    assert!(bench.bytes("other.html") == bench.bytes("x.html"));
    for file in ["x.html", "x.md"] {
        let text = String::from_utf8(bench.bytes(file)).expect("text");
        assert!(!text.contains("<script>alert"), "{file}");
    }
    let page = String::from_utf8(bench.bytes("x.html")).expect("text");
    assert!(page.contains("&lt;script&gt;alert(1)"));
}

#[test]
fn a_method_is_compared_with_itself_before_and_with_another() {
    let bench = &*SESSIONS;
    // The same takes with another threshold: the very errors.
    let same = bench.ok(&["compare", "out/b", "out/b_other"]);
    for words in [
        "Settings that differ:\n  evaluate.tau_mm: 5.0 -> 4.0\n",
        "Verdict on prior, all fingers, held out: no change beyond noise\n",
        "Verdict on prior, all fingers, published: no change beyond noise\n",
        "the same ones for both",
    ] {
        assert!(same.contains(words), "{words}: {same}");
    }
    assert!(!same.contains("reference"), "{same}");
    bench.ok(&[
        "compare",
        "out/b",
        "out/b_other",
        "--fail-if",
        "p75 > 0%",
        "--fail-if",
        "p75 < 0%",
    ]);

    let methods = [
        "compare",
        "out/b",
        "--method",
        "prior",
        "--against",
        "hermite",
    ];
    let text = bench.ok(&[&methods[..], &["-o", "pr.md"]].concat());
    assert!(
        text.contains("Verdict on hermite -> prior, all fingers, held out: "),
        "{text}"
    );
    let markdown = String::from_utf8(bench.bytes("pr.md")).expect("text");
    assert!(
        markdown.contains("| hermite -&gt; prior | held out | thumb | 75 % |"),
        "{markdown}"
    );

    let json: Value =
        serde_json::from_str(&bench.ok(&[&methods[..], &["--format", "json"]].concat()))
            .expect("JSON");
    let change = &json["errors"][3];
    assert_eq!(
        (&change["measure"], &change["finger"]),
        (&"p75".into(), &"all".into())
    );
    let of = |name: &str| {
        let evaluation = bench.json("out/b/evaluation.json");
        let methods = evaluation["methods"].as_array().expect("methods").clone();
        let own = methods
            .into_iter()
            .find(|own| own["name"] == name)
            .expect("evaluated");
        own["error_mm"]["all"]["p75"].as_f64().expect("a number")
    };
    let (before, after) = (of("hermite"), of("prior"));
    let found = change["relative_change"].as_f64().expect("a number");
    // Rows are stored to half a nanometre, here are millimetres.
    let off_mm = (found - (after - before) / before).abs() * before;
    assert!(off_mm < 1e-6 * (1.0 + after / before), "{off_mm} mm");
    let [low, high] =
        ["low", "high"].map(|end| change["relative"][end].as_f64().expect("a number"));
    assert!(low <= found && found <= high);

    let worse = if after > before {
        "p75 > 0%"
    } else {
        "p75 < 0%"
    };
    let failed = bench.inhand(&[&methods[..], &["--fail-if", worse]].concat());
    assert_eq!(failed.status.code(), Some(3));
    assert!(
        stderr(&failed).contains("check failed: p75"),
        "{}",
        stderr(&failed)
    );
}

#[test]
fn another_reference_is_stated_before_any_number() {
    let bench = &*SESSIONS;
    let compare = ["compare", "out/b", "out/b_window"];
    let text = bench.ok(&compare);
    let head = "The reference changed: errors before and after are distances to different motion.\n  \
                process.window: 50 -> 30\n";
    assert!(text.starts_with(head), "{text}");
    assert!(text.contains(", against another reference\n"), "{text}");
    // One screen, but for all.
    assert!(text.lines().count() <= 24, "{text}");
    let all = bench.ok(&[&compare[..], &["--all"]].concat());
    assert!(all.starts_with(head), "{all}");
    assert!(
        all.lines().count() > METHODS[1].split(',').count() * 30,
        "{all}"
    );
    let json: Value =
        serde_json::from_str(&bench.ok(&[&compare[..], &["--format", "json"]].concat()))
            .expect("JSON");
    let expected = serde_json::json!([{ "key": "process.window", "before": "50", "after": "30" }]);
    assert_eq!(json["reference_that_differs"], expected);

    // Made in single steps, only `process` knows the filter.
    let take = format!("b/test/{}", bench.files("b/test")[0]);
    bench.ok(&["process", &take, "-o", "p.mcap", "--window", "30"]);
    let dictionary = ["-d", "out/b/dictionary.mcap"];
    let methods = ["--methods", "prior,hermite,line"];
    bench.ok(&[
        &["generate", "p.mcap", "-o", "g.mcap"][..],
        &dictionary,
        &methods,
    ]
    .concat());
    bench.ok(&[&["evaluate", "g.mcap", "-o", "steps.json"][..], &dictionary].concat());
    let steps = bench.ok(&["compare", "out/b", "steps.json"]);
    assert!(
        steps.starts_with(head) && !steps.contains("test files"),
        "{steps}"
    );
    assert!(
        steps.contains("prior, all fingers, published: undetermined without intervals"),
        "{steps}"
    );
}

#[test]
fn sessions_of_other_segments_are_drawn_apart_and_nonsense_is_refused() {
    let bench = &*SESSIONS;
    let apart = bench.ok(&["compare", "out/a", "out/b", "--method", "prior"]);
    assert!(apart.contains("drawn apart"), "{apart}");
    assert!(
        apart.contains("  test files: cube_test_01.csv ("),
        "{apart}"
    );
    for (args, code, words) in [
        (&["out/b"][..], 2, "nothing to compare"),
        (
            &["out/b", "--method", "residual"],
            1,
            "no method \"residual\"",
        ),
        (&["out/a", "out/b", "--fail-if", "p75 5%"], 2, "no operator"),
        (
            &[
                "out/a",
                "out/b",
                "--method",
                "prior",
                "--fail-if",
                "line:p75 > 5%",
            ],
            2,
            "no such method",
        ),
        (
            &[
                "out/a",
                "out/b",
                "--draws",
                "0",
                "--fail-if",
                "p75.low > 5%",
            ],
            2,
            "no interval",
        ),
        (&["out/a", "nowhere"], 1, "nowhere"),
    ] {
        let refused = bench.inhand(&[&["compare"], args].concat());
        let message = stderr(&refused);
        assert_eq!(refused.status.code(), Some(code), "{args:?}: {message}");
        assert!(message.contains(words), "{args:?}: {message}");
    }
}

#[test]
fn a_batch_goes_past_a_bad_session_and_goes_on_later() {
    let bench = Bench::empty();
    for (name, seed) in [("good", "7"), ("bad", "8")] {
        simulate(&bench, name, seed);
    }
    let take = bench.files("bad/test")[0].clone();
    let sound = bench.bytes(&format!("bad/test/{take}"));
    // Cut in the header.
    bench.write(&format!("bad/test/{take}"), &sound[..400]);

    let batch = [
        &["batch", "bad", "good", "-o", "results"],
        &SMALL[..],
        &METHODS,
    ]
    .concat();
    let first = bench.inhand(&batch);
    let message = stderr(&first);
    assert_eq!(first.status.code(), Some(3), "{message}");
    assert!(
        message.contains("failed   bad: ") && message.contains(&take),
        "{message}"
    );
    assert!(
        message.contains("2 sessions, 1 done, 1 failed"),
        "{message}"
    );
    assert!(bench.path("results/good/report.html").exists());
    let page = String::from_utf8(bench.bytes("results/summary.html")).expect("a page is text");
    assert!(page.contains("1 session"));
    let states = || -> Vec<(String, String)> {
        let record = bench.json("results/batch.json");
        let sessions = record["sessions"].as_array().expect("sessions").clone();
        let text = |value: &Value| value.as_str().expect("a word").to_owned();
        sessions
            .iter()
            .map(|s| (text(&s["name"]), text(&s["state"])))
            .collect()
    };
    let expected = |bad: &str, good: &str| {
        vec![
            ("bad".to_owned(), bad.to_owned()),
            ("good".to_owned(), good.to_owned()),
        ]
    };
    assert_eq!(states(), expected("failed", "done"));
    // The one that failed is not in this call.
    let good = [&["batch", "good", "-o", "results"], &SMALL[..], &METHODS].concat();
    let alone = bench.inhand(&good);
    assert_eq!(alone.status.code(), Some(0), "{}", stderr(&alone));
    assert!(
        stderr(&alone).contains("1 sessions, 1 up to date\n"),
        "{}",
        stderr(&alone)
    );

    bench.write(&format!("bad/test/{take}"), &sound);
    let second = bench.inhand(&batch);
    let table = String::from_utf8_lossy(&second.stdout);
    let heads: Vec<_> = table
        .lines()
        .take(2)
        .flat_map(str::split_whitespace)
        .collect();
    assert_eq!(
        heads.join(" "),
        "held out published 3+ errors in mm median 95 % median contacts"
    );
    let rows = table.lines().take(5);
    assert!(rows.clone().all(|row| row.chars().count() <= 80), "{table}");
    assert_eq!(second.status.code(), Some(0), "{}", stderr(&second));
    assert_eq!(states(), expected("done", "up_to_date"));
    let page = String::from_utf8(bench.bytes("results/summary.html")).expect("a page is text");
    assert!(page.contains("2 sessions"));

    // Sessions of earlier calls stay in the report, in folders of their own, and can be joined again.
    bench.ok(&good);
    assert_eq!(states(), expected("done", "up_to_date"));
    bench.ok(&["report", "merge", "results", "-o", "again.html"]);
    std::fs::create_dir(bench.path("none")).expect("a folder");
    bench.write("none/batch.json", r#"{"sessions": []}"#);
    let refused = bench.inhand(&["report", "merge", "none", "-o", "x.html"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(stderr(&refused).contains("none of them has results"));
    for page in ["results/summary.html", "again.html"] {
        let page = String::from_utf8(bench.bytes(page)).expect("a page is text");
        assert!(page.contains("2 sessions"));
    }
    bench.edit("results/bad/evaluation.json", |text| {
        text[..text.len() / 2].to_owned()
    });
    std::fs::remove_dir_all(bench.path("bad")).expect("it is there");
    let gone = bench.inhand(&good);
    assert_eq!(gone.status.code(), Some(0), "{}", stderr(&gone));
    assert!(
        stderr(&gone).contains("leaves out sessions of earlier calls: results/bad/"),
        "{}",
        stderr(&gone)
    );
    let page = String::from_utf8(bench.bytes("results/summary.html")).expect("a page is text");
    assert!(
        !page.contains("2 sessions"),
        "no report over other sessions stays"
    );

    let nothing = bench.inhand(&["batch", "nowhere", "-o", "none"]);
    assert_eq!(nothing.status.code(), Some(1), "{}", stderr(&nothing));
    bench.write("taken/summary.html", "mine");
    let taken = bench.inhand(&[&["batch", "good", "-o", "taken"], &SMALL[..]].concat());
    assert_ne!(taken.status.code(), Some(0));
    assert_eq!(bench.bytes("taken/summary.html"), b"mine");
}
