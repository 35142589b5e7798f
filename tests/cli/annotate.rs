//! Events on a file's time line, and data selected by them.

use crate::support::{Bench, SMALL, stderr};

const TAKE: &str = "session/test/cube_test_01.csv";

/// A take, a file of events and the take with them.
fn labelled() -> Bench {
    let bench = Bench::csv();
    bench.ok(&["convert", TAKE, "-o", "a.mcap"]);
    bench.write(
        "events.csv",
        "start_s,end_s,task,label,note\n\
         2,7.5,rotate,,\"first, \"\"slow\"\"\"\n\
         4.123456789,4.2,,slip,\n\
         9,9.5,lift,,é\n",
    );
    bench.ok(&["annotate", "import", "a.mcap", "events.csv", "-o", "b.mcap"]);
    bench
}

#[test]
fn events_of_a_csv_come_back_to_the_byte() {
    let bench = labelled();
    bench.ok(&["annotate", "export", "b.mcap", "-o", "back.csv"]);
    assert_eq!(bench.bytes("back.csv"), bench.bytes("events.csv"));
    assert_eq!(
        bench.ok(&["annotate", "export", "b.mcap"]).into_bytes(),
        bench.bytes("events.csv")
    );
    // Importing them again in place of themselves changes nothing that is read.
    bench.ok(&[
        "annotate",
        "import",
        "b.mcap",
        "back.csv",
        "--replace",
        "-o",
        "c.mcap",
    ]);
    bench.ok(&["annotate", "export", "c.mcap", "-o", "again.csv"]);
    assert_eq!(bench.bytes("again.csv"), bench.bytes("events.csv"));

    // The take is as it was, the step is in its history, and later steps pass events on.
    let read = |name: &str| {
        inhand_channels::read_take(&bench.bytes(name), name).expect("annotate wrote a take")
    };
    let (a, b) = (read("a.mcap"), read("b.mcap"));
    let values = |take: &inhand_channels::ReadTake| -> Vec<String> {
        let markers = take.recording.markers.iter();
        markers
            .map(|marker| format!("{:?}", marker.track))
            .collect()
    };
    assert_eq!(values(&a), values(&b));
    assert_eq!(b.provenance.len(), a.provenance.len() + 1);
    assert_eq!(b.provenance.last().expect("a step").step, "annotate");
    // Without the object's shape no phases are added.
    bench.ok(&["process", "b.mcap", "-o", "p.mcap", "--settings", "none"]);
    assert_eq!(read("p.mcap").annotations, b.annotations);
    assert_eq!(b.annotations.events.len(), 3);
}

#[test]
fn events_are_added_changed_and_taken_out() {
    let bench = labelled();
    bench.ok(&[
        "annotate",
        "add",
        "b.mcap",
        "--at",
        "1..1.5",
        "--label",
        "slip",
        "--label",
        "finger=index",
        "-o",
        "c.mcap",
    ]);
    bench.ok(&[
        "annotate",
        "edit",
        "c.mcap",
        "--event",
        "3",
        "--at",
        "9..10",
        "--label",
        "task=drop",
        "--remove-label",
        "note",
        "-o",
        "d.mcap",
    ]);
    bench.ok(&[
        "annotate", "remove", "d.mcap", "--event", "1", "-o", "e.mcap",
    ]);
    bench.ok(&[
        "annotate",
        "about",
        "e.mcap",
        "--set",
        "subject=s01",
        "--set",
        "task=turn",
        "-o",
        "f.mcap",
    ]);
    let listed: serde_json::Value =
        serde_json::from_str(&bench.ok(&["annotate", "list", "f.mcap", "--format", "json"]))
            .expect("list prints JSON");
    assert_eq!(
        listed["about"],
        serde_json::json!({"subject": "s01", "task": "turn"})
    );
    let events = listed["events"].as_array().expect("a list");
    let short: Vec<_> = (events.iter())
        .map(|e| serde_json::json!([e["number"], e["start_s"], e["end_s"], e["labels"]]))
        .collect();
    assert_eq!(
        short,
        [
            serde_json::json!([1, 4.123_456_789, 4.2, {"label": "slip"}]),
            serde_json::json!([2, 9.0, 10.0, {"task": "drop"}]),
            serde_json::json!([3, 1.0, 1.5, {"label": "slip", "finger": "index"}]),
        ]
    );
    let text = bench.ok(&["annotate", "list", "f.mcap"]);
    assert!(text.starts_with("subject    s01\n"), "{text}");
    assert!(text.contains("1 .. 1.5"), "{text}");
    let remove = ["annotate", "remove", "f.mcap", "-o", "g.mcap", "--label"];
    let output = bench.inhand(&[&remove[..], &["slip", "--label", "slipp"]].concat());
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("slipp: no event has it"));
    assert!(!bench.path("g.mcap").exists());
    bench.ok(&[&remove[..], &["slip"]].concat());
    bench.ok(&[
        "annotate", "remove", "g.mcap", "--event", "1", "-o", "h.mcap",
    ]);
    let channels = bench.ok(&["info", "h.mcap", "--format", "json"]);
    assert!(
        !channels.contains("/annotations"),
        "the last event took its channel with it"
    );
    assert!(
        bench
            .ok(&["annotate", "list", "h.mcap"])
            .contains("subject")
    );
}

#[test]
fn events_join_files_that_hold_no_take() {
    let bench = Bench::csv();
    let train = [
        "session/train/cube_train_01.csv",
        "session/train/cube_train_02.csv",
    ];
    bench.ok(&[&["learn"], &train[..], &["-o", "d.mcap"], &SMALL].concat());
    bench.ok(&[
        "annotate", "add", "d.mcap", "--at", "0.5", "--label", "look", "-o", "e.mcap",
    ]);
    let text = bench.ok(&["annotate", "list", "e.mcap"]);
    assert!(text.contains("0.5 .. 0.5"), "{text}");
    // What was there is still what it was.
    let dictionary = |name: &str| {
        inhand_channels::read_dictionary(&bench.bytes(name), name)
            .expect("a dictionary")
            .0
    };
    assert_eq!(
        dictionary("d.mcap").primitives,
        dictionary("e.mcap").primitives
    );
}

#[test]
fn learning_and_judging_use_what_is_selected() {
    let bench = labelled();
    bench.ok(&["convert", "session/train/cube_train_01.csv", "-o", "t.mcap"]);
    bench.ok(&[
        "annotate",
        "add",
        "t.mcap",
        "--at",
        "1..9",
        "--label",
        "task=rotate",
        "-o",
        "u.mcap",
    ]);
    let learn = |options: &[&str]| -> serde_json::Value {
        let args = [
            &[
                "learn", "u.mcap", "-o", "d.mcap", "--force", "--format", "json",
            ],
            options,
        ];
        let small = [
            "--rank",
            "2",
            "--max-iterations",
            "3",
            "--deviation-primitives",
            "2",
        ];
        let printed = bench.ok(&[&args.concat()[..], &small].concat());
        serde_json::from_str(&printed).expect("learn prints JSON")
    };
    // A second a segment: eight of 1 s to 9 s, of 12 s eleven.
    assert_eq!(learn(&[])["segments"], 11);
    assert_eq!(learn(&["--event", "task=rotate"])["segments"], 8);
    assert_eq!(learn(&["--without", "task=rotate"])["segments"], 2);

    // Judged by what was selected when it was generated, less what is left out now.
    learn(&[]);
    let judged = |generated: &[&str], now: &[&str]| {
        let generate = [
            "generate", "b.mcap", "-d", "d.mcap", "-o", "g.mcap", "--force",
        ];
        bench.ok(&[&generate[..], &["--methods", "line"], generated].concat());
        let evaluate = [
            "evaluate", "g.mcap", "-d", "d.mcap", "-o", "e.json", "--force",
        ];
        bench.ok(&[&evaluate[..], now].concat());
        let n = &bench.json("e.json")["methods"][0]["error_mm"]["all"]["n"];
        n.as_u64().expect("a count") / 500
    };
    assert_eq!(judged(&[], &[]), 11);
    assert_eq!(
        judged(&["--event", "task=rotate"], &["--event", "task=rotate"]),
        5
    );
    assert_eq!(judged(&["--event", "task=rotate"], &[]), 5);
    assert_eq!(
        judged(&["--event", "task=rotate"], &["--without", "slip"]),
        4
    );

    let refused = bench.inhand(&["learn", "u.mcap", "-o", "x.mcap", "--event", "task=rotat"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        stderr(&refused).contains("task=rotate"),
        "{}",
        stderr(&refused)
    );
    assert!(!bench.path("x.mcap").exists());
}

#[test]
fn files_are_cut_by_events() {
    let bench = labelled();
    bench.ok(&["cut", "b.mcap", "--event", "task=rotate", "-o", "one.mcap"]);
    let take = inhand_channels::read_take(&bench.bytes("one.mcap"), "one.mcap").expect("a take");
    assert_eq!(take.recording.len(), 551, "both ends are included");
    bench.ok(&[
        "cut",
        "b.mcap",
        "--event",
        "task=rotate",
        "--without",
        "slip",
        "-o",
        "parts",
    ]);
    let length = |name: &str| {
        let take = inhand_channels::read_take(&bench.bytes(name), name).expect("a take");
        take.recording.len()
    };
    assert_eq!(
        [length("parts/b_01.mcap"), length("parts/b_02.mcap")],
        [213, 330]
    );
    let refused = bench.inhand(&["cut", "b.mcap", "--event", "fly", "-o", "x.mcap"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("annotate list"));
}

#[test]
fn labels_outside_the_vocabulary_are_refused() {
    let bench = labelled();
    bench.write(
        "words.toml",
        "task = [\"rotate\", \"lift\"]\nlabel = [\"slip\"]\nnote = \"any\"\n",
    );
    let words = ["--vocabulary", "words.toml", "-o", "x.mcap"];
    bench.ok(&[
        &["annotate", "import", "a.mcap", "events.csv"],
        &words[..],
        &["--force"],
    ]
    .concat());
    std::fs::remove_file(bench.path("x.mcap")).expect("it was written");
    for (label, expected) in [
        ("task=fly", "one of rotate, lift"),
        ("hand=left", "a key of the vocabulary"),
    ] {
        let add = ["annotate", "add", "a.mcap", "--at", "1", "--label", label];
        let refused = bench.inhand(&[&add[..], &words].concat());
        assert_eq!(refused.status.code(), Some(2));
        assert!(stderr(&refused).contains(expected), "{}", stderr(&refused));
        assert!(!bench.path("x.mcap").exists());
    }
    // Only what is typed has to be in it: the file has an event of its own.
    bench.ok(&[
        "annotate",
        "add",
        "a.mcap",
        "--at",
        "1",
        "--label",
        "hand=left",
        "-o",
        "own.mcap",
    ]);
    let add = [
        "annotate", "add", "own.mcap", "--at", "2..3", "--at", "4..900", "--label",
    ];
    let added = bench.inhand(&[&add[..], &["task=lift"], &words].concat());
    assert_eq!(added.status.code(), Some(0), "{}", stderr(&added));
    assert!(
        stderr(&added).contains("2 events added"),
        "{}",
        stderr(&added)
    );
    let late = "the event at 4 s ends after the take";
    assert!(stderr(&added).contains(late), "{}", stderr(&added));
}

#[test]
fn what_cannot_be_annotated_is_refused() {
    let bench = labelled();
    bench.write("bad.csv", "start_s,end_s,task\n1,2,a\n3,2.5,b\n");
    let cases: [(&[&str], i32, &str); 7] = [
        (
            &["add", TAKE, "--at", "1", "--label", "x"],
            1,
            "inhand convert",
        ),
        (
            &["add", "a.mcap", "--at", "2..1", "--label", "x"],
            2,
            "an end that is not before",
        ),
        (
            &["add", "a.mcap", "--at", "soon", "--label", "x"],
            2,
            "63.4..63.6",
        ),
        (
            &["add", "a.mcap", "--at", "1", "--label", "="],
            2,
            "is no label",
        ),
        (
            &["import", "a.mcap", "bad.csv"],
            1,
            "line 3, column 2 (\"end_s\")",
        ),
        (
            &["edit", "b.mcap", "--event", "4", "--label", "x"],
            2,
            "expected 1 to 3",
        ),
        (&["add", "a.mcap", "--at", "5e9", "--label", "x"], 1, "2106"),
    ];
    for (args, code, expected) in cases {
        let refused = bench.inhand(&[&["annotate"], args, &["-o", "x.mcap"]].concat());
        assert_eq!(
            refused.status.code(),
            Some(code),
            "{args:?}: {}",
            stderr(&refused)
        );
        assert!(
            stderr(&refused).contains(expected),
            "{args:?}: {}",
            stderr(&refused)
        );
        assert!(!bench.path("x.mcap").exists());
    }
    let same = bench.inhand(&[
        "annotate", "add", "a.mcap", "--at", "1", "--label", "x", "-o", "a.mcap",
    ]);
    assert!(stderr(&same).contains("the output is also an input"));
}

#[test]
fn events_that_reach_into_a_stretch_stay_with_it() {
    let bench = labelled();
    // From 4 s to 6 s: rotate began before, slip lies inside, lift comes after.
    bench.ok(&["cut", "b.mcap", "--from", "4", "--to", "6", "-o", "c.mcap"]);
    let take = inhand_channels::read_take(&bench.bytes("c.mcap"), "c.mcap").expect("a take");
    assert_eq!(take.recording.len(), 200);
    let labels: Vec<_> = (take.annotations.events.iter())
        .map(|event| event.labels.values().next().map(String::as_str))
        .collect();
    assert_eq!(labels.len(), 2, "{labels:?}");
    assert!(labels.contains(&Some("slip")), "{labels:?}");
    // After the last of them nothing is left.
    bench.ok(&["cut", "b.mcap", "--from", "10", "-o", "d.mcap"]);
    let listed = bench.ok(&["annotate", "list", "d.mcap"]);
    assert!(listed.contains("no events"), "{listed}");
}

#[test]
fn learning_leaves_out_what_lies_between_two_samples() {
    let bench = labelled();
    bench.ok(&["convert", "session/train/cube_train_01.csv", "-o", "t.mcap"]);
    let add = [
        "annotate", "add", "t.mcap", "--at", "7.0051", "--label", "slip",
    ];
    bench.ok(&[&add[..], &["-o", "u.mcap"]].concat());
    let small = [
        "--rank",
        "2",
        "--max-iterations",
        "3",
        "--deviation-primitives",
        "2",
    ];
    let learn = ["learn", "u.mcap", "-o", "d.mcap", "--without", "slip"];
    bench.ok(&[&learn[..], &small].concat());
}
