//! Refused input, and results of unknown numbers.

use inhand_contact::{ContactError, HullProbe, hull, hull_distance_m, inside};
use inhand_model::Hull;

use crate::positions;

const TETRAHEDRON: [[f64; 3]; 4] = [
    [0.0; 3],
    [0.01, 0.0, 0.0],
    [0.0, 0.01, 0.0],
    [0.0, 0.0, 0.01],
];

fn error(points: &[[f64; 3]]) -> ContactError {
    hull(&positions(points)).expect_err("these points have no hull")
}

#[test]
fn too_few_points() {
    for found in 0..4 {
        assert_eq!(
            error(&TETRAHEDRON[..found]),
            ContactError::TooFewPoints { found }
        );
    }
    assert!(hull(&positions(&TETRAHEDRON)).is_ok());
}

#[test]
fn not_finite_is_counted_and_placed() {
    let mut points = [TETRAHEDRON, TETRAHEDRON].concat();
    points[2][1] = f64::NAN;
    points[5][0] = f64::INFINITY;
    let found = error(&points);
    assert_eq!(
        found,
        ContactError::NotFinite {
            points: 8,
            not_finite: 2,
            first: 2
        }
    );
    assert!(found.to_string().contains("2 of 8 points"), "{found}");
}

#[test]
fn coordinates_beyond_any_volume() {
    let mut points = TETRAHEDRON;
    points[1][2] = -1e200;
    assert_eq!(
        error(&points),
        ContactError::TooFar {
            first: 1,
            found_m: 1e200,
            limit_m: 1e9
        }
    );
}

#[test]
fn points_without_volume() {
    let place = [[0.1, 0.2, 0.3]; 500];
    let line: Vec<_> = (0..500)
        .map(|k| [f64::from(k) * 1e-4, f64::from(k) * 2e-4, 0.7])
        .collect();
    let plane: Vec<_> = (0..500)
        .map(|k| {
            [
                f64::from(k % 20) * 1e-3,
                f64::from(k / 20) * 1e-3,
                f64::from(k % 20) * 1e-3,
            ]
        })
        .collect();
    for (points, extent) in [
        (&place[..], 0.0..=0.0),
        (&line, 0.11..=0.12),
        (&plane, 0.02..=0.04),
    ] {
        let ContactError::Flat {
            points: count,
            extent_m,
            thickness_m,
            needed_m,
        } = error(points)
        else {
            panic!("{:?}", error(points));
        };
        assert_eq!((count, needed_m), (500, 1e-9));
        assert!(extent.contains(&extent_m), "{extent_m}");
        assert!(thickness_m < 1e-15, "{thickness_m}");
    }
}

#[test]
fn a_nanometre_is_the_limit() {
    let sheet = |thickness: f64| {
        let mut points: Vec<_> = (0..300)
            .map(|k| [f64::from(k % 20) * 1e-3, f64::from(k / 20) * 1e-3, 0.0])
            .collect();
        points[137][2] = thickness;
        points
    };
    assert!(matches!(error(&sheet(0.5e-9)), ContactError::Flat { .. }));
    let thin = hull(&positions(&sheet(1e-8))).unwrap();
    assert_eq!(thin.vertices_m.len(), 5);
}

#[test]
fn unknown_points_are_not_inside() {
    let hull = hull(&positions(&TETRAHEDRON)).unwrap();
    for axis in 0..3 {
        let mut p = [0.001; 3];
        assert!(inside(&hull, p, 0.0));
        p[axis] = f64::NAN;
        assert!(hull_distance_m(&hull, p).is_nan());
        assert!(HullProbe::new(&hull).distance_m(p).is_nan());
        assert!(!inside(&hull, p, 1.0));
    }
    let far = [f64::NEG_INFINITY, 0.0, 0.0];
    assert!(!inside(&hull, far, 1.0));
    assert_eq!(hull_distance_m(&hull, far), f64::INFINITY);
    // A probe recovers from a missing sample.
    let mut probe = HullProbe::new(&hull);
    assert!(probe.distance_m([f64::NAN; 3]).is_nan());
    assert_eq!(
        probe.distance_m([0.001; 3]),
        hull_distance_m(&hull, [0.001; 3])
    );
}

#[test]
fn a_hull_without_planes_holds_nothing() {
    let none = Hull {
        vertices_m: vec![],
        triangles: vec![],
        normals: vec![],
        offsets_m: vec![],
    };
    assert!(!inside(&none, [0.0; 3], 1.0));
    assert!(hull_distance_m(&none, [0.0; 3]).is_nan());
    assert!(HullProbe::new(&none).distance_m([0.0; 3]).is_nan());
}
