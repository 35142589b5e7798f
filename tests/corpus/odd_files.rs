//! MCAP files as people report them, damaged or odd, with what is right.

use serde_json::Value;

use crate::{corpus, inhand, ok, stderr, text};

/// File, messages that `recover` saves, channels, exit code.
const RECOVERED: [(&str, u64, u64, i32); 16] = [
    ("blank_100mb_message", 101, 2, 0),
    ("channel_defined_nowhere", 0, 0, 3),
    ("chunk_times_zero", 100, 1, 0),
    ("lz4_end_mark_flipped", 120, 2, 3),
    ("metadata_of_one_name", 20, 1, 0),
    ("one_bit_in_a_chunk_length", 120, 2, 3),
    ("one_byte_inserted", 1977, 54, 3),
    ("one_flipped_bit_one_chunk", 0, 1, 3),
    ("open_chunk_in_the_middle", 200, 1, 3),
    ("recorder_clock_set_back_1h", 7000, 7, 0),
    ("silent_topics", 20, 3, 0),
    ("three_within_two_ns", 5, 1, 0),
    ("topic_with_two_schemas", 102, 4, 0),
    ("two_equal_channels", 20, 2, 0),
    ("two_files_joined", 40, 2, 0),
    ("wrong_statistics", 100, 1, 0),
];

fn parsed(bytes: &[u8]) -> Value {
    serde_json::from_slice(bytes).expect("the command prints JSON")
}

#[test]
fn odd_files_are_recovered() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().unwrap();
    for (name, messages, channels, code) in RECOVERED {
        let input = corpus.join(format!("hard/mcap/{name}.mcap"));
        let output = folder.path().join(format!("{name}.mcap"));
        let args = [
            "recover",
            text(&input),
            "-o",
            text(&output),
            "--format",
            "json",
        ];
        let called = inhand(&args);
        assert_eq!(
            called.status.code(),
            Some(code),
            "{name}: {}",
            stderr(&called)
        );
        let outcome = parsed(&called.stdout);
        assert_eq!(outcome["messages"], messages, "{name}: {outcome}");
        assert_eq!(outcome["channels"], channels, "{name}: {outcome}");
        let info = parsed(ok(&["info", text(&output), "--format", "json"]).as_bytes());
        assert_eq!(info["messages"], messages, "{name}");
        assert_eq!(
            info["channels"].as_array().map(Vec::len),
            Some(channels as usize)
        );
    }
    let input = corpus.join("hard/mcap/one_flipped_bit_one_chunk.mcap");
    let output = folder.path().join("unverified.mcap");
    let args = [
        "recover",
        text(&input),
        "-o",
        text(&output),
        "--keep-unverified",
    ];
    assert_eq!(inhand(&args).status.code(), Some(3));
    let info = parsed(ok(&["info", text(&output), "--format", "json"]).as_bytes());
    let topics = info["channels"].as_array().into_iter().flatten();
    let topics: Vec<_> = topics
        .map(|c| (c["topic"].as_str(), c["messages"].as_u64()))
        .collect();
    assert_eq!(
        topics,
        [(Some("/a"), Some(0)), (Some("/unverified/a"), Some(1000))]
    );
}

#[test]
fn every_verb_keeps_what_an_odd_file_has() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.mcap");
    for name in [
        "silent_topics",
        "two_equal_channels",
        "topic_with_two_schemas",
        "metadata_of_one_name",
    ] {
        let input = corpus.join(format!("hard/mcap/{name}.mcap"));
        let before = parsed(ok(&["info", text(&input), "--format", "json"]).as_bytes());
        let ends: [&[&str]; 3] = [
            &["filter", "-n", "/none"],
            &["cut", "--from", "0"],
            &["annotate", "add", "--at", "0.2", "--label", "slip"],
        ];
        for end in ends {
            let verb = if end[0] == "annotate" { 2 } else { 1 };
            let out = ["-o", text(&output), "--force"];
            ok(&[&end[..verb], &[text(&input)], &end[verb..], &out].concat());
            let after = parsed(ok(&["info", text(&output), "--format", "json"]).as_bytes());
            let has = |info: &Value, channel: &Value| {
                let mut all = info["channels"].as_array().into_iter().flatten();
                all.any(|other| {
                    ["id", "topic", "schema", "messages"]
                        .iter()
                        .all(|key| other[key] == channel[key])
                })
            };
            for channel in before["channels"].as_array().into_iter().flatten() {
                assert!(has(&after, channel), "{name} {end:?}: {channel}");
            }
            let records = before["metadata_records"].as_array().unwrap();
            let kept = after["metadata_records"].as_array().unwrap();
            assert_eq!(&kept[..records.len()], records, "{name} {end:?}");
        }
    }
}

#[test]
fn wrong_bookkeeping_costs_no_message() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.mcap");
    let cut = |name: &str, range: &[&str]| {
        let input = corpus.join(format!("hard/mcap/{name}.mcap"));
        let args = [
            "cut",
            text(&input),
            "-o",
            text(&output),
            "--force",
            "--format",
            "json",
        ];
        parsed(ok(&[&args[..], range].concat()).as_bytes())["messages"].clone()
    };
    for name in ["wrong_statistics", "chunk_times_zero"] {
        assert_eq!(cut(name, &["--from", "2", "--to", "5"]), 30, "{name}");
        let input = corpus.join(format!("hard/mcap/{name}.mcap"));
        let info = parsed(ok(&["info", text(&input), "--format", "json"]).as_bytes());
        assert_eq!(info["warnings"].as_array().map(Vec::len), Some(1), "{name}");
    }
    assert_eq!(
        cut("three_within_two_ns", &["--from", "1709146829659264520"]),
        4
    );
    let nowhere = corpus.join("hard/mcap/channel_defined_nowhere.mcap");
    assert_eq!(inhand(&["info", text(&nowhere)]).status.code(), Some(3));
}

#[test]
fn stamps_count_where_log_times_step_back() {
    let Some(corpus) = corpus() else { return };
    let input = corpus.join("hard/mcap/recorder_clock_set_back_1h.mcap");
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.mcap");
    ok(&["convert", text(&input), "-o", text(&output)]);
    let take = inhand_channels::read_take(&std::fs::read(&output).unwrap(), "out.mcap").unwrap();
    let recording = take.recording;
    assert_eq!(recording.len(), 1000);
    let markers = recording
        .markers
        .iter()
        .map(|m| m.track.iter().flatten().count());
    let bodies = recording
        .bodies
        .iter()
        .map(|b| b.track.iter().flatten().count());
    for present in markers.chain(bodies) {
        assert_eq!(present, 1000);
    }
}
