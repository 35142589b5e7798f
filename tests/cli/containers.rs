//! Files cut, filtered, merged and recovered.

use serde_json::Value;

use crate::bags::as_mocap4r2;
use crate::support::{Bench, stderr};

/// A session whose first training take is `take.mcap`, 12 s at 100 Hz.
fn with_take() -> Bench {
    let bench = Bench::csv();
    bench.ok(&[
        "convert",
        "session/train/cube_train_01.csv",
        "-o",
        "take.mcap",
    ]);
    bench
}

fn refused(bench: &Bench, args: &[&str], code: i32, expected: &str) {
    let output = bench.inhand(args);
    assert_eq!(output.status.code(), Some(code), "{}", stderr(&output));
    assert!(stderr(&output).contains(expected), "{}", stderr(&output));
}

fn printed(bench: &Bench, args: &[&str]) -> Value {
    let text = bench.ok(&[args, &["--format", "json"]].concat());
    serde_json::from_str(&text).expect("the command prints JSON")
}

fn take(bench: &Bench, name: &str) -> inhand_channels::ReadTake {
    inhand_channels::read_take(&bench.bytes(name), name).expect("the file holds a take")
}

#[test]
fn a_stretch_of_a_take_is_a_take_for_the_steps_after_it() {
    let bench = with_take();
    let cut = [
        "cut",
        "take.mcap",
        "--from",
        "2.5",
        "--to",
        "9.5",
        "-o",
        "cut.mcap",
    ];
    let outcome = printed(&bench, &cut);
    assert_eq!(outcome["samples"], serde_json::json!([250, 950]));
    let (whole, stretch) = (take(&bench, "take.mcap"), take(&bench, "cut.mcap"));
    let expected = whole.recording.slice(250..950);
    assert_eq!(stretch.recording.clock, expected.clock);
    assert_eq!(stretch.recording.len(), 700);
    assert!(
        (stretch.recording.markers.iter())
            .zip(&expected.markers)
            .all(|(a, b)| {
                a.track.iter().eq(b.track.iter()) && a.track.statuses() == b.track.statuses()
            })
    );
    // The cut is a step of its making, so that it is known to come from the same take.
    assert_eq!(stretch.provenance.len(), whole.provenance.len() + 1);
    assert_eq!(
        stretch.provenance.last().map(|step| &*step.step),
        Some("cut")
    );
    bench.ok(&["process", "cut.mcap", "-o", "processed.mcap"]);
    assert_eq!(take(&bench, "processed.mcap").recording.len(), 700);

    // The same by the clock on the wall.
    let start = whole.recording.clock.start_unix_nanos();
    let at = |s: u64| {
        let nanos = i128::from(start + s * 500_000_000);
        let seconds = nanos.div_euclid(1_000_000_000);
        (seconds, nanos.rem_euclid(1_000_000_000))
    };
    let utc = |(seconds, nanos): (i128, i128)| {
        // Days since 1970 to a date, by the proleptic calendar.
        let (days, rest) = (seconds.div_euclid(86_400), seconds.rem_euclid(86_400));
        let z = days + 719_468;
        let era = z.div_euclid(146_097);
        let of_era = z.rem_euclid(146_097);
        let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
        let of_year = of_era - (365 * year + year / 4 - year / 100);
        let shifted = (5 * of_year + 2) / 153;
        let (day, month) = (
            of_year - (153 * shifted + 2) / 5 + 1,
            (shifted + 2) % 12 + 1,
        );
        let year = year + era * 400 + i128::from(month <= 2);
        let (h, m, s) = (rest / 3600, rest / 60 % 60, rest % 60);
        format!("{year:04}-{month:02}-{day:02}T{h:02}:{m:02}:{s:02}.{nanos:09}Z")
    };
    let (from, to) = (utc(at(5)), utc(at(19)));
    bench.ok(&[
        "cut",
        "take.mcap",
        "--from",
        &from,
        "--to",
        &to,
        "-o",
        "utc.mcap",
    ]);
    assert_eq!(take(&bench, "utc.mcap").recording.len(), 700);
    assert_eq!(take(&bench, "utc.mcap").recording.clock, expected.clock);
}

#[test]
fn what_cannot_be_cut_is_refused_and_nothing_is_written() {
    let bench = with_take();
    let before = bench.bytes("take.mcap");
    refused(
        &bench,
        &["cut", "take.mcap", "-o", "take.mcap", "--force"],
        2,
        "also an input",
    );
    let noon = ["cut", "take.mcap", "--from", "noon", "-o", "out.mcap"];
    refused(&bench, &noon, 2, "seconds since the start");
    let backwards = [
        "cut",
        "take.mcap",
        "--from",
        "5",
        "--to",
        "4",
        "-o",
        "out.mcap",
    ];
    refused(&bench, &backwards, 2, "after");
    let after = ["cut", "take.mcap", "--from", "500", "-o", "out.mcap"];
    refused(&bench, &after, 1, "none of them");
    bench.write(
        "bag.mcap",
        as_mocap4r2(&take(&bench, "take.mcap").recording),
    );
    let after = ["cut", "bag.mcap", "--from", "500", "-o", "out.mcap"];
    refused(&bench, &after, 2, "no message is in that range");
    refused(
        &bench,
        &["cut", "session/inhand.toml", "-o", "out.mcap"],
        1,
        "",
    );
    bench.write("cut.mcap", &before[..before.len() / 2]);
    refused(
        &bench,
        &["cut", "cut.mcap", "-o", "out.mcap"],
        1,
        "inhand recover",
    );
    assert!(!bench.path("out.mcap").exists());
    assert!(bench.bytes("take.mcap") == before);
}

#[test]
fn topics_are_chosen_as_with_the_mcap_tool() {
    let bench = with_take();
    let topics = |name: &str| -> Vec<String> {
        let info = inhand_channels::info(&bench.bytes(name), name).expect("the file is sound");
        assert!(info.problem.is_none() && info.has_summary);
        info.channels
            .into_iter()
            .map(|channel| channel.topic)
            .collect()
    };
    bench.ok(&[
        "filter",
        "take.mcap",
        "-y",
        "/recording/.*",
        "-n",
        ".*/bodies",
        "-o",
        "a.mcap",
    ]);
    assert_eq!(
        topics("a.mcap"),
        [
            "/recording/markers",
            "/recording/fingertips",
            "/recording/findings"
        ]
    );
    // Whole topics are meant.
    let none = bench.inhand(&["filter", "take.mcap", "-y", "/record", "-o", "b.mcap"]);
    assert_eq!(none.status.code(), Some(3));
    assert!(
        stderr(&none).contains("no topic matches"),
        "{}",
        stderr(&none)
    );
    let plain = [
        "filter",
        "take.mcap",
        "--compression",
        "none",
        "--no-metadata",
        "-o",
        "c.mcap",
    ];
    bench.ok(&plain);
    assert_eq!(topics("c.mcap"), topics("take.mcap"));
    let info = inhand_channels::info(&bench.bytes("c.mcap"), "c").expect("the file is sound");
    assert!(info.metadata.0.is_empty());
    assert_eq!(info.chunks.compression.keys().collect::<Vec<_>>(), ["none"]);
    refused(
        &bench,
        &["filter", "take.mcap", "-y", "(", "-o", "d.mcap"],
        2,
        "--include-topic-regex",
    );
}

#[test]
fn two_takes_do_not_become_one_by_accident() {
    let bench = with_take();
    bench.ok(&[
        "convert",
        "session/train/cube_train_02.csv",
        "-o",
        "other.mcap",
    ]);
    let merge = ["merge", "take.mcap", "other.mcap", "-o", "both.mcap"];
    refused(&bench, &merge, 1, "a file can hold one take");
    assert!(!bench.path("both.mcap").exists());
    bench.ok(&[&merge[..], &["--keep-both"]].concat());
    let bytes = bench.bytes("both.mcap");
    let info = inhand_channels::info(&bytes, "both").expect("the file is sound");
    let of = |name: &str| {
        let info = inhand_channels::info(&bench.bytes(name), name);
        info.expect("the file is sound").messages
    };
    assert_eq!(info.messages, of("take.mcap") + of("other.mcap"));
    let names: Vec<_> = info.metadata.0.keys().collect();
    assert!(
        names
            .iter()
            .any(|name| *name == "inhand.recording@take.mcap"),
        "{names:?}"
    );
    assert!(inhand_channels::read_take(&bytes, "both").is_err());

    // One take and what belongs to it are a take.
    bench.ok(&[
        "filter",
        "take.mcap",
        "-y",
        "/tf_static",
        "--no-metadata",
        "-o",
        "tf.mcap",
    ]);
    bench.ok(&["merge", "take.mcap", "tf.mcap", "-o", "one.mcap"]);
    assert_eq!(take(&bench, "one.mcap").recording.len(), 1200);
    refused(
        &bench,
        &["merge", "tf.mcap", "tf.mcap", "-o", "two.mcap"],
        2,
        "twice",
    );
}

#[test]
fn what_is_saved_of_a_cut_file_reads_back() {
    let bench = with_take();
    let sound = bench.bytes("take.mcap");
    let whole = printed(&bench, &["recover", "take.mcap", "-o", "same.mcap"]);
    assert_eq!(whole["lossy"], false);
    assert_eq!(take(&bench, "same.mcap").recording.len(), 1200);

    bench.write("cut.mcap", &sound[..sound.len() * 2 / 3]);
    let output = bench.inhand(&["recover", "cut.mcap", "-o", "saved.mcap"]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        text.contains("cut off") && text.contains("no end"),
        "{text}"
    );
    let saved = inhand_channels::info(&bench.bytes("saved.mcap"), "saved").expect("it is sound");
    assert!(saved.problem.is_none() && saved.has_summary && saved.messages > 100);

    // What is left of a take is a take: the samples that are there are as they were.
    let (whole, saved) = (take(&bench, "take.mcap"), take(&bench, "saved.mcap"));
    let n = saved.recording.len();
    assert!((300..1200).contains(&n), "{n} samples");
    let tracks = |recording: &inhand_model::Recording| -> Vec<String> {
        let markers = recording.markers.iter();
        markers
            .map(|marker| format!("{:?}", marker.track))
            .collect()
    };
    assert_eq!(
        tracks(&saved.recording),
        tracks(&whole.recording.slice(0..n))
    );
    bench.ok(&["process", "saved.mcap", "-o", "processed.mcap"]);

    // A chunk in the middle is lost: its samples are missing, those behind it are not.
    let mut damaged = sound.clone();
    let middle = sound.len() / 2;
    damaged[middle..middle + 64].fill(0xaa);
    bench.write("damaged.mcap", &damaged);
    let output = bench.inhand(&["recover", "damaged.mcap", "-o", "rest.mcap"]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let rest = take(&bench, "rest.mcap").recording;
    assert_eq!(rest.len(), 1200);
    let lost = rest.markers[0].track.counts().missing;
    assert!(lost > 0 && lost < 1000, "{lost} samples are missing");
    for (found, expected) in rest.markers[0]
        .track
        .iter()
        .zip(whole.recording.markers[0].track.iter())
    {
        assert!(found.is_none() || found == expected);
    }
    refused(
        &bench,
        &["recover", "session/inhand.toml", "-o", "x.mcap"],
        1,
        "",
    );
    assert!(!bench.path("x.mcap").exists());
}
