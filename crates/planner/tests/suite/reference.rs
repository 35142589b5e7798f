//! Recorded optima of quadprog (`reference/solve_with_quadprog.py`).

use inhand_model::{ConstraintFamily, DictionaryKind, PlanStatus};
use inhand_planner::{Backend, Method, Planner};
use serde_json::Value;

use crate::support::{bounds, settings, smooth, target};

#[test]
fn agrees_with_quadprog_in_activations_and_objective() {
    let recorded: Value = serde_json::from_str(include_str!("../reference/quadprog.json")).unwrap();
    let number = |v: &Value| v.as_f64().unwrap();
    let samples = number(&recorded["samples"]) as usize;
    let rank = number(&recorded["rank"]) as usize;
    let cases = recorded["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 12);
    let mut active = 0;
    for case in cases {
        let method = match case["method"].as_str().unwrap() {
            "paper" => Method::Paper,
            _ => Method::Prior,
        };
        let kind = match case["kind"].as_str().unwrap() {
            "nmf" => DictionaryKind::Nmf,
            _ => DictionaryKind::Pca,
        };
        let dictionary = smooth(kind, samples, rank);
        let target = target(
            method,
            &dictionary,
            number(&case["case"]) as usize,
            number(&case["reach_m"]),
        );
        let settings = settings(bounds(number(&case["velocity_m_s"])));
        let planner = Planner::new(&dictionary, method, &settings).unwrap();
        for backend in [Backend::ActiveSet, Backend::Clarabel] {
            let plan = planner.clone().with_backend(backend).plan(&target).unwrap();
            assert_eq!(plan.status, PlanStatus::Solved);
            let objective = number(&case["objective"]);
            assert!((plan.objective - objective).abs() <= 1e-9 * objective.max(1.0));
            let recorded = case["activations_m"].as_array().unwrap();
            for (own, other) in plan.activations_m.iter().zip(recorded) {
                assert!((own - number(other)).abs() < 1e-9, "{method:?} {backend:?}");
            }
            active += plan.checks.active[ConstraintFamily::Velocity]
                + plan.checks.active[ConstraintFamily::Activations];
        }
    }
    assert!(active > 50, "the cases must have active bounds: {active}");
}
