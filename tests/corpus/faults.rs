//! Faults of input planted in a real recording: none may pass without a word, and the clean one has none.

#![expect(
    clippy::semicolon_if_nothing_returned,
    reason = "a plant is one expression"
)]

use std::path::Path;

use crate::plant::{ALL, Fault, Table, Takes, judge};
use crate::{corpus, inhand, json, stderr};

const TRAIN: &str = "train/a.tsv";
const TEST: &str = "test/b.tsv";

/// Samples that teach; the rest is the test.
const SPLIT: usize = 4000;

const SETTINGS: &str = "[roles]\nhand = \"hand_top, hand_left, hand_right\"\nobject = \"none\"\n\
                        [segments]\nstride = 20\n[learn]\nrank = 40\nmax_iterations = 10\n";

fn every(takes: &mut Takes, plant: impl Fn(&mut Table)) {
    takes.values_mut().for_each(plant);
}

fn one(takes: &mut Takes, take: &str, plant: impl FnOnce(&mut Table)) {
    plant(takes.get_mut(take).unwrap());
}

fn scale(table: &mut Table, by: f64) {
    table.change("Position", ALL, |p| p.iter_mut().for_each(|x| *x *= by));
}

/// Part of the recording, numbered from one.
fn part(table: &Table, samples: std::ops::Range<usize>) -> Table {
    let mut part = table.clone();
    part.rows = part.rows[samples].to_vec();
    part.state(
        "NO_OF_FRAMES\t6000",
        &format!("NO_OF_FRAMES\t{}", part.rows.len()),
    );
    part.renumber(1);
    part
}

const PILLOW: &str = "--object-body pillow_top,pillow_left,pillow_right";

const FAULTS: [Fault<'_>; 31] = [
    (
        "metres under millimetres",
        "",
        |t| every(t, |t| scale(t, 1e-3)),
        &["units"],
        1,
    ),
    (
        "metres under millimetres in one take",
        "",
        |t| one(t, TEST, |t| scale(t, 1e-3)),
        &["units"],
        1,
    ),
    (
        "inches under millimetres",
        "",
        |t| every(t, |t| scale(t, 1.0 / 25.4)),
        &["units"],
        1,
    ),
    (
        "one take mirrored",
        "",
        |t| one(t, TEST, |t| t.change("Position", ALL, |p| p[0] = -p[0])),
        &["takes-disagree"],
        1,
    ),
    (
        "y and z exchanged in one take",
        "",
        |t| one(t, TEST, |t| t.change("Position", ALL, |p| p.swap(1, 2))),
        &["takes-disagree"],
        1,
    ),
    (
        "hand's markers exchanged in one take",
        "",
        |t| one(t, TEST, |t| t.exchange("hand_left", "hand_right", ALL)),
        &["takes-disagree"],
        0,
    ),
    (
        "ring and little swapped in a take",
        "",
        |t| one(t, TRAIN, |t| t.exchange("ring_tip", "little_tip", ALL)),
        &["finger-order"],
        0,
    ),
    (
        "thumb and middle swapped in the test take",
        "",
        |t| one(t, TEST, |t| t.exchange("thumb_tip", "middle_tip", ALL)),
        &["takes-disagree"],
        1,
    ),
    (
        "index and middle swapped in every take",
        "",
        |t| every(t, |t| t.exchange("index_tip", "middle_tip", ALL)),
        &["finger-order"],
        0,
    ),
    (
        "index and middle swapped for a second",
        "",
        |t| {
            one(t, TRAIN, |t| {
                t.exchange("index_tip", "middle_tip", 2000..2100)
            })
        },
        &["swaps"],
        0,
    ),
    (
        "spikes of 30 mm",
        "",
        |t| {
            one(t, TRAIN, |t| {
                (1..9).for_each(|n| {
                    t.change("index_tip Position", 300 * n..300 * n + 1, |p| p[0] += 30.0)
                })
            })
        },
        &["spikes"],
        0,
    ),
    (
        "a marker lost for most of a take",
        "",
        |t| one(t, TEST, |t| t.lose("little_tip", 100..1900)),
        &["gaps"],
        1,
    ),
    (
        "a take twice",
        "",
        |t| {
            t.insert("train/again.tsv".into(), t[TRAIN].clone());
        },
        &["same-take"],
        1,
    ),
    (
        "a take twice, three seconds later",
        "",
        |t| {
            let mut again = t[TRAIN].clone();
            again.rows.drain(..300);
            again.renumber(1);
            t.insert("train/again.tsv".into(), again);
        },
        &["same-take"],
        1,
    ),
    (
        "the test take among the training takes",
        "",
        |t| {
            t.insert("train/again.tsv".into(), t[TEST].clone());
        },
        &["error: session/test/b.tsv: the test take is also"],
        1,
    ),
    (
        "the elbow as a fingertip",
        "",
        |t| every(t, |t| t.copy("right_elbow", "middle_tip")),
        &["finger-spread"],
        0,
    ),
    (
        "the back as the hand",
        "--hand back_top,back_left,back_right",
        |_| {},
        &["units"],
        0,
    ),
    (
        "a pillow as a cube in the hand",
        "--object-body pillow_top,pillow_left,pillow_right --object cube:0.05",
        |_| {},
        &["object-fit"],
        0,
    ),
    ("no shape", PILLOW, |_| {}, &["no-shape"], 0),
    (
        "a cube of 50 m",
        "--object cube:50",
        |_| {},
        &["object-size"],
        1,
    ),
    (
        "contacts from 20 mm",
        "--object cube:0.05 --tau-mm 20",
        |_| {},
        &["tau"],
        0,
    ),
    (
        "120 Hz in a header over 100 Hz",
        "",
        |t| every(t, |t| t.state("FREQUENCY\t100", "FREQUENCY\t120")),
        &["source", "time-column", "rate"],
        0,
    ),
    (
        "every 20th sample dropped",
        "",
        |t| one(t, TRAIN, Table::drop_samples),
        &["frame-jumps", "time-column"],
        3,
    ),
    (
        "every 20th sample dropped, numbered anew",
        "",
        |t| {
            one(t, TRAIN, |t| {
                t.drop_samples();
                t.renumber(1);
            })
        },
        &["cut-short"],
        3,
    ),
    (
        "samples repeated",
        "",
        |t| one(t, TEST, Table::repeat_samples),
        &["repeated-frames", "rate"],
        0,
    ),
    (
        "a marker frozen for two seconds",
        "",
        |t| one(t, TEST, |t| t.freeze("index_tip", 400..600)),
        &["frozen"],
        0,
    ),
    (
        "a marker of the hand frozen for two seconds",
        "",
        |t| one(t, TEST, |t| t.freeze("hand_left", 400..600)),
        &["frozen"],
        0,
    ),
    (
        "noise of 5 mm",
        "",
        |t| one(t, TEST, |t| t.shake("thumb_tip Position", 5.0)),
        &["noise"],
        0,
    ),
    (
        "times that jump",
        "",
        |t| one(t, TEST, |t| t.jump(600..1200, 2.0)),
        &["time-column"],
        0,
    ),
    (
        "a window of 50 s",
        "--window 5000",
        |_| {},
        &["filter-window"],
        1,
    ),
    ("a margin of 0.3 s", "--margin 0.3", |_| {}, &["margin"], 0),
];

#[test]
fn no_planted_fault_passes_without_a_word() {
    let Some(corpus) = corpus() else { return };
    let text = std::fs::read_to_string(corpus.join("real/hand/recording.tsv")).unwrap();
    let all = Table::new(&text);
    let good = Takes::from([
        (TRAIN.to_owned(), part(&all, 0..SPLIT)),
        (TEST.to_owned(), part(&all, SPLIT..all.rows.len())),
    ]);
    let wrong = FAULTS.iter().filter_map(|fault| {
        let mut takes = good.clone();
        fault.2(&mut takes);
        let folder = tempfile::tempdir().unwrap();
        let (code, stderr) = run(folder.path(), &takes, fault.1);
        let stderr = stderr.replace(&format!("{}/", folder.path().display()), "");
        let result = folder.path().join("out/evaluation.json");
        let evaluation = (matches!(code, Some(0 | 3))).then(|| json(&result));
        judge(fault, code, &stderr, evaluation.as_ref())
    });
    let wrong: Vec<_> = wrong.collect();
    assert!(
        wrong.is_empty(),
        "{} faults\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    let folder = tempfile::tempdir().unwrap();
    let (code, clean) = run(folder.path(), &good, "");
    let warned: Vec<_> = (clean.lines().filter(|line| line.starts_with("warn")))
        .filter_map(|line| {
            line.split([' ', ':'])
                .find(|word| !word.is_empty() && *word != "warn")
        })
        .collect();
    assert_eq!(
        (code, &warned[..]),
        (Some(0), &["segments", "filter-moves"][..]),
        "{clean}"
    );
}

/// Runs a session of these takes.
fn run(folder: &Path, takes: &Takes, options: &str) -> (Option<i32>, String) {
    let session = folder.join("session");
    for (take, table) in takes {
        let path = session.join(take);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, table.text()).unwrap();
    }
    std::fs::write(session.join("inhand.toml"), SETTINGS).unwrap();
    let (session, output) = (
        session.display().to_string(),
        folder.join("out").display().to_string(),
    );
    let mut args = vec!["run", &session, "-o", &output];
    args.extend(options.split_whitespace());
    let output = inhand(&args);
    (output.status.code(), stderr(&output))
}
