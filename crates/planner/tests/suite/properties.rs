//! Properties for every target and every bound.

use inhand_model::{DictionaryKind, PlanStatus, SEGMENT_COORDINATES};
use inhand_planner::{Method, Planner, Target, plan_all};
use proptest::prelude::*;

use crate::support::{bounds, settings, smooth, target};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn plans_keep_their_bounds_and_prove_their_optimum(
        case in 0_usize..1000,
        reach in 0.0..0.05,
        size_m_s in 0.02..0.5,
        method in proptest::sample::select(Method::ALL.to_vec()),
        kind in proptest::sample::select(vec![DictionaryKind::Nmf, DictionaryKind::Pca]),
    ) {
        let dictionary = smooth(kind, 25, 30);
        let planner = Planner::new(&dictionary, method, &settings(bounds(size_m_s))).unwrap();
        let plan = planner.plan(&target(method, &dictionary, case, reach)).unwrap();
        // Zero activations stand still, so there always is a solution.
        prop_assert_eq!(plan.status, PlanStatus::Solved);
        prop_assert!(plan.certificate.worst() <= 1e-6);
        if kind == DictionaryKind::Nmf {
            prop_assert!(plan.activations_m.min() >= 0.0);
        }
        let trajectory = plan.trajectory.unwrap();
        let values_m = trajectory.values_m();
        for (now, next) in values_m.iter().zip(&values_m[SEGMENT_COORDINATES..]) {
            let velocity_m_s = (next - now) * dictionary.layout.rate_hz;
            prop_assert!(velocity_m_s.abs() <= size_m_s * (1.0 + 1e-6));
        }
        let rebuilt = &dictionary.offset_m + &dictionary.primitives * &plan.activations_m;
        for (a, b) in rebuilt.iter().zip(values_m) {
            prop_assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn tighter_bounds_never_cost_less(case in 0_usize..1000, reach in 0.0..0.03) {
        let dictionary = smooth(DictionaryKind::Nmf, 20, 20);
        let target = target(Method::Prior, &dictionary, case, reach);
        let mut least = 0.0;
        for size_m_s in [1.0, 0.2, 0.1, 0.05, 0.02] {
            let planner =
                Planner::new(&dictionary, Method::Prior, &settings(bounds(size_m_s))).unwrap();
            let objective = planner.plan(&target).unwrap().objective;
            prop_assert!(objective >= least * (1.0 - 1e-9));
            least = objective;
        }
    }
}

#[test]
fn many_targets_come_back_in_order_and_equal_to_the_bit() {
    let dictionary = smooth(DictionaryKind::Nmf, 25, 30);
    let planner = Planner::new(&dictionary, Method::Prior, &settings(bounds(0.1))).unwrap();
    let targets: Vec<Target> = (0..40)
        .map(|case| target(Method::Prior, &dictionary, case, 0.02))
        .collect();
    let together = plan_all(&planner, &targets);
    assert_eq!(together.len(), targets.len());
    for (target, (plan, _)) in targets.iter().zip(together) {
        assert_eq!(planner.plan(target).unwrap(), plan.unwrap());
    }
}
