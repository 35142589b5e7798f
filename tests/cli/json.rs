//! Output of `--format json` against the schemas.

use std::path::Path;

use jsonschema::{Registry, Validator};
use serde_json::Value;

use crate::support::{Bench, SMALL, stderr};

const BASE: &str = "https://inhand.invalid/schemas/";

/// A schema, the call that prints a document of it or the file that is one, and the exit code.
const DOCUMENTS: [(&str, &[&str], i32); 34] = [
    ("clean", &["clean", "train.csv"], 0),
    ("clean", &["clean", "faulty.csv"], 0),
    (
        "clean",
        &["clean", "faulty.csv", "--repair", "-o", "c.mcap"],
        0,
    ),
    ("convert", &["convert", "train.csv", "-o", "train.mcap"], 0),
    ("process", &["process", "train.csv", "-o", "p.mcap"], 0),
    ("run", &["out/run.json"], 0),
    (
        "learn",
        &[
            "learn",
            "train.csv",
            "test.csv",
            "-o",
            "d.mcap",
            "--rank",
            "6..12:6",
            "--restarts",
            "2",
        ],
        0,
    ),
    (
        "learn",
        &[
            "learn",
            "init",
            "train.csv",
            "-o",
            "shards",
            "--rank",
            "6",
            "--max-iterations",
            "2",
        ],
        0,
    ),
    ("learn", &["learn", "stats", "shards"], 0),
    ("learn", &["learn", "update", "shards"], 0),
    ("info", &["info", "out/cube_test_01.mcap"], 0),
    ("info", &["info", "out/dictionary.mcap"], 0),
    (
        "generate",
        &[
            "generate",
            "test.csv",
            "-d",
            "out/dictionary.mcap",
            "-o",
            "g.mcap",
        ],
        0,
    ),
    ("view", &["view", "g.mcap", "-o", "v.mcap"], 0),
    (
        "plan",
        &[
            "plan",
            "-d",
            "out/dictionary.mcap",
            "--from",
            "test.csv@2",
            "--to",
            "test.csv@2.99",
            "-o",
            "m.mcap",
        ],
        0,
    ),
    (
        "plan",
        &[
            "plan",
            "-d",
            "out/dictionary.mcap",
            "--from",
            "test.csv@2",
            "--to",
            "test.csv@6",
            "-o",
            "n.mcap",
            "--ends",
            "hard",
            "--velocity-m-s",
            "0.0001",
        ],
        1,
    ),
    (
        "batch",
        &[
            "batch",
            "session",
            "other",
            "none",
            "-o",
            "b",
            "--allow-different",
            "--rank",
            "6",
            "--stride",
            "10",
        ],
        3,
    ),
    ("batch", &["b/batch.json"], 0),
    (
        "summary",
        &["report", "merge", "b", "-o", "s.md", "--allow-different"],
        0,
    ),
    ("compare", &["compare", "out", "b/session"], 0),
    ("error", &["info", "none.mcap"], 1),
    (
        "error",
        &["run", "session", "-o", "x", "--object", "cube:50"],
        1,
    ),
    ("annotate", &["annotate", "list", "events.mcap"], 0),
    (
        "cut",
        &["cut", "events.mcap", "--to", "8", "-o", "cut.mcap"],
        0,
    ),
    (
        "cut",
        &["cut", "events.mcap", "--event", "task=rotate", "-o", "cuts"],
        0,
    ),
    (
        "cut",
        &[
            "cut",
            "out/dictionary.mcap",
            "--from",
            "900",
            "-o",
            "no.mcap",
        ],
        0,
    ),
    (
        "filter",
        &["filter", "events.mcap", "-y", "/tf.*", "-o", "tf.mcap"],
        0,
    ),
    (
        "merge",
        &[
            "merge",
            "events.mcap",
            "tf.mcap",
            "--keep-both",
            "-o",
            "both.mcap",
        ],
        0,
    ),
    ("verify", &["verify", "out"], 0),
    ("verify", &["verify", "torn.mcap"], 3),
    ("recover", &["recover", "tf.mcap", "-o", "whole.mcap"], 0),
    ("recover", &["recover", "torn.mcap", "-o", "saved.mcap"], 3),
    (
        "overlay",
        &[
            "overlay",
            "out/cube_test_01.mcap",
            "--methods",
            "residual,line",
            "-o",
            "layers.mcap",
        ],
        0,
    ),
    (
        "export",
        &["export", "out/dictionary.mcap", "-o", "matrices.npz"],
        0,
    ),
];

/// Objects whose keys are names; a star is any key.
const NAMES: [(&str, &str); 13] = [
    ("annotate", "/about"),
    ("annotate", "/events/0/labels"),
    ("export", "/matrices"),
    ("info", "/fingertips"),
    ("info", "/metadata"),
    ("info", "/metadata/*"),
    ("info", "/metadata_records/0/facts"),
    ("info", "/chunks/compression"),
    ("info", "/channels/0/metadata"),
    ("recover", "/mended"),
    ("run", "/timings_s"),
    ("run", "/plan_ms"),
    ("run", "/manifest/outputs"),
];

/// Keys that some documents of a schema do not have.
const OPTIONAL: [(&str, &str); 2] = [("info", "/dictionary"), ("learn", "/rank_choice")];

fn schema(name: &str) -> Value {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../schemas");
    let text = std::fs::read_to_string(folder.join(format!("{name}.schema.json")));
    serde_json::from_str(&text.expect("every output has a schema")).expect("schemas are JSON")
}

fn with_validator(name: &str, check: impl FnOnce(&Validator)) {
    let shared = ["common", "evaluation"].map(|name| (name, self::schema(name)));
    let schema = schema(name);
    jsonschema::meta::validate(&schema).expect("the schema is one");
    let mut registry = Registry::new();
    for (name, schema) in &shared {
        let uri = format!("{BASE}{name}.schema.json");
        registry = registry.add(uri, schema).expect("a resource");
    }
    let registry = registry.prepare().expect("resources");
    let options = jsonschema::options()
        .with_base_uri(BASE)
        .with_registry(&registry);
    check(&options.build(&schema).expect("references resolve"));
}

/// Places of all keys as JSON pointers; the first and the last element of a list stand for all.
fn keys(value: &Value, place: &str, found: &mut Vec<String>) {
    match value {
        Value::Object(map) => {
            for (key, inner) in map {
                let place = format!("{place}/{}", key.replace('~', "~0").replace('/', "~1"));
                keys(inner, &place, found);
                found.push(place);
            }
        }
        Value::Array(list) => {
            let ends = (list.iter().enumerate()).filter(|(n, _)| [0, list.len() - 1].contains(n));
            ends.for_each(|(n, inner)| keys(inner, &format!("{place}/{n}"), found));
        }
        _ => {}
    }
}

fn is_free(name: &str, place: &str) -> bool {
    // In the tables, 0 is any element.
    let parts = (place.split('/')).map(|part| part.parse::<usize>().map_or(part, |_| "0"));
    let place = &parts.collect::<Vec<_>>().join("/")[..];
    let (parent, _) = place.rsplit_once('/').expect("a pointer to a key");
    let (grandparent, _) = parent.rsplit_once('/').unwrap_or(("", ""));
    let any = format!("{grandparent}/*");
    NAMES
        .iter()
        .any(|&(of, free)| of == name && (free == parent || free == any))
        || OPTIONAL.contains(&(name, place))
}

/// Inputs of the documents.
fn bench() -> Bench {
    let bench = Bench::csv();
    bench.run("out", &["--methods", "residual,prior,line"]);
    bench.ok(&[
        "simulate",
        "-o",
        "other",
        "--format",
        "csv",
        "--takes",
        "1",
        "--duration",
        "8",
        "--seed",
        "8",
    ]);
    bench.ok(&[
        "simulate",
        "-o",
        "faulty",
        "--format",
        "csv",
        "--takes",
        "1",
        "--duration",
        "8",
        "--faults",
    ]);
    for (name, of) in [
        ("train.csv", "session/train/cube_train_01.csv"),
        ("test.csv", "session/test/cube_test_01.csv"),
        ("faulty.csv", "faulty/train/cube_train_01.csv"),
    ] {
        bench.write(name, bench.bytes(of));
    }
    for call in [
        "annotate add out/cube_test_01.mcap -o e.mcap --at 2..3 --at 5..6 --label task=rotate",
        "annotate about e.mcap -o events.mcap --set subject=s01",
    ] {
        bench.ok(&call.split(' ').collect::<Vec<_>>());
    }
    let whole = bench.bytes("events.mcap");
    bench.write("torn.mcap", &whole[..whole.len() * 2 / 3]);
    bench
}

#[test]
fn every_output_follows_its_schema_and_the_schema_requires_every_key() {
    let bench = bench();
    for (name, call, code) in DOCUMENTS {
        let document = match call {
            [file] => bench.json(file),
            _ => {
                let small: &[&str] =
                    if call[0] == "learn" && call[1] != "stats" && call[1] != "update" {
                        &SMALL[..2]
                    } else {
                        &[]
                    };
                let output = bench.inhand(&[call, small, &["--format", "json"]].concat());
                assert_eq!(
                    output.status.code(),
                    Some(code),
                    "{call:?}\n{}",
                    stderr(&output)
                );
                serde_json::from_slice(&output.stdout).expect("one document is printed")
            }
        };
        let mut found = Vec::new();
        keys(&document, "", &mut found);
        with_validator(name, |validator| {
            let errors: Vec<_> = validator
                .iter_errors(&document)
                .map(|e| e.to_string())
                .collect();
            assert!(errors.is_empty(), "{call:?}: {errors:?}");
            for place in found.iter().filter(|place| !is_free(name, place)) {
                let mut cut = document.clone();
                let (parent, key) = place.rsplit_once('/').expect("a pointer to a key");
                let parent = cut.pointer_mut(parent).and_then(Value::as_object_mut);
                parent
                    .expect("it has the key")
                    .remove(&key.replace("~1", "/").replace("~0", "~"));
                assert!(
                    !validator.is_valid(&cut),
                    "{call:?}: the schema does not require {place}"
                );
            }
        });
    }
}

#[test]
fn errors_are_json_with_findings_and_the_exit_code() {
    let bench = Bench::csv();
    let failed = |call: &[&str], code: i64| -> Value {
        let output = bench.inhand(&[call, &["--format=json"]].concat());
        assert_eq!(output.status.code().map(i64::from), Some(code), "{call:?}");
        let document: Value = serde_json::from_slice(&output.stdout).expect("stdout is JSON");
        assert_eq!(document["error"]["exit_code"], code);
        let message = document["error"]["message"].as_str().expect("words");
        let said = stderr(&output);
        assert!(said.contains(message), "{said}");
        document["error"].clone()
    };
    let missing = failed(&["info", "none.mcap"], 1);
    assert_eq!(missing["message"], "cannot read none.mcap");
    assert!(
        missing["causes"][0]
            .as_str()
            .is_some_and(|cause| cause.contains("No such file"))
    );
    let call = failed(&["plan", "--nonsense"], 2);
    assert_eq!(call["message"], "unexpected argument '--nonsense' found");
    let refused = failed(&["run", "session", "-o", "out", "--object", "cube:50"], 1);
    assert_eq!(refused["findings"][0]["id"], "object-size");
    assert_eq!(refused["findings"][0]["level"], "fail");
    let setting = failed(&["run", "session", "-o", "out", "--object", "cube:x"], 2);
    assert_eq!(setting["findings"], serde_json::json!([]));
    // A comparison is not printed before what is wrong with it.
    bench.run("done", &["--methods", "residual,line"]);
    let compare = |more: &[&str]| {
        let call = [
            "compare",
            "done",
            "--method",
            "residual",
            "--against",
            "line",
        ];
        failed(&[&call[..], more].concat(), 2)["message"].to_string()
    };
    let unknown = compare(&["--fail-if", "prior:p75 > 5%", "-o", "none.md"]);
    assert!(unknown.contains("no such method"), "{unknown}");
    assert!(!bench.path("none.md").exists());
    bench.write("there.md", "notes");
    let there = compare(&["-o", "there.md"]);
    assert!(there.contains("already exists"), "{there}");

    // Text stays text.
    let output = bench.inhand(&["info", "none.mcap"]);
    assert!(output.stdout.is_empty());
}

/// The schemas of evaluations and of `check` are tested where they are written.
#[test]
fn every_schema_has_a_document() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../schemas");
    for file in std::fs::read_dir(folder).expect("a folder").flatten() {
        let file = file.file_name().to_string_lossy().into_owned();
        let Some(name) = file.strip_suffix(".schema.json") else {
            continue;
        };
        let elsewhere = ["evaluation", "check", "common"].contains(&name);
        assert!(
            elsewhere || DOCUMENTS.iter().any(|(of, ..)| *of == name),
            "{name}"
        );
    }
}
