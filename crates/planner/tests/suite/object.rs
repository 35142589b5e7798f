//! The object in targets and plans, and fingers that hold it.

use inhand_contact::FingerOffsets;
use inhand_model::{
    EndConditions, Finger, Hand, Object, ObjectEnds, PlanStatus, Pose, Position, SegmentLayout,
    Shape, SmoothCurve, object_coordinates_m,
};
use inhand_planner::{
    Ends, PlanError, Planner, PlannerSettings, Target, held_fingers, object_between,
};
use nalgebra::{Isometry3, Vector3};

use crate::support::{bounds, residual, settings};

fn object() -> ObjectEnds {
    ObjectEnds {
        first: Pose::new(Isometry3::new(
            Vector3::new(0.09, -0.02, 0.01),
            Vector3::new(0.3, -0.5, 1.1),
        )),
        last: Pose::new(Isometry3::new(
            Vector3::new(0.08, -0.01, 0.02),
            Vector3::new(0.9, -0.2, 1.4),
        )),
    }
}

fn given() -> EndConditions {
    EndConditions {
        first_m: [0.01; 15],
        last_m: [0.02; 15],
        first_velocity_m_s: [0.0; 15],
        last_velocity_m_s: [0.0; 15],
        object: Some(object()),
    }
}

fn hard() -> PlannerSettings {
    PlannerSettings {
        ends: Ends::Hard,
        ..settings(bounds(100.0))
    }
}

#[test]
fn planned_objects_go_from_start_to_goal() {
    let residual = residual(25, 12, true);
    let planner = Planner::residual(&residual, &hard()).unwrap();
    let plan = planner.plan(&Target::from(given())).unwrap();
    assert_eq!(plan.status, PlanStatus::Solved);
    assert_eq!(plan.object.len(), 25);
    // Expected rows: the smooth curve plus what is expected of the deviation.
    let x = given().to_vector(residual.layout).unwrap();
    let rows = SmoothCurve::Hermite.basis(residual.layout) * &x
        + &residual.primitives * residual.expected_m(&x);
    for (t, &pose) in plan.object.iter().enumerate() {
        let found = object_coordinates_m(object().first, pose);
        for (coordinate, value) in found.iter().enumerate() {
            let row = residual.layout.object_row(t, coordinate);
            assert!((value - rows[row]).abs() < 1e-12, "{t} {coordinate}");
        }
    }
    for (pose, wanted) in [
        (plan.object[0], object().first),
        (plan.object[24], object().last),
    ] {
        assert!(pose.origin().distance_m(wanted.origin()) < 1e-12);
        let turned = pose
            .isometry()
            .rotation
            .angle_to(&wanted.isometry().rotation);
        assert!(turned < 1e-7, "{turned}");
    }
}

#[test]
fn position_and_rotation_have_their_own_weights() {
    let residual = residual(25, 12, true);
    let miss = |settings: &PlannerSettings| {
        let planner = Planner::residual(&residual, settings).unwrap();
        let target = Target::new()
            .object_first(object().first)
            .object_last(object().last);
        let plan = planner.plan(&target).unwrap();
        assert_eq!(plan.status, PlanStatus::Solved);
        let (pose, wanted) = (plan.object[24].isometry(), object().last.isometry());
        (
            (pose.translation.vector - wanted.translation.vector).norm(),
            pose.rotation.angle_to(&wanted.rotation),
        )
    };
    let soft = settings(bounds(100.0));
    let (position, rotation) = miss(&soft);
    let (near, turned) = miss(&PlannerSettings {
        object_sigma_m: 1e-6,
        object_sigma_rad: 0.2,
        ..soft.clone()
    });
    assert!(near < position / 10.0 && turned > rotation * 10.0);
    let (far, aligned) = miss(&PlannerSettings {
        object_sigma_m: 1e-2,
        object_sigma_rad: 1e-4,
        ..soft
    });
    assert!(far > position * 10.0 && aligned < rotation / 10.0);
}

#[test]
fn objects_that_segments_do_not_carry() {
    let without = residual(10, 3, false);
    let planner = Planner::residual(&without, &hard()).unwrap();
    // End conditions may have one; what was asked for must be there.
    let plan = planner.plan(&Target::from(given())).unwrap();
    assert!(plan.status == PlanStatus::Solved && plan.object.is_empty());
    let target = Target::new().last([0.01; 15]).object_first(object().first);
    let error = planner.plan(&target).unwrap_err().to_string();
    assert!(error.contains("which is not in these segments"), "{error}");
    let planner = Planner::residual(&residual(10, 3, true), &hard()).unwrap();
    let target = Target::new().object_last(object().last);
    let error = planner.plan(&target).unwrap_err().to_string();
    assert!(error.contains("last pose and not its first"), "{error}");
    let nowhere = Pose::new(Isometry3::translation(83.5, 0.0, 0.0));
    let error = planner
        .plan(&Target::new().object_first(nowhere))
        .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("first pose of the object holds 83.5"),
        "{error}"
    );
}

#[test]
fn fingers_that_touch_at_both_ends_hold() {
    let cube = Shape::Cuboid { edges_m: [0.05; 3] };
    let offsets = FingerOffsets::default();
    let object = object();
    // Thumb, index, middle on faces; ring slides, little never touches.
    let on = [
        [0.0, -0.027, 0.0],
        [0.0, 0.026, 0.01],
        [0.0, 0.026, -0.01],
        [0.01, 0.0, 0.025],
        [0.0, 0.0, 0.06],
    ];
    let place = |pose: Pose<Hand, Object>, slide: f64| -> [f64; 15] {
        let mut configuration = [0.0; 15];
        for (finger, [x, y, z]) in Finger::ALL.into_iter().zip(on) {
            let slide = if finger == Finger::Ring { slide } else { 0.0 };
            let tip = pose * Position::<Object>::new(x - slide, y, z);
            let at = SegmentLayout::row(0, finger, 0);
            configuration[at..at + 3].copy_from_slice(&tip.to_array());
        }
        configuration
    };
    let held = |tau_m, slide| {
        let (first, last) = (place(object.first, 0.0), place(object.last, slide));
        held_fingers(&cube, &offsets, tau_m, &first, &last, &object)
    };
    let contacts = held(0.005, 0.03).unwrap();
    for (finger, contact) in contacts.iter() {
        let holds = matches!(finger, Finger::Thumb | Finger::Index | Finger::Middle);
        assert_eq!(contact.is_some(), holds, "{finger}");
    }
    let index = contacts[Finger::Index].unwrap();
    assert!(index.distance_m(Position::new(0.0, 0.026, 0.01)) < 1e-12);
    // A little sliding is none: the contact point is in the middle.
    let ring = held(0.005, 0.004).unwrap()[Finger::Ring].unwrap();
    assert!(ring.distance_m(Position::new(0.008, 0.0, 0.025)) < 1e-12);
    let error = held(0.0015, 0.03).unwrap_err();
    let message = error.to_string();
    assert!(matches!(error, PlanError::TooFewHold(_)), "{message}");
    assert!(
        message.contains("2 fingers hold") && message.contains("3 are needed"),
        "{message}"
    );
    assert!(message.contains("thumb 0.0020 and 0.0020 m"), "{message}");
}

#[test]
fn objects_between_poses_move_and_turn_evenly() {
    let poses = object_between(&object(), 11);
    assert_eq!(
        (poses[0].origin(), poses[10]),
        (object().first.origin(), object().last)
    );
    let step = |t: usize| {
        let (a, b) = (poses[t].isometry(), poses[t + 1].isometry());
        let way = (b.translation.vector - a.translation.vector).norm();
        (way, a.rotation.angle_to(&b.rotation))
    };
    for t in 1..10 {
        assert!((step(t).0 - step(0).0).abs() < 1e-15);
        assert!((step(t).1 - step(0).1).abs() < 1e-12);
    }
    assert_eq!(object_between(&object(), 1).len(), 1);
}
