//! The row-typed Motive CSV before 1.2.

use inhand_capture::{CaptureError, ReadSettings};
use inhand_model::{LengthUnit, MarkerKind, Recording, RotationOrder, StartTime};

use super::text::findings;

/// Two bodies, of which one is lost at the third frame; a marker with a name, one without.
const NAMED: &str = "\
comment,\"OptiTrack Export Data\"
righthanded
info,version,1.1
info,framecount,4
info,rigidbodycount,2
rigidbody,\"Hand, left\",1,1,0.1,0.2,0.3
rigidbody,\"Cup\",7,0
frame,10,0.500,2,1,1,2,3,0,0,0,1,9,9,9,7,4,5,6,0,0,1,0,9,9,9,2,1.5,2.5,3.5,3,Hand,-1,-2,-3,55,Marker-55
rigidbody,10,0.500,\"Hand, left\",1,0,1,1.4,2.4,3.4,3,1.5,2.5,3.5,1,0.75,0.01
frame,11,0.510,1,1,1,2,4,0,0,0,1,9,9,9,1,1,1,1,8,wrist
rigidbody,11,0.510,\"Hand, left\",1,0,1,1.5,2.5,3.5,3,NAN,NAN,NAN,0,0.5,0.01
frame,13,0.530,0,0
rigidbody,13,0.530,\"Hand, left\",1,2,1,1.5,2.5,3.5,3,NAN,NAN,NAN,0,0.5,0.01
frame,14,0.540,0,2,0,0,1,0,,0,0,2,0,
";

fn read(text: &str) -> Result<Recording, CaptureError> {
    inhand_capture::read(text.as_bytes(), "old.csv", &ReadSettings::default())
}

fn refusal(text: &str) -> String {
    read(text).expect_err(text).to_string()
}

fn x(recording: &Recording, kind: MarkerKind, name: &str) -> Vec<Option<f64>> {
    let mut markers = recording.markers.iter();
    let marker = markers.find(|m| m.kind == kind && m.name == name);
    let track = &marker.unwrap_or_else(|| panic!("{name}")).track;
    track.iter().map(|p| p.map(|p| p.to_array()[0])).collect()
}

#[test]
fn bodies_and_markers_of_every_kind() {
    let recording = read(NAMED).unwrap();
    assert_eq!(recording.source.format, "Motive CSV 1.1");
    assert_eq!(recording.source.length_unit, LengthUnit::Metres);
    assert_eq!(recording.source.rotation, Some(RotationOrder::Quaternion));
    assert_eq!(recording.source.header["rigidbodycount"], "2");
    assert_eq!(recording.clock.rate_hz(), 100.0);
    assert_eq!(recording.clock.start_time(), StartTime::Unknown);
    assert_eq!(recording.len(), 5, "frame 12 is left out");

    let names: Vec<&str> = recording.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["Hand, left", "Cup"]);
    let hand = &recording.bodies[0].track;
    assert_eq!(hand.gaps().first(), Some(&(2..5)));
    assert_eq!(hand.get(1).unwrap().origin().to_array(), [1.0, 2.0, 4.0]);
    let cup = recording.bodies[1].track.get(0).unwrap();
    assert_eq!(cup.quaternion_xyzw(), [0.0, 0.0, 1.0, 0.0]);

    let of_hand = "Hand, left-Marker 1";
    let fitted = x(&recording, MarkerKind::RigidBodyMarker, of_hand);
    // The last row repeats a fit of a body that was lost two frames before.
    assert_eq!(fitted, [Some(1.4), Some(1.5), None, None, None]);
    let seen = x(&recording, MarkerKind::Labelled, of_hand);
    assert_eq!(seen, [Some(1.5), None, None, None, None]);
    let quality = recording.markers[0].quality.as_ref().unwrap();
    assert_eq!(quality[..2], [0.75, 0.5]);
    let (marker, none) = (|name| x(&recording, MarkerKind::Unlabelled, name), None);
    assert_eq!(marker("Marker-55"), [Some(-1.0), none, none, none, none]);
    assert_eq!(marker("Unlabeled 2"), [none, none, none, none, Some(0.0)]);
    let wrist = x(&recording, MarkerKind::Labelled, "wrist");
    assert_eq!(wrist, [none, Some(1.0), none, none, none]);
    assert_eq!(recording.markers.len(), 6, "each marker once");

    assert_eq!(
        findings(&recording),
        [
            "start time: the file states no start time: the take starts at 1970-01-01",
            "rate: the file states none: 100 Hz by its time stamps",
            "markers: in 1 frames there are up to 2 markers that nothing identifies: they are \
             numbered in the order of their row, so that one number may stand for several markers",
            "mean errors: not read: the file calls them millimetres, but they are as large as \
             metres would be",
            "the first frame is at 0.500 s of its trial: it is at 0 s here",
            "line 12: frame 13 follows frame 11; in all the frame column jumps 1 times and leaves \
             out 1 frames: taken as missing samples",
        ]
    );
}

#[test]
fn trackables_of_version_1() {
    let text = NAMED
        .replace("info,version,1.1\n", "")
        .replace("rigidbody", "trackable")
        .replace(",3,Hand,-1,-2,-3,55,Marker-55", ",0,-1,-2,-3,0")
        .replace(",1,1,1,8,wrist", ",1,1,1,0")
        .replace("0,0,1,0,,0,0,2,0,", "0,0,1,0,0,0,2,0")
        .replace(",3.4,3,", ",3.4,")
        .replace(",3.5,3,", ",3.5,")
        .replace("framecount,4", "framecount,9");
    let recording = read(&text).unwrap();
    assert_eq!(recording.source.format, "Motive CSV 1");
    let seen = x(&recording, MarkerKind::Labelled, "Hand, left-Marker 1");
    assert_eq!(seen[0], Some(1.5));
    let nameless = x(&recording, MarkerKind::Unlabelled, "Unlabeled 1");
    assert_eq!(nameless, [Some(-1.0), Some(1.0), None, None, Some(0.0)]);
    let declared = "framecount: the header promises 9 rows, found 4";
    assert!(findings(&recording).iter().any(|f| f.starts_with(declared)));
}

#[test]
fn rates_come_from_time_stamps() {
    let rate = |times: &[f64]| {
        let rows = times.iter().enumerate();
        let rows: String = rows
            .map(|(k, t)| format!("frame,{k},{t:.6},0,0\n"))
            .collect();
        read(&rows).map(|recording| (recording.clock.rate_hz(), findings(&recording).len()))
    };
    let jitter = |k: usize| 4e-4 * ((k * 7919 % 13) as f64 - 6.0) / 6.0;
    let even = |n: usize, hz: f64| (0..n).map(|k| k as f64 / hz).collect::<Vec<_>>();
    let with_jitter: Vec<f64> = (0..1000).map(|k| k as f64 / 250.0 + jitter(k)).collect();
    assert_eq!(rate(&with_jitter).unwrap(), (250.0, 2));
    assert_eq!(rate(&even(2, 100.0)).unwrap().0, 100.0);
    assert_eq!(rate(&even(500, 128.0)).unwrap().0, 128.0);
    // Over five minutes 119.88 Hz are not 120.
    let film = rate(&even(36_000, 119.88)).unwrap().0;
    assert!((film - 119.88).abs() < 1e-3, "{film}");
    // A clock that stands still for a while is a finding.
    let mut late = even(100, 100.0);
    late.iter_mut().take(60).skip(50).for_each(|t| *t = 0.5);
    assert_eq!(rate(&late).unwrap(), (100.0, 3));
    for times in [
        &[][..],
        &[0.0],
        &[1.0, 1.0],
        &[1.0, 0.5],
        &[f64::NAN, f64::NAN],
    ] {
        assert!(rate(times).is_err(), "{times:?}");
    }
}

#[test]
fn what_is_refused() {
    let line = |row: &str| format!("righthanded\ninfo,version,1.1\n{row}\n");
    for (text, expected) in [
        (
            line("frame,0,0,1,1,2,3"),
            "old.csv, line 3: expected 15 cells, found 7: the row is cut off",
        ),
        (
            line("frame,0,0,18446744073709551615,1"),
            "line 3: expected 18446744073709551615 cells, found 5",
        ),
        (
            line("frame,0,0,x,0"),
            "line 3, column 4 (row-typed format): expected a count of bodies, found \"x\"",
        ),
        (
            line("frame,0,0,-1,0"),
            "expected a count of bodies, found \"-1\"",
        ),
        (
            line("frame,0.5,0,0,0"),
            "line 3, column 2 (row-typed format): expected a frame number",
        ),
        (
            line("frame,0,0,0,1,1,2,3,4,5,6"),
            "line 3, column 10: expected no more than the header's 9 columns",
        ),
        (
            line("frame,0,0,0"),
            "line 3, column 5 (the row is cut off): expected a count of markers",
        ),
        (
            line("frame,0,1e999,0,0"),
            "expected a time in seconds, found \"1e999\"",
        ),
        (
            line("skeleton,1"),
            "line 3, column 1 (row-typed format): expected comment, info",
        ),
        (
            line("rigidbody,\"a\",1,5,1,2,3"),
            "line 3: expected 19 cells, found 7",
        ),
        (
            line("lefthanded"),
            "left-handed coordinates (line 3) is not read yet: export it right-handed",
        ),
        (
            NAMED.replace("frame,11,", "frame,10,"),
            "line 10: frame 10 follows frame 10",
        ),
        (
            NAMED.replace("frame,14,", "frame,14000000,"),
            "cannot be one take",
        ),
        (line(""), "followed by no samples"),
    ] {
        let found = refusal(&text);
        assert!(found.contains(expected), "{found}");
    }
    let error = inhand_capture::read(
        b"info,version,1.1\nrigidbody,\"H\xE9\",1,0\n",
        "old.csv",
        &ReadSettings::default(),
    );
    let error = error.unwrap_err().to_string();
    assert!(
        error.starts_with("old.csv, line 2: expected UTF-8 text"),
        "{error}"
    );
    let settings = ReadSettings {
        length_unit: Some(LengthUnit::Millimetres),
        ..ReadSettings::default()
    };
    let error = inhand_capture::read(NAMED.as_bytes(), "old.csv", &settings).unwrap_err();
    assert!(
        error.to_string().contains("the file itself states metres"),
        "{error}"
    );
}

#[test]
fn names_that_are_there_twice() {
    let text = NAMED.replace(
        "rigidbody,\"Cup\",7,0",
        "rigidbody,\"Hand, left\",7,0\nrigidbody,\"Cup\",7,0",
    );
    let recording = read(&text).unwrap();
    assert_eq!(recording.bodies.len(), 2);
    let found = findings(&recording);
    assert!(
        found
            .iter()
            .any(|f| f == "body \"Cup\": its ID 7 is that of a body before it: not read")
    );
    // The same marker twice in one row: the second one is none that anybody can name.
    let text = NAMED.replace("1,1,1,1,8,wrist", "2,1,1,1,8,wrist,2,2,2,8,wrist");
    let nameless = x(&read(&text).unwrap(), MarkerKind::Unlabelled, "Unlabeled 1");
    assert_eq!(nameless[1], Some(2.0));
}

#[test]
fn markers_seen_once_cost_no_track_over_a_long_take() {
    let rows = 20_000;
    let text: String = (0..rows)
        .map(|k| {
            format!(
                "frame,{k},{:.2},0,2,1,2,3,{k},Marker-{k},1,2,4,7,tip\n",
                k as f64 / 100.0
            )
        })
        .collect();
    let recording = read(&text).unwrap();
    assert!(recording.markers.len() <= 50, "{}", recording.markers.len());
    let tip = x(&recording, MarkerKind::Labelled, "tip");
    assert!(tip.iter().all(Option::is_some));
    let found = findings(&recording);
    assert!(
        found.iter().any(|f| f.contains("seen too seldom")),
        "{found:?}"
    );
}
