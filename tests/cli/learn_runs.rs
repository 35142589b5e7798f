//! Learning that is spread over calls, and what is taken in from elsewhere.

use crate::support::{Bench, stderr};

const TAKES: [&str; 2] = [
    "session/train/cube_train_01.csv",
    "session/train/cube_train_02.csv",
];

/// A segment starts at every sample: more than one block of them.
const MANY: [&str; 6] = ["--stride", "1", "--rank", "8", "--max-iterations", "2"];

fn learn(bench: &Bench, output: &str, options: &[&str]) {
    bench.ok(&[&["learn"], &TAKES[..], &["-o", output], options].concat());
}

fn init(bench: &Bench, run: &str, options: &[&str]) {
    bench.ok(&[&["learn", "init"], &TAKES[..], &["-o", run], options].concat());
}

/// The call must fail with these words.
fn refused(bench: &Bench, args: &[&str], words: &[&str]) {
    let output = bench.inhand(args);
    let message = stderr(&output);
    assert!(
        matches!(output.status.code(), Some(1 | 2)),
        "{args:?} {message}"
    );
    for word in words {
        assert!(message.contains(word), "\"{word}\" in: {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
}

/// Rounds until learning stops; returns how many.
fn rounds(bench: &Bench, run: &str, shards: usize) -> usize {
    for round in 1..20 {
        for shard in (1..=shards).rev() {
            let threads = if shard % 2 == 0 { "2" } else { "1" };
            let shard = format!("{shard}/{shards}");
            bench.ok(&[
                "--threads",
                threads,
                "learn",
                "stats",
                run,
                "--shard",
                &shard,
            ]);
        }
        let updated = bench.ok(&["learn", "update", run, "--format", "json"]);
        let updated: serde_json::Value = serde_json::from_str(&updated).expect("JSON");
        if updated["done"] == true {
            return round;
        }
    }
    panic!("learning does not stop");
}

#[test]
fn one_process_and_any_shards_write_the_same_bytes() {
    let bench = Bench::csv();
    learn(
        &bench,
        "one.mcap",
        &[&MANY[..], &["--threads", "1"]].concat(),
    );
    learn(
        &bench,
        "two.mcap",
        &[&MANY[..], &["--threads", "2"]].concat(),
    );
    assert!(bench.bytes("one.mcap") == bench.bytes("two.mcap"));
    for (run, shards) in [("a", 1), ("b", 2), ("c", 8)] {
        init(&bench, run, &MANY);
        assert_eq!(rounds(&bench, run, shards), 3);
        let output = format!("{run}.mcap");
        bench.ok(&["learn", "finish", run, "-o", &output]);
        assert!(bench.bytes("one.mcap") == bench.bytes(&output), "{shards}");
    }
    let printed = bench.ok(&["learn", "update", "a"]);
    assert!(printed.contains("done: write the dictionary"), "{printed}");
}

#[test]
fn restarts_keep_the_best_and_shards_agree_on_it() {
    let bench = Bench::csv();
    let options = [&MANY[..], &["--restarts", "3", "--precision", "f32"]].concat();
    let args = [
        &["learn"],
        &TAKES[..],
        &["-o", "one.mcap", "--format", "json"],
        &options,
    ]
    .concat();
    let printed: serde_json::Value = serde_json::from_str(&bench.ok(&args)).expect("JSON");
    let restarts = printed["restarts"].as_array().expect("a list").clone();
    assert_eq!(restarts.len(), 3);
    let best = (restarts.iter())
        .filter_map(|restart| restart["rms_mm"].as_f64())
        .fold(f64::INFINITY, f64::min);
    let kept = (restarts.iter())
        .find(|restart| restart["seed"] == printed["seed"])
        .expect("the kept start is one of them");
    assert_eq!(kept["rms_mm"].as_f64(), Some(best));
    assert_eq!(kept["matched_cosine"], 1.0);
    for restart in &restarts {
        let cosine = restart["matched_cosine"].as_f64().expect("a number");
        assert!((0.5..=1.0).contains(&cosine), "{cosine}");
    }
    let info = bench.ok(&["info", "one.mcap", "--format", "json"]);
    let info: serde_json::Value = serde_json::from_str(&info).expect("JSON");
    assert_eq!(info["dictionary"]["rank"], 8);
    assert_eq!(info["dictionary"]["seed"], printed["seed"]);
    assert_eq!(info["dictionary"]["inputs"][1]["name"], "cube_train_02.csv");
    let text = bench.ok(&["info", "one.mcap"]);
    assert!(
        text.contains("8 primitives (nmf) from 2186 segments"),
        "{text}"
    );
    assert_eq!(text.matches("mean matched cosine").count(), 3);
    init(&bench, "run", &options);
    assert_eq!(rounds(&bench, "run", 2), 9);
    bench.ok(&["learn", "finish", "run", "-o", "run.mcap"]);
    assert!(bench.bytes("one.mcap") == bench.bytes("run.mcap"));
}

#[test]
fn a_run_that_was_killed_goes_on() {
    let bench = Bench::csv();
    learn(&bench, "one.mcap", &MANY);
    init(&bench, "work", &MANY);
    bench.ok(&["learn", "stats", "work", "--shard", "1/2"]);
    // The second half of the round, all others and the dictionary: what `--work` finds and does.
    std::fs::remove_file(bench.path("work/start-000/round-00000/shard-1-of-2.sums"))
        .expect("the shard's sums are there");
    let args = [
        &["learn"],
        &TAKES[..],
        &["-o", "d.mcap", "--work", "work"],
        &MANY,
    ]
    .concat();
    let output = bench.inhand(&args);
    assert!(
        stderr(&output).contains("going on with the run"),
        "{}",
        stderr(&output)
    );
    assert!(bench.bytes("one.mcap") == bench.bytes("d.mcap"));

    // A file that a crash of the machine cut off is not taken for whole.
    init(&bench, "cut", &MANY);
    bench.ok(&["learn", "stats", "cut"]);
    let sums = "cut/start-000/round-00000/shard-1-of-1.sums";
    let bytes = bench.bytes(sums);
    bench.write(sums, &bytes[..bytes.len() / 2]);
    refused(
        &bench,
        &["learn", "update", "cut"],
        &["shard-1-of-1.sums", "damaged or cut off"],
    );
    bench.ok(&["learn", "stats", "cut"]);
    assert!(bench.bytes(sums) == bytes);
    bench.ok(&["learn", "update", "cut"]);

    let changed = ["--stride", "1", "--rank", "7", "--max-iterations", "2"];
    let other = [
        &["learn"],
        &TAKES[..],
        &["-o", "e.mcap", "--work", "work"],
        &changed,
    ];
    refused(
        &bench,
        &other.concat(),
        &["learning.json", "another value of setting learn.rank"],
    );
    let swapped = [TAKES[1], TAKES[0]];
    let other = [
        &["learn"],
        &swapped[..],
        &["-o", "e.mcap", "--work", "work"],
        &MANY,
    ];
    refused(
        &bench,
        &other.concat(),
        &["learning.json", "another take", "cube_train_02.csv"],
    );
    assert!(!bench.path("e.mcap").exists());
}

#[test]
fn sums_that_do_not_belong_are_refused() {
    let bench = Bench::csv();
    init(&bench, "a", &MANY);
    init(&bench, "b", &[&MANY[..], &["--seed", "5"]].concat());
    for run in ["a", "b"] {
        bench.ok(&["learn", "stats", run, "--shard", "1/2"]);
    }
    refused(
        &bench,
        &["learn", "update", "a"],
        &["round-00000", "a shard's file is missing"],
    );
    let other = "b/start-000/round-00000/shard-1-of-2.sums";
    refused(
        &bench,
        &["learn", "update", "a", other],
        &[other, "another run"],
    );
    bench.ok(&["learn", "stats", "a", "--shard", "2/2"]);
    bench.ok(&["learn", "stats", "a", "--shard", "1/1"]);
    refused(
        &bench,
        &["learn", "update", "a"],
        &["shards of different splits"],
    );
    let whole = "a/start-000/round-00000/shard-1-of-1.sums";
    std::fs::copy(bench.path(whole), bench.path("kept.sums")).expect("a copy can be made");
    std::fs::remove_file(bench.path(whole)).expect("the file is there");
    bench.ok(&["learn", "update", "a"]);
    refused(
        &bench,
        &["learn", "update", "a", "kept.sums"],
        &["kept.sums", "round 0: expected start 0, round 1"],
    );
    refused(
        &bench,
        &["learn", "finish", "a", "-o", "d.mcap"],
        &["start 1 of 1 is in round 1", "learn stats"],
    );
    assert!(!bench.path("d.mcap").exists());
    refused(
        &bench,
        &["learn", "stats", "a", "--shard", "3/2"],
        &["from 1 to N"],
    );
    refused(
        &bench,
        &["learn", "stats", "a", "--shard", "0/2"],
        &["from 1 to N"],
    );
    refused(&bench, &["learn", "stats", "none"], &["learn init"]);
    let again = [&["learn", "init"], &TAKES[..], &["-o", "a"], &MANY].concat();
    refused(&bench, &again, &["there is a run in it already"]);
    let pca = [
        &["learn", "init"],
        &TAKES[..],
        &["-o", "p", "--kind", "pca"],
    ]
    .concat();
    refused(&bench, &pca, &["principal components have no rounds"]);
    assert!(!bench.path("p/learning.json").exists());
}

#[test]
fn takes_that_cannot_teach_leave_no_run() {
    let bench = Bench::csv();
    let few = [
        &["learn", "init"],
        &TAKES[..],
        &["-o", "run", "--rank", "500"],
    ]
    .concat();
    refused(&bench, &few, &["rank 500 is too large", "largest possible"]);
    assert!(!bench.path("run/learning.json").exists());
    bench.ok(&[
        "simulate",
        "-o",
        "slow",
        "--takes",
        "1",
        "--duration",
        "12",
        "--rate",
        "50",
    ]);
    let mixed = [TAKES[0], "slow/train/cube_train_01.csv"];
    let args = [&["learn", "init"], &mixed[..], &["-o", "run"], &MANY].concat();
    refused(&bench, &args, &["cube_train_01", "50 Hz", "100 Hz"]);
    assert!(!bench.path("run/learning.json").exists());
    let one = [
        &["learn"],
        &TAKES[..],
        &["-o", "d.mcap", "--activation-l1", "0.1"],
        &MANY,
    ]
    .concat();
    refused(&bench, &one, &["penalise both"]);
    let word = [
        &["learn"],
        &TAKES[..],
        &["-o", "d.mcap", "--precision", "f16"],
    ]
    .concat();
    refused(&bench, &word, &["--precision", "f16", "f64", "f32"]);
    assert!(!bench.path("d.mcap").exists());
}

#[test]
fn primitives_from_elsewhere_make_the_same_dictionary() {
    let bench = Bench::csv();
    let options = ["--stride", "10"];
    let learned = [&options[..], &["--rank", "12", "--sweeps", "60"]].concat();
    learn(&bench, "own.mcap", &learned);
    for file in ["own.npz", "own.mat"] {
        bench.ok(&["export", "own.mcap", "-o", file]);
        learn(
            &bench,
            "given.mcap",
            &[&options[..], &["--primitives", file, "--force"]].concat(),
        );
        let [own, given] = ["own.mcap", "given.mcap"].map(|name| {
            inhand_channels::read_dictionary(&bench.bytes(name), name).expect("a dictionary")
        });
        assert!((&own.0.primitives - &given.0.primitives).amax() < 1e-15);
        assert_eq!(own.0.offset_m, given.0.offset_m);
        assert!(own.0.residual == given.0.residual);
        // The same primitives with activations at their best.
        assert!(given.0.learning.rms_m <= own.0.learning.rms_m);
        assert!(given.0.learning.rms_m > 0.8 * own.0.learning.rms_m);
        assert_eq!(given.0.learning.iterations, 0);
        let made = given.1.last().expect("the step is noted");
        assert_eq!(
            made.inputs.last().map(|input| input.name.as_str()),
            Some(file)
        );
    }
    let pca = [&["learn"], &TAKES[..], &["-o", "p.mcap", "--kind", "pca"]].concat();
    let pca = [&pca[..], &["--primitives", "own.npz"]].concat();
    refused(&bench, &pca, &["--kind nmf"]);
    let wrong = [
        &["learn"],
        &TAKES[..],
        &["-o", "p.mcap", "--primitives", TAKES[0]],
    ]
    .concat();
    refused(&bench, &wrong, &["cube_train_01.csv"]);
    assert!(!bench.path("p.mcap").exists());
}

#[test]
fn primitives_without_their_offset_are_refused() {
    let bench = Bench::csv();
    learn(&bench, "own.mcap", &["--rank", "12", "--stride", "10"]);
    bench.ok(&["export", "own.mcap", "-o", "own.npz"]);
    let mut own =
        inhand_export::matrices::read(&bench.bytes("own.npz"), "own.npz").expect("matrices");
    let mut refuse = |offset_m: Option<f64>, words: &[&str]| {
        own.retain(|name, _| name == "primitives");
        if let Some(offset_m) = offset_m {
            let one = nalgebra::DMatrix::from_element(1, 1, offset_m);
            own.insert(
                "offset_m".to_owned(),
                inhand_export::matrices::Variable::Numbers(one),
            );
        }
        let list: Vec<_> = own.clone().into_iter().collect();
        let form = inhand_export::matrices::MatrixFormat::Npz;
        let bytes =
            inhand_export::matrices::write(form, "w.npz", &list).expect("matrices can be written");
        bench.write("w.npz", bytes);
        let args = [
            &["learn"],
            &TAKES[..],
            &["-o", "p.mcap", "--primitives", "w.npz"],
        ];
        refused(&bench, &args.concat(), words);
        assert!(!bench.path("p.mcap").exists());
    };
    refuse(None, &["w.npz", "offset_m"]);
    refuse(
        Some(1.0),
        &["offset of row 0 is 1 m", "data above the offset"],
    );
    // The limit on memory holds for all variables together.
    let half = inhand_export::matrices::Variable::Numbers(nalgebra::DMatrix::zeros(100_000, 1));
    let list = [("primitives", half.clone()), ("offset_m", half)];
    for (form, file) in [
        (inhand_export::matrices::MatrixFormat::Npz, "large.npz"),
        (inhand_export::matrices::MatrixFormat::Mat, "large.mat"),
    ] {
        let bytes = inhand_export::matrices::write(form, file, &list).expect("matrices");
        bench.write(file, bytes);
        let args = [
            &["learn"],
            &TAKES[..],
            &["-o", "p.mcap", "--primitives", file, "--memory-limit", "1"],
        ];
        refused(
            &bench,
            &args.concat(),
            &[file, "offset_m", "1048576 bytes", "--memory-limit"],
        );
    }
}

#[test]
fn a_start_that_was_not_begun_is_begun() {
    let bench = Bench::csv();
    let options = [&MANY[..], &["--restarts", "2"]].concat();
    learn(&bench, "one.mcap", &options);
    init(&bench, "work", &options);
    let first = || {
        for round in 0..3 {
            bench.ok(&["learn", "stats", "work"]);
            bench.ok(&["learn", "update", "work"]);
            assert!(bench.path("work/start-001").exists() == (round == 2));
        }
    };
    first();
    // As if killed between the end of one start and the beginning of the next.
    std::fs::remove_dir_all(bench.path("work/start-001")).expect("it is there");
    refused(&bench, &["learn", "stats", "work"], &["learn update"]);
    learn(
        &bench,
        "d.mcap",
        &[&options[..], &["--work", "work"]].concat(),
    );
    assert!(bench.bytes("one.mcap") == bench.bytes("d.mcap"));
}

#[test]
fn options_that_do_not_go_together_are_refused_at_once() {
    let bench = Bench::csv();
    let learn = |options: &[&str], words: &[&str]| {
        let args = [&["learn"], &TAKES[..], &["-o", "d.mcap"], options].concat();
        refused(&bench, &args, words);
        assert!(!bench.path("d.mcap").exists());
        assert!(!bench.path("work").exists());
    };
    learn(
        &["--kind", "pca", "--restarts", "2"],
        &["learn.restarts", "exact"],
    );
    learn(
        &["--kind", "pca", "--work", "work"],
        &["--work", "no rounds"],
    );
    learn(&["--rank", "5..9", "--work", "work"], &["single --rank"]);
    learn(&["--primitives", "none.npz"], &["none.npz"]);
    learn(&["--stop-rms-mm", "0"], &["learn.stop_rms_m"]);
    let heavy = ["--activation-l1", "1", "--primitive-l1", "1", "--rank", "5"];
    learn(&heavy, &["every activation is zero", "lower them"]);
}

#[test]
fn one_pass_learns() {
    let bench = Bench::csv();
    let options = [
        "--stride",
        "1",
        "--rank",
        "12",
        "--start",
        "online",
        "--max-iterations",
        "0",
    ];
    learn(&bench, "d.mcap", &options);
    let (dictionary, _) =
        inhand_channels::read_dictionary(&bench.bytes("d.mcap"), "d.mcap").expect("a dictionary");
    assert_eq!(dictionary.learning.iterations, 0);
    assert!(
        dictionary.learning.rms_m < 0.003,
        "{}",
        dictionary.learning.rms_m
    );
}
