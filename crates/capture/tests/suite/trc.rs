//! TRC.

use inhand_capture::ReadSettings;
use inhand_model::{LengthUnit, MarkerKind, Position, Recording, StartTime, Status, UpAxis};
use proptest::prelude::*;

use super::text::findings;

const TRC: &str = "PathFileType\t4\t(X/Y/Z)\tC:\\takes\\one.trc\r\n\
    DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\t\
    OrigDataRate\tOrigDataStartFrame\tOrigNumFrames\r\n\
    120.00\t240.00\t3\t2\tmm\t120.00\t1\t3\r\n\
    Frame#\tTime\tThumb\t\t\tUnlabeled 7\t\t\r\n\
    \t\tX1\tY1\tZ1\tX2\tY2\tZ2\r\n\
    \r\n\
    1\t0.00000\t1000\t2000\t-3\t4\t5\t6\r\n\
    2\t0.00833\t\t\t\t0.0\t0.0\t0.0\r\n\
    3\t0.01667\t110.763\t 8 \t9\t4\t\t6\t\r\n";

const NO_START: &str = "the file states no start time: the take starts at 1970-01-01";
const UP_ASSUMED: &str =
    "TRC does not say which axis points up: y is assumed; set `source.up` to y or z";

fn read_with(text: &str, settings: &ReadSettings) -> Result<Recording, String> {
    inhand_capture::read(text.as_bytes(), "dir/take 1.trc", settings).map_err(|e| e.to_string())
}

fn read(text: &str) -> Result<Recording, String> {
    read_with(text, &ReadSettings::default())
}

fn assert_same_tracks(found: &Recording, expected: &Recording, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    assert_eq!(found.markers.len(), expected.markers.len(), "{what}");
    for (a, b) in found.markers.iter().zip(&expected.markers) {
        assert_eq!(a.name, b.name, "{what}");
        assert!(a.track.iter().eq(b.track.iter()), "{what}: {}", a.name);
    }
}

#[test]
fn everything_in_a_file() {
    let recording = read(TRC).unwrap();
    assert_eq!((recording.name.as_str(), recording.len()), ("take 1", 3));
    assert_eq!(recording.clock.rate_hz(), 120.0);
    assert_eq!(recording.clock.start_time(), StartTime::Unknown);
    assert_eq!(recording.source.format, "TRC");
    assert_eq!(recording.source.length_unit, LengthUnit::Millimetres);
    assert_eq!(recording.source.up_axis, UpAxis::Y);
    assert_eq!(recording.source.rotation, None);
    assert_eq!(recording.source.header["CameraRate"], "240.00");
    assert_eq!(
        recording.source.header["PathFileType"],
        "4 (X/Y/Z) C:\\takes\\one.trc"
    );
    assert!(recording.bodies.is_empty());
    let [thumb, other] = &recording.markers[..] else {
        panic!("two markers");
    };
    assert_eq!((&*thumb.name, thumb.kind), ("Thumb", MarkerKind::Labelled));
    assert_eq!(other.kind, MarkerKind::Unlabelled);
    assert_eq!(thumb.track.get(0).unwrap().to_array(), [1.0, 2.0, -0.003]);
    assert_eq!(
        thumb.track.get(2).unwrap().to_array(),
        [0.110763, 0.008, 0.009]
    );
    assert_eq!(
        thumb.track.statuses(),
        [Status::Measured, Status::Missing, Status::Measured]
    );
    assert_eq!(
        other.track.statuses(),
        [Status::Measured, Status::Missing, Status::Missing]
    );
    // Five decimals of a second do not disagree with 120 Hz.
    assert_eq!(
        findings(&recording),
        [
            NO_START,
            UP_ASSUMED,
            "marker \"Unlabeled 7\": some of its cells are blank in 1 rows, first on line 9: \
             taken as missing",
            "marker \"Unlabeled 7\": it is exactly at the origin in 1 rows, first on line 8: \
             taken as missing",
        ]
    );
}

#[test]
fn what_programs_write_differently() {
    let expected = read(TRC).unwrap();
    let with_timestamp: String = TRC
        .replace("Time\t", "Time\tTimestamp\t")
        .replace("\t\tX1", "\t\t\tX1")
        .replace("0.00000\t", "0.00000\t12:00\t")
        .replace("0.00833\t", "0.00833\t\t")
        .replace("0.01667\t", "0.01667\tx\t");
    for (what, text) in [
        ("no blank line", TRC.replace("\r\n\r\n", "\r\n")),
        (
            "a blank line of tabs",
            TRC.replace("\r\n\r\n", "\r\n\t\t\t\r\n"),
        ),
        ("line feeds", TRC.replace("\r\n", "\n")),
        ("a byte-order mark", format!("\u{feff}{TRC}")),
        (
            "names without blank cells",
            TRC.replace("Thumb\t\t\t", "Thumb\t"),
        ),
        (
            "tabs at the ends",
            TRC.replace("Z2\r", "Z2\t\r").replace("7\t\t", "7\t\t\t\t"),
        ),
        (
            "labels in another case",
            TRC.replace("Frame#", "frame")
                .replace("X1\tY1\tZ1", "x1\ty1\tz1"),
        ),
        ("another column before the markers", with_timestamp),
        (
            "nan",
            TRC.replace("0.00833\t\t\t\t", "0.00833\tnan\tNaN\t-nan\t"),
        ),
        (
            "spaces in the first line",
            TRC.replacen("Type\t4\t(X/Y/Z)\t", "Type  4  (X/Y/Z) ", 1),
        ),
        ("type 3", TRC.replace("Type\t4", "Type\t3")),
        ("two carriage returns", TRC.replace("Z2\r", "Z2\r\r")),
        (
            "keys in another order",
            TRC.replace("DataRate\tCameraRate", "CameraRate\tDataRate")
                .replace("120.00\t240.00", "240.00\t120.00"),
        ),
    ] {
        assert_ne!(text, TRC, "{what}");
        let recording = read(&text).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_same_tracks(&recording, &expected, what);
        assert_eq!(
            findings(&recording).len(),
            4,
            "{what}: {:?}",
            findings(&recording)
        );
    }
}

#[test]
fn a_row_that_ends_behind_its_time_has_no_marker() {
    let text = TRC.replace("0.00000\t1000\t2000\t-3\t4\t5\t6", "0.00000");
    let recording = read(&text).unwrap();
    assert_eq!(recording.len(), 3);
    for (marker, expected) in recording.markers.iter().zip(read(TRC).unwrap().markers) {
        assert_eq!(marker.track.get(0), None);
        assert_eq!(marker.track.get(2), expected.track.get(2));
    }
    // With fewer cells, or some but not all, it is cut.
    for (cut, found) in [("1\r", 1), ("1\t0.00000\t1000\r", 3)] {
        let text = text.replace("1\t0.00000\r", cut);
        let error = read(&text).unwrap_err();
        let expected = format!("line 7: expected 8 cells, found {found}: the row is cut off");
        assert!(error.contains(&expected), "{error}");
    }
}

#[test]
fn units() {
    for (unit, expected, metres) in [
        ("m", LengthUnit::Metres, 1000.0),
        ("cm", LengthUnit::Centimetres, 10.0),
        ("mm", LengthUnit::Millimetres, 1.0),
        ("in", LengthUnit::Inches, 25.4),
        ("ft", LengthUnit::Feet, 304.8),
        ("Meters", LengthUnit::Metres, 1000.0),
    ] {
        let recording = read(&TRC.replace("\tmm\t", &format!("\t{unit}\t"))).unwrap();
        assert_eq!(recording.source.length_unit, expected, "{unit}");
        let x = recording.markers[0].track.get(0).unwrap().to_array()[0];
        assert!((x - metres).abs() < 1e-12 * metres, "{unit}: {x}");
    }

    let unstated = TRC.replace("\tmm\t", "\t\t");
    assert_eq!(
        read(&unstated).unwrap_err(),
        "dir/take 1.trc: the header has no \"Units\": say it with `source.units` (metres, centimetres, \
         millimetres, inches, feet)"
    );
    let metres = ReadSettings {
        length_unit: Some(LengthUnit::Metres),
        up_axis: Some(UpAxis::Z),
        ..ReadSettings::default()
    };
    let recording = read_with(&unstated, &metres).unwrap();
    assert_eq!(recording.source.length_unit, LengthUnit::Metres);
    assert_eq!(recording.source.up_axis, UpAxis::Z);
    let error = read_with(TRC, &metres).unwrap_err();
    assert!(error.contains("`source.units` says metres, but the file itself states millimetres"));
}

#[test]
fn what_does_not_add_up_is_a_finding() {
    for (what, text, expected) in [
        (
            "frames",
            TRC.replace("\t3\t2\tmm", "\t900\t2\tmm"),
            "NumFrames: the header promises 900 rows, found 3",
        ),
        (
            "markers",
            TRC.replace("\t3\t2\tmm", "\t3\t41\tmm"),
            "NumMarkers: the header promises 41 markers and has columns for 2",
        ),
        (
            "no count",
            TRC.replace("\t3\t2\tmm", "\t3\t-1\tmm"),
            "NumMarkers: expected a count, found \"-1\"",
        ),
        (
            "rate",
            TRC.replace("120.00\t240", "100.00\t240"),
            "line 9: the time column says 0.016670 s where frame and rate (100 Hz) give 0.020000 s",
        ),
        (
            "time",
            TRC.replace("0.00833", "0.00835"),
            "line 8: the time column says 0.008350 s",
        ),
        (
            "jump",
            TRC.replace("3\t0.01667", "5\t0.03333"),
            "line 9: frame 5 follows frame 2",
        ),
        (
            "type",
            TRC.replace("Type\t4", "Type\t5"),
            "PathFileType: expected type 4, found \"5\"",
        ),
    ] {
        assert_ne!(text, TRC, "{what}");
        let recording = read(&text).unwrap_or_else(|e| panic!("{what}: {e}"));
        let findings = findings(&recording);
        assert_eq!(findings.len(), 5, "{what}: {findings:?}");
        assert!(
            findings.iter().any(|f| f.starts_with(expected)),
            "{what}: {findings:?}"
        );
    }
}

#[test]
fn time_columns_are_held_to_their_own_rounding() {
    let take = |decimals: usize, off_s: f64| {
        let rows: String = (0..500)
            .map(|k| {
                let time_s = f64::from(k) / 120.0 + if k == 300 { off_s } else { 0.0 };
                format!("{}\t{time_s:.decimals$}\t1\t2\t3\n", k + 1)
            })
            .collect();
        let text = format!(
            "PathFileType\t4\t(X/Y/Z)\ta\nDataRate\tUnits\n120\tm\n\
             Frame#\tTime\tA\n\t\tX1\tY1\tZ1\n{rows}"
        );
        findings(&read(&text).unwrap()).len() - 2
    };
    for (decimals, rounding_s) in [(3, 1e-3), (4, 1e-4), (5, 1e-5), (6, 1e-6)] {
        assert_eq!(take(decimals, 0.0), 0, "{decimals} decimals");
        assert_eq!(take(decimals, 4.0 * rounding_s), 1, "{decimals} decimals");
    }
}

#[test]
fn what_is_refused() {
    for (what, text, expected) in [
        (
            "other coordinates",
            TRC.replace("(X/Y/Z)", "(X/Z/Y)"),
            "a TRC file with coordinates \"(X/Z/Y)\" (line 1) is not read yet: export \
             it with coordinates (X/Y/Z)",
        ),
        (
            "spaces for tabs",
            TRC.replace('\t', " "),
            "line 2: expected a line of keys with DataRate among them, separated by tabs, found \
             \"DataRate CameraRate NumFrames NumMarkers…\"",
        ),
        (
            "no rate",
            TRC.replace("120.00\t240.00", "\t240.00"),
            "line 3: \"DataRate\" is missing: expected a rate in Hz, such as 100.00",
        ),
        (
            "odd rate",
            TRC.replace("120.00\t240.00", "120;00\t240.00"),
            "line 3: \"DataRate\" is \"120;00\": expected a rate in Hz",
        ),
        (
            "odd unit",
            TRC.replace("\tmm\t", "\tfurlongs\t"),
            "line 3: \"Units\" is \"furlongs\": expected m, cm, mm, in or ft",
        ),
        (
            "no time column",
            TRC.replace("Frame#\tTime\t", "Frame#\tThumb\t"),
            "line 4: expected a row of labels (Frame#, Time, then marker names) with Time in \
             column 2, found \"Thumb\"",
        ),
        (
            "axis lost",
            TRC.replace("\tY2", ""),
            "line 5: expected Y of a marker in column 7, found \"Z2\": the header is cut or \
             edited; export the take again",
        ),
        (
            "axis cut",
            TRC.replace("\tZ2", ""),
            "line 5: expected Z of a marker in column 8, found the end of the line",
        ),
        (
            "no axes",
            TRC.replace("\t\tX1\tY1\tZ1\tX2\tY2\tZ2\r\n\r\n", ""),
            "line 5: expected a row of axes (X1, Y1, Z1, X2, ...) from column 3 on, found \"1\" in \
             column 1",
        ),
        (
            "a name too many",
            TRC.replace("7\t\t", "7\t\t\tIndex"),
            "line 5: expected an X, a Y and a Z below the name \"Index\" of line 4, column 9, \
             found axes of 2 markers, up to column 8",
        ),
        (
            "no number",
            TRC.replace("\t5\t6", "\t5;5\t6"),
            "line 7, column 7 (\"Unlabeled 7\" Y): expected a number, found \"5;5\"",
        ),
        (
            "a cut row",
            TRC.replace("\t5\t6", ""),
            "line 7: expected 8 cells, found 6: the row is cut off",
        ),
        (
            "a row too long",
            TRC.replace("\t5\t6", "\t5\t6\t7"),
            "line 7, column 9: expected no more than the header's 8 columns, found \"7\"",
        ),
        (
            "frames that fall",
            TRC.replace("3\t0.01667", "1\t0.01667"),
            "line 9: frame 1 follows frame 2",
        ),
        (
            "no rows",
            TRC[..TRC.find("1\t0.00000").unwrap()].to_owned(),
            "the header is followed by no samples",
        ),
        (
            "a cut header",
            TRC[..TRC.find("Frame#").unwrap()].to_owned(),
            "line 4: expected a row of labels (Frame#, Time, then marker names), found the end of \
             the file",
        ),
        (
            "a NUL byte",
            TRC.replace("Thumb", "\0"),
            "line 4: expected UTF-8 text, found a NUL byte",
        ),
        (
            "another word",
            TRC.replace("PathFileType", "PathFileTypes"),
            "not a capture file",
        ),
    ] {
        assert_ne!(text, TRC, "{what}");
        let found = read(&text).expect_err(what);
        assert!(found.contains(expected), "{what}: {found}");
    }
    let error = inhand_capture::read(b"Format 1.23", "a.trc", &ReadSettings::default());
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains("TRC (starts with \"PathFileType\") or C3D, found"),
        "{error}"
    );
}

#[test]
fn a_take_without_markers_has_its_rows() {
    let recording = read(
        "PathFileType\t4\t(X/Y/Z)\ta\nDataRate\tNumMarkers\n100\t0\nFrame#\tTime\n\n\n\
         1\t0.00\n2\t0.01\n",
    )
    .unwrap();
    assert_eq!((recording.len(), recording.markers.len()), (2, 0));
    assert_eq!(findings(&recording), [NO_START, UP_ASSUMED]);
}

/// A file in metres, every coordinate in as many digits as it has.
fn write(tracks: &[Vec<Option<[f64; 3]>>], rows: usize) -> String {
    let markers = tracks.len();
    let names: String = (1..=markers).map(|m| format!("M {m}\t\t\t")).collect();
    let axes: String = (1..=markers)
        .map(|m| format!("X{m}\tY{m}\tZ{m}\t"))
        .collect();
    let mut text = format!(
        "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n\
         60\t{rows}\t{markers}\tm\nFrame#\tTime\t{names}\n\t\t{axes}\n\n"
    );
    for row in 0..rows {
        text += &format!("{}\t{:.6}", row + 1, row as f64 / 60.0);
        for track in tracks {
            text += &match track[row] {
                Some([x, y, z]) => format!("\t{x}\t{y:e}\t{z}"),
                None => "\t\t\t".to_owned(),
            };
        }
        text += "\n";
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn what_is_written_reads_back(
        (rows, tracks) in (1_usize..20, 1_usize..6).prop_flat_map(|(rows, markers)| {
            let point = prop::option::weighted(0.7, [1e-9..3.0, -3.0..3.0, -1e-3..1e-3]);
            (Just(rows), prop::collection::vec(prop::collection::vec(point, rows), markers))
        }),
    ) {
        let recording = read(&write(&tracks, rows)).unwrap();
        prop_assert_eq!(recording.len(), rows);
        prop_assert_eq!(findings(&recording), [NO_START, UP_ASSUMED]);
        prop_assert_eq!(recording.markers.len(), tracks.len());
        for (m, (marker, track)) in recording.markers.iter().zip(&tracks).enumerate() {
            prop_assert_eq!(&marker.name, &format!("M {}", m + 1));
            let found: Vec<_> = marker.track.iter().map(|p| p.map(Position::to_array)).collect();
            prop_assert_eq!(&found, track);
        }
    }
}

#[test]
fn a_first_frame_beyond_one_is_told() {
    let starting_at = |first: i64, time_s: f64| {
        let rows: String = (0..3)
            .map(|k| format!("{}\t{:.3}\t1\t2\t3\n", first + k, time_s + k as f64 / 60.0))
            .collect();
        let text = format!(
            "PathFileType\t4\t(X/Y/Z)\ta\nDataRate\tUnits\n60\tm\n\
             Frame#\tTime\tA\n\t\tX1\tY1\tZ1\n{rows}"
        );
        let recording = read(&text).unwrap();
        assert_eq!(
            (recording.len(), recording.clock.start_unix_nanos()),
            (3, 0)
        );
        findings(&recording)[2..].join("\n")
    };
    for (first, time_s) in [
        (185, 184.0 / 60.0),
        (185, 185.0 / 60.0),
        (185, 0.0),
        (-5, -0.1),
    ] {
        let words = format!("the first frame is number {first} of its trial: it is at 0 s here");
        assert_eq!(starting_at(first, time_s), words);
    }
    assert_eq!(starting_at(1, 0.0), "");
    assert_eq!(starting_at(0, 0.0), "");
    assert_eq!(starting_at(1, 1.0 / 60.0), "");
    // Numbers that start anew, or that count another rate.
    for first in [1, 185] {
        let words = "the first frame is at 5.000 s of its trial: it is at 0 s here";
        assert_eq!(starting_at(first, 5.0), words);
    }
}

#[test]
fn what_spreadsheets_and_other_countries_write() {
    let expected = read(TRC).unwrap();
    let spread = TRC
        .replace("\r\n", "\t\t\r\n")
        .replace("C:\\takes\\one.trc", "\"one, two.trc\"");
    let commas = spread
        .replace("120.00", "120,00")
        .replace("110.763", "110,763")
        .replace("\t0.0", "\t0,0");
    for (what, text) in [("tabs and quotes", spread), ("decimal commas", commas)] {
        let recording = read(&text).unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_same_tracks(&recording, &expected, what);
        assert_eq!(recording.clock, expected.clock, "{what}");
        assert_eq!(findings(&recording), findings(&expected), "{what}");
    }
    let nameless = read(&TRC.replace("Unlabeled 7", "")).unwrap();
    assert_eq!(nameless.markers[1].name, "2");
    assert_eq!(nameless.markers[1].kind, MarkerKind::Unlabelled);
}
