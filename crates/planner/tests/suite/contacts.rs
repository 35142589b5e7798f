//! Fingertips that keep apart, and fingers that hold: constraints that are not linear.

use inhand_model::{
    ConstraintFamily, Dictionary, EndConditions, Finger, Hand, Object, PerFinger, PlanStatus, Pose,
    Position,
};
use inhand_planner::{Constraints, Ends, Holding, Method, Planner, PlannerSettings, Target};
use nalgebra::{DVector, Isometry3, Vector3};

use crate::families::{check, only, place, plain, prior};
use crate::plain::{Answer, Gaussian};
use crate::support::{ends, free};

/// Thumb and index pass each other at a few mm, the others are far off.
fn passing(offset_m: f64) -> (Dictionary, EndConditions) {
    let dictionary = free(15, 15.0, |c| 0.05 * (c / 3) as f64);
    let mut given = EndConditions {
        first_m: std::array::from_fn(|c| 0.05 * (c / 3) as f64),
        last_m: std::array::from_fn(|c| 0.05 * (c / 3) as f64),
        first_velocity_m_s: [0.0; 15],
        last_velocity_m_s: [0.0; 15],
        object: None,
    };
    given.first_m[..6].copy_from_slice(&[-0.02, 0.0, 0.0, 0.02, offset_m, 0.0]);
    given.last_m[..6].copy_from_slice(&[0.02, 0.0, 0.0, -0.02, offset_m, 0.0]);
    (dictionary, given)
}

fn apart(least_m: f64) -> PlannerSettings {
    only(Constraints {
        separation_m: Some(least_m),
        ..Constraints::default()
    })
}

#[test]
fn fingertips_keep_apart_and_pass_each_other() {
    for (offset_m, least_m) in [(0.003, 0.001), (0.003, 0.012), (-0.001, 0.02)] {
        let (dictionary, given) = passing(offset_m);
        let target = Method::Prior.target(&given);
        let planner = prior(&dictionary, &apart(least_m));
        let plan = planner.plan(&target).unwrap();
        assert_eq!(plan.status, PlanStatus::Solved, "{:?}", plan.certificate);
        assert!(plan.certificate.worst() <= 1e-6);
        let trajectory = plan.trajectory.as_ref().unwrap();
        let away = |t, a, b| {
            let (a, b) = (trajectory.position(t, a), trajectory.position(t, b));
            a.coords_m() - b.coords_m()
        };
        // With all pairs and instants kept apart in the plan's own directions, no motion is better:
        // a first-order optimum of the problem that is not convex.
        let gaussian = Gaussian::of_dictionary(&dictionary);
        let mut plain = plain(&gaussian, &given);
        let mut nearest = f64::INFINITY;
        for t in 0..15 {
            for (i, a) in Finger::ALL.into_iter().enumerate() {
                for b in Finger::ALL.into_iter().skip(i + 1) {
                    let between = away(t, a, b);
                    nearest = nearest.min(between.norm());
                    let n = between.normalize();
                    let n = DVector::from_column_slice(n.as_slice());
                    let (a, b) = (gaussian.tip(t, a), gaussian.tip(t, b));
                    let row = (&a.factors - &b.factors).transpose() * &n;
                    plain.at_least(row, least_m * 1e3 - n.dot(&(&a.base - &b.base)));
                }
            }
        }
        assert!(nearest >= least_m * (1.0 - 1e-6), "{nearest} {least_m}");
        let Answer::Solved(h) = plain.solve() else {
            panic!("the plan is a solution");
        };
        let reference = plain.objective(&h);
        let relative = (plan.objective - reference) / reference.abs().max(1.0);
        assert!(relative.abs() < 1e-5, "{} {reference}", plan.objective);
        let by = plan.checks.violation[ConstraintFamily::Separation].unwrap();
        assert!((by - (least_m - nearest)).abs() < 1e-12);
        assert_eq!(plan.checks.rows, 150);
        if least_m > 0.003 {
            assert!(plan.checks.active[ConstraintFamily::Separation] > 0);
        }
    }
}

#[test]
fn fingertips_that_coincide_are_parted_and_exact_distances_are_kept() {
    // Thumb and index in one place all the time.
    let dictionary = free(6, 10.0, |c| if c < 6 { 0.0 } else { 0.05 * (c / 3) as f64 });
    let planner = prior(&dictionary, &apart(0.01));
    let target = Target::new().first(place(0.0)).last(place(0.0));
    let plan = planner.plan(&target).unwrap();
    assert_eq!(plan.status, PlanStatus::Solved, "{:?}", plan.certificate);
    assert_eq!(planner.plan(&target).unwrap(), plan);
    let trajectory = plan.trajectory.unwrap();
    for t in 0..6 {
        let (a, b) = (Finger::Thumb, Finger::Index);
        let distance_m = trajectory
            .position(t, a)
            .distance_m(trajectory.position(t, b));
        assert!(distance_m >= 0.01 * (1.0 - 1e-6), "{distance_m}");
    }
    // At exactly the distance, nothing is to be paid.
    let exact = Target::new().first(place(0.01)).last(place(0.01));
    let apart = Planner::new(&dictionary, Method::Prior, &apart(0.01)).unwrap();
    let hard = PlannerSettings {
        ends: Ends::Hard,
        ..only(Constraints::default())
    };
    let plan = apart.plan(&exact).unwrap();
    assert_eq!(plan.status, PlanStatus::Solved);
    assert_eq!(
        prior(&dictionary, &hard).plan(&exact).unwrap().status,
        PlanStatus::Solved
    );
}

/// An object that moves, and three fingers that hold it.
fn holding(samples: usize, tau_m: f64) -> Holding {
    let poses = (0..samples).map(|t| {
        let s = t as f64 / samples as f64;
        let way = Vector3::new(0.02 * s, 0.01 * (6.0 * s).sin(), 0.0);
        Pose::<Hand, Object>::new(Isometry3::new(way, Vector3::z() * s))
    });
    let mut contacts = PerFinger::from_fn(|_| None);
    contacts[Finger::Thumb] = Some(Position::new(0.02, 0.0, 0.0));
    contacts[Finger::Index] = Some(Position::new(-0.02, 0.01, 0.0));
    contacts[Finger::Middle] = Some(Position::new(-0.02, -0.01, 0.01));
    Holding {
        hand_from_object: poses.collect(),
        contacts,
        tau_m,
    }
}

#[test]
fn holding_fingers_stay_in_their_balls() {
    let dictionary = free(12, 12.0, |c| 0.01 * (1.3 * c as f64).sin());
    let gaussian = Gaussian::of_dictionary(&dictionary);
    let given = ends(&dictionary, 1, 0.002);
    let planner = prior(&dictionary, &only(Constraints::default()));
    let mut active = 0;
    for tau_m in [0.2, 0.02, 0.005, 0.001] {
        let held = holding(12, tau_m);
        let mut plain = plain(&gaussian, &given);
        for (t, &pose) in held.hand_from_object.iter().enumerate() {
            for (finger, contact) in held.contacts.iter() {
                let Some(contact) = *contact else { continue };
                let centre = (pose * contact).to_array().map(|v| v * 1e3);
                let centre = DVector::from_column_slice(&centre);
                plain.near(&gaussian.tip(t, finger), &centre, tau_m * 1e3);
            }
        }
        let target = Method::Prior.target(&given).holding(held.clone());
        let plan = check(&planner, &target, &plain);
        active += plan.checks.active[ConstraintFamily::Holding];
        assert_eq!(plan.checks.rows, 36);
        let trajectory = plan.trajectory.unwrap();
        for (t, &pose) in held.hand_from_object.iter().enumerate() {
            for (finger, contact) in held.contacts.iter() {
                let Some(contact) = *contact else { continue };
                let away = trajectory.position(t, finger).distance_m(pose * contact);
                assert!(away <= tau_m * (1.0 + 1e-6), "{t} {finger}: {away}");
            }
        }
    }
    assert!(
        active > 20,
        "small balls are left nowhere but at their rim: {active}"
    );
}
