//! Relaxations where there is no solution, against closed forms.

use std::sync::Arc;

use inhand_contact::hull;
use inhand_model::{
    ConstraintFamily, EndConditions, Finger, Hand, Hull, Object, PerFinger, Plan, PlanStatus, Pose,
    Position, SmoothCurve, VelocityBounds,
};
use inhand_planner::{
    AccelerationBounds, Constraints, Ends, Holding, Method, Planner, PlannerSettings, Target,
};

use crate::support::{bounds, free, residual, settings};

/// At 10 Hz: 0.6 s.
const SAMPLES: usize = 7;

fn hard(constraints: Constraints) -> PlannerSettings {
    PlannerSettings {
        ends: Ends::Hard,
        constraints,
        ..settings(bounds(1.0))
    }
}

/// Fingers 50 mm apart, in a dictionary that can do any motion.
fn row(thumb_m: [f64; 3]) -> [f64; 15] {
    let mut configuration: [f64; 15] = std::array::from_fn(|c| 0.05 * (c / 3) as f64);
    configuration[..3].copy_from_slice(&thumb_m);
    configuration
}

fn plan(settings: &PlannerSettings, target: &Target) -> Plan {
    let dictionary = free(SAMPLES, 10.0, |c| 0.05 * (c / 3) as f64);
    let planner = Planner::new(&dictionary, Method::Prior, settings).expect("sound parts");
    let plan = planner.plan(target).expect("a sound target");
    assert_eq!(plan.status, PlanStatus::Infeasible);
    assert!(plan.objective.is_infinite() && plan.trajectory.is_none());
    plan
}

/// Which families, by how much, alone.
fn assert_alone(plan: &Plan, expected: &[(ConstraintFamily, f64)]) {
    let found: Vec<_> = plan
        .relaxations
        .iter()
        .map(|r| (r.family, r.joint))
        .collect();
    let families: Vec<_> = expected
        .iter()
        .map(|(family, _)| (*family, false))
        .collect();
    assert_eq!(found, families, "{:?}", plan.relaxations);
    for (relaxation, (family, by)) in plan.relaxations.iter().zip(expected) {
        let away = (relaxation.by - by).abs() / by;
        assert!(away < 1e-5, "{family}: {} for {by}", relaxation.by);
    }
}

#[test]
fn too_far_for_the_velocity_bounds() {
    let settings = hard(settings(bounds(0.05)).constraints);
    let target = Target::new()
        .first(row([0.0; 3]))
        .last(row([0.06, 0.0, 0.0]));
    // 60 mm in 0.6 s are 0.1 m/s; with 0.05 m/s, 30 mm are made and both ends give 15 mm.
    assert_alone(
        &plan(&settings, &target),
        &[
            (ConstraintFamily::Targets, 0.015),
            (ConstraintFamily::Velocity, 0.05),
        ],
    );
    // A smooth curve of which everything is given can only be allowed to be as fast as it is.
    let residual = residual(SAMPLES, 0, false);
    let ends = EndConditions {
        first_m: [0.0; 15],
        last_m: [0.06; 15],
        first_velocity_m_s: [0.0; 15],
        last_velocity_m_s: [0.0; 15],
        object: None,
    };
    let curve =
        SmoothCurve::Hermite.basis(residual.layout) * ends.to_vector(residual.layout).unwrap();
    let fastest = (0..curve.len() - 15)
        .map(|row| (curve[row + 15] - curve[row]) * residual.layout.rate_hz)
        .fold(0.0, f64::max);
    let planner = Planner::residual(&residual, &settings).unwrap();
    let plan = planner.plan(&Target::from(ends)).unwrap();
    let velocity = plan
        .relaxations
        .iter()
        .find(|r| r.family == ConstraintFamily::Velocity);
    let by = velocity.unwrap().by;
    assert!((by - (fastest - 0.05)).abs() < 1e-6, "{by}");
}

#[test]
fn too_sudden_for_the_acceleration_bounds() {
    let settings = hard(Constraints {
        acceleration: Some(AccelerationBounds {
            min_m_s2: [-1.0; 15],
            max_m_s2: [1.0; 15],
        }),
        ..Constraints::default()
    });
    // 0, 0, 20 mm at 10 Hz: 2 m/s² in the middle.
    let target = Target::new()
        .waypoint(0.2, row([0.0; 3]))
        .waypoint(0.3, row([0.0; 3]))
        .waypoint(0.4, row([0.02, 0.0, 0.0]));
    // a - 2 b + c = 20 mm has to shrink by 10 mm: a, c by s, b by s the other way: 4 s = 10 mm.
    assert_alone(
        &plan(&settings, &target),
        &[
            (ConstraintFamily::Targets, 0.0025),
            (ConstraintFamily::Acceleration, 1.0),
        ],
    );
}

#[test]
fn outside_the_hull() {
    let corner = |k: usize| {
        let side = |bit: usize| if k & bit == 0 { -0.3 } else { 0.3 };
        Position::<Hand>::new(side(1), side(2), side(4))
    };
    let corners: Vec<_> = (0..8).map(corner).collect();
    let cube: Hull = hull(&corners).unwrap();
    let settings = PlannerSettings {
        hulls: Some(Arc::new(PerFinger::from_fn(|_| cube.clone()))),
        ..hard(Constraints {
            reachability_margin_m: Some(0.0),
            ..Constraints::default()
        })
    };
    let target = Target::new()
        .first(row([0.0; 3]))
        .last(row([0.0, 0.308, 0.0]));
    assert_alone(
        &plan(&settings, &target),
        &[
            (ConstraintFamily::Targets, 0.008),
            (ConstraintFamily::Reachability, 0.008),
        ],
    );
}

#[test]
fn fingertips_wanted_too_near() {
    let settings = hard(Constraints {
        separation_m: Some(0.01),
        ..Constraints::default()
    });
    // Thumb 4 mm beside the index: 6 mm are missing, or 3 mm of each, along x.
    let target = Target::new().last(row([0.046, 0.05, 0.05]));
    assert_alone(
        &plan(&settings, &target),
        &[
            (ConstraintFamily::Targets, 0.003),
            (ConstraintFamily::Separation, 0.006),
        ],
    );
}

#[test]
fn a_goal_too_far_from_the_contact_point() {
    let mut contacts = PerFinger::from_fn(|_| None);
    contacts[Finger::Thumb] = Some(Position::<Object>::new(0.01, 0.0, 0.0));
    let holding = Holding {
        hand_from_object: vec![Pose::identity(); SAMPLES],
        contacts,
        tau_m: 0.005,
    };
    let target = Target::new()
        .first(row([0.01, 0.0, 0.0]))
        .last(row([0.023, 0.0, 0.0]))
        .holding(holding);
    assert_alone(
        &plan(&hard(Constraints::default()), &target),
        &[
            (ConstraintFamily::Targets, 0.008),
            (ConstraintFamily::Holding, 0.008),
        ],
    );
}

#[test]
fn hard_targets_that_primitives_cannot_reach() {
    // A residual moves its first sample with its end conditions alone; all positions at two waypoints
    // are more than two primitives can give.
    let planner = Planner::residual(&residual(SAMPLES, 2, false), &hard(Constraints::default()));
    let target = Target::new()
        .first([0.0; 15])
        .last([0.0; 15])
        .first_velocity([0.0; 15])
        .last_velocity([0.0; 15])
        .waypoint(3.0 / 7.0, [0.02; 15]);
    let plan = planner.unwrap().plan(&target).unwrap();
    assert_eq!(plan.status, PlanStatus::Infeasible);
    let families: Vec<_> = plan.relaxations.iter().map(|r| r.family).collect();
    // Velocities alone do it too: faster on leaving and arriving, the cubic passes anywhere.
    assert_eq!(
        families,
        [
            ConstraintFamily::Targets,
            ConstraintFamily::TargetVelocities
        ]
    );
    // With velocity v at the start and -v at the end the cubic rises by v T / 4 in the middle.
    let duration_s = 6.0 / 7.0;
    let by = plan.relaxations[1].by;
    assert!(by < 4.0 * 0.02 / duration_s * 1.2, "{by}");
}

#[test]
fn where_no_family_alone_is_enough_they_give_way_together() {
    // The thumb has to rise at 0.1 m/s all the time, 60 mm in all, within a hull of 40 mm: velocity
    // or hull. And thumb and index are wanted 4 mm apart where 10 mm are needed: targets or
    // separation. Together, with s of each: 0.6 (0.1 - s) <= 0.04 + 2 s, and 0.01 - s <= 0.004 + 2 s.
    let corner = |k: usize| {
        let side = |bit: usize| if k & bit == 0 { -0.02 } else { 0.02 };
        Position::<Hand>::new(side(1), side(2), side(4))
    };
    let corners: Vec<_> = (0..8).map(corner).collect();
    let small: Hull = hull(&corners).unwrap();
    let corners: Vec<_> = (0..8)
        .map(|k| Position::<Hand>::from_coords(corner(k).coords_m() * 50.0))
        .collect();
    let large: Hull = hull(&corners).unwrap();
    let mut velocity = VelocityBounds {
        min_m_s: [-1.0; 15],
        max_m_s: [1.0; 15],
    };
    velocity.min_m_s[2] = 0.1;
    let settings = PlannerSettings {
        hulls: Some(Arc::new(PerFinger::from_fn(|finger| match finger {
            Finger::Thumb => small.clone(),
            _ => large.clone(),
        }))),
        ..hard(Constraints {
            velocity: Some(velocity),
            reachability_margin_m: Some(0.0),
            separation_m: Some(0.01),
            ..Constraints::default()
        })
    };
    let mut last = PerFinger::from_fn(|_| None);
    last[Finger::Index] = Some([0.05; 3]);
    last[Finger::Middle] = Some([0.054, 0.05, 0.05]);
    let plan = plan(&settings, &Target::new().last(last));
    let families: Vec<_> = plan
        .relaxations
        .iter()
        .map(|r| (r.family, r.joint))
        .collect();
    assert_eq!(
        families,
        [
            (ConstraintFamily::Targets, true),
            (ConstraintFamily::Velocity, true),
            (ConstraintFamily::Reachability, true),
            (ConstraintFamily::Separation, true),
        ]
    );
    let expected = (0.02_f64 / 2.6).max(0.002);
    for relaxation in &plan.relaxations {
        assert!(
            (relaxation.by - expected).abs() < 1e-7,
            "{relaxation:?} {expected}"
        );
    }
}
