//! TRC files that are written.

use inhand_capture::{ReadSettings, trc};
use inhand_model::{
    Clock, LengthUnit, Marker, MarkerKind, PointTrack, Position, Recording, Source, StartTime,
    UpAxis, World,
};
use proptest::prelude::*;

fn recording(names: &[&str], values: &[Vec<Option<[f64; 3]>>], rate_hz: f64) -> Recording {
    let markers = names.iter().zip(values).map(|(&name, values)| Marker {
        name: name.to_owned(),
        id: String::new(),
        kind: MarkerKind::Labelled,
        track: PointTrack::<World>::from_measured(values.iter().map(|v| v.map(Position::from))),
        quality: None,
    });
    let source = Source {
        format: "test".to_owned(),
        length_unit: LengthUnit::Millimetres,
        up_axis: UpAxis::Y,
        rotation: None,
        header: [].into(),
    };
    let clock = Clock::new(0, StartTime::Unknown, rate_hz).expect("a rate");
    let samples = values.first().map_or(0, Vec::len);
    let markers = markers.collect();
    Recording::new("take".to_owned(), clock, source, samples, markers, vec![]).expect("one length")
}

fn written(recording: &Recording) -> String {
    let mut bytes = Vec::new();
    trc::write(recording, &mut bytes).expect("memory takes all");
    String::from_utf8(bytes).expect("TRC is UTF-8")
}

#[test]
fn a_file_as_others_expect_it() {
    let values = [
        vec![Some([0.25, 1.5, -2.0]), None],
        vec![Some([1.0, 2.0, 3.0]), Some([4.0, 5.0, 6.0])],
    ];
    let text = written(&recording(&["Thumb", "Index\ttip"], &values, 100.0));
    let expected = [
        "PathFileType\t4\t(X/Y/Z)\ttake.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        "100\t100\t2\t2\tm\t100\t1\t2",
        "Frame#\tTime\tThumb\t\t\tIndex tip\t\t",
        "\t\tX1\tY1\tZ1\tX2\tY2\tZ2",
        "",
        "1\t0.000000\t0.25\t1.5\t-2\t1\t2\t3",
        "2\t0.010000\t\t\t\t4\t5\t6",
        "",
    ];
    assert_eq!(text.split("\r\n").collect::<Vec<_>>(), expected);
}

#[test]
fn a_recording_with_z_up_is_turned_so_that_y_is() {
    let values = [vec![Some([0.25, 1.5, -2.0]), None]];
    let mut z_up = recording(&["Thumb"], &values, 100.0);
    z_up.source.up_axis = UpAxis::Z;
    let found = inhand_capture::read(written(&z_up).as_bytes(), "a.trc", &ReadSettings::default());
    let found = found.expect("the file is sound");
    assert_eq!(found.source.up_axis, UpAxis::Y);
    let assumed = |r: &Recording| {
        r.findings
            .iter()
            .any(|f| f.to_string().contains("`source.up`"))
    };
    assert!(assumed(&found), "{:?}", found.findings);
    // Upright, it is where it was.
    let turned = found.markers[0].track.get(0).expect("seen").to_array();
    assert_eq!(turned, [0.25, -2.0, -1.5]);
    let upright = found.source.up_axis.upright_from_world() * nalgebra::Vector3::from(turned);
    assert!((upright - nalgebra::Vector3::new(0.25, 1.5, -2.0)).norm() < 1e-12);
    let told = ReadSettings {
        up_axis: Some(UpAxis::Y),
        ..ReadSettings::default()
    };
    let told =
        inhand_capture::read(written(&z_up).as_bytes(), "a.trc", &told).expect("the file is sound");
    assert!(!assumed(&told));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_is_written_reads_back_bit_for_bit(
        values in prop::collection::vec(
            prop::collection::vec(prop::option::of(prop::array::uniform3(-3.0..3.0_f64)), 2..30),
            1..5,
        ),
        rate_hz in 1.0..500.0_f64,
    ) {
        let samples = values.iter().map(Vec::len).min().unwrap_or(0);
        let values: Vec<_> = values.iter().map(|v| v[..samples].to_vec()).collect();
        let names = ["Thumb", "Index", "Middle", "Ring", "Little"];
        let expected = recording(&names[..values.len()], &values, rate_hz);
        let text = written(&expected);
        let found = inhand_capture::read(text.as_bytes(), "take.trc", &ReadSettings::default());
        let found = found.expect("the file is sound");
        prop_assert_eq!(found.clock.rate_hz(), rate_hz);
        prop_assert_eq!(found.markers.len(), expected.markers.len());
        for (a, b) in found.markers.iter().zip(&expected.markers) {
            prop_assert_eq!(&a.name, &b.name);
            prop_assert!(a.track.iter().eq(b.track.iter()), "{}", a.name);
        }
    }
}
