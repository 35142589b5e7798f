//! Motive CSV: what its cells mean, its variants over the versions, and what is refused.

use inhand_capture::ReadSettings;
use inhand_model::{
    BodyKind, LengthUnit, MarkerKind, RotationOrder, Severity, StartTime, Status, UpAxis,
};
use nalgebra::Vector3;

use super::text::{Motive, body, euler_body, findings, marker, marker_of, quality, ring};

/// 2023-11-28 10:27:58.765 UTC, from `date -u -d '2023-11-28 10:27:58.765' +%s%N`.
const START_NANOS: u64 = 1_701_167_278_765_000_000;

#[test]
fn a_take_in_millimetres_with_everything() {
    let columns = [
        body("Hand"),
        quality("Rigid Body", "Hand", "B0", "Mean Marker Error"),
        marker_of("Rigid Body Marker", "Hand:Marker1", "B0"),
        quality("Rigid Body Marker", "Hand:Marker1", "B0", "Marker Quality"),
        marker("Hand:Marker1"),
        marker_of("Marker", "Unlabeled 1036", "U1"),
        marker_of("Marker", "Unlabeled:108", "U2"),
    ]
    .concat();
    let recording = Motive::new(
        columns,
        &[
            "0,0.000,0,0,0.6,0.8,1000,0,-1,0.25,10,20,30,0.9,11,21,31,1,2,3,,,",
            "1,0.010,0,0,-0.6,-0.8,1001,0,-1,,,,,,,,,1,2,3,,,",
        ],
    )
    .with("Length Units", "Millimeters")
    .read()
    .unwrap();

    assert_eq!(recording.name, "take");
    assert_eq!(recording.len(), 2);
    assert_eq!(recording.clock.start_unix_nanos(), START_NANOS);
    assert_eq!(recording.clock.start_time(), StartTime::AssumedUtc);
    assert_eq!(recording.clock.rate_hz(), 100.0);
    let source = &recording.source;
    assert_eq!(source.format, "Motive CSV 1.23");
    assert_eq!(source.length_unit, LengthUnit::Millimetres);
    assert_eq!(source.up_axis, UpAxis::Y);
    assert_eq!(source.rotation, Some(RotationOrder::Quaternion));
    assert_eq!(source.header["Coordinate Space"], "Global");
    assert_eq!(source.header["Take Notes"], "");

    let hand = &recording.bodies[0];
    assert_eq!(
        (hand.name.as_str(), hand.kind),
        ("Hand", BodyKind::RigidBody)
    );
    let pose = hand.track.get(0).unwrap();
    assert_eq!(pose.origin().to_array(), [1.0, 0.0, -0.001]);
    assert_eq!(pose.quaternion_xyzw(), [0.0, 0.0, 0.6, 0.8]);
    // A turn about z with sine 0.96 and cosine 0.28 takes the body's x there.
    let x = pose.isometry() * Vector3::x();
    assert!((x - Vector3::new(0.28, 0.96, 0.0)).norm() < 1e-15);
    // The other sign is the same rotation and stays as written.
    let flipped = hand.track.get(1).unwrap();
    assert_eq!(flipped.quaternion_xyzw(), [0.0, 0.0, -0.6, -0.8]);
    let error_m = hand.marker_error_m.as_ref().unwrap();
    assert_eq!(error_m[0], 0.00025);
    assert!(error_m[1].is_nan());

    let kinds: Vec<_> = recording.markers.iter().map(|m| m.kind).collect();
    assert_eq!(
        kinds,
        [
            MarkerKind::RigidBodyMarker,
            MarkerKind::Labelled,
            MarkerKind::Unlabelled,
            MarkerKind::Unlabelled
        ]
    );
    let [fitted, seen, _, absent] = &recording.markers[..] else {
        panic!("four markers");
    };
    assert_eq!(fitted.track.get(0).unwrap().to_array(), [0.01, 0.02, 0.03]);
    assert_eq!(fitted.quality.as_ref().unwrap()[0], 0.9);
    assert_eq!(seen.track.statuses(), [Status::Measured, Status::Missing]);
    assert!(seen.quality.is_none());
    // Blank from start to end, and still there.
    assert_eq!(absent.track.counts().missing, 2);
    assert_eq!(recording.marker("Hand:Marker1").unwrap().id, "M0");
    assert_eq!(findings(&recording), Vec::<String>::new());
}

#[test]
fn variants_of_the_header_read_alike() {
    let plain = Motive::new(
        [body("Hand"), marker("Ring")].concat(),
        &[
            "0,0.000000,0,0,0,1,1,2,3,4,5,6",
            "1,0.010000,0,0,0,1,1,2,3,,,",
        ],
    );
    let expected = plain.read().unwrap();
    let text = plain.text();

    let mut unlabelled = plain.clone();
    unlabelled.labelled = false;
    let mut quoted = plain.clone();
    for column in &mut quoted.columns[7..] {
        column[1] = format!("\"{}\"", column[1]);
        column[2] = format!("\"{}\"", column[2]);
        column[4] = column[4].to_lowercase();
    }
    let variants = [
        ("unlabelled rows, as 1.21", unlabelled.text()),
        ("quotes, small axis letters", quoted.text()),
        ("line feeds", text.replace("\r\n", "\n")),
        ("byte-order mark", format!("\u{feff}{text}")),
        ("1.21 time label", text.replace("Time (Seconds)", "Time")),
        (
            "trailing commas of a spreadsheet",
            text.replace("\r\n", ",,,,\r\n"),
        ),
        (
            "semicolons and decimal commas",
            text.replace(',', ";")
                .replace("0.0", "0,0")
                .replace("100.", "100,"),
        ),
        ("no end of the last line", text.trim_end().to_owned()),
        (
            "parents, as 1.25",
            text.replace(",,Rotation", ",Parent,Root,Root\r\n,,Rotation"),
        ),
        (
            "lines of nothing at the end",
            format!("{text}\r\n,,,,,\r\n"),
        ),
        ("spaces", text.replace("0.000000,0,", "0.000000, 0 ,")),
    ];
    for (what, variant) in variants {
        assert_ne!(variant, text, "{what}");
        let read = inhand_capture::read(variant.as_bytes(), "take.csv", &ReadSettings::default())
            .unwrap_or_else(|e| panic!("{what}: {e}"));
        assert_eq!(
            read.bodies[0].track.get(1),
            expected.bodies[0].track.get(1),
            "{what}"
        );
        assert_eq!(
            read.markers[0].track.get(0),
            expected.markers[0].track.get(0),
            "{what}"
        );
        assert_eq!(read.markers[0].track.get(1), None, "{what}");
        assert_eq!(read.markers[0].id, "M0", "{what}");
        assert_eq!(read.clock, expected.clock, "{what}");
        assert_eq!(findings(&read), Vec::<String>::new(), "{what}");
    }
}

#[test]
fn columns_in_any_order_and_a_time_code() {
    let mut columns = [marker_of("Marker", "A", "1"), marker_of("Marker", "A", "2")].concat();
    columns.swap(1, 3);
    columns.insert(0, ["", "", "", "", "TimeCode"].map(str::to_owned));
    let recording = Motive::new(columns, &["0,0.0,15:26:46:12.02,1,4,3,2,5,6"])
        .read()
        .unwrap();
    let at = |m: usize| recording.markers[m].track.get(0).unwrap().to_array();
    assert_eq!((at(0), at(1)), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]));
    assert_eq!(
        findings(&recording),
        [
            "column 3: columns 3 (TimeCode) are neither position, rotation nor quality of a marker \
          or body: not read"
        ]
    );
    assert_eq!(recording.findings[0].severity, Severity::Info);
    // The size of a marker is described by the manual, anything else may matter.
    let sized = [
        marker("A"),
        quality("Marker", "A", "M0", "Size"),
        quality("Marker", "A", "M0", "Colour"),
    ];
    let sized = Motive::new(sized.concat(), &["0,0.0,1,2,3,14.0,7"])
        .read()
        .unwrap();
    let severities: Vec<_> = sized
        .findings
        .iter()
        .map(|f| (f.severity, f.place.as_str()))
        .collect();
    assert_eq!(
        severities,
        [
            (Severity::Warning, "column 7"),
            (Severity::Info, "column 6")
        ]
    );
    // Two entities that share everything.
    let twins = Motive::new([marker("A"), marker("A")].concat(), &["0,0.0,1,2,3,4,5,6"]);
    assert_eq!(twins.read().unwrap().markers.len(), 2);
}

#[test]
fn a_take_without_any_entity() {
    let empty = Motive::new(Vec::new(), &["0,0.000", "1,0.010", "2,0.020"]);
    for empty in [empty.clone(), empty.without("Length Units")] {
        let recording = empty.read().unwrap();
        assert_eq!(
            (
                recording.len(),
                recording.markers.len(),
                recording.bodies.len()
            ),
            (3, 0, 0)
        );
        assert_eq!(recording.source.rotation, None);
    }
}

#[test]
fn bones_in_local_space_are_a_finding() {
    let mut columns = body("Skeleton:Hip");
    for column in &mut columns {
        column[0] = "Bone".to_owned();
    }
    let bones = Motive::new(columns, &["0,0.0,0,0,0,1,0,0,0"]);
    let recording = bones.clone().read().unwrap();
    assert_eq!(recording.bodies[0].kind, BodyKind::Bone);
    assert!(recording.findings.is_empty());
    let local = bones.with("Coordinate Space", "Local").read().unwrap();
    assert!(findings(&local)[0].contains("relative to their parent bone"));
}

#[test]
fn euler_angles_agree_with_scipy() {
    let reference = include_str!("../reference/euler.csv");
    assert_eq!(reference.lines().count(), 36);
    for line in reference.lines() {
        let cells: Vec<&str> = line.split(',').collect();
        let row = format!("0,0.0,{},{},{},0,0,0", cells[1], cells[2], cells[3]);
        let recording = Motive::new(euler_body("Hand"), &[&row])
            .with("Rotation Type", cells[0])
            .read()
            .unwrap();
        let expected: Vec<f64> = cells[4..]
            .iter()
            .map(|cell| cell.parse().unwrap())
            .collect();
        let found = recording.bodies[0].track.get(0).unwrap().quaternion_xyzw();
        // The same rotation whatever the sign: the product of both is 1 or -1.
        let cosine: f64 = expected.iter().zip(found).map(|(a, b)| a * b).sum();
        assert!((cosine.abs() - 1.0).abs() < 1e-14, "{line}: {found:?}");
    }
}

#[test]
fn euler_columns_go_by_their_labels() {
    let order = Some(RotationOrder::Euler([2, 1, 0]));
    let mut columns = euler_body("Hand");
    columns.swap(0, 2);
    let swapped = Motive::new(columns, &["0,0.0,90,0,0,0,0,0"]).with("Rotation Type", "ZYX");
    let recording = swapped.read().unwrap();
    assert_eq!(recording.source.rotation, order);
    let x = recording.bodies[0].track.get(0).unwrap().isometry() * Vector3::x();
    assert!((x - Vector3::y()).norm() < 1e-15, "a quarter turn about z");
    // The order may come from the user where the file is silent.
    let settings = ReadSettings {
        rotation_order: order,
        ..ReadSettings::default()
    };
    let told = swapped.without("Rotation Type").read_with(&settings);
    assert_eq!(
        told.unwrap().bodies[0].track.get(0),
        recording.bodies[0].track.get(0)
    );
}

#[test]
fn what_is_missing() {
    let columns = [body("Hand"), marker("Ring")].concat();
    let recording = Motive::new(
        columns,
        &[
            "0,0.00,0,0,0,1,1,2,3,4,5,6",
            "1,0.01,,,,,,,,NaN,nan,NAN",
            "2,0.02,0,0,0,1,1,2,,4,,6",
            "3,0.03,0,0,0,0,1,2,3,4,5,6",
            "4,0.04,0,0,0,1.001,1,2,3,4,5,6",
        ],
    )
    .read()
    .unwrap();
    use Status::{Measured, Missing};
    assert_eq!(
        recording.bodies[0].track.statuses(),
        [Measured, Missing, Missing, Missing, Measured]
    );
    assert_eq!(
        recording.bodies[0].track.get(4).unwrap().quaternion_xyzw(),
        [0.0, 0.0, 0.0, 1.0],
        "brought to unit length"
    );
    assert_eq!(
        recording.markers[0].track.statuses(),
        [Measured, Missing, Missing, Measured, Measured]
    );
    assert_eq!(
        findings(&recording),
        [
            "body \"Hand\": some of its cells are blank in 1 rows, first on line 10: taken as \
             missing",
            "body \"Hand\": its quaternion is not of unit length in 1 rows, first on line 11: \
             taken as missing",
            "marker \"Ring\": some of its cells are blank in 1 rows, first on line 10: taken as \
             missing",
        ]
    );
}

#[test]
fn jumps_of_the_frame_column_are_missing_samples() {
    let columns = [
        marker("Ring"),
        quality("Marker", "Ring", "M0", "Marker Quality"),
        body("Hand"),
    ]
    .concat();
    let recording = Motive::new(
        columns,
        &[
            "40,0.40,1,0,0,0.5,0,0,0,1,1,0,0",
            "43,0.43,2,0,0,0.6,0,0,0,1,2,0,0",
            "44,0.44,3,0,0,0.7,0,0,0,1,3,0,0",
            "46,0.46,4,0,0,0.8,0,0,0,1,4,0,0",
        ],
    )
    .with("Total Exported Frames", "9")
    .read()
    .unwrap();
    assert_eq!(recording.len(), 7);
    let ring = &recording.markers[0];
    assert_eq!(ring.track.gaps(), [1..3, 5..6]);
    assert_eq!(ring.track.get(6).unwrap().to_array()[0], 4.0);
    let quality = ring.quality.as_ref().unwrap();
    assert!(quality[1].is_nan() && quality[3] == 0.6);
    assert_eq!(recording.bodies[0].track.gaps(), [1..3, 5..6]);
    // The capture started 40 frames before.
    assert_eq!(recording.clock.unix_nanos(0), START_NANOS + 400_000_000);
    assert_eq!(
        findings(&recording),
        [
            "the first frame is number 40 of its trial: the take starts 0.400 s after its trial",
            "Total Exported Frames: the header promises 9 rows, found 4: read what is there; the \
             file was cut or edited after the export",
            "line 9: frame 43 follows frame 40; in all the frame column jumps 2 times and leaves \
             out 3 frames: taken as missing samples",
        ]
    );
}

#[test]
fn a_range_starts_later_than_its_capture() {
    for (first, start_nanos) in [
        (0, START_NANOS),
        (1, START_NANOS + 10_000_000),
        (1000, START_NANOS + 10_000_000_000),
        (-50, START_NANOS - 500_000_000),
    ] {
        let rows =
            [first, first + 1].map(|k: i32| format!("{k},{:.6},1,2,3", f64::from(k) / 100.0));
        let take = ring(&[&rows[0], &rows[1]]).with("Capture Start Frame", "78593");
        let recording = take.read().unwrap();
        assert_eq!(recording.clock.start_unix_nanos(), start_nanos, "{first}");
        assert_eq!((recording.len(), recording.clock.time_s(1)), (2, 0.01));
        // What is written starts with frame 0 at the same time.
        let mut written = Vec::new();
        inhand_capture::motive::write(&recording, &mut written).unwrap();
        let again = inhand_capture::read(&written, "take.csv", &ReadSettings::default()).unwrap();
        assert_eq!(again.clock, recording.clock, "{first}");
    }
}

#[test]
fn a_first_frame_that_no_capture_reaches_is_taken_as_the_start() {
    let take = ring(&["9007199254740000,0.0,1,2,3", "9007199254740001,0.01,1,2,3"]);
    let recording = take.read().unwrap();
    assert_eq!(recording.clock.start_unix_nanos(), START_NANOS);
    let found = findings(&recording).join("\n");
    assert!(
        found.contains("s from the start of its trial: taken as the start"),
        "{found}"
    );
}

#[test]
fn frames_that_cannot_be_one_take_are_refused() {
    assert_eq!(
        ring(&["0,0,1,2,3", "1,0.01,1,2,3", "1,0.02,1,2,3"]).refusal(),
        "take.csv, line 10: frame 1 follows frame 1: expected rising frame numbers; are two takes \
         joined in this file?"
    );
    assert!(
        ring(&["5,0,1,2,3", "4,0.01,1,2,3"])
            .refusal()
            .contains("frame 4 follows frame 5")
    );
    let refusal = ring(&["0,0,1,2,3", "9000000000,0.01,1,2,3"]).refusal();
    assert!(refusal.starts_with("take.csv, line 9: frame 9000000000 follows frame 0: 8999999999"));
    // Many small jumps count together.
    let rows: Vec<String> = (0..200).map(|k| format!("{},,1,2,3", k * 1000)).collect();
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    assert!(ring(&rows).refusal().contains("cannot be one take"));
    assert_eq!(ring(&rows[..50]).read().unwrap().len(), 49_001);
}

#[test]
fn the_time_column_is_a_check() {
    let time = |rate: f64, times: &[String]| {
        let rows: Vec<String> = times
            .iter()
            .enumerate()
            .map(|(k, time)| format!("{k},{time},1,2,3"))
            .collect();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let recording = ring(&rows)
            .with("Export Frame Rate", &rate.to_string())
            .read()
            .unwrap();
        findings(&recording)
    };
    let at = |rate: f64, decimals: usize| -> Vec<String> {
        (0..500)
            .map(|k| {
                format!(
                    "{:.6}",
                    format!("{:.decimals$}", k as f64 / rate)
                        .parse::<f64>()
                        .unwrap()
                )
            })
            .collect()
    };
    let none = Vec::<String>::new();
    assert_eq!(time(360.0, &at(360.0, 3)), none, "rounded to milliseconds");
    assert_eq!(time(120.0, &at(120.0, 6)), none, "six decimals");
    assert_eq!(time(100.0, &vec![String::new(); 3]), none, "blank");
    // A hundredth of a hertz off is 4 ms in 50 s... here 5 s: 0.4 ms, seen at six decimals.
    let drift = time(120.0, &at(119.99, 6));
    assert_eq!(drift.len(), 1, "{drift:?}");
    assert!(
        drift[0].starts_with("line 507: the time column says 4.158680 s"),
        "{drift:?}"
    );
    let wrong = time(240.0, &["0".to_owned(), "0.5".to_owned()]);
    assert!(wrong[0].contains("says 0.500000 s where frame and rate (240 Hz) give 0.004167 s"));
}

#[test]
fn what_the_user_says_fills_in_and_never_contradicts() {
    let silent = Motive::new(euler_body("Hand"), &["0,0,0,0,90,100,0,0"])
        .without("Length Units")
        .without("Rotation Type");
    assert_eq!(
        silent.refusal(),
        "take.csv: the header has no \"Rotation Type\" and body \"Hand\" has three rotation \
         columns: say in which order the angles apply with `source.rotation_order` (XYZ, XZY, YXZ, YZX, \
         ZXY or ZYX); it has no \"Length Units\" either: say it with `source.units` (metres, \
         centimetres, millimetres, inches, feet)"
    );
    let mut settings = ReadSettings {
        rotation_order: Some(RotationOrder::Euler([0, 1, 2])),
        ..ReadSettings::default()
    };
    let refusal = silent.read_with(&settings).unwrap_err().to_string();
    assert_eq!(
        refusal,
        "take.csv: the header has no \"Length Units\": say it with `source.units` (metres, centimetres, \
         millimetres, inches, feet)"
    );
    settings.length_unit = Some(LengthUnit::Centimetres);
    settings.up_axis = Some(UpAxis::Z);
    let recording = silent.read_with(&settings).unwrap();
    assert_eq!(
        recording.bodies[0]
            .track
            .get(0)
            .unwrap()
            .origin()
            .to_array(),
        [1.0, 0.0, 0.0]
    );
    assert_eq!(recording.source.up_axis, UpAxis::Z);

    // Four columns are a quaternion, stated or not.
    let quaternion = Motive::new(body("Hand"), &["0,0,0,0,0,1,0,0,0"]);
    let silent = quaternion.clone().without("Rotation Type").read().unwrap();
    assert_eq!(silent.source.rotation, Some(RotationOrder::Quaternion));

    settings = ReadSettings {
        length_unit: Some(LengthUnit::Millimetres),
        ..ReadSettings::default()
    };
    assert_eq!(
        quaternion.read_with(&settings).unwrap_err().to_string(),
        "take.csv: `source.units` says millimetres, but the file itself states metres: leave `source.units` out"
    );
    settings = ReadSettings {
        rotation_order: Some(RotationOrder::Euler([0, 1, 2])),
        ..ReadSettings::default()
    };
    let refusal = quaternion.read_with(&settings).unwrap_err().to_string();
    assert!(
        refusal.contains("says XYZ, but the file itself states quaternion"),
        "{refusal}"
    );
    let refusal = quaternion
        .without("Rotation Type")
        .read_with(&settings)
        .unwrap_err()
        .to_string();
    assert!(refusal.contains("four rotation columns"), "{refusal}");
}

#[test]
fn damaged_headers_are_refused() {
    let take = Motive::new(
        [body("Hand"), marker("Ring")].concat(),
        &["0,0,0,0,0,1,1,2,3,4,5,6"],
    );
    let text = take.text();
    let refusal = |text: &str| {
        inhand_capture::read(text.as_bytes(), "take.csv", &ReadSettings::default())
            .expect_err(text)
            .to_string()
    };
    let lines: Vec<&str> = text.split_inclusive("\r\n").collect();
    for (what, text, expected) in [
        ("empty", String::new(), "not a capture file"),
        ("text", "a,b,c\n1,2,3\n".to_owned(), "found \"a,b,c\""),
        ("tabs", text.replace(',', "\t"), "not a capture file"),
        (
            "C3D",
            "\u{2}P\u{c}\0".to_owned(),
            "take.csv: not a sound C3D file: at byte 512",
        ),
        (
            "rows only",
            lines[7..].concat(),
            "found \"0,0,0,0,0,1,1,2,3,4,5,6\"",
        ),
        (
            "row-typed",
            "comment,\"OptiTrack Export Data\"\n".to_owned(),
            "followed by no samples",
        ),
        (
            "cut in the header",
            lines[..5].concat(),
            "line 6: expected the row of axis labels",
        ),
        ("no rows", lines[..7].concat(), "followed by no samples"),
        (
            "no rate",
            text.replace("Export Frame Rate", "Something"),
            "\"Export Frame Rate\" is missing",
        ),
        (
            "rate of zero",
            text.replace("Export Frame Rate,100", "Export Frame Rate,0"),
            "\"Export Frame Rate\" is \"0.000000\"",
        ),
        (
            "unit",
            text.replace("Meters", "Furlongs"),
            "\"Length Units\" is \"Furlongs\"",
        ),
        (
            "rotation type",
            text.replace("Type,Quaternion", "Type,XYX"),
            "\"Rotation Type\" is \"XYX\"",
        ),
        (
            "rotation type that the columns are not",
            text.replace("Type,Quaternion", "Type,XYZ"),
            "four rotation columns, X, Y, Z, W, for body \"Hand\"",
        ),
        (
            "axis lost",
            text.replace("W,X,Y,Z,X,Y,Z", "W,X,Y,Z,X,Y"),
            "line 7, column 10: marker \"Ring\" has only Position X, Position Y: expected",
        ),
        (
            "body without rotation",
            text.replace("Rotation", "Rubbish")
                .replace("Rubbish Type", "Rotation Type"),
            "body \"Hand\" has only Position X, Position Y, Position Z",
        ),
        (
            "type lost",
            text.replace(",Marker,Marker,Marker", ""),
            "expected a type such as Marker for column 10 (Position X)",
        ),
        (
            "NUL",
            text.replace("Ring", "Ri\0ng"),
            "line 4: expected UTF-8 text, found a NUL byte",
        ),
    ] {
        let found = refusal(&text);
        assert!(found.contains(expected), "{what}: {found}");
        assert!(found.starts_with("take.csv"), "{what}: {found}");
    }
    let mut latin = text.clone().into_bytes();
    let at = text.find("Ring").unwrap();
    latin[at] = 0xE9;
    let error = inhand_capture::read(&latin, "take.csv", &ReadSettings::default()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("line 4: expected UTF-8 text, found the byte 0xE9")
    );
}

#[test]
fn damaged_rows_are_refused_with_line_column_and_entity() {
    assert_eq!(
        ring(&["0,0,1,2,3", "1,0.01,1,1.0.24,3"]).refusal(),
        "take.csv, line 9, column 4 (\"Ring\" Position Y): expected a number, found \"1.0.24\""
    );
    assert_eq!(
        ring(&["zero,0,1,2,3"]).refusal(),
        "take.csv, line 8, column 1 (Frame): expected a number, found \"zero\""
    );
    assert_eq!(
        ring(&["0,0,1,2,3", "1,0.01,1,2"]).refusal(),
        "take.csv, line 9: expected 5 cells, found 4: the row is cut off"
    );
    assert!(
        ring(&["0,0,1,5,2,5,3,5"])
            .refusal()
            .contains("decimal point")
    );
    // A megabyte without any end of line, as header and as row.
    let long = "7".repeat(1 << 20);
    assert!(ring(&[&format!("0,0,{long},2,3")]).refusal().len() < 300);
    assert!(ring(&[&long]).refusal().len() < 300);
    let long_header = Motive::new(marker(&long), &["0,0,1,2,3"]).read().unwrap();
    assert_eq!(long_header.markers[0].name.len(), 1 << 20);
}

#[test]
fn versions_that_were_never_seen_are_a_finding() {
    let recording = ring(&["0,0,1,2,3"])
        .with("Format Version", "1.40")
        .read()
        .unwrap();
    assert_eq!(
        findings(&recording),
        ["Format Version: 1.40 is none of 1.21 to 1.25: read as its header rows say"]
    );
}

#[test]
fn a_count_that_is_none_is_a_finding() {
    for absurd in ["99999999999999999999", "-1", "all"] {
        let recording = ring(&["0,0,1,2,3"])
            .with("Total Exported Frames", absurd)
            .read()
            .unwrap();
        let expected = format!(
            "Total Exported Frames: expected a count, found \"{absurd}\": counted what is there"
        );
        assert_eq!(findings(&recording), [expected]);
    }
}

#[test]
fn markers_of_bodies_in_local_space_are_a_finding() {
    let mut columns = marker("Hand:Marker1");
    for column in &mut columns {
        column[0] = "Rigid Body Marker".to_owned();
    }
    let columns = [body("Hand"), columns].concat();
    let take = Motive::new(columns, &["0,0,0,0,0,1,1,2,3,0.01,0.02,0.03"]);
    assert_eq!(findings(&take.read().unwrap()), Vec::<String>::new());
    let local = take.with("Coordinate Space", "Local").read().unwrap();
    assert_eq!(
        findings(&local),
        [
            "Coordinate Space: Local: positions of rigid-body markers may be relative to their body, \
          not to the world: kept as they are"
        ]
    );
    assert_eq!(
        local.markers[0].track.get(0).unwrap().to_array(),
        [0.01, 0.02, 0.03]
    );
}

#[test]
fn names_that_are_there_twice_are_entities_of_their_own() {
    let columns = [marker("Ring"), marker("Ring"), body("Hand"), body("Hand")].concat();
    let row = "0,0,1,2,3,4,5,6,0,0,0,1,7,8,9,0,0,0,1,10,11,12";
    let recording = Motive::new(columns, &[row]).read().unwrap();
    let first = |n: usize| recording.markers[n].track.get(0).unwrap().to_array();
    assert_eq!((first(0), first(1)), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]));
    let origins = recording
        .bodies
        .iter()
        .map(|b| b.track.get(0).unwrap().origin().to_array());
    assert_eq!(
        origins.collect::<Vec<_>>(),
        [[7.0, 8.0, 9.0], [10.0, 11.0, 12.0]]
    );
}
