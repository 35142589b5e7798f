//! Problems whose solution can be written down.

use inhand_model::{
    ConstraintFamily, DictionaryKind, EndConditions, PlanStatus, SEGMENT_COORDINATES, SegmentLayout,
};
use inhand_planner::{Backend, Method, Planner};
use nalgebra::{DMatrix, DVector};

use crate::support::{bounds, dictionary, ends, settings, smooth};

const BACKENDS: [Backend; 2] = [Backend::ActiveSet, Backend::Clarabel];

/// One primitive of two samples: every coordinate goes from `from` to `to` for activation 1.
fn one_primitive(
    kind: DictionaryKind,
    from: f64,
    to: f64,
    mean_m: f64,
    variance_m2: f64,
) -> inhand_model::Dictionary {
    dictionary(
        kind,
        SegmentLayout {
            samples: 2,
            rate_hz: 10.0,
            object: false,
        },
        DVector::zeros(2 * SEGMENT_COORDINATES),
        DMatrix::from_fn(2 * SEGMENT_COORDINATES, 1, |row, _| {
            if row < SEGMENT_COORDINATES { from } else { to }
        }),
        DVector::repeat(1, mean_m),
        DMatrix::repeat(1, 1, variance_m2),
    )
}

fn between(first_m: f64, last_m: f64) -> EndConditions {
    EndConditions {
        first_m: [first_m; SEGMENT_COORDINATES],
        last_m: [last_m; SEGMENT_COORDINATES],
        first_velocity_m_s: [0.0; SEGMENT_COORDINATES],
        last_velocity_m_s: [0.0; SEGMENT_COORDINATES],
        object: None,
    }
}

#[test]
fn without_active_bounds_it_is_the_conditional_mean_of_a_gaussian() {
    // mu + Sigma Aᵀ (A Sigma Aᵀ + sigma² I)⁻¹ (y - A mu), another route than the planner's.
    let dictionary = smooth(DictionaryKind::Pca, 20, 25);
    let ends = ends(&dictionary, 1, 0.01);
    let target = Method::Prior.target(&ends);
    let rows = dictionary.layout.rows();
    let observed: Vec<usize> = (0..15).chain(rows - 15..rows).collect();
    let a = dictionary.primitives.select_rows(&observed);
    let wanted = [ends.first_m, ends.last_m].concat();
    let y = DVector::from_vec(wanted) - dictionary.offset_m.select_rows(&observed);
    let (mu, sigma) = (
        &dictionary.activation_mean_m,
        &dictionary.activation_covariance_m2,
    );
    let spread = &a * sigma * a.transpose() + DMatrix::identity(30, 30) * 1e-8;
    let expected = mu + sigma * a.transpose() * spread.lu().solve(&(y - &a * mu)).unwrap();

    for backend in BACKENDS {
        let plan = Planner::new(&dictionary, Method::Prior, &settings(bounds(100.0)))
            .unwrap()
            .with_backend(backend)
            .plan(&target)
            .unwrap();
        assert_eq!(plan.status, PlanStatus::Solved);
        assert_eq!(
            (
                plan.checks.active[ConstraintFamily::Velocity],
                plan.checks.active[ConstraintFamily::Activations]
            ),
            (0, 0)
        );
        assert!(
            (plan.activations_m - &expected).amax() < 1e-11,
            "{backend:?}"
        );
    }
}

#[test]
fn one_activation_is_the_weighted_mean_of_prior_and_targets() {
    // 15 targets of 20 mm and 15 of 40 mm at sigma 0.1 mm against a prior of 10 mm, sigma 0.1 mm.
    let dictionary = one_primitive(DictionaryKind::Nmf, 1.0, 1.0, 0.01, 1e-8);
    let planner = Planner::new(&dictionary, Method::Prior, &settings(bounds(1.0))).unwrap();
    let plan = planner
        .plan(&Method::Prior.target(&between(0.02, 0.04)))
        .unwrap();
    let expected_m = (15.0 * 0.02 + 15.0 * 0.04 + 0.01) / 31.0;
    assert!((plan.activations_m[0] - expected_m).abs() < 1e-15);
    let misses_mm = [(20.0, 15.0), (40.0, 15.0), (10.0, 1.0)];
    let objective: f64 = misses_mm
        .iter()
        .map(|(wanted, count)| 0.5 * count * (expected_m * 1e3 - wanted).powi(2) / 0.01)
        .sum();
    assert!((plan.objective / objective - 1.0).abs() < 1e-12);
}

#[test]
fn paper_weighs_the_squared_miss_in_mm_against_the_ridge() {
    // 15 equations h = 30 mm and ridge 1e-4: h = 15 * 30 / (15 + 1e-4).
    let dictionary = one_primitive(DictionaryKind::Nmf, 1.0, 1.0, 5.0, 1.0);
    let planner = Planner::new(&dictionary, Method::Paper, &settings(bounds(1.0))).unwrap();
    let plan = planner
        .plan(&Method::Paper.target(&between(f64::NAN, 0.03)))
        .unwrap();
    let expected_m = 15.0 * 0.03 / (15.0 + 1e-4);
    assert!((plan.activations_m[0] - expected_m).abs() < 1e-15);
    let (h, ridge) = (expected_m * 1e3, 1e-4);
    let objective = 0.5 * (15.0 * (h - 30.0).powi(2) + ridge * h * h);
    assert!((plan.objective / objective - 1.0).abs() < 1e-9);
}

#[test]
fn a_velocity_bound_stops_the_motion_exactly_there() {
    // From 0 to h in a tenth of a second, 0.2 m/s allowed: h = 20 mm though 50 mm are wanted.
    let dictionary = one_primitive(DictionaryKind::Nmf, 0.0, 1.0, 0.0, 1.0);
    for backend in BACKENDS {
        for method in Method::ALL {
            let planner = Planner::new(&dictionary, method, &settings(bounds(0.2)))
                .unwrap()
                .with_backend(backend);
            let plan = planner.plan(&method.target(&between(0.0, 0.05))).unwrap();
            assert_eq!(plan.status, PlanStatus::Solved, "{method:?} {backend:?}");
            assert!(
                (plan.activations_m[0] - 0.02).abs() < 1e-12,
                "{method:?} {backend:?}"
            );
            assert!(plan.checks.active[ConstraintFamily::Velocity] >= 1);
            assert!(plan.checks.rows_taken_up >= 1 && plan.rounds == 2);
        }
    }
}

#[test]
fn only_nmf_keeps_activations_from_turning_negative() {
    for (kind, expected_m, active) in [
        (DictionaryKind::Nmf, 0.0, 1),
        (DictionaryKind::Pca, -0.03, 0),
    ] {
        let dictionary = one_primitive(kind, 1.0, 1.0, -0.03, 1e-2);
        let planner = Planner::new(&dictionary, Method::Prior, &settings(bounds(1.0))).unwrap();
        let plan = planner
            .plan(&Method::Prior.target(&between(-0.03, -0.03)))
            .unwrap();
        assert!((plan.activations_m[0] - expected_m).abs() < 1e-12);
        assert_eq!(plan.checks.active[ConstraintFamily::Activations], active);
    }
}
