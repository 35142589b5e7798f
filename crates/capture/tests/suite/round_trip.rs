//! Round trips of written takes.

use inhand_capture::{ReadSettings, motive};
use inhand_model::{
    Body, BodyKind, Clock, LengthUnit, Marker, MarkerKind, PointTrack, Pose, PoseTrack, Position,
    Recording, Source, StartTime, TrackedBody, UpAxis, World,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;

fn same_series(a: &Option<Vec<f64>>, b: &Option<Vec<f64>>) -> bool {
    let bits = |series: &Option<Vec<f64>>| {
        series
            .as_ref()
            .map(|s| s.iter().map(|v| v.to_bits()).collect::<Vec<_>>())
    };
    bits(a) == bits(b)
}

fn assert_same(read: &Recording, written: &Recording) {
    assert_eq!(read.name, written.name);
    assert_eq!(read.len(), written.len());
    assert_eq!(read.clock.rate_hz(), written.clock.rate_hz());
    assert_eq!(
        read.clock.start_unix_nanos(),
        written.clock.start_unix_nanos()
    );
    assert_eq!(read.source.up_axis, written.source.up_axis);
    assert_eq!(read.markers.len(), written.markers.len());
    for (a, b) in read.markers.iter().zip(&written.markers) {
        assert_eq!((&a.name, &a.id, a.kind), (&b.name, &b.id, b.kind));
        assert!(a.track.iter().eq(b.track.iter()), "{}", a.name);
        assert!(same_series(&a.quality, &b.quality), "{}", a.name);
    }
    assert_eq!(read.bodies.len(), written.bodies.len());
    for (a, b) in read.bodies.iter().zip(&written.bodies) {
        assert_eq!((&a.name, &a.id, a.kind), (&b.name, &b.id, b.kind));
        assert!(a.track.iter().eq(b.track.iter()), "{}", a.name);
        assert!(
            same_series(&a.marker_error_m, &b.marker_error_m),
            "{}",
            a.name
        );
    }
}

fn written(recording: &Recording) -> String {
    let mut bytes = Vec::new();
    motive::write(recording, &mut bytes).expect("memory takes all");
    String::from_utf8(bytes).expect("CSV is UTF-8")
}

fn source(up_axis: UpAxis) -> Source {
    Source {
        format: "test".to_owned(),
        length_unit: LengthUnit::Millimetres,
        up_axis,
        rotation: None,
        header: [("Take Notes".to_owned(), "one, two".to_owned())].into(),
    }
}

fn point() -> impl Strategy<Value = Option<Position<World>>> {
    prop::option::weighted(
        0.8,
        (-3.0..3.0, prop::num::f64::NORMAL, -1e-9..1e-9)
            .prop_map(|(x, y, z): (f64, f64, f64)| Position::new(x, y % 10.0, z)),
    )
}

fn pose() -> impl Strategy<Value = Option<Pose<World, Body>>> {
    let number = -3.0..3.0;
    prop::option::weighted(
        0.8,
        (
            [number.clone(), number.clone(), number.clone()],
            [number.clone(), number.clone(), number],
        )
            .prop_map(|(turn, at)| {
                Pose::new(Isometry3::from_parts(
                    Translation3::from(Vector3::from(at)),
                    UnitQuaternion::from_scaled_axis(Vector3::from(turn)),
                ))
            }),
    )
}

prop_compose! {
    fn recording()(samples in 1_usize..20)(
        points in prop::collection::vec(prop::collection::vec(point(), samples), 4),
        poses in prop::collection::vec(prop::collection::vec(pose(), samples), 2),
        quality in prop::collection::vec(prop::option::of(0.0..1.0), samples),
        start in 0_u64..4_000_000_000_000_000_000,
        rate_hz in prop::sample::select(vec![100.0, 120.0, 59.94, 1000.0 / 3.0]),
        up_axis in prop::sample::select(vec![UpAxis::Y, UpAxis::Z]),
        name in "[a-zA-Z ,\"é]{0,8}x",
    ) -> Recording {
        let quality: Vec<f64> = quality.into_iter().map(|q| q.unwrap_or(f64::NAN)).collect();
        let kinds = [
            ("Hand:Marker1", MarkerKind::RigidBodyMarker),
            ("Hand:Marker1", MarkerKind::Labelled),
            (name.as_str(), MarkerKind::Labelled),
            ("Unlabeled 7", MarkerKind::Unlabelled),
        ];
        let markers = kinds.iter().zip(points).enumerate().map(|(m, (&(name, kind), points))| Marker {
            name: name.to_owned(),
            id: format!("M{m}"),
            kind,
            track: PointTrack::from_measured(points),
            quality: (m == 0).then(|| quality.clone()),
        }).collect();
        let bodies = [("Hand", BodyKind::RigidBody), ("Skeleton:Hip", BodyKind::Bone)];
        let bodies = bodies.into_iter().zip(poses).map(|((name, kind), poses)| TrackedBody {
            name: name.to_owned(),
            id: String::new(),
            kind,
            track: PoseTrack::from_measured(poses),
            marker_error_m: (name == "Hand").then(|| quality.clone()),
        }).collect();
        let clock = Clock::new(start, StartTime::AssumedUtc, rate_hz).expect("positive");
        Recording::new(name, clock, source(up_axis), quality.len(), markers, bodies).expect("one length")
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    /// Every value to the last bit, through text.
    #[test]
    fn motive_csv_keeps_every_value(recording in recording()) {
        let text = written(&recording);
        let read = inhand_capture::read(text.as_bytes(), "a.csv", &ReadSettings::default()).unwrap();
        assert_same(&read, &recording);
        assert_eq!(read.source.header["Take Notes"], "one, two");
        // What was written is what Motive would write: nothing in it is odd.
        assert!(read.findings.is_empty(), "{:?}", read.findings);
        // And written again it is the same text.
        assert_eq!(written(&read), text);
    }
}

#[test]
fn the_layout_is_that_of_motive() {
    let recording = super::text::Motive::new(
        [
            super::text::body("Hand"),
            super::text::marker_of("Rigid Body Marker", "Hand:Marker1", "B0"),
            super::text::marker("Ring, left"),
        ]
        .concat()
        .into_iter()
        .map(|column| column.map(|cell| cell.replace("Ring, left", "\"Ring, left\"")))
        .collect(),
        &["0,0,0,0,0,1,1,2,3,4,5,6,,,", "1,0.01,,,,,,,,4,5,6,7,8,9.5"],
    )
    .read()
    .unwrap();
    assert_eq!(
        written(&recording),
        "Format Version,1.23,Take Name,take,Take Notes,,Capture Frame Rate,100.000000,\
         Export Frame Rate,100.000000,Capture Start Time,2023-11-28 10.27.58.765 AM,\
         Total Frames in Take,2,Total Exported Frames,2,Rotation Type,Quaternion,\
         Length Units,Meters,Coordinate Space,Global\r\n\
         \r\n\
         ,Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,\
         Rigid Body Marker,Rigid Body Marker,Rigid Body Marker,Marker,Marker,Marker\r\n\
         ,Name,Hand,Hand,Hand,Hand,Hand,Hand,Hand,Hand:Marker1,Hand:Marker1,Hand:Marker1,\
         \"Ring, left\",\"Ring, left\",\"Ring, left\"\r\n\
         ,ID,B0,B0,B0,B0,B0,B0,B0,B0,B0,B0,M0,M0,M0\r\n\
         ,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,\
         Position,Position,Position,Position,Position,Position\r\n\
         Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,X,Y,Z,X,Y,Z\r\n\
         0,0.000000,0,0,0,1,1,2,3,4,5,6,,,\r\n\
         1,0.010000,,,,,,,,4,5,6,7,8,9.5\r\n"
    );
}

#[test]
fn a_take_without_start_time_has_none_after_the_trip() {
    let clock = Clock::new(0, StartTime::Unknown, 100.0).unwrap();
    let recording =
        Recording::new("a".to_owned(), clock, source(UpAxis::Y), 1, vec![], vec![]).unwrap();
    let text = written(&recording);
    let read = inhand_capture::read(text.as_bytes(), "a.csv", &ReadSettings::default()).unwrap();
    assert_eq!(read.clock, clock);
}
