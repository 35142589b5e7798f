//! Faults found and repaired, with what was measured kept.

use serde_json::Value;

use crate::support::{Bench, stderr};

const TAKE: &str = "session/test/cube_test_01.csv";

fn faulty() -> Bench {
    let bench = Bench::empty();
    let sizes = ["--takes", "1", "--duration", "30", "--seed", "3"];
    bench.ok(&[
        &["simulate", "-o", "session", "--format", "csv", "--faults"],
        &sizes[..],
    ]
    .concat());
    bench
}

#[test]
fn planted_faults_are_listed_and_nothing_is_written() {
    let bench = faulty();
    let truth: Value = bench.json("session/test/cube_test_01.truth.json");
    assert!(truth.to_string().contains("swap"), "{truth}");
    let listed = bench.ok(&["clean", TAKE]);
    for step in ["--swaps", "--flips", "--spikes", "--stitch"] {
        assert!(listed.contains(step), "{listed}");
    }
    let call = format!("to repair them: inhand clean {TAKE} --repair -o CLEANED.mcap\n");
    assert!(listed.ends_with(&call), "{listed}");
    let files = std::fs::read_dir(bench.folder.path()).expect("the folder is there");
    assert_eq!(files.count(), 1, "only the session is there");
}

#[test]
fn a_repaired_take_keeps_what_was_measured() {
    let bench = faulty();
    bench.ok(&["convert", TAKE, "-o", "a.mcap"]);
    bench.ok(&[
        "clean", "a.mcap", "--repair", "--fill", "cubic", "-o", "b.mcap",
    ]);
    let read = |name: &str| {
        inhand_channels::read_take(&bench.bytes(name), name).expect("a take was written")
    };
    let (a, b) = (read("a.mcap"), read("b.mcap"));
    let values = |recording: &inhand_model::Recording| -> Vec<String> {
        let markers = recording
            .markers
            .iter()
            .map(|marker| format!("{:?}", marker.track));
        let bodies = recording
            .bodies
            .iter()
            .map(|body| format!("{:?}", body.track));
        markers.chain(bodies).collect()
    };
    assert!(
        values(&a.recording) == values(&b.recording),
        "what was measured stays"
    );
    let cleaned = b.cleaned.expect("the cleaned recording is beside it");
    assert!(values(&cleaned.recording) != values(&a.recording));
    assert!(cleaned.changes.len() > 20, "{}", cleaned.changes.len());

    // Little is left to find, later steps use the cleaned recording, and pass both on.
    let again = bench.ok(&["check", "b.mcap", "--format", "json", "--fail-on", "never"]);
    let again: Value = serde_json::from_str(&again).expect("check prints JSON");
    let kinds = again.to_string();
    assert!(!kinds.contains("\"swaps\",\"level\":\"warn\""), "{kinds}");
    bench.ok(&["process", "b.mcap", "-o", "p.mcap"]);
    assert!(read("p.mcap").cleaned.is_some());
    let filled = |name: &str| -> usize {
        let motion = read(name).motion.expect("process stored it");
        (motion.fingertips.iter())
            .map(|(_, track)| track.counts().missing)
            .sum()
    };
    bench.ok(&["process", "a.mcap", "-o", "q.mcap"]);
    assert!(
        filled("p.mcap") < filled("q.mcap"),
        "less is missing after cleaning"
    );
}

#[test]
fn a_session_is_cleaned_where_its_settings_say_so() {
    let bench = faulty();
    let settings = String::from_utf8(bench.bytes("session/inhand.toml")).expect("text");
    let run = |out: &str| {
        let args = [
            "run",
            "session",
            "-o",
            out,
            "--rank",
            "5",
            "--max-iterations",
            "3",
        ];
        bench.ok(&[&args[..], &["--methods", "line,hermite"]].concat());
        let evaluation = bench.json(&format!("{out}/evaluation.json"));
        evaluation["session"]["test"][0]["segments"]
            .as_u64()
            .expect("a count")
    };
    let plain = run("plain");
    bench.write(
        "session/inhand.toml",
        format!("{settings}\n[clean]\nflips = true\nswaps = true\nspikes = true\nstitch = true\n"),
    );
    assert!(run("cleaned") > plain, "more segments are whole");
}

#[test]
fn steps_that_make_no_sense_are_refused() {
    let bench = faulty();
    for (args, code, expected) in [
        (&["--repair"][..], 2, "-o"),
        (&["--fill", "magic", "-o", "x.mcap"], 2, "neighbours"),
        (&["--resample", "-5", "-o", "x.mcap"], 1, "1 to 10000 Hz"),
        (&["--pad-mm", "toe=1,2,3", "-o", "x.mcap"], 2, "index=0,0,8"),
    ] {
        let refused = bench.inhand(&[&["clean", TAKE], args].concat());
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
}

#[test]
fn a_cut_of_a_cleaned_take_is_one_and_cleaning_goes_on() {
    let bench = faulty();
    bench.ok(&["clean", TAKE, "--repair", "--fill", "cubic", "-o", "a.mcap"]);
    let read = |name: &str| {
        inhand_channels::read_take(&bench.bytes(name), name).expect("a take was written")
    };
    let changes = |name: &str| read(name).cleaned.expect("it is cleaned").changes.len();
    bench.ok(&["clean", "a.mcap", "--resample", "50", "-o", "b.mcap"]);
    assert!(
        changes("b.mcap") > changes("a.mcap"),
        "what was cleaned before stays"
    );
    for name in ["a.mcap", "b.mcap"] {
        bench.ok(&[
            "cut", name, "--from", "10", "--to", "20", "-o", "c.mcap", "--force",
        ]);
        let (whole, cut) = (read(name), read("c.mcap"));
        assert_eq!(cut.recording.len(), 1000);
        let whole = whole.cleaned.expect("it is cleaned").recording;
        let cut = cut.cleaned.expect("it is cleaned").recording;
        let rate_hz = whole.clock.rate_hz() as usize;
        let of = |recording: &inhand_model::Recording| format!("{:?}", recording.markers[0].track);
        assert_eq!(of(&cut), of(&whole.slice(10 * rate_hz..20 * rate_hz)));
        bench.ok(&["process", "c.mcap", "-o", "p.mcap", "--force"]);
    }
}
