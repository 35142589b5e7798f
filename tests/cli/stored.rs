//! Settings of a session and those stored in files, used by single steps.

use serde_json::Value;

use crate::support::{Bench, SMALL, stderr, without_provenance};
use crate::view::messages;

const TRAIN: [&str; 2] = [
    "session/train/cube_train_01.csv",
    "session/train/cube_train_02.csv",
];
const TEST: &str = "session/test/cube_test_01.csv";

/// Settings of the last step that made a file.
fn last_step(bench: &Bench, name: &str) -> Value {
    let metadata = inhand_channels::read_metadata(&bench.bytes(name), name).expect("it is sound");
    let steps = metadata.provenance(name).expect("ours");
    let last = steps.last().expect("a step made it");
    serde_json::from_str(&last.settings_json).expect("settings are JSON")
}

/// Why a call is refused as wrong.
fn refused(bench: &Bench, call: &[&str]) -> String {
    let output = bench.inhand(call);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    stderr(&output)
}

#[test]
fn single_steps_repeat_nothing() {
    let bench = Bench::csv();
    bench.write(
        "session/inhand.toml",
        r#"
        name = "another name"
        object = { shape = "cube:0.05", offset_m = [0.0, 0.0, 0.002] }
        process = { window = 30 }
        segments = { stride = 10, margin_s = 0.2 }
        learn = { rank = 12, max_iterations = 15 }
        plan = { methods = ["residual", "prior", "hermite"], velocity_factor = 1.3 }
        evaluate = { tau_mm = 6.0, draws = 200 }
        "#,
    );
    bench.ok(&["run", "session", "-o", "out", "--take-methods", "all"]);
    let run = without_provenance(bench.json("out/evaluation.json"));
    let learned = bench.ok(&[
        &["learn"],
        &TRAIN[..],
        &["-o", "d.mcap", "--format", "json"],
    ]
    .concat());
    let learned: Value = serde_json::from_str(&learned).expect("learn prints JSON");
    assert!(learned["rms_mm"].is_number());
    assert_eq!(learned["rms_mm"], run["dictionary"]["rms_mm"]);

    let output = bench.inhand(&["process", TEST, "-o", "processed.mcap"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(
        said.starts_with("settings  session/inhand.toml\n"),
        "{said}"
    );
    // From here on no file is in the session.
    let dictionary = ["-d", "out/dictionary.mcap", "-o"];
    bench.ok(&[
        &["generate", "processed.mcap"][..],
        &dictionary,
        &["generated.mcap"],
    ]
    .concat());
    bench.ok(&["view", "generated.mcap", "-o", "viewed.mcap"]);
    for take in ["out/cube_test_01.mcap", "generated.mcap", "viewed.mcap"] {
        bench.ok(&[&["evaluate", take][..], &dictionary, &["e.json", "--force"]].concat());
        let steps = without_provenance(bench.json("e.json"));
        for key in [
            "dictionary",
            "methods",
            "default_method",
            "contacts",
            "intervals",
        ] {
            assert!(!run[key].is_null(), "{key}");
            assert_eq!(steps[key], run[key], "{take}: {key}");
        }
        let [counts, of_run] = [&steps, &run].map(|evaluation| {
            let test = &evaluation["session"]["test"][0];
            (test["segments"].clone(), test["left_out"].clone())
        });
        assert!(!of_run.0.is_null() && !of_run.1.is_null(), "{of_run:?}");
        assert_eq!(counts, of_run, "{take}");
    }
    let of_run = messages(&bench, "out/cube_test_01.mcap");
    for take in ["generated.mcap", "viewed.mcap"] {
        let found = messages(&bench, take);
        for topic in [
            "/view/hulls",
            "/view/object",
            "/processed/object",
            "/evaluation/recorded/contact",
        ] {
            assert!(
                found.get(topic).is_some_and(|m| !m.is_empty()),
                "{take}: {topic} {:?}",
                found.keys()
            );
            assert!(found[topic] == of_run[topic], "{take}: {topic}");
        }
    }
}

#[test]
fn typed_settings_win_over_a_file_and_that_over_stored_ones() {
    let bench = Bench::csv();
    let layers = [
        ("40", "cube:0.04"),
        ("30", "cube:0.06"),
        ("20", "cube:0.07"),
    ];
    for combination in 0..8 {
        let [stored, file, typed] = [0, 1, 2].map(|layer| {
            let (window, shape) = layers[layer];
            (combination & (1 << layer) != 0).then_some([window, shape])
        });
        let options = |set: Option<[&'static str; 2]>| {
            let options = set.map(|[window, shape]| vec!["--window", window, "--object", shape]);
            options.unwrap_or_default()
        };
        let first = [
            "process",
            TEST,
            "-o",
            "a/x.mcap",
            "--force",
            "--settings",
            "none",
        ];
        bench.ok(&[&first[..], &options(stored)].concat());
        let text = file.map(|[window, shape]| {
            format!("process.window = {window}\nobject.shape = \"{shape}\"\n")
        });
        bench.write("a/inhand.toml", text.unwrap_or_default());
        let expected = typed.or(file).or(stored);
        let window = expected.map_or("50", |[window, _]| window);
        for step in ["process", "view"] {
            let call = [step, "a/x.mcap", "-o", "y.mcap", "--force"];
            let options = options(typed);
            let from = if step == "view" { 2 } else { 0 };
            bench.ok(&[&call[..], options.get(from..).unwrap_or_default()].concat());
            let set = last_step(&bench, "y.mcap");
            let shape = expected.map(|[_, shape]| shape);
            assert_eq!(
                set["object"]["shape"].as_str(),
                shape,
                "{combination} {step}"
            );
            if step == "process" {
                assert_eq!(
                    set["process"]["window"].to_string(),
                    window,
                    "{combination}"
                );
            }
        }
    }
}

#[test]
fn a_finger_is_one_setting_by_all_its_names() {
    let bench = Bench::csv();
    let quick = [
        "run",
        "session",
        "-o",
        "out",
        "--rank",
        "5",
        "--max-iterations",
        "2",
        "--methods",
        "line,hermite",
        "--pad-offset-mm",
        "little=0",
    ];
    let clean = [
        "clean",
        TEST,
        "-o",
        "clean.mcap",
        "--pad-mm",
        "little=0,0,1",
    ];
    let process = ["process", TEST, "-o", "x.mcap", "--finger", "little=Little"];
    for (table, value, call, made, key) in [
        (
            "evaluate.pad_offset_mm",
            "3.0",
            &quick[..],
            "out/cube_test_01.mcap",
            "/evaluate/pad_offset_mm",
        ),
        (
            "clean.pad_mm",
            "[1, 2, 3]",
            &clean,
            "clean.mcap",
            "/clean/pad_mm",
        ),
        ("fingers", "\"Ring\"", &process, "x.mcap", "/fingers"),
    ] {
        let text = format!("[{table}]\npinky = {value}\n");
        bench.write("session/inhand.toml", &text);
        bench.ok(call);
        let made = last_step(&bench, made);
        let fingers = made.pointer(key).and_then(Value::as_object);
        let fingers = fingers.unwrap_or_else(|| panic!("{key}: {made}"));
        let typed = [("little=0", "0.0"), ("little=0,0,1", "[0.0,0.0,1.0]")];
        let typed = typed.iter().find(|(typed, _)| call.contains(typed));
        let typed = typed.map_or("\"Little\"", |(_, shown)| shown);
        assert_eq!(fingers.len(), 1, "{fingers:?}");
        assert_eq!(fingers["little"].to_string(), typed);
        // The same finger twice in one file has no meaning.
        bench.write("session/inhand.toml", format!("{text}Little = {value}\n"));
        let said = refused(&bench, call);
        assert!(said.contains("found little under two names"), "{said}");
    }
    // A file wins over what is stored.
    bench.write("p.toml", "[evaluate.pad_offset_mm]\nPinky = 3.0\n");
    let view = ["view", "out/cube_test_01.mcap", "-o", "v.mcap"];
    bench.ok(&[&view[..], &["--settings", "p.toml"]].concat());
    assert_eq!(
        last_step(&bench, "v.mcap")["evaluate"]["pad_offset_mm"].to_string(),
        "{\"little\":3.0}"
    );
}

#[test]
fn stored_motion_is_used_where_it_was_made_by_the_same_settings() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let generated = |take: &str, options: &[&str], name: &str| {
        let call = ["generate", take, "-d", "out/dictionary.mcap", "-o", name];
        bench.ok(&[&call[..], options].concat());
        messages(&bench, name).remove("/processed/fingertips")
    };
    let take = "out/cube_test_01.mcap";
    let usual = generated(TEST, &[], "a.mcap");
    assert!(usual.is_some() && generated(take, &[], "b.mcap") == usual);
    let window = ["--window", "20"];
    let other = generated(take, &window, "c.mcap");
    assert!(other != usual && other == generated(TEST, &window, "d.mcap"));
    assert!(generated("c.mcap", &[], "e.mcap") == other);
}

#[test]
fn an_evaluation_says_where_it_compares_other_motion_and_by_what_it_was_made() {
    let bench = Bench::csv();
    bench.run("out", &["--margin", "0.2", "--window", "30"]);
    let call = [
        "evaluate",
        "out/cube_test_01.mcap",
        "-d",
        "out/dictionary.mcap",
    ];
    let evaluate = |options: &[&str]| {
        let output = bench.inhand(&[&call[..], &["-o", "e.json", "--force"], options].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stderr(&output)
    };
    let different = "published errors compare different motion";
    let said = evaluate(&[]);
    assert!(!said.contains(different), "{said}");
    let said = evaluate(&["--window", "20"]);
    let line = format!(
        "warning  out/cube_test_01.mcap: trajectories were generated with process.window 30, here it is 20: {different}\n"
    );
    assert!(said.contains(&line), "{said}");
    // Segments are those of the step that generated, whatever a file says.
    bench.write("margin.toml", "segments.margin_s = 0.1\n");
    evaluate(&["--settings", "margin.toml"]);
    let text = String::from_utf8(bench.bytes("e.json")).expect("JSON is text");
    let last = text.rsplit("margin_s").next().unwrap_or_default();
    assert!(
        last.trim_start_matches(['\\', '"', ':', ' '])
            .starts_with("0.2"),
        "{last}"
    );
}

#[test]
fn an_evaluation_writes_all_its_files_or_none() {
    let bench = Bench::csv();
    bench.run("out", &[]);
    let call = [
        "evaluate",
        "out/cube_test_01.mcap",
        "-d",
        "out/dictionary.mcap",
    ];
    let files = ["e.json", "r.csv", "r.held_out.csv"];
    for kept in files {
        bench.write(kept, "somebody's notes");
        let call = [&call[..], &["-o", files[0], "--rows", files[1]]].concat();
        let said = refused(&bench, &call);
        assert!(said.contains(&format!("{kept}: already exists")), "{said}");
        for file in files {
            assert_eq!(bench.path(file).exists(), file == kept, "{kept}: {file}");
        }
        bench.ok(&[&call[..], &["--force"]].concat());
        bench.ok(&call);
        for file in files {
            std::fs::remove_file(bench.path(file)).expect("it is written");
        }
    }
}

#[test]
fn a_setting_is_named_as_it_was_typed_and_a_file_by_its_own_words() {
    let bench = Bench::csv();
    let call = ["process", TEST, "-o", "x.mcap"];
    let said = refused(&bench, &[&call[..], &["--object", "ball:1"]].concat());
    assert!(
        said.contains("error: --object (object.shape): expected"),
        "{said}"
    );
    let said = refused(&bench, &[&call[..], &["--up", "x"]].concat());
    assert!(
        said.contains("error: --up (source.up): expected y or z"),
        "{said}"
    );
    bench.write("session/inhand.toml", "object.shape = \"ball:1\"\n");
    let said = refused(&bench, &call);
    assert!(
        said.contains("error: setting object.shape: expected"),
        "{said}"
    );
    bench.write("session/inhand.toml", "[fingres]\n");
    let said = refused(&bench, &call);
    assert!(
        said.contains("`fingers`") && !said.contains("--finger"),
        "{said}"
    );
}

#[test]
fn stored_settings_that_differ_are_an_error_that_names_both() {
    let bench = Bench::csv();
    for (take, name, window, shape) in [
        (TRAIN[0], "a.mcap", "40", "cube:0.05"),
        (TRAIN[1], "b.mcap", "30", "cube:0.05"),
        (TRAIN[1], "c.mcap", "40", "cylinder:0.05x0.07"),
    ] {
        bench.ok(&[
            "process", take, "-o", name, "--window", window, "--object", shape,
        ]);
    }
    let call = ["process", "a.mcap", "b.mcap", "-o", "."];
    let said = refused(&bench, &call);
    for part in ["a.mcap", "b.mcap", "process.window is 40", "30"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    bench.write("folder/empty.toml", "");
    bench.ok(&[
        "process", "a.mcap", "b.mcap", "-o", "folder", "--window", "20",
    ]);
    assert_eq!(last_step(&bench, "folder/a.mcap")["process"]["window"], 20);
    // Takes of two objects can teach one dictionary.
    bench.ok(&[&["learn", "a.mcap", "c.mcap", "-o", "d.mcap"][..], &SMALL].concat());

    bench.write("one/inhand.toml", "[process]\n");
    bench.write("two/test/x.csv", bench.bytes(TEST));
    bench.write("one/y.csv", bench.bytes(TEST));
    bench.write("two/inhand.toml", "");
    let said = refused(
        &bench,
        &["process", "one/y.csv", "two/test/x.csv", "-o", "folder"],
    );
    assert!(
        said.contains("one/inhand.toml") && said.contains("two/inhand.toml"),
        "{said}"
    );
    let none = ["--settings", "none"];
    bench.ok(&[
        &["process", "one/y.csv", "two/test/x.csv", "-o", "folder"][..],
        &none,
    ]
    .concat());
}

#[test]
fn stored_roles_stay_where_others_are_typed() {
    let bench = Bench::csv();
    bench.edit(TEST, |csv| {
        csv.replace("Thumb", "Digit1").replace("Index", "Digit2")
    });
    let both = ["--finger", "thumb=Digit1", "--finger", "index=Digit2"];
    bench.ok(&[&["process", TEST, "-o", "a.mcap"][..], &both].concat());
    bench.ok(&[
        "process",
        "a.mcap",
        "-o",
        "b.mcap",
        "--finger",
        "index=Digit2",
    ]);
    bench.ok(&["process", "b.mcap", "-o", "c.mcap"]);
    let tips = |name: &str| messages(&bench, name).remove("/processed/fingertips");
    assert!(tips("a.mcap").is_some() && tips("a.mcap") == tips("c.mcap"));
    // Motion with other roles is made anew.
    let swapped = ["--finger", "thumb=Digit2", "--finger", "index=Digit1"];
    bench.ok(&[&["process", TEST, "-o", "d.mcap"][..], &swapped].concat());
    let learned = |take: &str, fingers: &[&str]| {
        let call = ["learn", take, "-o", "d.mcap", "--force", "--format", "json"];
        let learned = bench.ok(&[&call[..], &SMALL, fingers].concat());
        let learned: Value = serde_json::from_str(&learned).expect("learn prints JSON");
        learned["rms_mm"].as_f64().expect("a number")
    };
    bench.ok(&["process", "d.mcap", "-o", "e.mcap"]);
    assert_eq!(learned("a.mcap", &swapped), learned("e.mcap", &[]));
}

#[test]
fn check_looks_at_every_take_of_a_session() {
    let bench = Bench::csv();
    let checked = |input: &str| {
        let printed = bench.ok(&["check", input, "--format", "json"]);
        let printed: Value = serde_json::from_str(&printed).expect("check prints JSON");
        let takes = printed["takes"].as_array().expect("takes are listed");
        let mut files: Vec<_> = takes.iter().map(|take| take["file"].to_string()).collect();
        files.sort();
        files
    };
    let expected =
        [TEST, TRAIN[0], TRAIN[1]].map(|take| format!("{:?}", &take["session/".len()..]));
    assert_eq!(checked("session"), expected);
    assert_eq!(checked("session/inhand.toml"), expected);
    bench.write(
        "ranges.toml",
        "takes = [{ path = \"session/test/cube_test_01.csv\", role = \"train\", to_s = 8.0 }, \
                  { path = \"session/test/cube_test_01.csv\", role = \"test\", from_s = 8.0 }]",
    );
    let printed = |input: &str| -> Value {
        let printed = bench.ok(&["check", input, "--format", "json"]);
        serde_json::from_str(&printed).expect("check prints JSON")
    };
    let parts = |input: &str| {
        let mut parts = printed(input)["takes"].as_array().expect("takes").clone();
        parts.retain(|take| {
            take["file"]
                .as_str()
                .is_some_and(|file| file.ends_with("test/cube_test_01.csv"))
        });
        parts.sort_by_key(|take| take["role"] == "test");
        let facts = ["role", "from_s", "to_s"];
        (parts
            .iter()
            .map(|take| facts.map(|fact| take[fact].clone())))
        .collect::<Vec<_>>()
    };
    let of = |role: &str, from_s: f64, to_s: f64| -> [Value; 3] {
        [role.into(), from_s.into(), to_s.into()]
    };
    let halves = [of("train", 0.0, 8.0), of("test", 8.0, 12.0)];
    assert_eq!(parts("ranges.toml"), halves);
    let text = bench.ok(&["check", "ranges.toml"]);
    assert!(
        text.contains("test/cube_test_01.csv (0 s to 8 s)"),
        "{text}"
    );
    // A take without a role serves both: each part is told by its own range.
    bench.write("both.toml", format!("takes = [{{ path = \"{TEST}\" }}]"));
    let both = parts("both.toml");
    assert_eq!([&both[0][0], &both[1][0]], ["train", "test"]);
    assert_eq!([&both[0][1], &both[1][2]], [0.0, 12.0]);
    assert!(
        both[0][2].is_number() && both[0][2] == both[1][1],
        "{both:?}"
    );
    let alone = printed(TEST)["takes"][0].clone();
    assert!(
        ["role", "from_s", "to_s"]
            .iter()
            .all(|fact| alone[fact].is_null()),
        "{alone}"
    );
    // Another settings file says how to read the takes that a session's file stands for.
    bench.write("other.toml", "");
    let other = ["check", "session/inhand.toml", "--settings", "other.toml"];
    let text = bench.ok(&[&other[..], &["--format", "json"]].concat());
    let printed: Value = serde_json::from_str(&text).expect("check prints JSON");
    assert_eq!(printed["takes"].as_array().map(Vec::len), Some(3));
}
