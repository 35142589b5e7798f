//! Against SciPy, NumPy and quadprog; `../reference/make_contact.py` made the numbers.

use inhand_contact::{hull, hull_distance_m, inside, surface_distance_m};
use inhand_model::{Position, Shape};
use serde_json::Value;

use crate::{area_m2, is_closed, positions, volume_m3};

/// Both sides round at 1e-16 of some centimetres; quadprog's projection is good to 1e-13 of that.
const DISTANCE_TOLERANCE_M: f64 = 1e-12;

fn recorded() -> Value {
    serde_json::from_str(include_str!("../reference/contact.json")).expect("written by the script")
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list");
    list.iter().map(|v| v.as_f64().expect("a number")).collect()
}

fn triples(value: &Value) -> Vec<[f64; 3]> {
    let list = value.as_array().expect("a list");
    list.iter()
        .map(|v| numbers(v).try_into().expect("three numbers"))
        .collect()
}

#[test]
fn hulls_agree_with_qhull() {
    let recorded = recorded();
    let cases = recorded["hulls"].as_array().unwrap();
    assert_eq!(cases.len(), 4);
    for case in cases {
        let name = &case["name"];
        let points = triples(&case["points_m"]);
        let hull = hull(&positions(&points)).unwrap();
        assert!(is_closed(&hull), "{name}");

        let volume = case["volume_m3"].as_f64().unwrap();
        assert!((volume_m3(&hull) / volume - 1.0).abs() < 1e-11, "{name}");
        let area = case["area_m2"].as_f64().unwrap();
        assert!((area_m2(&hull) / area - 1.0).abs() < 1e-11, "{name}");
        if let Some(corners) = case["corners"].as_array() {
            let corners: Vec<[f64; 3]> = corners
                .iter()
                .map(|k| points[k.as_u64().unwrap() as usize])
                .collect();
            assert_eq!(hull.vertices_m, corners, "{name}");
        }

        let expected = numbers(&case["distance_m"]);
        assert!(expected.iter().any(|&d| d < 0.0) && expected.iter().any(|&d| d > 0.0));
        for (p, expected) in triples(&case["queries_m"]).into_iter().zip(expected) {
            let found = hull_distance_m(&hull, p);
            assert!(
                (found - expected).abs() < DISTANCE_TOLERANCE_M,
                "{name} at {p:?}: expected {expected}, found {found}"
            );
            assert_eq!(inside(&hull, p, 0.0), expected <= 0.0, "{name} at {p:?}");
        }
    }
}

#[test]
fn surface_distances_agree_with_numpy() {
    let recorded = recorded();
    let cases = recorded["shapes"].as_array().unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        let shape: Shape = case["shape"].as_str().unwrap().parse().unwrap();
        let expected = numbers(&case["distance_m"]);
        for (p, expected) in triples(&case["queries_m"]).into_iter().zip(expected) {
            let found = surface_distance_m(&shape, Position::from(p));
            assert!(
                (found - expected).abs() < 1e-15,
                "{shape} at {p:?}: expected {expected}, found {found}"
            );
        }
    }
}
