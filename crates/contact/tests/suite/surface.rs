//! Distances to box and cylinder against their closed forms.
//!
//! With `q` how far a point lies beyond each perpendicular pair of faces, the distance is
//! `|max(q, 0)| + min(max_i q_i, 0)`; a cylinder is a box in the plane of radius and height.

use inhand_contact::surface_distance_m;
use inhand_model::{Object, Position, Shape};
use proptest::prelude::*;

/// Both sides round at 1e-16 of some decimetres.
const NEAR_M: f64 = 1e-12;

fn closed_form_m(shape: &Shape, [x, y, z]: [f64; 3]) -> f64 {
    match *shape {
        Shape::Cuboid { edges_m: [a, b, c] } => {
            beyond_faces_m(&[x.abs() - a / 2.0, y.abs() - b / 2.0, z.abs() - c / 2.0])
        }
        Shape::Cylinder {
            diameter_m,
            height_m,
        } => beyond_faces_m(&[x.hypot(y) - diameter_m / 2.0, z.abs() - height_m / 2.0]),
    }
}

fn beyond_faces_m(beyond_m: &[f64]) -> f64 {
    let highest = beyond_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let outside: f64 = beyond_m.iter().map(|d| d.max(0.0).powi(2)).sum();
    outside.sqrt() + highest.min(0.0)
}

fn check(shape: &Shape, p: [f64; 3]) {
    let found = surface_distance_m(shape, Position::<Object>::from(p));
    let expected = closed_form_m(shape, p);
    assert!(
        (found - expected).abs() < NEAR_M,
        "{shape} at {p:?}: expected {expected}, found {found}"
    );
}

/// Cubes, slabs and rods; cylinders of which the centre is nearest to the side, to the caps, to both.
fn shapes() -> Vec<Shape> {
    let boxes = [[0.05; 3], [0.04, 0.06, 0.08], [0.1, 0.1, 0.002]];
    let cylinders = [
        (0.05, 0.05),
        (0.04, 0.09),
        (0.09, 0.02),
        (0.3, 1e-4),
        (2e-3, 0.2),
    ];
    let boxes = boxes.map(|edges_m| Shape::Cuboid { edges_m });
    let cylinders = cylinders.map(|(diameter_m, height_m)| Shape::Cylinder {
        diameter_m,
        height_m,
    });
    boxes.into_iter().chain(cylinders).collect()
}

fn half_extents_m(shape: &Shape) -> [f64; 3] {
    match *shape {
        Shape::Cuboid { edges_m } => edges_m.map(|edge| edge / 2.0),
        Shape::Cylinder {
            diameter_m,
            height_m,
        } => [diameter_m / 2.0, diameter_m / 2.0, height_m / 2.0],
    }
}

#[test]
fn faces_edges_corners_and_planes_of_symmetry() {
    // The middle, where several surface points are nearest; the surface; a rounding error beside
    // each; far away.
    let shares: Vec<f64> = [
        0.0,
        1e-16,
        0.3,
        0.5,
        1.0 - 1e-16,
        1.0,
        1.0 + 3e-16,
        1.4,
        60.0,
    ]
    .into_iter()
    .flat_map(|share| [share, -share])
    .collect();
    for shape in shapes() {
        let [a, b, c] = half_extents_m(&shape);
        for &u in &shares {
            for &v in &shares {
                for &w in &shares {
                    check(&shape, [u * a, v * b, w * c]);
                    // Round a cylinder: on its axis, side and rims.
                    let (sin, cos) = (7.0 * v).sin_cos();
                    check(&shape, [u * a * cos, u * b * sin, w * c]);
                }
            }
        }
    }
}

#[test]
fn as_deep_below_the_side_as_below_the_caps() {
    for shape in shapes() {
        let [a, b, c] = half_extents_m(&shape);
        let least = a.min(b).min(c);
        for k in 0..=20 {
            let depth = least * f64::from(k) / 20.0;
            for [x, y, z] in [[1.0, 0.0, 1.0], [0.6, 0.8, -1.0], [-1.0, 0.0, 0.0]] {
                check(&shape, [(a - depth) * x, (b - depth) * y, (c - depth) * z]);
            }
        }
    }
}

#[test]
fn the_middle_of_a_disc_is_nearest_to_its_caps() {
    let disc = Shape::Cylinder {
        diameter_m: 0.04,
        height_m: 0.01,
    };
    for p in [[0.0; 3], [0.003, -0.004, 0.0], [0.0, 0.014, -0.0]] {
        let found = surface_distance_m(&disc, Position::from(p));
        assert!((found + 0.005).abs() < 1e-15, "{p:?}: {found}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn anywhere(
        edges_m in prop::array::uniform3(1e-3..0.2),
        is_box in any::<bool>(),
        p in prop::array::uniform3(-0.2..0.2),
    ) {
        let [a, _, c] = edges_m;
        let shape = if is_box {
            Shape::Cuboid { edges_m }
        } else {
            Shape::Cylinder { diameter_m: a, height_m: c }
        };
        check(&shape, p);
    }
}
