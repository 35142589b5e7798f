//! A small recording with everything that tables have to carry.

use inhand_model::{
    BodyKind, Clock, LengthUnit, Marker, MarkerKind, PointTrack, Pose, PoseTrack, Position,
    Recording, RotationOrder, Source, StartTime, Status, TrackedBody, UpAxis,
};
use nalgebra::{Isometry3, Vector3};

pub(crate) const START: u64 = 1_700_000_000_123_456_789;

pub(crate) fn recording(samples: usize, rate_hz: f64) -> Recording {
    let wave = |k: usize, c: usize| (0.1 * k as f64 + c as f64).sin() / 3.0;
    let point = |k: usize| Position::new(wave(k, 0), wave(k, 1), wave(k, 2));
    let marker = |name: &str, kind, quality: bool| {
        let mut track = PointTrack::missing(0);
        for k in 0..samples {
            match k % 7 {
                3 => track.push(None, Status::Missing),
                4 => track.push(Some(point(k)), Status::Filled),
                _ => track.push(Some(point(k + name.len())), Status::Measured),
            }
        }
        let series = |k| {
            if k % 3 == 0 {
                f64::NAN
            } else {
                wave(k, 5).abs()
            }
        };
        Marker {
            name: name.to_owned(),
            id: format!("id of {name}"),
            kind,
            track,
            quality: quality.then(|| (0..samples).map(series).collect()),
        }
    };
    let pose = |k: usize| {
        let turn = Vector3::new(wave(k, 3), wave(k, 4), 2.0);
        Pose::new(Isometry3::new(Vector3::new(wave(k, 0), 1e-9, -0.0), turn))
    };
    let mut track = PoseTrack::missing(0);
    for k in 0..samples {
        let present = k % 5 != 2;
        track.push(
            present.then(|| pose(k)),
            if present {
                Status::Measured
            } else {
                Status::Missing
            },
        );
    }
    let body = TrackedBody {
        name: "Hand, \"left\"".to_owned(),
        id: "7".to_owned(),
        kind: BodyKind::RigidBody,
        track: track.clone(),
        marker_error_m: Some((0..samples).map(|k| 1e-4 * wave(k, 6).abs()).collect()),
    };
    let bone = TrackedBody {
        name: "thumb.tip".to_owned(),
        id: String::new(),
        kind: BodyKind::Bone,
        track,
        marker_error_m: None,
    };
    let source = Source {
        format: "Motive CSV 1.23".to_owned(),
        length_unit: LengthUnit::Millimetres,
        up_axis: UpAxis::Z,
        rotation: Some(RotationOrder::Euler([0, 2, 1])),
        header: [("Take Notes".to_owned(), "a, \"b\"\nc".to_owned())].into(),
    };
    let markers = vec![
        marker("Thumb", MarkerKind::Labelled, true),
        marker("Thumb", MarkerKind::RigidBodyMarker, false),
        marker("Thumb#2", MarkerKind::Unlabelled, false),
    ];
    let clock = Clock::new(START, StartTime::Stated, rate_hz).unwrap();
    let name = "Take 1".to_owned();
    Recording::new(name, clock, source, samples, markers, vec![body, bone]).unwrap()
}
