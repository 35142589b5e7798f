//! The public interface.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod boundary;
mod clusters;
mod object;
mod process;
mod reference;
mod segments;
mod spectrum;

use inhand_model::{
    BodyKind, BodySource, Clock, Finger, LengthUnit, Marker, MarkerKind, PerFinger, Pose, Position,
    Recording, Roles, Source, StartTime, Track, TrackedBody, UpAxis, World,
};
use inhand_motion::{Filter, GapFill, ProcessSettings};
use nalgebra::{Isometry3, Vector3};

fn source() -> Source {
    Source {
        format: "test".into(),
        length_unit: LengthUnit::Metres,
        up_axis: UpAxis::Y,
        rotation: None,
        header: Default::default(),
    }
}

fn marker(name: &str, track: impl IntoIterator<Item = Option<[f64; 3]>>) -> Marker {
    Marker {
        name: name.into(),
        id: String::new(),
        kind: MarkerKind::Labelled,
        track: Track::from_measured(track.into_iter().map(|p| p.map(Position::<World>::from))),
        quality: None,
    }
}

fn body(name: &str, track: impl IntoIterator<Item = Option<Isometry3<f64>>>) -> TrackedBody {
    TrackedBody {
        name: name.into(),
        id: String::new(),
        kind: BodyKind::RigidBody,
        track: Track::from_measured(track.into_iter().map(|p| p.map(Pose::new))),
        marker_error_m: None,
    }
}

fn recording(rate_hz: f64, markers: Vec<Marker>, bodies: Vec<TrackedBody>) -> Recording {
    let clock = Clock::new(0, StartTime::Unknown, rate_hz).unwrap();
    let samples = markers[0].track.len();
    Recording::new("take".into(), clock, source(), samples, markers, bodies).unwrap()
}

fn roles(hand: BodySource, object: Option<BodySource>) -> Roles {
    Roles {
        hand,
        object,
        fingers: PerFinger::from_fn(|finger| finger.to_string()),
    }
}

fn rigid_body(name: &str) -> BodySource {
    BodySource::RigidBody(name.into())
}

fn cluster(names: &[&str]) -> BodySource {
    BodySource::Markers(names.iter().map(ToString::to_string).collect())
}

/// Nothing filled, nothing filtered.
const PLAIN: ProcessSettings = ProcessSettings {
    max_gap_s: 0.0,
    fill: GapFill::None,
    filter: Filter::None,
    object_offset_m: [0.0; 3],
};

/// A take of `samples` samples whose hand rests at the origin and whose fingertips go along
/// `(k, k², finger)` millimetres, missing where `seen` says so.
fn resting_hand(samples: usize, seen: impl Fn(Finger, usize) -> bool) -> Recording {
    let tips = Finger::ALL.map(|finger| {
        let seen = &seen;
        marker(
            finger.name(),
            (0..samples).map(move |k| seen(finger, k).then(|| tip_m(finger, k as f64))),
        )
    });
    let hand = body("Hand", (0..samples).map(|_| Some(Isometry3::identity())));
    recording(100.0, tips.into(), vec![hand])
}

fn tip_m(finger: Finger, k: f64) -> [f64; 3] {
    [1e-3 * k, 1e-3 * k * k, 1e-3 * finger.index() as f64]
}

#[track_caller]
fn assert_near(found: Position<impl inhand_model::Frame>, expected: [f64; 3], tolerance_m: f64) {
    let distance = (found.coords_m() - Vector3::from(expected)).norm();
    assert!(
        distance <= tolerance_m,
        "{found:?}, expected {expected:?}: {distance:e} m apart"
    );
}
