//! Each family of constraints against Clarabel on the plain problem with every row present:
//! feasible, infeasible, degenerate and ill-conditioned siblings.

use std::sync::Arc;

use inhand_contact::hull;
use inhand_model::{
    ConstraintFamily, Dictionary, DictionaryKind, EndConditions, Finger, Hand, Hull, PerFinger,
    Plan, PlanStatus, Position,
};
use inhand_planner::{
    AccelerationBounds, Backend, Constraints, Ends, Method, Planner, PlannerSettings, Target,
};
use proptest::prelude::*;

use crate::plain::{Answer, Gaussian, Plain};
use crate::support::{bounds, ends, free, residual, settings, smooth};

/// Constraints and nothing else.
pub(crate) fn only(constraints: Constraints) -> PlannerSettings {
    PlannerSettings {
        constraints,
        ..settings(bounds(1.0))
    }
}

fn acceleration(size_m_s2: f64) -> Constraints {
    Constraints {
        acceleration: Some(AccelerationBounds {
            min_m_s2: [-size_m_s2; 15],
            max_m_s2: [size_m_s2; 15],
        }),
        ..Constraints::default()
    }
}

/// A box of half this size for every finger.
fn boxes(half_m: f64) -> Arc<PerFinger<Hull>> {
    let corner = |k: usize| {
        let side = |bit: usize| if k & bit == 0 { -half_m } else { half_m };
        Position::<Hand>::new(side(1), side(2), side(4))
    };
    let corners: Vec<_> = (0..8).map(corner).collect();
    let cube = hull(&corners).expect("a box has a hull");
    Arc::new(PerFinger::from_fn(|_| cube.clone()))
}

fn reach(half_m: f64, margin_m: f64) -> PlannerSettings {
    PlannerSettings {
        hulls: Some(boxes(half_m)),
        ..only(Constraints {
            reachability_margin_m: Some(margin_m),
            ..Constraints::default()
        })
    }
}

/// First and last configuration, softly, before any constraint.
pub(crate) fn plain(gaussian: &Gaussian, given: &EndConditions) -> Plain {
    let mut plain = Plain::new(gaussian);
    let (rows, wanted) = gaussian.ends(given);
    plain.soft(&rows, &wanted, 0.1);
    plain
}

/// Both backends reach the plain problem's optimum and prove it, or say that there is none.
pub(crate) fn check(planner: &Planner, target: &Target, plain: &Plain) -> Plan {
    let answer = plain.solve();
    let plans = [Backend::ActiveSet, Backend::Clarabel]
        .map(|backend| planner.clone().with_backend(backend).plan(target));
    let plans = plans.map(|plan| plan.expect("a sound target"));
    for plan in &plans {
        match &answer {
            Answer::Infeasible => {
                assert_eq!(plan.status, PlanStatus::Infeasible);
                assert!(!plan.relaxations.is_empty());
            }
            Answer::Solved(h) => {
                assert_eq!(plan.status, PlanStatus::Solved, "{:?}", plan.certificate);
                assert!(plan.certificate.worst() <= 1e-6, "{:?}", plan.certificate);
                let (reference, own) = (plain.objective(h), plan.objective);
                let away = (own - reference).abs() / reference.abs().max(1.0);
                assert!(away <= 1e-6, "{own} against {reference}");
                let again = plain.objective(&(&plan.activations_m * 1e3));
                assert!((again - own).abs() <= 1e-6 * own.abs().max(1.0));
            }
        }
    }
    let [plan, _] = plans;
    plan
}

/// The usual problem of a dictionary of principal components.
fn usual(case: usize, reach_m: f64) -> (Dictionary, Gaussian, EndConditions, Target) {
    let dictionary = smooth(DictionaryKind::Pca, 20, 30);
    let gaussian = Gaussian::of_dictionary(&dictionary);
    let given = ends(&dictionary, case, reach_m);
    (dictionary, gaussian, given, Method::Prior.target(&given))
}

pub(crate) fn prior(dictionary: &Dictionary, settings: &PlannerSettings) -> Planner {
    Planner::new(dictionary, Method::Prior, settings).expect("sound parts")
}

#[test]
fn acceleration_bounds() {
    let mut active = 0;
    for (case, size_m_s2) in [(0, 100.0), (1, 1.0), (2, 0.3), (3, 0.0)] {
        let (dictionary, gaussian, given, target) = usual(case, 0.02);
        let size = [size_m_s2 * 1e3];
        let mut soft = plain(&gaussian, &given);
        soft.between(&gaussian.differences(2), &size.map(|v| -v), &size);
        let planner = prior(&dictionary, &only(acceleration(size_m_s2)));
        let plan = check(&planner, &target, &soft);
        let found = plan.checks.active[ConstraintFamily::Acceleration];
        active += found;
        assert_eq!(plan.checks.rows, 2 * 15 * 18);
        let by = plan.checks.violation[ConstraintFamily::Acceleration].unwrap();
        assert!(by <= 1e-6 * size_m_s2.max(1e-3), "{by}");
        assert_eq!(plan.checks.violation[ConstraintFamily::Velocity], None);
    }
    assert!(active > 40, "tight bounds are active: {active}");

    // Hard ends, in a dictionary that can do any motion.
    let dictionary = free(12, 12.0, |_| 0.0);
    let gaussian = Gaussian::of_dictionary(&dictionary);
    for (case, size_m_s2) in [(0, 2.0), (1, 0.3), (2, 0.05), (3, 0.0)] {
        let given = ends(&dictionary, case, 0.01);
        let (rows, wanted) = gaussian.ends(&given);
        let mut hard = Plain::new(&gaussian);
        hard.hard(&rows, &wanted);
        let size = [size_m_s2 * 1e3];
        hard.between(&gaussian.differences(2), &size.map(|v| -v), &size);
        let settings = PlannerSettings {
            ends: Ends::Hard,
            ..only(acceleration(size_m_s2))
        };
        check(
            &prior(&dictionary, &settings),
            &Method::Prior.target(&given),
            &hard,
        );
    }
}

#[test]
fn no_acceleration_at_all_is_the_straight_line() {
    // Bounds of zero width, in a dictionary that can do any motion.
    let dictionary = free(8, 10.0, |_| 0.0);
    let hard = PlannerSettings {
        ends: Ends::Hard,
        ..only(acceleration(0.0))
    };
    let target = Target::new().first([0.0; 15]).last([0.035; 15]);
    for backend in [Backend::ActiveSet, Backend::Clarabel] {
        let planner = prior(&dictionary, &hard).with_backend(backend);
        let plan = planner.plan(&target).unwrap();
        assert_eq!(plan.status, PlanStatus::Solved, "{:?}", plan.certificate);
        let trajectory = plan.trajectory.unwrap();
        for t in 0..8 {
            let away = trajectory.configuration_m(t)[4] - 0.005 * t as f64;
            assert!(away.abs() < 1e-10, "{backend:?} {t}: {away}");
        }
    }
}

#[test]
fn reachability_keeps_every_fingertip_in_its_hull() {
    let mut active = 0;
    for (case, half_m, margin_m) in [(0, 0.2, 0.0), (1, 0.03, 0.0), (2, 0.035, -0.005)] {
        let (dictionary, gaussian, given, target) = usual(case, 0.02);
        let mut plain = plain(&gaussian, &given);
        let size = [(half_m + margin_m) * 1e3];
        let rows: Vec<usize> = (0..gaussian.layout.finger_rows()).collect();
        plain.between(&gaussian.coordinates(&rows), &size.map(|v| -v), &size);
        let planner = prior(&dictionary, &reach(half_m, margin_m));
        let plan = check(&planner, &target, &plain);
        active += plan.checks.active[ConstraintFamily::Reachability];
        let outside = plan.checks.hull_distance_m.unwrap();
        assert!(outside <= margin_m + 1e-9, "{outside}");
        assert_eq!(plan.checks.rows, 5 * 12 * 20);
    }
    assert!(active > 10, "tight hulls are active: {active}");
}

#[test]
fn a_hull_exactly_touched_and_one_too_small() {
    // Standing still on a face of the box: feasible, and nothing to pay for it.
    let dictionary = free(6, 10.0, |_| 0.0);
    let target = Target::new().first([0.02; 15]).last([0.02; 15]);
    let hard = PlannerSettings {
        ends: Ends::Hard,
        ..reach(0.02, 0.0)
    };
    let plan = prior(&dictionary, &hard).plan(&target).unwrap();
    assert_eq!(plan.status, PlanStatus::Solved, "{:?}", plan.certificate);
    assert!(plan.checks.hull_distance_m.unwrap().abs() < 1e-9);
    let smaller = PlannerSettings {
        ends: Ends::Hard,
        ..reach(0.02, -1e-4)
    };
    let plan = prior(&dictionary, &smaller).plan(&target).unwrap();
    assert_eq!(plan.status, PlanStatus::Infeasible);
    // The distance to the hull is reported whether reachability is on or not.
    let off = PlannerSettings {
        hulls: Some(boxes(0.015)),
        ..settings(bounds(100.0))
    };
    let plan = prior(&dictionary, &off).plan(&target).unwrap();
    let trajectory = plan.trajectory.unwrap();
    let tips = trajectory.values_m().chunks_exact(3);
    let beyond = |tip: &[f64]| {
        tip.iter()
            .map(|v| (v.abs() - 0.015).max(0.0).powi(2))
            .sum::<f64>()
    };
    let farthest = tips.map(|tip| beyond(tip).sqrt()).fold(0.0, f64::max);
    assert!((plan.checks.hull_distance_m.unwrap() - farthest).abs() < 1e-12);
    assert!(farthest > 0.008);
}

/// Thumb at the origin, index at `x`, the others far off.
pub(crate) fn place(x: f64) -> [f64; 15] {
    let mut configuration: [f64; 15] = std::array::from_fn(|c| 0.05 * (c / 3) as f64);
    configuration[..6].copy_from_slice(&[0.0, 0.0, 0.0, x, 0.0, 0.0]);
    configuration
}

#[test]
fn ill_conditioned_siblings() {
    // Sharp targets against every family at once, in a dictionary whose activations range over six
    // orders of magnitude.
    let mut dictionary = smooth(DictionaryKind::Pca, 20, 30);
    for i in 0..30 {
        for j in 0..30 {
            let size = |k: usize| 10_f64.powf(-0.1 * k as f64);
            dictionary.activation_covariance_m2[(i, j)] *= size(i) * size(j);
        }
    }
    let given = ends(&dictionary, 1, 0.001);
    for sigma_m in [1e-4, 1e-6] {
        for constraints in [
            acceleration(0.5),
            Constraints {
                velocity: Some(bounds(0.03)),
                ..acceleration(0.5)
            },
            reach(0.03, 0.0).constraints,
        ] {
            let settings = PlannerSettings {
                ends: Ends::Soft { sigma_m },
                hulls: Some(boxes(0.03)),
                ..only(constraints)
            };
            let plan = prior(&dictionary, &settings)
                .plan(&Method::Prior.target(&given))
                .unwrap();
            assert_eq!(plan.status, PlanStatus::Solved, "{:?}", plan.certificate);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn all_families_at_once_hold_on_every_model(
        case in 0_usize..1000,
        reach_m in 0.0..0.01,
        hard in any::<bool>(),
        with_residual in any::<bool>(),
    ) {
        let settings = PlannerSettings {
            ends: if hard { Ends::Hard } else { Ends::Soft { sigma_m: 1e-4 } },
            hulls: Some(boxes(0.05)),
            ..only(Constraints {
                velocity: Some(bounds(0.2)),
                reachability_margin_m: Some(0.0),
                separation_m: Some(0.004),
                ..acceleration(2.0)
            })
        };
        let dictionary = smooth(DictionaryKind::Pca, 20, 40);
        let planner = if with_residual {
            Planner::residual(&residual(20, 30, false), &settings).unwrap()
        } else {
            prior(&dictionary, &settings)
        };
        let target = Method::Prior.target(&ends(&dictionary, case, reach_m)).waypoint(0.5, place(0.01));
        let plan = planner.plan(&target.only(&[Finger::Thumb, Finger::Index])).unwrap();
        if plan.status == PlanStatus::Solved {
            prop_assert!(plan.certificate.worst() <= 1e-6);
            for (family, by) in plan.checks.violation.iter() {
                // Relative to bounds, or to one unit in mm.
                let scale = match family {
                    ConstraintFamily::Acceleration => 2.0,
                    ConstraintFamily::Velocity => 0.2,
                    _ => 0.05,
                };
                prop_assert!(by.is_none_or(|by| by <= 1e-6 * scale), "{family} {by:?}");
            }
        } else {
            prop_assert_eq!(plan.status, PlanStatus::Infeasible);
            prop_assert!(!plan.relaxations.is_empty());
            prop_assert!(plan.relaxations.iter().all(|r| r.by > 0.0), "{:?}", plan.relaxations);
        }
    }
}
