//! `inhand run`: results, reuse, the same bytes every time.

use crate::support::{Bench, without_provenance};
use crate::view::messages;

const RESULTS: [&str; 10] = [
    "contacts.parquet",
    "cube_test_01.mcap",
    "dictionary.mcap",
    "evaluation.json",
    "phases.parquet",
    "report.html",
    "rows.held_out.parquet",
    "rows.parquet",
    "run.json",
    "segments.parquet",
];

/// Results without the folder of figures.
fn beside_figures(bench: &Bench, folder: &str) -> Vec<String> {
    let mut files = bench.files(folder);
    files.retain(|file| !file.starts_with("figures/"));
    files
}

/// Names of figures by their drawings.
fn figures(bench: &Bench) -> Vec<String> {
    let files = bench.files("out/figures");
    let names = files.iter().filter_map(|file| file.strip_suffix(".svg"));
    names.map(str::to_owned).collect()
}

#[test]
fn every_figure_is_a_drawing_and_its_numbers() {
    let bench = Bench::simulated(&["--gaps", "0.02", "--format", "csv"]);
    bench.run("out", &[]);
    let names = figures(&bench);
    for illustration in [
        "gaps",
        "filtering",
        "spectrum",
        "path-median",
        "path-worst",
        "worst-errors",
        "hulls",
        "primitives",
        "explained-variance",
        "point-clouds",
    ] {
        assert!(
            names.iter().any(|name| name == illustration),
            "{illustration}: {names:?}"
        );
    }
    assert_eq!(bench.files("out/figures").len(), 4 * names.len());
    let listed = bench.json("out/run.json");
    let page = String::from_utf8(bench.bytes("out/report.html")).expect("the page is text");
    for name in &names {
        assert!(
            page.contains(&format!("id=\"figure-{name}\"")),
            "{name} is on the page"
        );
        let csv = String::from_utf8(bench.bytes(&format!("out/figures/{name}.csv")));
        assert!(
            csv.expect("a table is text").lines().count() > 1,
            "{name} has numbers"
        );
        let parquet = bench.bytes(&format!("out/figures/{name}.parquet"));
        assert!(parquet.starts_with(b"PAR1") && parquet.ends_with(b"PAR1"));
        let pdf = String::from_utf8(bench.bytes(&format!("out/figures/{name}.pdf")));
        let pdf = pdf.expect("a PDF without fonts is text");
        assert!(pdf.starts_with("%PDF-1.4") && pdf.ends_with("%%EOF\n"));
        // Shapes and texts of the drawing, and no letter that the font lacks.
        assert!(pdf.contains(" l ") && pdf.contains(") Tj"), "{name}");
        assert!(!pdf.contains('?') && !pdf.contains("NaN"), "{name}");
        for extension in ["svg", "pdf", "csv", "parquet"] {
            let file = format!("figures/{name}.{extension}");
            assert!(listed["manifest"]["outputs"][&file].is_string(), "{file}");
        }
    }
}

#[test]
fn figures_are_made_again_and_old_ones_leave() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    assert!(figures(&bench).contains(&"point-clouds".to_owned()));
    let hulls = bench.bytes("out/figures/hulls.svg");
    bench.write("out/figures/hulls.svg", "changed");
    bench.write("out/figures/mine.svg", "mine");
    bench.run("out", &[]);
    assert_eq!(bench.bytes("out/figures/hulls.svg"), hulls);

    // Without an object there are no distances to it; what a person put there stays.
    bench.edit("session/inhand.toml", |text| {
        text.lines()
            .filter(|line| !line.starts_with("shape"))
            .collect::<Vec<_>>()
            .join("\n")
    });
    bench.run("out", &[]);
    assert!(!figures(&bench).contains(&"point-clouds".to_owned()));
    assert_eq!(bench.bytes("out/figures/mine.svg"), b"mine");
}

#[test]
fn figures_of_others_need_force() {
    let bench = Bench::csv();
    bench.write("out/figures/hulls.svg", "mine");
    let args = [&["run", "session", "-o", "out"], &crate::support::SMALL[..]].concat();
    let output = bench.inhand(&args);
    assert_eq!(output.status.code(), Some(2));
    assert!(crate::support::stderr(&output).contains("figures"));
    assert_eq!(bench.files("out"), ["figures/hulls.svg"]);
}

#[test]
fn a_page_made_later_has_the_times_of_its_run() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let page = |from: &str| {
        bench.ok(&["report", from, "-o", "later.html", "--force"]);
        String::from_utf8(bench.bytes("later.html")).expect("the page is text")
    };
    let times = "id=\"figure-plan-times\"";
    assert!(page("out/evaluation.json").contains(times));
    let own = String::from_utf8(bench.bytes("out/report.html")).expect("the page is text");
    assert!(!own.contains(times), "times differ from run to run");
    // Those of another evaluation are not its own.
    bench.edit("out/evaluation.json", |text| text + "\n");
    assert!(!page("out/evaluation.json").contains(times));
}

#[test]
fn writes_every_result() {
    let bench = Bench::csv();
    let table = bench.run("out", &[]);
    assert_eq!(beside_figures(&bench, "out"), RESULTS);
    for method in [
        "residual",
        "prior",
        "paper",
        "hermite",
        "minimum_jerk",
        "line",
        "hold",
    ] {
        assert!(table.contains(method), "{table}");
    }
    let run = bench.json("out/run.json");
    for step in [
        "read",
        "hand_frame",
        "filter",
        "learn",
        "generate",
        "evaluate",
        "contacts",
        "illustrate",
        "report",
        "total",
    ] {
        assert!(
            run["timings_s"][step].as_f64().is_some_and(|s| s >= 0.0),
            "{step}: {run}"
        );
    }
    for method in ["residual", "prior", "paper"] {
        assert!(
            run["plan_ms"][method]["p50"]
                .as_f64()
                .is_some_and(|ms| ms > 0.0),
            "{run}"
        );
    }
    assert!(run["threads"].as_u64().is_some_and(|n| n > 0));
}

#[test]
fn training_takes_and_other_methods_are_written_on_request() {
    let bench = Bench::csv();
    let count = |root: &str| {
        let topics = messages(&bench, "out/cube_test_01.mcap").into_keys();
        let of = |topic: &String| topic.starts_with(root) && topic.ends_with("/fingertips");
        topics.filter(of).count()
    };
    bench.run("out", &[]);
    assert_eq!((count("/generated/"), count("/view/generated/")), (2, 1));
    assert_eq!(count("/held_out/"), count("/generated/"));
    let all = ["--takes", "all", "--take-methods", "all", "--views", "all"];
    bench.run("out", &all);
    assert_eq!((count("/generated/"), count("/view/generated/")), (7, 7));
    assert!(bench.path("out/cube_train_01.mcap").is_file());
    // What this run does not write does not stay behind.
    bench.run("out", &["--views", "none"]);
    assert_eq!(beside_figures(&bench, "out"), RESULTS);
    assert_eq!(count("/view/"), 0);
}

#[test]
fn evaluation_follows_its_schema() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let schema = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../schemas/evaluation.schema.json"
    );
    let schema = std::fs::read_to_string(schema).expect("the schema is there");
    let schema = serde_json::from_str(&schema).expect("the schema is JSON");
    let evaluation = bench.json("out/evaluation.json");
    jsonschema::validate(&schema, &evaluation).expect("the evaluation follows the schema");
    assert_eq!(evaluation["default_method"], "residual");
    let all = &evaluation["methods"][0]["error_mm"]["all"];
    // One test take of 12 s gives 11 segments, 100 samples and 5 fingers each.
    assert_eq!(all["n"], 11 * 100 * 5);
    assert_eq!(evaluation["methods"][0]["plan"]["solved"], 11);
}

#[test]
fn same_bytes_for_any_number_of_threads() {
    let bench = Bench::csv();
    bench.run("one", &["--threads", "1"]);
    bench.run("three", &["--threads", "3"]);
    for file in bench.files("one").iter().filter(|file| *file != "run.json") {
        let (one, three) = (
            bench.bytes(&format!("one/{file}")),
            bench.bytes(&format!("three/{file}")),
        );
        assert!(one == three, "{file} differs");
    }
}

#[test]
fn mcap_takes_give_the_numbers_of_their_csv() {
    let bench = Bench::simulated(&["--gaps", "0.02", "--format", "csv"]);
    for role in ["train", "test"] {
        for file in bench.files(&format!("session/{role}")) {
            let input = format!("session/{role}/{file}");
            let output = format!("converted/{role}/{}", file.replace(".csv", ".mcap"));
            bench.ok(&["convert", &input, "-o", &output]);
        }
    }
    bench.write("converted/inhand.toml", bench.bytes("session/inhand.toml"));
    bench.run("from_csv", &["--settings", "session/inhand.toml"]);
    let small = crate::support::SMALL;
    bench.ok(&[&["run", "converted", "-o", "from_mcap"], &small[..]].concat());
    let read = |folder: &str| {
        let mut evaluation = without_provenance(bench.json(&format!("{folder}/evaluation.json")));
        evaluation["session"]["name"] = "the same".into();
        evaluation
    };
    assert_eq!(read("from_csv"), read("from_mcap"));
}

#[test]
fn second_run_does_only_what_changed() {
    let bench = Bench::csv();
    let first = bench.run("out", &[]);
    let before = bench.bytes("out/run.json");
    let again =
        bench.inhand(&[&["run", "session", "-o", "out"], &crate::support::SMALL[..]].concat());
    assert_eq!(String::from_utf8(again.stdout.clone()).unwrap(), first);
    for line in [
        "format   Motive CSV 1.23, 100 Hz, ",
        "fingers  thumb \"",
        "gaps     none in any fingertip\n",
        "train    2 takes, 24 s: ",
        "test     1 take, 12 s: 11 segments of 1 s\n",
    ] {
        assert!(first.contains(line), "{line}: {first}");
    }
    assert_eq!(bench.run("out", &["-q"]), first);
    assert!(crate::support::stderr(&again).contains("up to date"));
    assert_eq!(bench.bytes("out/run.json"), before, "nothing was computed");

    // A result that somebody changed is made again.
    let report = bench.bytes("out/report.html");
    bench.edit("out/report.html", |text| text.replace("mm", "km"));
    bench.run("out", &[]);
    assert_eq!(bench.bytes("out/report.html"), report);

    // So is one that is missing; takes and rows stay as they are.
    let kept = ["cube_test_01.mcap", "rows.parquet", "rows.held_out.parquet"];
    let written = || {
        kept.map(|name| {
            let facts = std::fs::metadata(bench.path(&format!("out/{name}"))).unwrap();
            facts.modified().unwrap()
        })
    };
    let earlier = written();
    std::fs::remove_file(bench.path("out/report.html")).unwrap();
    std::fs::remove_file(bench.path("out/figures/error-ecdf.svg")).unwrap();
    bench.run("out", &[]);
    assert_eq!(bench.bytes("out/report.html"), report);
    assert!(bench.path("out/figures/error-ecdf.svg").is_file());
    assert_eq!(written(), earlier);

    // A threshold of the evaluation leaves the dictionary alone.
    let dictionary = bench.bytes("out/dictionary.mcap");
    let written = std::fs::metadata(bench.path("out/dictionary.mcap"))
        .unwrap()
        .modified()
        .unwrap();
    bench.run("out", &["--tau-mm", "4"]);
    let now = std::fs::metadata(bench.path("out/dictionary.mcap"))
        .unwrap()
        .modified()
        .unwrap();
    assert_eq!(
        (bench.bytes("out/dictionary.mcap"), now),
        (dictionary, written)
    );
    assert_eq!(
        bench.json("out/evaluation.json")["methods"][0]["contact"]["tau_mm"],
        4.0
    );

    // Another seed does not.
    bench.run("out", &["--tau-mm", "4", "--seed", "5"]);
    let now = std::fs::metadata(bench.path("out/dictionary.mcap"))
        .unwrap()
        .modified()
        .unwrap();
    assert_ne!(now, written);

    // Nor does another centre of the object: it is in the segments.
    let learned = bench.bytes("out/dictionary.mcap");
    let moved = ["--seed", "5", "--object-offset", "0,0.02,0.03"];
    bench.run("out", &moved);
    assert_ne!(bench.bytes("out/dictionary.mcap"), learned);
    bench.run("fresh", &moved);
    assert_eq!(
        bench.bytes("out/dictionary.mcap"),
        bench.bytes("fresh/dictionary.mcap")
    );
}

#[test]
fn takes_may_share_a_file_by_time_range() {
    let bench = Bench::csv();
    let listed = "[[takes]]\npath = \"train/cube_train_01.csv\"\nrole = \"train\"\nto_s = 8\n\
                  [[takes]]\npath = \"train/cube_train_01.csv\"\nrole = \"test\"\nfrom_s = 8\n";
    bench.write("session/ranges.toml", listed);
    let args = ["run", "session/ranges.toml", "-o", "out", "--takes", "all"];
    bench.ok(&[&args[..], &crate::support::SMALL].concat());
    let evaluation = bench.json("out/evaluation.json");
    assert_eq!(evaluation["session"]["train"][0]["samples"], 800);
    assert_eq!(evaluation["session"]["test"][0]["samples"], 400);
    assert!(bench.path("out/cube_train_01.train.mcap").is_file());
    assert!(bench.path("out/cube_train_01.test.mcap").is_file());
}

#[test]
fn an_interrupted_run_is_taken_up() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let report = bench.bytes("out/report.html");
    let dictionary = bench.bytes("out/dictionary.mcap");
    // As if it had been killed after the dictionary was written.
    let mut run = bench.json("out/run.json");
    run["manifest"]["key"] = "".into();
    run["manifest"]["outputs"] = serde_json::json!({});
    bench.write("out/run.json", run.to_string());
    for lost in [
        "report.html",
        "evaluation.json",
        "rows.parquet",
        "cube_test_01.mcap",
    ] {
        std::fs::remove_file(bench.path(&format!("out/{lost}"))).unwrap();
    }
    bench.run("out", &[]);
    assert_eq!(beside_figures(&bench, "out"), RESULTS);
    assert_eq!(bench.bytes("out/report.html"), report);
    assert_eq!(bench.bytes("out/dictionary.mcap"), dictionary);
}
