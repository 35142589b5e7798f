//! Units, axes and rotations against what the data says.

use inhand_inspection::{CheckSettings, Level, check};
use inhand_model::{BodySource, LengthUnit, Recording, Roles, RotationOrder, UpAxis};
use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::support::{
    RATE_HZ, body, checked, complaints, good_take, hand_pose, number, result, roles, take_with,
};

#[test]
fn the_right_file_passes() {
    let checkup = checked(&good_take());
    assert_eq!(complaints(&checkup), Vec::<&str>::new());
    assert_eq!(result(&checkup, "axes", "Hand").level, Level::Ok);
    let units = result(&checkup, "units", "");
    assert_eq!(units.level, Level::Ok);
    // The middle finger is the furthest: |(0, 0.12 +- 0.01, 0.03)| in the middle of its swing.
    let expected_mm = 1e3 * (0.12_f64 * 0.12 + 0.03 * 0.03).sqrt();
    assert!(
        (number(units, "hand_mm") - expected_mm).abs() < 1.0,
        "{units:?}"
    );
}

/// Takes whose numbers are in one unit and whose header states another.
#[test]
fn a_wrong_unit_is_found_and_the_right_one_named() {
    use LengthUnit::{Centimetres, Inches, Metres, Millimetres};
    let cases = [
        (Millimetres, Metres),
        (Metres, Millimetres),
        (Centimetres, Metres),
        (Metres, Centimetres),
        (Millimetres, Centimetres),
        (Centimetres, Millimetres),
        (Millimetres, Inches),
        (Inches, Millimetres),
        (Centimetres, Inches),
        (Inches, Centimetres),
        (Inches, Metres),
    ];
    for (truth, stated) in cases {
        let factor = stated.metres() / truth.metres();
        let mut take = take_with(|k| hand_pose(k).rotation, |place| place * factor);
        take.source.length_unit = stated;
        let checkup = checked(&take);
        let units = result(&checkup, "units", "");
        assert_eq!(units.level, Level::Warn, "{truth:?} stated as {stated:?}");
        let words = format!("in {}", truth.name());
        assert!(
            units.found.ends_with(&words),
            "{truth:?} as {stated:?}: {}",
            units.found
        );
        assert!(
            (number(units, "hand_then_mm") - 123.7).abs() < 1.0,
            "{units:?}"
        );
    }
}

#[test]
fn hands_of_all_sizes_pass() {
    for factor in [0.55, 0.8, 1.0, 1.3, 1.9] {
        let take = take_with(|k| hand_pose(k).rotation, |place| place * factor);
        let checkup = checked(&take);
        assert_eq!(result(&checkup, "units", "").level, Level::Ok, "{factor}");
    }
}

#[test]
fn one_far_finger_is_named() {
    let mut take = good_take();
    let marker = take
        .markers
        .iter_mut()
        .find(|m| m.name == "little")
        .unwrap();
    marker.track = marker
        .track
        .map(|p| inhand_model::Position::from_coords(p.coords_m() + Vector3::new(0.0, 0.0, 0.7)));
    let checkup = checked(&take);
    assert_eq!(complaints(&checkup), ["finger-place"]);
    let far = result(&checkup, "finger-place", "little");
    // The finger is nowhere nearer to the back of the hand than its 0.7 m less its reach.
    assert!(
        (600.0..850.0).contains(&number(far, "distance_mm")),
        "{far:?}"
    );
    assert_eq!(result(&checkup, "units", "").level, Level::Ok);
}

/// What the axes check says of rotations and positions written another way.
fn axes_of(take: &Recording) -> (Level, String) {
    let checkup = checked(take);
    let axes = result(&checkup, "axes", "Hand");
    (axes.level, axes.found.clone())
}

#[test]
fn rotations_written_another_way_are_found() {
    let inverse = take_with(|k| hand_pose(k).rotation.inverse(), |place| place);
    let (level, found) = axes_of(&inverse);
    assert_eq!(level, Level::Warn);
    assert!(found.contains("rotations are the opposite ones"), "{found}");

    // Written w, x, y, z and read as x, y, z, w.
    let scalar_first = |k: usize| {
        let q = hand_pose(k).rotation;
        UnitQuaternion::new_unchecked(Quaternion::new(q.k, q.w, q.i, q.j))
    };
    let (level, found) = axes_of(&take_with(scalar_first, |place| place));
    assert_eq!(level, Level::Warn);
    assert!(found.contains("w comes before x, y and z"), "{found}");
}

#[test]
fn positions_in_other_axes_than_rotations_are_found() {
    type Change = fn(Vector3<f64>) -> Vector3<f64>;
    // What turns the positions back, in words.
    let cases: [(Change, &str); 5] = [
        (|p| Vector3::new(-p.x, p.y, p.z), "axes (-x, y, z)"),
        (|p| Vector3::new(p.x, p.y, -p.z), "axes (x, y, -z)"),
        (|p| Vector3::new(p.x, p.z, p.y), "axes (x, z, y)"),
        (|p| Vector3::new(p.x, -p.z, p.y), "axes (x, z, -y)"),
        (|p| Vector3::new(p.y, p.z, p.x), "axes (z, x, y)"),
    ];
    for (change, words) in cases {
        let (level, found) = axes_of(&take_with(|k| hand_pose(k).rotation, change));
        assert_eq!(level, Level::Warn, "{words}");
        assert!(found.contains(words), "{words}: {found}");
    }
}

#[test]
fn every_wrong_euler_order_is_found_and_the_right_one_named() {
    let orders: [[u8; 3]; 6] = [
        [0, 1, 2],
        [0, 2, 1],
        [1, 0, 2],
        [1, 2, 0],
        [2, 0, 1],
        [2, 1, 0],
    ];
    let about = |axis: u8, angle: f64| {
        let mut turn = Vector3::zeros();
        turn[usize::from(axis)] = angle;
        UnitQuaternion::from_scaled_axis(turn)
    };
    for written in orders {
        for read in orders {
            // The angles about x, y and z are the same; the file is read in another order, and what
            // the camera system meant is the order it was written in.
            let angles = |k: usize| {
                let t = k as f64 / RATE_HZ;
                [
                    0.6 * (0.9 * t).sin(),
                    0.5 * (0.7 * t).sin(),
                    0.7 * (1.3 * t).cos(),
                ]
            };
            let product = |k: usize, order: [u8; 3]| {
                let [a, b, c] = order.map(|axis| about(axis, angles(k)[usize::from(axis)]));
                a * b * c
            };
            // Markers stay in place on the body as it was: the take turns by `written` where the
            // hand of other tests turns by its own rotation.
            let mut take = take_with(|k| hand_pose(k).rotation, |place| place);
            for k in 0..take.len() {
                let place = hand_pose(k).translation;
                let truth = Isometry3::from_parts(place, product(k, written));
                let back = truth * hand_pose(k).inverse();
                for marker in &mut take.markers {
                    let seen = marker.track.get(k).map(|p| back * p.point());
                    marker.track.set(
                        k,
                        seen.map(inhand_model::Position::from_point),
                        inhand_model::Status::Measured,
                    );
                }
                let pose = Isometry3::from_parts(place, product(k, read));
                take.bodies[0].track.set(
                    k,
                    Some(inhand_model::Pose::new(pose)),
                    inhand_model::Status::Measured,
                );
            }
            take.source.rotation = Some(RotationOrder::Euler(read));
            let (level, found) = axes_of(&take);
            if written == read {
                assert_eq!(level, Level::Ok, "{written:?}: {found}");
            } else {
                assert_eq!(level, Level::Warn, "{written:?} read as {read:?}");
                let words = format!("in the order {}", RotationOrder::Euler(written));
                assert!(
                    found.contains(&words),
                    "{written:?} read as {read:?}: {found}"
                );
            }
        }
    }
}

#[test]
fn markers_of_another_take_are_not_explained_away() {
    let wrong = |k: usize| {
        UnitQuaternion::from_scaled_axis(Vector3::new(1.1 * (0.37 * k as f64).sin(), 0.0, 0.9))
    };
    let (level, found) = axes_of(&take_with(wrong, |place| place));
    assert_eq!(level, Level::Warn);
    assert!(found.contains("under any convention known"), "{found}");
}

#[test]
fn a_body_that_hardly_turns_proves_nothing() {
    let small =
        |k: usize| UnitQuaternion::from_scaled_axis(hand_pose(k).rotation.scaled_axis() * 0.05);
    let mut take = take_with(small, |place| place);
    for k in 0..take.len() {
        let still = Isometry3::from_parts(hand_pose(k).translation, small(k));
        for (marker, local) in take.markers.iter_mut().zip(crate::support::PLATE_M) {
            let seen = still * nalgebra::Point3::from(local);
            marker.track.set(
                k,
                Some(inhand_model::Position::from_point(seen)),
                inhand_model::Status::Measured,
            );
        }
    }
    let (level, found) = axes_of(&take);
    assert_eq!(level, Level::Info);
    assert!(found.starts_with("no evidence"), "{found}");
}

/// An object that lies on a table at (0, h, 0), is lifted and carried about, and is laid down again
/// elsewhere, while the hand keeps moving. Up is the world axis `up`.
fn lifted(up: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Recording {
    let mut take = take_with(|k| hand_pose(k).rotation, &up);
    let object = body("Object", take.len(), |k| {
        let t = k as f64 / RATE_HZ;
        let noise = 1e-4 * (1.7 * k as f64).sin();
        let carried = ((t - 2.0) / 5.0).clamp(0.0, 1.0) * std::f64::consts::TAU;
        let place = Vector3::new(
            0.1 * carried.sin() + noise,
            0.8 + 0.15 * (0.5 * carried).sin() + noise,
            0.12 * (2.0 * carried).sin() + noise,
        );
        Isometry3::from(up(place))
    });
    take.bodies.push(object);
    take
}

fn with_object(take: &Recording) -> inhand_inspection::Checkup {
    let roles = Roles {
        object: Some(BodySource::RigidBody("Object".into())),
        ..roles()
    };
    check(take, Ok(&roles), &[], &CheckSettings::default())
}

#[test]
fn up_is_where_resting_things_are_lifted_to() {
    let right = with_object(&lifted(|p| p));
    let up = result(&right, "up-axis", "");
    assert_eq!(
        (up.level, up.found.starts_with("+y is up")),
        (Level::Ok, true),
        "{up:?}"
    );
    assert!((number(up, "lift_mm") - 150.0).abs() < 1.0, "{up:?}");
    assert_eq!(number(up, "rests"), 2.0);

    type Change = fn(Vector3<f64>) -> Vector3<f64>;
    let cases: [(Change, &str); 4] = [
        (|p| Vector3::new(p.x, -p.z, p.y), "+z looks like up"),
        (|p| Vector3::new(p.y, p.z, p.x), "+x looks like up"),
        (|p| Vector3::new(p.x, -p.y, -p.z), "-y looks like up"),
        (|p| Vector3::new(p.x, p.z, -p.y), "-z looks like up"),
    ];
    for (change, words) in cases {
        let checkup = with_object(&lifted(change));
        let up = result(&checkup, "up-axis", "");
        assert_eq!(up.level, Level::Warn, "{words}");
        assert!(up.found.starts_with(words), "{words}: {}", up.found);
    }
    // The same with z up is right where the file says so.
    let mut z_up = lifted(|p| Vector3::new(p.x, -p.z, p.y));
    z_up.source.up_axis = UpAxis::Z;
    assert_eq!(result(&with_object(&z_up), "up-axis", "").level, Level::Ok);
}

#[test]
fn an_object_in_the_hand_says_nothing_about_up() {
    let mut take = good_take();
    take.bodies.push(body("Object", take.len(), |k| {
        hand_pose(k) * Isometry3::translation(0.0, 0.1, 0.05)
    }));
    let checkup = with_object(&take);
    let up = result(&checkup, "up-axis", "");
    assert_eq!(up.level, Level::Info);
    assert!(up.found.starts_with("no evidence"), "{}", up.found);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Another world frame changes nothing: what is measured are distances and relative poses.
    #[test]
    fn a_turned_world_changes_no_verdict(turn in prop::array::uniform3(-3.0..3.0_f64), shift in prop::array::uniform3(-5.0..5.0_f64)) {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
        let shift = Vector3::from(shift);
        let take = take_with(|k| turn * hand_pose(k).rotation, |place| turn * place + shift);
        let checkup = checked(&take);
        prop_assert_eq!(complaints(&checkup), Vec::<&str>::new());
    }
}
