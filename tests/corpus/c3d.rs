//! The C3D file of the corpus against what another reader found in it (`reference/c3d.py`), and
//! through every format that is written.

use inhand_capture::ReadSettings;
use inhand_model::{Position, Recording, UpAxis, World};
use serde_json::Value;

use crate::{corpus, inhand, ok, stderr, text};

const FILE: &str = "real/c3d/walkingOptiTrack.c3d";

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list");
    list.iter().map(|n| n.as_f64().expect("a number")).collect()
}

#[test]
fn points_are_where_another_reader_sees_them() {
    let Some(corpus) = corpus() else { return };
    let bytes = std::fs::read(corpus.join(FILE)).expect("it is there");
    let recording = inhand_capture::read(&bytes, "walkingOptiTrack.c3d", &ReadSettings::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let expected: Value = serde_json::from_str(include_str!("reference/c3d.json")).expect("JSON");
    assert_eq!(Some(recording.len() as u64), expected["frames"].as_u64());
    assert_eq!(
        Some(recording.clock.rate_hz()),
        expected["rate_hz"].as_f64()
    );
    // The file says Y_SCREEN = +Z.
    assert_eq!(recording.source.up_axis, UpAxis::Z);
    assert_eq!(recording.markers.len(), 12);
    for marker in &recording.markers {
        let of = &expected["markers"][&marker.name];
        let seen = marker.track.counts().measured as u64;
        assert_eq!(Some(seen), of["seen"].as_u64(), "{}", marker.name);
        for key in ["first", "middle", "last"] {
            let values = numbers(&of[key]);
            let found = marker
                .track
                .get(values[0] as usize)
                .expect("it is seen")
                .to_array();
            let off = found.iter().zip(&values[1..]).map(|(a, b)| (a - b).abs());
            // The other reader computes in single precision.
            assert!(
                off.fold(0.0, f64::max) < 1e-7,
                "{} {key}: {found:?} {values:?}",
                marker.name
            );
        }
    }
    assert!(
        recording
            .markers
            .iter()
            .any(|m| m.track.get(2353).is_some())
    );
}

/// A position of a world whose other axis points up, turned so that Z does, exactly.
fn z_up(position: Position<World>, up: UpAxis) -> Position<World> {
    let [x, y, z] = position.to_array();
    match up {
        UpAxis::Y => Position::from([x, -z, y]),
        UpAxis::Z => position,
    }
}

/// In metres, upright; the second one's Z is up.
fn largest_difference(a: &Recording, b: &Recording) -> f64 {
    assert_eq!((a.len(), a.markers.len()), (b.len(), b.markers.len()));
    assert_eq!(a.clock.rate_hz(), b.clock.rate_hz());
    let up = a.source.up_axis;
    let of_markers = a.markers.iter().zip(&b.markers).map(|(a, b)| {
        assert_eq!(a.name, b.name);
        assert_eq!(a.track.statuses(), b.track.statuses(), "{}", a.name);
        let both = a.track.iter().flatten().zip(b.track.iter().flatten());
        let off = both.map(|(a, b)| Position::distance_m(z_up(a, up), b));
        off.fold(0.0, f64::max)
    });
    of_markers.fold(0.0, f64::max)
}

#[test]
fn a_take_goes_through_mcap_to_trc_and_c3d_and_back() {
    let Some(corpus) = corpus() else { return };
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let path = |name: &str| folder.path().join(name);
    let mcap = path("take.mcap");
    ok(&["convert", text(&corpus.join(FILE)), "-o", text(&mcap)]);
    let read = |file: &std::path::Path| {
        let bytes = std::fs::read(file).expect("it is there");
        let name = text(file);
        inhand_capture::read(&bytes, name, &ReadSettings::default())
            .unwrap_or_else(|error| panic!("{error}"))
    };
    let original = read(&corpus.join(FILE));
    let z = UpAxis::Z;
    assert_eq!(original.source.up_axis, z);
    for (name, limit_m, up) in [("take.trc", 0.0, UpAxis::Y), ("take.c3d", 1e-7, z)] {
        let output = inhand(&["convert", text(&mcap), "-o", text(&path(name))]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let found = read(&path(name));
        assert_eq!(found.source.up_axis, up, "{name}");
        let off_m = largest_difference(&found, &original);
        assert!(off_m <= limit_m, "{name}: {off_m}");
    }
}
