//! Motion and contacts of an evaluation, recomputed from its tables; phases as events.

use std::collections::BTreeMap;

use inhand_export::ParquetTable;
use serde_json::Value;

use crate::support::{Bench, stderr};

const FINGERS: [&str; 5] = ["thumb", "index", "middle", "ring", "little"];

/// With gaps, and thresholds that make contacts come and go in a simulated session.
const OPTIONS: [&str; 8] = [
    "--tau-mm",
    "0.6",
    "--min-contact-s",
    "0.02",
    "--max-lift-s",
    "3",
    "--grasp-fingers",
    "1",
];

fn bench() -> Bench {
    let bench = Bench::simulated(&["--format", "csv", "--gaps", "0.05"]);
    bench.run("out", &OPTIONS);
    bench
}

/// A row of a table: words and numbers by column.
#[derive(Debug)]
struct Row {
    words: BTreeMap<&'static str, String>,
    numbers: BTreeMap<&'static str, f64>,
}

impl Row {
    fn is(&self, column: &str, word: &str) -> bool {
        self.words[column] == word
    }

    fn on(&self, column: &str) -> bool {
        self.numbers[column] == 1.0
    }
}

fn table(
    bench: &Bench,
    name: &str,
    words: &[&'static str],
    counts: &[&'static str],
    numbers: &[&'static str],
) -> Vec<Row> {
    let table = ParquetTable::open(&bench.path(name)).expect("run wrote it");
    let all = 0..table.rows();
    let mut rows: Vec<Row> = all
        .clone()
        .map(|_| Row {
            words: BTreeMap::new(),
            numbers: BTreeMap::new(),
        })
        .collect();
    for &column in words {
        let cells = table.words(column, all.clone()).expect("words");
        for (row, cell) in rows.iter_mut().zip(cells) {
            row.words.insert(column, cell);
        }
    }
    for &column in counts {
        let cells = table.counts(column, all.clone()).expect("counts");
        for (row, cell) in rows.iter_mut().zip(cells) {
            row.numbers.insert(column, cell as f64);
        }
    }
    for &column in numbers {
        let cells = table.numbers(column, all.clone()).expect("numbers");
        for (row, cell) in rows.iter_mut().zip(cells) {
            row.numbers.insert(column, cell);
        }
    }
    rows
}

/// A distribution as NumPy would give it, against the one in the evaluation.
fn same(found: &Value, mut values: Vec<f64>, scale: f64, at: &str) {
    assert_eq!(found["n"], values.len(), "{at}");
    if values.is_empty() {
        assert_eq!(found["p50"], Value::Null, "{at}");
        return;
    }
    values.iter_mut().for_each(|value| *value *= scale);
    values.sort_by(f64::total_cmp);
    let n = values.len() as f64;
    let quantile = |q: f64| {
        let h = (n - 1.0) * q;
        let (low, high) = (h.floor() as usize, h.ceil() as usize);
        values[low] + (h - h.floor()) * (values[high] - values[low])
    };
    let (p25, p75) = (quantile(0.25), quantile(0.75));
    let reach = 1.5 * (p75 - p25);
    let inside = || {
        values
            .iter()
            .filter(|v| **v >= p25 - reach && **v <= p75 + reach)
    };
    for (key, expected) in [
        ("mean", values.iter().sum::<f64>() / n),
        (
            "rmse",
            (values.iter().map(|v| v * v).sum::<f64>() / n).sqrt(),
        ),
        ("min", values[0]),
        ("p5", quantile(0.05)),
        ("p25", p25),
        ("p50", quantile(0.5)),
        ("p75", p75),
        ("p95", quantile(0.95)),
        ("max", values[values.len() - 1]),
        (
            "whisker_low",
            *inside().next().expect("quartiles are inside"),
        ),
        (
            "whisker_high",
            *inside().next_back().expect("quartiles are inside"),
        ),
    ] {
        near(&found[key], expected, &format!("{at} {key}"));
    }
}

fn near(found: &Value, expected: f64, at: &str) {
    let found = found.as_f64().unwrap_or(f64::NAN);
    assert!(
        (found - expected).abs() <= 1e-9 * expected.abs().max(1e-3)
            || (found.is_nan() && expected.is_nan()),
        "{at}: {found}, expected {expected}"
    );
}

/// The recording and each method of a part of the evaluation, by name.
fn motions(part: &Value) -> Vec<(String, &Value)> {
    let methods = part["methods"].as_array().expect("a list").iter();
    let methods =
        methods.map(|method| (method["name"].as_str().expect("a name").to_owned(), method));
    std::iter::once(("recorded".to_owned(), &part["recorded"]))
        .chain(methods)
        .collect()
}

#[test]
fn movement_is_what_the_table_of_segments_gives() {
    let bench = bench();
    let evaluation = bench.json("out/evaluation.json");
    let measures = [
        "length_m",
        "peak_speed_m_s",
        "static_share",
        "sparc",
        "ldlj",
    ];
    let rows = table(
        &bench,
        "out/segments.parquet",
        &["motion", "finger", "take"],
        &["segment", "filled", "makes", "breaks"],
        &[
            &measures[..],
            &[
                "nearest_demonstration_m",
                "nearest_demonstration",
                "known_s",
                "duty",
            ],
        ]
        .concat(),
    );
    let takes = evaluation["session"]["test"].as_array().unwrap();
    let sum = |key: &str| {
        takes
            .iter()
            .map(|take| take[key].as_u64().unwrap())
            .sum::<u64>()
    };
    let (segments, without_gaps) = (sum("segments"), sum("segments") + sum("left_out"));
    assert!(without_gaps > segments, "gaps take segments away");
    let movement = &evaluation["movement"];
    let all = motions(movement);
    assert_eq!(rows.len() as u64, all.len() as u64 * segments * 5);
    assert!(movement["demonstrations"].as_u64().unwrap() > 10);
    for (name, found) in &all {
        for finger in FINGERS {
            let of: Vec<&Row> = (rows.iter())
                .filter(|row| row.is("motion", name) && row.is("finger", finger))
                .collect();
            let keys = [
                "length_mm",
                "peak_speed_mm_s",
                "static_share",
                "sparc",
                "ldlj",
            ];
            let scales = [1e3, 1e3, 1.0, 1.0, 1.0];
            for ((column, key), scale) in measures.into_iter().zip(keys).zip(scales) {
                let at = format!("{name} {finger} {key}");
                let known = || of.iter().filter(|row| row.numbers[column].is_finite());
                let found = &found["by_finger"][finger][key];
                same(
                    found,
                    known().map(|row| row.numbers[column]).collect(),
                    scale,
                    &at,
                );
                assert_eq!(
                    found["n_filled"],
                    known().filter(|row| row.on("filled")).count(),
                    "{at}"
                );
                assert_eq!(
                    found["n_left_out"],
                    without_gaps - known().count() as u64,
                    "{at}"
                );
            }
        }
        let nearest = rows
            .iter()
            .filter(|row| row.is("motion", name) && row.is("finger", "thumb"));
        let nearest = nearest.map(|row| row.numbers["nearest_demonstration_m"]);
        let nearest = nearest.filter(|value| value.is_finite()).collect();
        same(&found["nearest_demonstration_mm"], nearest, 1e3, name);
    }
    // Contacts inside segments add up, too.
    for (name, found) in motions(&evaluation["contacts"]) {
        for finger in FINGERS {
            let of =
                || (rows.iter()).filter(|row| row.is("motion", &name) && row.is("finger", finger));
            let sum = |column: &str| of().map(|row| row.numbers[column]).sum::<f64>();
            let found = &found["by_finger"][finger];
            near(&found["makes"], sum("makes"), "makes");
            near(&found["breaks"], sum("breaks"), "breaks");
            near(&found["known_s"], sum("known_s"), "known_s");
            let known = || of().filter(|row| row.numbers["known_s"] > 0.0);
            let touching: f64 = known()
                .map(|r| r.numbers["duty"] * r.numbers["known_s"])
                .sum();
            near(&found["duty"], touching / sum("known_s"), "duty");
        }
    }
}

#[test]
fn contacts_are_what_the_tables_of_contacts_and_phases_give() {
    let bench = bench();
    let contacts = &bench.json("out/evaluation.json")["contacts"];
    let rules = &contacts["rules"];
    near(&rules["tau_mm"], 0.6, "tau");
    assert_eq!(
        (&rules["min_duration_s"], &rules["max_lift_s"]),
        (&0.02.into(), &3.0.into())
    );
    assert_eq!(rules["min_fingers"], 1);
    let words = ["kind", "motion", "scope", "take"];
    let rows = table(
        &bench,
        "out/contacts.parquet",
        &[&words[..], &["finger"]].concat(),
        &["made", "broken", "filled", "samples"],
        &["segment", "start_s", "end_s", "slip_m"],
    );
    let together = table(
        &bench,
        "out/phases.parquet",
        &[&words[..], &["what", "holding"]].concat(),
        &["samples"],
        &["segment", "start_s", "end_s", "complete", "step_m"],
    );
    let fingers = |found: &Value, of: &dyn Fn(&Row) -> bool, length_s: Option<f64>, at: &str| {
        for finger in FINGERS {
            let at = format!("{at} {finger}");
            let facts = &found[finger];
            let all = || {
                rows.iter()
                    .filter(|row| of(row) && row.is("finger", finger))
            };
            let contacts = || all().filter(|row| row.is("kind", "contact"));
            let whole = || contacts().filter(|row| row.on("made") && row.on("broken"));
            let length = |row: &Row| row.numbers["end_s"] - row.numbers["start_s"];
            let touching: f64 = contacts().map(length).sum();
            if let Some(length_s) = length_s {
                let unknown: f64 = all()
                    .filter(|row| row.is("kind", "unknown"))
                    .map(length)
                    .sum();
                near(&facts["known_s"], length_s - unknown, &at);
            }
            near(
                &facts["duty"],
                touching / facts["known_s"].as_f64().unwrap(),
                &at,
            );
            assert_eq!(
                facts["makes"],
                contacts().filter(|row| row.on("made")).count(),
                "{at}"
            );
            assert_eq!(
                facts["breaks"],
                contacts().filter(|row| row.on("broken")).count(),
                "{at}"
            );
            assert_eq!(
                facts["censored"],
                contacts().count() - whole().count(),
                "{at}"
            );
            same(
                &facts["duration_s"],
                whole().map(length).collect(),
                1.0,
                &at,
            );
            assert_eq!(
                facts["duration_s"]["n_filled"],
                whole().filter(|row| row.on("filled")).count()
            );
            let slip = contacts()
                .map(|row| row.numbers["slip_m"])
                .filter(|slip| slip.is_finite());
            same(&facts["slip_mm"], slip.collect(), 1e3, &at);
        }
    };
    let takes = contacts["takes"].as_array().unwrap();
    assert_eq!(takes.len(), 1);
    let mut seen = (0, 0);
    for take in takes {
        let name = take["take"].as_str().unwrap();
        let of = |row: &Row| row.is("scope", "take") && row.is("take", name);
        fingers(&take["by_finger"], &of, take["duration_s"].as_f64(), name);
        let of_kind = |kind: &'static str| {
            together
                .iter()
                .filter(move |row| of(row) && row.is("kind", kind))
        };
        let names = |set: &Value| {
            let names = set
                .as_array()
                .unwrap()
                .iter()
                .map(|name| name.as_str().unwrap());
            names.collect::<Vec<_>>().join("+")
        };
        let all: f64 = of_kind("state").map(|row| row.numbers["samples"]).sum();
        for state in take["states"].as_array().unwrap() {
            let set = names(&state["fingers"]);
            let set = if set.is_empty() { "none" } else { &set };
            let runs = || of_kind("state").filter(|row| row.is("what", set));
            let samples: f64 = runs().map(|row| row.numbers["samples"]).sum();
            near(&state["samples"], samples, set);
            near(&state["share"], samples / all, set);
            assert_eq!(state["runs"], runs().count());
            let whole = runs().filter(|row| row.on("complete"));
            let lengths = whole.map(|row| row.numbers["end_s"] - row.numbers["start_s"]);
            same(&state["duration_s"], lengths.collect(), 1.0, set);
        }
        let states: Vec<&Row> = of_kind("state").collect();
        let changes = states
            .windows(2)
            .filter(|pair| pair[0].numbers["end_s"] == pair[1].numbers["start_s"]);
        let transitions = take["transitions"].as_array().unwrap().iter();
        let counted: u64 = transitions.map(|t| t["count"].as_u64().unwrap()).sum();
        assert_eq!(counted, changes.count() as u64);
        for (key, kind, what) in [("phases", "phase", "kind"), ("gaits", "gait", "finger")] {
            let found = take[key].as_array().unwrap();
            assert_eq!(found.len(), of_kind(kind).count(), "{key}");
            for (found, row) in found.iter().zip(of_kind(kind)) {
                assert_eq!(found[what], row.words["what"].as_str());
                near(&found["span_s"][0], row.numbers["start_s"], key);
                near(&found["span_s"][1], row.numbers["end_s"], key);
                if kind == "gait" {
                    near(&found["step_mm"], 1e3 * row.numbers["step_m"], key);
                }
            }
        }
        seen = (of_kind("phase").count(), of_kind("gait").count());
    }
    assert!(
        seen.0 > 3 && seen.1 > 0,
        "a session in which nothing happens shows nothing: {seen:?}"
    );
    for (name, found) in motions(contacts) {
        let of = |row: &Row| row.is("scope", "segment") && row.is("motion", &name);
        fingers(&found["by_finger"], &of, None, &name);
        let mut by_fingers = [0.0; 6];
        for row in together
            .iter()
            .filter(|row| of(row) && row.is("kind", "state"))
        {
            let set = &row.words["what"];
            let count = if set == "none" {
                0
            } else {
                set.split('+').count()
            };
            by_fingers[count] += row.numbers["samples"];
        }
        assert_eq!(
            found["by_fingers"],
            serde_json::json!(by_fingers.map(|n| n as u64))
        );
    }
}

#[test]
fn phases_are_events_that_select_nothing_and_are_not_doubled() {
    let bench = bench();
    let take = "out/cube_test_01.mcap";
    let listed = |file: &str| -> Value {
        let text = bench.ok(&["annotate", "list", file, "--format", "json"]);
        serde_json::from_str(&text).expect("JSON")
    };
    let events = |file: &str| listed(file)["events"].as_array().expect("a list").clone();
    let first = events(take);
    let evaluation = bench.json("out/evaluation.json");
    let of_take = &evaluation["contacts"]["takes"][0];
    let count = |key: &str| of_take[key].as_array().unwrap().len();
    assert_eq!(first.len(), count("phases") + count("gaits"));
    assert!(first.iter().all(|event| event["labels"]["by"] == "inhand"));
    let csv = bench.ok(&["annotate", "export", take]);
    assert!(
        csv.starts_with("start_s,end_s,phase,gait,holding,step_mm,by\n"),
        "{csv}"
    );

    // A person's event of the same words stays, and what was found is replaced.
    bench.ok(&[
        "annotate",
        "add",
        take,
        "--at",
        "1..2",
        "--label",
        "phase=in_grasp",
        "-o",
        "known.mcap",
    ]);
    assert_eq!(events("known.mcap").len(), first.len() + 1);
    bench.ok(&[
        "process",
        "known.mcap",
        "-o",
        "again.mcap",
        "--object",
        "cube:0.05",
    ]);
    let again = events("again.mcap");
    let given = again
        .iter()
        .filter(|event| event["labels"].get("by").is_none());
    assert_eq!(given.count(), 1);

    // Selecting by a word that was found alone leaves nothing: people did not say it.
    let refused = bench.inhand(&[
        "learn",
        take,
        "-o",
        "none.mcap",
        "--event",
        "phase=in_grasp",
    ]);
    assert_ne!(refused.status.code(), Some(0));
    assert!(
        stderr(&refused).contains("no labelled event"),
        "{}",
        stderr(&refused)
    );
}
