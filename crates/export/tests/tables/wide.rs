//! Wide and tidy CSV, and wide CSV back.

use inhand_export::{
    ExportError, facts_json, looks_like_wide_csv, read_wide_csv, recording_entities, tidy, wide,
    write_csv,
};
use inhand_model::{Recording, Sample, StartTime, Status, Track, UpAxis};
use proptest::prelude::*;

use crate::common::recording;

fn wide_csv(recording: &Recording) -> Vec<u8> {
    let mut csv = Vec::new();
    let entities = recording_entities(recording);
    write_csv(&wide(&entities, recording.clock, recording.len()), &mut csv).unwrap();
    csv
}

fn bits<T: Sample, const N: usize>(
    track: &Track<T>,
    numbers: impl Fn(T) -> [f64; N],
) -> Vec<(Status, Option<[u64; N]>)> {
    (track.iter().zip(track.statuses()))
        .map(|(value, &status)| (status, value.map(|v| numbers(v).map(f64::to_bits))))
        .collect()
}

fn assert_same(found: &Recording, expected: &Recording) {
    assert_eq!(found.name, expected.name);
    assert_eq!(found.clock, expected.clock);
    assert_eq!(found.source, expected.source);
    assert_eq!(found.len(), expected.len());
    let series = |series: &Option<Vec<f64>>| {
        let series = series.as_ref();
        series.map(|s| {
            s.iter()
                .map(|v| if v.is_nan() { 0 } else { v.to_bits() })
                .collect::<Vec<_>>()
        })
    };
    assert_eq!(found.markers.len(), expected.markers.len());
    for (found, expected) in found.markers.iter().zip(&expected.markers) {
        assert_eq!(
            (&found.name, &found.id, found.kind),
            (&expected.name, &expected.id, expected.kind)
        );
        let of = |m: &inhand_model::Marker| bits(&m.track, inhand_model::Position::to_array);
        assert_eq!(of(found), of(expected));
        assert_eq!(series(&found.quality), series(&expected.quality));
    }
    assert_eq!(found.bodies.len(), expected.bodies.len());
    for (found, expected) in found.bodies.iter().zip(&expected.bodies) {
        assert_eq!(
            (&found.name, &found.id, found.kind),
            (&expected.name, &expected.id, expected.kind)
        );
        let of = |b: &inhand_model::TrackedBody| {
            bits(&b.track, |pose| {
                let ([x, y, z], [a, b, c, d]) = (pose.origin().to_array(), pose.quaternion_xyzw());
                [x, y, z, a, b, c, d]
            })
        };
        assert_eq!(of(found), of(expected));
        assert_eq!(
            series(&found.marker_error_m),
            series(&expected.marker_error_m)
        );
    }
}

#[test]
fn a_name_that_begins_a_formula_is_none_in_a_spreadsheet_and_comes_back() {
    let mut take = recording(3, 100.0);
    take.markers[0].name = "=1+1".to_owned();
    let csv = wide_csv(&take);
    assert!(
        String::from_utf8_lossy(&csv).contains(",'=1+1.x_m,"),
        "{}",
        String::from_utf8_lossy(&csv)
    );
    let facts = facts_json(&take);
    let back = read_wide_csv(&csv, "a.csv", Some(facts.as_bytes()), None).unwrap();
    assert_same(&back, &take);
}

#[test]
fn a_recording_comes_back_bit_for_bit() {
    // 120 Hz: sample times have no short decimals.
    for (samples, rate_hz) in [(1000, 120.0), (1, 100.0), (0, 100.0)] {
        let take = recording(samples, rate_hz);
        let csv = wide_csv(&take);
        let facts = facts_json(&take);
        assert!(looks_like_wide_csv(&csv));
        let back = read_wide_csv(&csv, "a.csv", Some(facts.as_bytes()), None).unwrap();
        assert_same(&back, &take);
        assert_eq!(back.findings, []);
        assert_eq!((wide_csv(&back), facts_json(&back)), (csv, facts));
    }
}

#[test]
fn without_facts_the_rate_comes_from_the_times() {
    let take = recording(500, 120.0);
    let csv = wide_csv(&take);
    let back = read_wide_csv(&csv, "a.csv", None, Some(UpAxis::Z)).unwrap();
    assert_eq!(back.clock.rate_hz(), 120.0);
    assert_eq!(back.clock.start_time(), StartTime::Unknown);
    assert_eq!((back.source.up_axis, back.findings.len()), (UpAxis::Z, 0));
    assert_eq!((back.markers.len(), back.bodies.len()), (3, 2));
    assert_eq!(back.markers[1].name, "Thumb#2");
    assert_eq!(back.name, "a");

    // What is assumed is said.
    let back = read_wide_csv(&csv, "a.csv", None, None).unwrap();
    assert!(back.findings[0].message.contains("y is taken to point up"));
}

#[test]
fn tidy_has_a_row_for_each_entity_and_sample() {
    let take = recording(4, 100.0);
    let entities = recording_entities(&take);
    let table = tidy(&entities, take.clock, take.len());
    let mut csv = Vec::new();
    write_csv(&table, &mut csv).unwrap();
    let text = String::from_utf8(csv).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 1 + 4 * 5);
    assert_eq!(
        lines[0],
        "time_s,sample,entity,kind,frame,x_m,y_m,z_m,qx,qy,qz,qw,status,marker_error_m,quality"
    );
    assert!(lines[1].starts_with("0,0,\"Hand, \"\"left\"\"\",rigid_body,world,0,0.000000001,-0,"));
    assert_eq!(lines[18], "0.03,3,Thumb,labelled,world,,,,,,,,missing,,");
    // Without entities there are no rows, and no division by their number.
    assert_eq!(tidy(&[], take.clock, 4).rows, 0);
}

fn refused(csv: &str) -> String {
    read_wide_csv(csv.as_bytes(), "a.csv", None, None)
        .unwrap_err()
        .to_string()
}

#[test]
fn what_cannot_be_read_is_refused_with_its_place() {
    let head = "time_s,a.x_m,a.y_m,a.z_m,a.status\n";
    let cases = [
        (
            format!("{head}0,1,2,3,measured\n0.01,1,zwei,3,measured\n"),
            "line 3, column 3 (\"a.y_m\")",
        ),
        (
            format!("{head}0,1,2,3,seen\n"),
            "line 2, column 5 (\"a.status\")",
        ),
        (format!("{head}0,1,2,inf,measured\n"), "column 4"),
        (format!("{head}0,1,2,3\n"), "line 2: expected 5 cells"),
        (format!("{head},1,2,3,measured\n"), "column 1 (\"time_s\")"),
        (
            format!("{head}0,1,2,3,measured\n0.01,,,,\n0.03,,,,\n"),
            "in row 2",
        ),
        (
            format!("{head}0,1,2,3,measured\n0,1,2,3,measured\n"),
            "evenly spaced times",
        ),
        ("time_s,a.x_m,a.y_m\n".to_owned(), "\"a.z_m\""),
        (
            "time_s,a.x_m,a.y_m,a.z_m,a.x_m\n0,1,2,3,4\n".to_owned(),
            "\"a.x_m\" twice",
        ),
        (
            "time_s,a.x_m,a.y_m,a.z_m,a.qx,a.qy,a.qz,a.qw\n0,1,2,3,1,1,0,0\n".to_owned(),
            "unit length",
        ),
    ];
    for (csv, expected) in cases {
        let error = refused(&csv);
        assert!(error.contains(expected), "{error}\nhas no {expected}");
    }
    let not_text = [head.as_bytes(), b"0,1,2,3,\xff\n"].concat();
    let error = read_wide_csv(&not_text, "a.csv", None, None).unwrap_err();
    assert!(
        error.to_string().contains("line 2: expected text in UTF-8"),
        "{error}"
    );
}

#[test]
fn facts_that_are_none_are_refused() {
    let take = recording(3, 100.0);
    let csv = wide_csv(&take);
    let facts = facts_json(&take);
    let with = |from: &str, to: &str| {
        assert!(facts.contains(from), "{from}");
        let facts = facts.replace(from, to);
        read_wide_csv(&csv, "a.csv", Some(facts.as_bytes()), None)
    };
    for (from, to, expected) in [
        ("\"inhand_table\": 1", "\"inhand_table\": 2", "version 2"),
        ("\"rate_hz\": 100.0", "\"rate_hz\": -1.0", "\"rate_hz\""),
        (
            "\"up_axis\": \"z\"",
            "\"up_axis\": \"w\"",
            "expected `y` or `z`",
        ),
        ("\"kind\": \"bone\"", "\"kind\": \"fish\"", "a kind of body"),
        (
            "\"rotation\": \"XZY\"",
            "\"rotation\": \"XQ\"",
            "quaternion or an axis order",
        ),
        ("{", "", "expected value"),
    ] {
        let error = with(from, to).unwrap_err().to_string();
        assert!(error.starts_with("a.csv.json: "), "{error}");
        assert!(
            error.contains(expected) || expected == "expected value",
            "{error}"
        );
    }
    // A table that was cut is still read, and says so.
    let back = with("\"samples\": 3", "\"samples\": 4").unwrap();
    assert!(
        back.findings[0]
            .message
            .contains("state 4 samples, it has 3")
    );
}

#[test]
fn blank_cells_are_missing_and_half_samples_are_told() {
    let csv = "time_s,a.x_m,a.y_m,a.z_m\r\n0,1,2,3\r\n0.5,,,\r\n1,1,,3\r\n1.5,NaN,nan,NAN\r\n";
    let take = read_wide_csv(csv.as_bytes(), "a.csv", None, None).unwrap();
    let track = &take.markers[0].track;
    assert_eq!(track.counts().missing, 3);
    assert_eq!(take.clock.rate_hz(), 2.0);
    let told = &take.findings[1];
    assert_eq!(told.place, "a");
    assert!(
        told.message.starts_with("1 samples") && told.message.contains("line 4"),
        "{told}"
    );
}

/// Were each column sought among all others, this would take a minute.
#[test]
fn a_table_of_many_columns_is_read() {
    let names = (0..6000).map(|n| format!(",m{n}.x_m,m{n}.y_m,m{n}.z_m"));
    let mut csv = "time_s".to_owned() + &names.collect::<String>();
    for time in ["0", "0.01", "0.02"] {
        csv = csv + "\n" + time + &",1,2,3".repeat(6000);
    }
    let take = read_wide_csv(csv.as_bytes(), "a.csv", None, None).unwrap();
    assert_eq!((take.markers.len(), take.len()), (6000, 3));
    assert_eq!(take.markers[5999].name, "m5999");
}

#[test]
fn only_wide_tables_look_like_one() {
    assert!(looks_like_wide_csv(b"\xef\xbb\xbftime_s,a.x_m"));
    for other in [
        &b""[..],
        b"time_s,a",
        b"Format Version,1.23,a.x_m",
        b"\0\0time_s,a.x_m",
    ] {
        assert!(!looks_like_wide_csv(other));
    }
}

proptest! {
    #[test]
    fn damaged_tables_never_panic(cut in 0_usize..4000, at in 0_usize..4000, byte: u8) {
        let take = recording(20, 100.0);
        let mut csv = wide_csv(&take);
        csv.truncate(cut);
        if let Some(place) = csv.get_mut(at) {
            *place = byte;
        }
        let facts = facts_json(&take);
        for facts in [None, Some(facts.as_bytes())] {
            match read_wide_csv(&csv, "a.csv", facts, None) {
                Ok(back) => prop_assert!(back.len() <= 20),
                Err(error) => {
                    let writing = matches!(error, ExportError::Write(_));
                    prop_assert!(!writing, "{error}");
                },
            }
        }
    }
}
