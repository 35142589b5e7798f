//! Small takes with known content.

use inhand_inspection::{CheckResult, CheckSettings, Checkup, Level, check};
use inhand_model::{
    Body, BodyKind, BodySource, Clock, Finger, LengthUnit, Marker, MarkerKind, PerFinger, Pose,
    PoseTrack, Position, Recording, Roles, RotationOrder, Source, StartTime, Status, Track,
    TrackedBody, UpAxis, World,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

pub(crate) const RATE_HZ: f64 = 100.0;

/// Where the markers of a body are, in its frame, metres.
pub(crate) const PLATE_M: [[f64; 3]; 3] =
    [[0.04, 0.0, 0.0], [-0.02, 0.03, 0.0], [-0.01, -0.03, 0.01]];

/// Fingertips in the frame of the hand, metres.
pub(crate) const TIPS_M: [[f64; 3]; 5] = [
    [-0.05, 0.05, 0.03],
    [-0.03, 0.11, 0.03],
    [0.0, 0.12, 0.03],
    [0.02, 0.11, 0.03],
    [0.04, 0.09, 0.03],
];

/// A hand that moves and turns about all axes, with a wobble in every sample so that no two are
/// alike.
pub(crate) fn hand_pose(k: usize) -> Isometry3<f64> {
    let t = k as f64 / RATE_HZ;
    let turn = Vector3::new(
        0.6 * (0.9 * t).sin(),
        0.8 * (0.7 * t).sin(),
        0.5 * (1.3 * t).sin(),
    );
    let place = Vector3::new(
        0.2 * (0.5 * t).sin(),
        1.0 + 0.1 * (0.8 * t).cos(),
        0.15 * (0.6 * t).sin(),
    );
    Isometry3::from_parts(
        Translation3::from(place),
        UnitQuaternion::from_scaled_axis(turn),
    )
}

/// A marker from its positions.
pub(crate) fn marker(
    name: &str,
    kind: MarkerKind,
    samples: usize,
    place_m: impl Fn(usize) -> Vector3<f64>,
) -> Marker {
    Marker {
        name: name.to_owned(),
        id: String::new(),
        kind,
        track: Track::from_measured((0..samples).map(|k| Some(Position::from_coords(place_m(k))))),
        quality: None,
    }
}

/// A body from its poses.
pub(crate) fn body(
    name: &str,
    samples: usize,
    pose: impl Fn(usize) -> Isometry3<f64>,
) -> TrackedBody {
    let track: PoseTrack<World, Body> =
        Track::from_measured((0..samples).map(|k| Some(Pose::new(pose(k)))));
    TrackedBody {
        name: name.to_owned(),
        id: String::new(),
        kind: BodyKind::RigidBody,
        track,
        marker_error_m: None,
    }
}

pub(crate) fn source() -> Source {
    Source {
        format: "test".into(),
        length_unit: LengthUnit::Metres,
        up_axis: UpAxis::Y,
        rotation: Some(RotationOrder::Quaternion),
        header: std::collections::BTreeMap::new(),
    }
}

pub(crate) fn recording(
    samples: usize,
    markers: Vec<Marker>,
    bodies: Vec<TrackedBody>,
) -> Recording {
    let clock = Clock::new(0, StartTime::Unknown, RATE_HZ).expect("the rate is one");
    Recording::new("take".into(), clock, source(), samples, markers, bodies)
        .expect("tracks have the take's length")
}

/// A hand with its markers and fingertips over ten seconds; nothing is wrong with it.
pub(crate) fn good_take() -> Recording {
    take_with(|k| hand_pose(k).rotation, |place| place)
}

/// The same, with the rotations that the file writes for the true ones, and with every position
/// changed after that.
pub(crate) fn take_with(
    rotation: impl Fn(usize) -> UnitQuaternion<f64>,
    position: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> Recording {
    let samples = 1000;
    let at = |k: usize, local: [f64; 3]| {
        let place = hand_pose(k) * nalgebra::Point3::from(local);
        position(place.coords)
    };
    let mut markers: Vec<_> = (PLATE_M.iter().enumerate())
        .map(|(i, &local)| {
            let name = format!("Hand:Marker{}", i + 1);
            marker(&name, MarkerKind::RigidBodyMarker, samples, |k| {
                at(k, local)
            })
        })
        .collect();
    for finger in Finger::ALL {
        let [x, y, z] = TIPS_M[finger.index()];
        markers.push(marker(finger.name(), MarkerKind::Labelled, samples, |k| {
            at(k, [x, y + 0.01 * (0.05 * k as f64).sin(), z])
        }));
    }
    let hand = body("Hand", samples, |k| {
        let place = position(hand_pose(k).translation.vector);
        Isometry3::from_parts(Translation3::from(place), rotation(k))
    });
    recording(samples, markers, vec![hand])
}

pub(crate) fn roles() -> Roles {
    Roles {
        hand: BodySource::RigidBody("Hand".into()),
        object: None,
        fingers: PerFinger::from_fn(|finger| finger.name().to_owned()),
    }
}

pub(crate) fn checked(take: &Recording) -> Checkup {
    check(take, Ok(&roles()), &[], &CheckSettings::default())
}

/// The result of an id about an entity.
pub(crate) fn result<'a>(checkup: &'a Checkup, id: &str, entity: &str) -> &'a CheckResult {
    let mut results = checkup.results.iter();
    results
        .find(|result| result.id == id && result.entity == entity)
        .unwrap_or_else(|| panic!("no {id} of {entity:?} among {:#?}", checkup.results))
}

/// Identifiers of what is worse than worth knowing.
pub(crate) fn complaints(checkup: &Checkup) -> Vec<&str> {
    let odd = checkup
        .results
        .iter()
        .filter(|result| result.level >= Level::Warn);
    odd.map(|result| result.id).collect()
}

/// The number of a name.
pub(crate) fn number(result: &CheckResult, name: &str) -> f64 {
    let mut numbers = result.numbers.iter();
    let found = numbers.find(|number| number.name == name);
    found
        .unwrap_or_else(|| panic!("no {name} in {result:#?}"))
        .value
}

/// Takes samples of a marker away.
pub(crate) fn hide(take: &mut Recording, name: &str, samples: std::ops::Range<usize>) {
    let marker = take.markers.iter_mut().find(|m| m.name == name);
    let marker = marker.expect("the take has the marker");
    for k in samples {
        marker.track.set(k, None, Status::Missing);
    }
}
