//! The optimum against Clarabel on the plain problem with every row present: feasible, infeasible,
//! degenerate and ill-conditioned siblings.

use inhand_model::{
    ConstraintFamily, Dictionary, DictionaryKind, PlanStatus, SEGMENT_COORDINATES, VelocityBounds,
};
use inhand_planner::{Backend, Ends, Method, Planner, PlannerSettings};
use nalgebra::DMatrix;

use crate::plain::Answer;
use crate::support::{bounds, ends, plain, settings, smooth};

/// Both backends reach the plain problem's optimum and prove it.
fn check(
    dictionary: &Dictionary,
    method: Method,
    settings: &PlannerSettings,
    case: usize,
    reach: f64,
) -> inhand_model::Plan {
    let ends = ends(dictionary, case, reach);
    let target = method.target(&ends);
    let plain = plain(dictionary, method, settings, &ends);
    let planner = Planner::new(dictionary, method, settings).expect("sound parts");
    let answer = plain.solve();
    let plans = [Backend::ActiveSet, Backend::Clarabel].map(|backend| {
        let planner = planner.clone().with_backend(backend);
        planner.plan(&target).expect("a sound target")
    });
    for plan in &plans {
        match &answer {
            Answer::Infeasible => {
                assert_eq!(plan.status, PlanStatus::Infeasible, "{method:?} {case}");
                assert!(plan.trajectory.is_none() && plan.activations_m.is_empty());
                assert!(plan.objective.is_infinite() && plan.certificate.primal > 1e-6);
            }
            Answer::Solved(h_mm) => {
                assert_eq!(
                    plan.status,
                    PlanStatus::Solved,
                    "{method:?} {case} {plan:?}"
                );
                assert!(plan.certificate.worst() <= 1e-8, "{:?}", plan.certificate);
                let reference = plain.objective(h_mm);
                let own = plain.objective(&(&plan.activations_m * 1e3));
                assert!(
                    (own - reference).abs() <= 1e-6 * reference.abs().max(1.0),
                    "{method:?} {case}: {own} against {reference}"
                );
                assert!((plan.objective - own).abs() <= 1e-6 * own.abs().max(1.0));
            }
        }
    }
    let [plan, _] = plans;
    plan
}

#[test]
fn feasible_without_and_with_active_velocity_bounds() {
    let dictionary = smooth(DictionaryKind::Nmf, 30, 40);
    let mut active = 0;
    for method in Method::ALL {
        for (case, size_m_s) in [(0, 10.0), (1, 0.2), (2, 0.1), (3, 0.05), (4, 0.03)] {
            let plan = check(&dictionary, method, &settings(bounds(size_m_s)), case, 0.02);
            active += plan.checks.active[ConstraintFamily::Velocity];
        }
    }
    assert!(
        active > 20,
        "the tight cases must have active bounds: {active}"
    );
}

#[test]
fn principal_components_have_no_sign() {
    let dictionary = smooth(DictionaryKind::Pca, 30, 40);
    for method in Method::ALL {
        for (case, size_m_s) in [(0, 10.0), (1, 0.05)] {
            let plan = check(&dictionary, method, &settings(bounds(size_m_s)), case, 0.05);
            assert_eq!(plan.checks.active[ConstraintFamily::Activations], 0);
        }
    }
}

#[test]
fn infeasible_bounds_are_an_answer() {
    let dictionary = smooth(DictionaryKind::Nmf, 12, 10);
    // Every coordinate has to rise all the time, which waves cannot.
    let rising = VelocityBounds {
        min_m_s: [0.01; SEGMENT_COORDINATES],
        max_m_s: [1.0; SEGMENT_COORDINATES],
    };
    for method in Method::ALL {
        let plan = check(&dictionary, method, &settings(rising), 0, 0.02);
        assert_eq!(plan.status, PlanStatus::Infeasible);
    }
}

#[test]
fn degenerate_equal_bounds_equal_rows_and_equal_primitives() {
    // Standing still is the only motion allowed, each bound twice, and every primitive comes twice.
    let mut dictionary = smooth(DictionaryKind::Nmf, 12, 10);
    let half = dictionary.primitives.columns(0, 5).into_owned();
    dictionary.primitives.columns_mut(5, 5).copy_from(&half);
    for method in Method::ALL {
        let plan = check(&dictionary, method, &settings(bounds(0.0)), 0, 0.02);
        assert!(plan.activations_m.amax() < 1e-12, "only zero stands still");
        check(&dictionary, method, &settings(bounds(0.05)), 0, 0.02);
    }
    // Coordinates that move alike: rows of the constraints are copies of each other.
    let mut dictionary = smooth(DictionaryKind::Nmf, 12, 10);
    for row in 0..dictionary.layout.rows() {
        let copied = row - row % SEGMENT_COORDINATES;
        let source = dictionary.primitives.row(copied).into_owned();
        dictionary.primitives.row_mut(row).copy_from(&source);
    }
    for method in Method::ALL {
        check(&dictionary, method, &settings(bounds(0.02)), 0, 0.02);
    }
}

#[test]
fn ill_conditioned_covariance_and_sharp_targets() {
    let mut dictionary = smooth(DictionaryKind::Nmf, 12, 10);
    // Standard deviations from 1 µm to 1 m.
    dictionary.activation_covariance_m2 = DMatrix::from_fn(10, 10, |i, j| {
        if i == j {
            10_f64.powf(-12.0 + 12.0 * i as f64 / 9.0)
        } else {
            0.0
        }
    });
    let sharp = PlannerSettings {
        ends: Ends::Soft { sigma_m: 1e-6 },
        ..settings(bounds(0.1))
    };
    for settings in [settings(bounds(0.1)), sharp] {
        let ends = ends(&dictionary, 0, 0.002);
        let target = Method::Prior.target(&ends);
        let planner = Planner::new(&dictionary, Method::Prior, &settings).unwrap();
        let plan = planner.plan(&target).unwrap();
        assert_eq!(plan.status, PlanStatus::Solved, "{plan:?}");
        // The plain solver loses digits here, so the proof is the judge: no point is better.
        if let Answer::Solved(h_mm) = plain(&dictionary, Method::Prior, &settings, &ends).solve() {
            let plain = plain(&dictionary, Method::Prior, &settings, &ends);
            let own = plain.objective(&(&plan.activations_m * 1e3));
            assert!(own <= plain.objective(&h_mm) * (1.0 + 1e-6));
        }
    }
}
