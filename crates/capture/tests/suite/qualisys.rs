//! Qualisys TSV.

use inhand_capture::{Blocks, Extent, ReadSettings};
use inhand_model::{LengthUnit, Recording, StartTime, Status, UpAxis};

use super::text::findings;

const TSV: &str = "NO_OF_FRAMES\t3\r\n\
    NO_OF_CAMERAS\t7\r\n\
    NO_OF_MARKERS\t2\r\n\
    FREQUENCY\t100\r\n\
    DESCRIPTION\t--\r\n\
    TIME_STAMP\t2023-11-28, 10:27:58.765\t1483034.68525310\r\n\
    DATA_INCLUDED\t3D\r\n\
    MARKER_NAMES\tthumb_tip\tindex_tip\r\n\
    TRAJECTORY_TYPES\tMeasured\tMixed\r\n\
    Frame\tTime\tthumb_tip X\tthumb_tip Y\tthumb_tip Z\tindex_tip X\tindex_tip Y\tindex_tip Z\t\r\n\
    1\t0.00000\t1000\t2000\t-3\t4\t5\t6\r\n\
    2\t0.01000\tnan\tnan\tnan\t0.000\t0.000\t0.000\r\n\
    3\t0.02000\t\t\t\t4\t5\t0.000\r\n";

fn read(text: &str) -> Result<Recording, String> {
    inhand_capture::read(text.as_bytes(), "take 1.tsv", &ReadSettings::default())
        .map_err(|e| e.to_string())
}

#[test]
fn everything_in_a_file() {
    let recording = read(TSV).unwrap();
    assert_eq!((recording.name.as_str(), recording.len()), ("take 1", 3));
    assert_eq!(
        recording.clock.start_unix_nanos(),
        1_701_167_278_765_000_000
    );
    assert_eq!(recording.clock.start_time(), StartTime::AssumedUtc);
    assert_eq!(recording.source.format, "Qualisys TSV");
    assert_eq!(recording.source.length_unit, LengthUnit::Millimetres);
    assert_eq!(recording.source.up_axis, UpAxis::Z);
    assert_eq!(recording.source.rotation, None);
    assert_eq!(recording.source.header["NO_OF_CAMERAS"], "7");
    let [thumb, index] = &recording.markers[..] else {
        panic!("two markers");
    };
    assert_eq!(thumb.track.get(0).unwrap().to_array(), [1.0, 2.0, -0.003]);
    assert_eq!(
        thumb.track.statuses()[1..],
        [Status::Missing; 2],
        "nan and blank cells"
    );
    assert_eq!(
        index.track.statuses(),
        [Status::Measured, Status::Missing, Status::Measured],
        "three zeros, but not one"
    );
    assert_eq!(
        findings(&recording),
        [
            "TRAJECTORY_TYPES: the capture software filled samples of index_tip; the file does \
             not say which, so they count as measured",
            "marker \"index_tip\": it is exactly at the origin in 1 rows, first on line 12: \
             taken as missing",
        ]
    );
}

#[test]
fn frame_time_and_column_names_are_optional() {
    let expected = read(TSV).unwrap();
    let lines: Vec<&str> = TSV.split_inclusive("\r\n").collect();
    let header = lines[..9].concat();
    let bare = |line: &str| line.splitn(3, '\t').last().unwrap().to_owned();
    let rows: String = lines[10..].iter().copied().map(bare).collect();
    for (what, text) in [
        ("no column names", header.clone() + &lines[10..].concat()),
        (
            "no frame and time",
            header.clone() + &bare(lines[9]) + &rows,
        ),
        ("neither", header.clone() + &rows),
        ("line feeds", TSV.replace("\r\n", "\n")),
        (
            "tab at the end of a row",
            TSV.replace("\t6\r\n", "\t6\t\r\n"),
        ),
    ] {
        let recording = read(&text).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_eq!(recording.len(), 3, "{what}");
        for (marker, expected) in recording.markers.iter().zip(&expected.markers) {
            assert_eq!(marker.name, expected.name, "{what}");
            assert_eq!(marker.track.gaps(), expected.track.gaps(), "{what}");
            assert_eq!(marker.track.get(0), expected.track.get(0), "{what}");
        }
    }
}

#[test]
fn what_is_refused() {
    for (what, text, expected) in [
        (
            "other data",
            TSV.replace("INCLUDED\t3D", "INCLUDED\t6D"),
            "a Qualisys TSV of 6D data is not read yet: export the 3D data",
        ),
        (
            "external clock",
            TSV.replace("FREQUENCY\t100", "FREQUENCY\tEXT"),
            "\"FREQUENCY\" is \"EXT\"",
        ),
        (
            "axis lost",
            TSV.replace("index_tip Y\t", ""),
            "line 10: expected the X, Y and Z of a marker from column 6 on",
        ),
        (
            "no number",
            TSV.replace("\t5\t6", "\t5;5\t6"),
            "line 11, column 7 (\"index_tip\" Y): expected a number, found \"5;5\"",
        ),
        (
            "cut row",
            TSV.replace("\t5\t6", "\t5"),
            "line 11: expected 8 cells, found 7",
        ),
        ("cut header", TSV[..100].to_owned(), "take 1.tsv"),
        (
            "cut within the first line",
            "NO_OF_FRAMES".to_owned(),
            "take 1.tsv, line 1: \"FREQUENCY\" is missing: expected a rate in Hz",
        ),
        (
            "one line",
            "NO_OF_FRAMES\t3\r\n".to_owned(),
            "take 1.tsv, line 1: \"FREQUENCY\" is missing: expected a rate in Hz",
        ),
        (
            "neither names nor column names",
            TSV.replace("MARKER_NAMES", "OTHER")
                .replace("Frame\tTime\tthumb_tip X", "1\t0\t2"),
            "expected MARKER_NAMES",
        ),
    ] {
        let found = read(&text).expect_err(what);
        assert!(found.contains(expected), "{what}: {found}");
    }
    let metres = ReadSettings {
        length_unit: Some(LengthUnit::Metres),
        ..ReadSettings::default()
    };
    let error = inhand_capture::read(TSV.as_bytes(), "take.tsv", &metres).unwrap_err();
    assert!(error.to_string().contains("states millimetres"));
}

#[test]
fn a_wrong_count_is_a_finding() {
    let recording = read(
        &TSV.replace("FRAMES\t3", "FRAMES\t4")
            .replace("MARKERS\t2", "MARKERS\t5"),
    )
    .unwrap();
    let findings = findings(&recording);
    assert!(
        findings
            .iter()
            .any(|f| f.contains("promises 4 rows, found 3")),
        "{findings:?}"
    );
    assert!(
        findings.iter().any(|f| f.contains("promises 5 markers")),
        "{findings:?}"
    );
}

/// Labels and times after the start of the take, seconds.
fn events(recording: &Recording) -> Vec<(String, f64)> {
    let start = recording.clock.start_unix_nanos();
    let events = recording.annotations.events.iter();
    events
        .map(|event| {
            assert_eq!(event.start_unix_nanos, event.end_unix_nanos);
            let after = (event.start_unix_nanos - start) as f64 / 1e9;
            (event.labels["label"].clone(), after)
        })
        .collect()
}

/// The file with lines of events.
fn with_events(lines: &str) -> String {
    TSV.replace("MARKER_NAMES", &format!("{lines}MARKER_NAMES"))
}

#[test]
fn events_are_at_their_times() {
    let text = with_events("EVENT\tgrasp\t2\t0.01000\r\nEVENT\tslip\t3\r\nEVENT\t\t3\t0.02\r\n");
    let recording = read(&text).unwrap();
    let expected = [("grasp", 0.01), ("slip", 0.02), ("event", 0.02)];
    let expected = expected.map(|(name, time_s)| (name.to_owned(), time_s));
    assert_eq!(events(&recording), expected);
    assert_eq!(findings(&recording).len(), 2, "as without events");
    // Blocks say the same before the first sample.
    let mut extent = Extent::default();
    extent.add(text.as_bytes());
    let settings = ReadSettings::default();
    let blocks = Blocks::open(text.as_bytes(), extent, "take 1.tsv", &settings).unwrap();
    assert_eq!(blocks.header().annotations, recording.annotations);

    let odd = read(&with_events(
        "EVENT\tgrasp\tsoon\tlater\r\nEVENT\tx\t2\t-1\r\n",
    ))
    .unwrap();
    assert_eq!(events(&odd), []);
    let found = findings(&odd).join("\n");
    assert!(
        found.contains("EVENT: expected a name, a frame and a time"),
        "{found}"
    );
    assert!(
        found.contains("found \"grasp soon later\": left out"),
        "{found}"
    );
}

#[test]
fn a_range_starts_later_than_its_capture() {
    let text = with_events("EVENT\tbefore\t5\t0.04\r\nEVENT\tgrasp\t12\t0.11\r\n")
        .replace("\n1\t0.00000", "\n11\t0.10000")
        .replace("\n2\t0.01000", "\n12\t0.11000")
        .replace("\n3\t0.02000", "\n13\t0.12000");
    // Without a frame column the time column says so.
    let times_alone = text
        .replace("Frame\tTime", "Time")
        .replace("\n11\t", "\n")
        .replace("\n12\t", "\n")
        .replace("\n13\t", "\n");
    for (text, first) in [(text, "number 11"), (times_alone, "at 0.100 s")] {
        let recording = read(&text).unwrap();
        let start = recording.clock.start_unix_nanos();
        assert_eq!(start, 1_701_167_278_865_000_000, "{first}");
        assert_eq!(events(&recording), [("grasp".to_owned(), 0.01)], "{first}");
        assert_eq!(recording.len(), 3);
        let found = findings(&recording).join("\n");
        let words =
            format!("the first frame is {first} of its trial: the take starts 0.100 s after");
        assert!(found.contains(&words), "{found}");
        assert!(
            found.contains("event before at 0.040 s is before the first frame"),
            "{found}"
        );
    }
}

#[test]
fn spreadsheets_fill_up_rows_and_quote_texts() {
    let plain = with_events("EVENT\tgrasp\t2\t0.01\r\n");
    let expected = read(&plain).unwrap();
    let padded = plain.replace("\r\n", "\t\t\t\r\n");
    let quoted = padded.replace("2023-11-28, 10:27:58.765", "\"2023-11-28, 10:27:58.765\"");
    let bare = |line: &str| line.splitn(3, '\t').last().unwrap().to_owned();
    let lines: Vec<&str> = padded.split_inclusive("\r\n").collect();
    for (what, text) in [
        ("quotes", quoted.clone()),
        ("byte-order mark", format!("\u{feff}{quoted}")),
        (
            "decimal commas",
            quoted.replace("0.01", "0,01").replace("0.000", "0,000"),
        ),
        (
            "no column names",
            [&lines[..10], &lines[11..]].concat().concat(),
        ),
        (
            "neither names nor frames",
            lines[..10].concat()
                + &lines[11..]
                    .iter()
                    .map(|line| bare(line))
                    .collect::<String>(),
        ),
    ] {
        let recording = read(&text).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_eq!(recording.len(), 3, "{what}");
        assert_eq!(findings(&recording).len(), 2, "{what}: as before");
        assert_eq!(recording.clock, expected.clock, "{what}");
        assert_eq!(recording.annotations, expected.annotations, "{what}");
        assert_eq!(recording.markers.len(), 2, "{what}");
        for (marker, expected) in recording.markers.iter().zip(&expected.markers) {
            assert_eq!(marker.name, expected.name, "{what}");
            assert!(marker.track.iter().eq(expected.track.iter()), "{what}");
        }
    }
}
