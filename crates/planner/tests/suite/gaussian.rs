//! Targets of every kind against the conditional distribution of a Gaussian, by its formula.

use inhand_model::{DictionaryKind, EndConditions, Finger, PerFinger, PlanStatus, SegmentLayout};
use inhand_planner::{Ends, Method, Planner, PlannerSettings, Target};
use nalgebra::{DMatrix, DVector};

use crate::plain::{Gaussian, Rows};
use crate::support::{bounds, ends, free, residual, settings, smooth};

/// Deviation of soft velocities, mm/s.
const SPEED_SIGMA: f64 = PlannerSettings::VELOCITY_SIGMA_M_S * 1e3;

fn loose() -> PlannerSettings {
    settings(bounds(100.0))
}

fn hard() -> PlannerSettings {
    PlannerSettings {
        ends: Ends::Hard,
        ..loose()
    }
}

/// The plan's motion is the Gaussian's mean, everywhere.
fn assert_motion(plan: &inhand_model::Plan, expected_mm: &DVector<f64>, tolerance_m: f64) {
    assert_eq!(plan.status, PlanStatus::Solved, "{:?}", plan.certificate);
    assert!(plan.certificate.worst() <= 1e-8, "{:?}", plan.certificate);
    let trajectory = plan.trajectory.as_ref().expect("a solved plan has one");
    for (row, value) in trajectory.values_m().iter().enumerate() {
        let away = (value - expected_mm[row] * 1e-3).abs();
        assert!(away < tolerance_m, "row {row}: {away}");
    }
}

/// Several sets of rows as one.
fn stacked(parts: &[(Rows, Vec<f64>)]) -> (Rows, DVector<f64>) {
    let columns = parts[0].0.factors.ncols();
    let count = parts.iter().map(|(rows, _)| rows.base.len()).sum();
    let mut factors = DMatrix::zeros(count, columns);
    let (mut base, mut wanted) = (Vec::new(), Vec::new());
    for (rows, values) in parts {
        let n = rows.base.len();
        factors.rows_mut(base.len(), n).copy_from(&rows.factors);
        base.extend(rows.base.iter().copied());
        wanted.extend(values.iter().map(|v| v * 1e3));
    }
    let base = DVector::from_vec(base);
    (Rows { factors, base }, DVector::from_vec(wanted))
}

#[test]
fn a_subset_of_fingers_is_the_marginal_and_the_others_follow() {
    let dictionary = smooth(DictionaryKind::Pca, 20, 25);
    let all = Gaussian::of_dictionary(&dictionary);
    let given = ends(&dictionary, 1, 0.01);
    let fingers = [Finger::Thumb, Finger::Ring];
    let tips = |sample: usize, configuration: &[f64; 15]| {
        fingers.map(|finger| {
            let at = SegmentLayout::row(0, finger, 0);
            (all.tip(sample, finger), configuration[at..at + 3].to_vec())
        })
    };
    let parts = [tips(0, &given.first_m), tips(19, &given.last_m)].into_iter();
    let parts: Vec<_> = parts.flatten().collect();
    let (rows, wanted) = stacked(&parts);
    let expected = all.given(&rows, &wanted, 0.1).motion();
    let planner = Planner::new(&dictionary, Method::Prior, &loose()).unwrap();
    let target = Method::Prior.target(&given).only(&fingers);
    let plan = planner.plan(&target).unwrap();
    assert_motion(&plan, &expected, 1e-9);
    // The same by naming each position.
    let mut first = PerFinger::from_fn(|_| None);
    let mut last = first;
    for finger in fingers {
        let at = SegmentLayout::row(0, finger, 0);
        first[finger] = Some([0, 1, 2].map(|axis| given.first_m[at + axis]));
        last[finger] = Some([0, 1, 2].map(|axis| given.last_m[at + axis]));
    }
    let named = Target::new().first(first).last(last);
    assert_eq!(planner.plan(&named).unwrap(), plan);
}

#[test]
fn waypoints_condition_the_motion_on_the_way() {
    let dictionary = smooth(DictionaryKind::Pca, 20, 25);
    let all = Gaussian::of_dictionary(&dictionary);
    // 0.26 s at 20 Hz is nearest to sample 5, 0.95 s is the last one.
    let point = [0.013, -0.004, 0.021];
    let mut way = PerFinger::from_fn(|_| None);
    way[Finger::Middle] = Some(point);
    let mut end = PerFinger::from_fn(|_| None);
    end[Finger::Little] = Some([0.01; 3]);
    let (rows, wanted) = stacked(&[
        (all.tip(5, Finger::Middle), point.to_vec()),
        (all.tip(19, Finger::Little), vec![0.01; 3]),
    ]);
    let expected = all.given(&rows, &wanted, 0.1).motion();
    let planner = Planner::new(&dictionary, Method::Prior, &loose()).unwrap();
    let target = Target::new().waypoint(0.26, way).waypoint(0.95, end);
    assert_motion(&planner.plan(&target).unwrap(), &expected, 1e-9);
    // A waypoint at the end is the last configuration; saying it twice changes nothing.
    let twice = Target::new()
        .last(end)
        .waypoint(0.26, way)
        .waypoint(0.95, end);
    assert_motion(&planner.plan(&twice).unwrap(), &expected, 1e-9);
}

#[test]
fn velocities_of_a_dictionary_are_its_first_and_last_steps() {
    let dictionary = smooth(DictionaryKind::Pca, 20, 40);
    let all = Gaussian::of_dictionary(&dictionary);
    let given = EndConditions {
        first_velocity_m_s: [0.05; 15],
        last_velocity_m_s: [-0.02; 15],
        ..ends(&dictionary, 2, 0.005)
    };
    let steps = all.differences(1);
    let at = |from: usize| Rows {
        factors: steps.factors.rows(from, 15).into_owned(),
        base: steps.base.rows(from, 15).into_owned(),
    };
    let (rows, wanted) = all.ends(&given);
    let (speeds, speed) = stacked(&[(at(0), vec![0.05; 15]), (at(18 * 15), vec![-0.02; 15])]);
    let expected = all
        .given(&rows, &wanted, 0.1)
        .given(&speeds, &speed, SPEED_SIGMA)
        .motion();
    let planner = Planner::new(&dictionary, Method::Prior, &loose()).unwrap();
    assert_motion(
        &planner.plan(&Target::from(given)).unwrap(),
        &expected,
        1e-8,
    );
}

#[test]
fn hard_targets_are_the_limit_of_sharp_ones_and_are_met_exactly() {
    let dictionary = free(20, 20.0, |c| 0.001 * c as f64);
    let given = ends(&dictionary, 1, 0.01);
    let target = Method::Prior.target(&given);
    let exact = Planner::new(&dictionary, Method::Prior, &hard()).unwrap();
    let exact = exact.plan(&target).unwrap().trajectory.unwrap();
    for (axis, value) in given.first_m.iter().enumerate() {
        assert!((exact.configuration_m(0)[axis] - value).abs() < 1e-14);
    }
    let mut before = f64::INFINITY;
    for sigma_m in [1e-3, 1e-4, 1e-5, 1e-6] {
        let sharp = PlannerSettings {
            ends: Ends::Soft { sigma_m },
            ..loose()
        };
        let planner = Planner::new(&dictionary, Method::Prior, &sharp).unwrap();
        let plan = planner.plan(&target).unwrap();
        let motion = plan.trajectory.unwrap();
        let away = (motion.values_m().iter().zip(exact.values_m()))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        // The first order is linear in the variance.
        assert!(away < before * 0.05, "{sigma_m}: {away} after {before}");
        before = away;
    }
    assert!(before < 1e-6, "{before}");
}

#[test]
fn a_residual_through_hard_ends_is_the_cubic_with_what_is_expected_of_its_deviation() {
    let residual = residual(25, 12, false);
    let given = EndConditions {
        first_m: std::array::from_fn(|c| 0.01 * (c as f64).sin()),
        last_m: std::array::from_fn(|c| 0.02 * (c as f64).cos()),
        first_velocity_m_s: [0.03; 15],
        last_velocity_m_s: [-0.01; 15],
        object: None,
    };
    let x = given.to_vector(residual.layout).unwrap();
    let all = Gaussian::of_residual(&residual, &x);
    let expected = (inhand_model::SmoothCurve::Hermite.basis(residual.layout) * &x
        + &residual.primitives * residual.expected_m(&x))
        * 1e3;
    let planner = Planner::residual(&residual, &hard()).unwrap();
    let plan = planner.plan(&Target::from(given)).unwrap();
    assert_motion(&plan, &expected, 1e-12);
    assert_eq!(planner.unknowns(), 72);
    // The deviation vanishes at both ends, so its activations are what is expected.
    for (k, z) in residual.expected_m(&x).iter().enumerate() {
        assert!((plan.activations_m[60 + k] - z).abs() < 1e-12);
    }

    // Soft, it is the Gaussian, with velocities as end conditions of their own.
    let (rows, wanted) = all.ends(&given);
    let mut speeds = DMatrix::zeros(30, 72);
    for i in 0..30 {
        speeds[(i, 30 + i)] = 1.0;
    }
    let speeds = Rows {
        factors: speeds,
        base: DVector::zeros(30),
    };
    let speed = x.rows(30, 30) * 1e3;
    let expected = all
        .given(&rows, &wanted, 0.1)
        .given(&speeds, &speed, SPEED_SIGMA)
        .motion();
    let planner = Planner::residual(&residual, &loose()).unwrap();
    assert_motion(
        &planner.plan(&Target::from(given)).unwrap(),
        &expected,
        1e-8,
    );
}

#[test]
fn end_conditions_that_are_not_given_are_taken_at_their_most_likely() {
    let residual = residual(25, 12, false);
    // Last position of the index alone: the other 57 follow from how end conditions vary together.
    let point = [0.03, -0.02, 0.01];
    let known = [15 + 3, 15 + 4, 15 + 5];
    let (m, c) = (&residual.ends_mean, &residual.ends_covariance);
    let own = c.select_rows(&known).select_columns(&known);
    let away = DVector::from_column_slice(&point) - m.select_rows(&known);
    let likely = m + c.select_columns(&known) * own.lu().solve(&away).unwrap();
    let all = Gaussian::of_residual(&residual, &likely);
    let mut last = PerFinger::from_fn(|_| None);
    last[Finger::Index] = Some(point);
    let (rows, wanted) = stacked(&[(all.tip(24, Finger::Index), point.to_vec())]);
    let expected = all.given(&rows, &wanted, 0.1).motion();
    let planner = Planner::residual(&residual, &loose()).unwrap();
    let plan = planner.plan(&Target::new().last(last)).unwrap();
    assert_motion(&plan, &expected, 1e-8);
}

#[test]
fn a_residual_without_primitives_is_the_smooth_curve() {
    let residual = residual(10, 0, false);
    let given = EndConditions {
        first_m: [0.01; 15],
        last_m: [0.02; 15],
        first_velocity_m_s: [0.03; 15],
        last_velocity_m_s: [-0.01; 15],
        object: None,
    };
    let x = given.to_vector(residual.layout).unwrap();
    let plan = Planner::residual(&residual, &hard()).unwrap();
    let plan = plan.plan(&Target::from(given)).unwrap();
    let expected = inhand_model::SmoothCurve::Hermite.basis(residual.layout) * x * 1e3;
    assert_motion(&plan, &expected, 1e-12);
}

#[test]
fn corridors_are_the_conditional_covariance() {
    let residual = residual(25, 12, false);
    let all = Gaussian::of_residual(&residual, &residual.ends_mean);
    let mut first = PerFinger::from_fn(|_| None);
    first[Finger::Thumb] = Some([0.01; 3]);
    let target = Target::new().first(first).waypoint(0.4, first);
    let (rows, wanted) = stacked(&[
        (all.tip(0, Finger::Thumb), vec![0.01; 3]),
        (all.tip(10, Finger::Thumb), vec![0.01; 3]),
    ]);
    for (settings, sigma) in [(loose(), 0.1), (hard(), 0.0)] {
        let given = all.given(&rows, &wanted, sigma);
        let planner = Planner::residual(&residual, &settings).unwrap();
        let corridor = planner.corridor(&target).unwrap();
        assert_eq!(corridor.covariance_m2().len(), 25);
        for (t, covariance) in corridor.covariance_m2().iter().enumerate() {
            for (finger, found) in covariance.iter() {
                let at = given.tip(t, finger).factors;
                let expected = &at * &given.covariance * at.transpose() * 1e-6;
                for i in 0..3 {
                    for j in 0..3 {
                        let own = if i == j { residual.unexplained_m2 } else { 0.0 };
                        let away = found[i][j] - expected[(i, j)] - own;
                        assert!(away.abs() < 1e-12, "{t} {finger}: {away}");
                    }
                }
            }
        }
        // The values of a target do not matter, and the plan itself is at no distance.
        let elsewhere = Target::new().first(first).waypoint(0.4, [0.0; 15]);
        assert_eq!(planner.corridor(&target).unwrap(), corridor);
        assert_ne!(planner.corridor(&elsewhere).unwrap(), corridor);
        let plan = planner.plan(&target).unwrap().trajectory.unwrap();
        let there = plan.position(7, Finger::Index);
        assert_eq!(corridor.mahalanobis(&plan, 7, Finger::Index, there), 0.0);
    }
    let dictionary = smooth(DictionaryKind::Nmf, 6, 4);
    let paper = Planner::new(&dictionary, Method::Paper, &loose()).unwrap();
    let error = paper.corridor(&target).unwrap_err().to_string();
    assert!(error.contains("paper has no prediction region"), "{error}");
}

#[test]
fn many_patterns_of_targets_come_and_go() {
    let dictionary = smooth(DictionaryKind::Pca, 60, 8);
    let planner = Planner::new(&dictionary, Method::Prior, &loose()).unwrap();
    let target = |t: usize| Target::new().waypoint(t as f64 / 60.0, [0.01; 15]);
    let first: Vec<_> = (0..60).map(|t| planner.plan(&target(t)).unwrap()).collect();
    for (t, plan) in first.iter().enumerate() {
        assert_eq!(&planner.plan(&target(t)).unwrap(), plan);
    }
}
