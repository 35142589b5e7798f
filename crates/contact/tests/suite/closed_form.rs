//! Hulls and distances that can be written down.

use inhand_contact::{HullProbe, hull, hull_distance_m, inside};
use inhand_model::Hull;

use crate::{area_m2, fibonacci_sphere, is_closed, positions, volume_m3};

/// The corners of a box around the origin.
fn box_corners([a, b, c]: [f64; 3]) -> Vec<[f64; 3]> {
    (0..8)
        .map(|k| {
            let side = |bit: i32, edge: f64| {
                if k & bit == 0 {
                    -edge / 2.0
                } else {
                    edge / 2.0
                }
            };
            [side(1, a), side(2, b), side(4, c)]
        })
        .collect()
}

fn check_distance(hull: &Hull, p: [f64; 3], expected_m: f64) {
    let found = hull_distance_m(hull, p);
    assert!(
        (found - expected_m).abs() < 1e-15,
        "at {p:?}: expected {expected_m}, found {found}"
    );
    assert_eq!(HullProbe::new(hull).distance_m(p), found, "at {p:?}");
    assert_eq!(inside(hull, p, 0.0), found <= 0.0, "at {p:?}");
}

#[test]
fn distances_to_a_box() {
    let hull = hull(&positions(&box_corners([0.04, 0.06, 0.08]))).unwrap();
    check_distance(&hull, [0.0, 0.0, 0.0], -0.02);
    check_distance(&hull, [0.0, 0.029, 0.0], -0.001);
    check_distance(&hull, [0.0, 0.03, 0.0], 0.0);
    check_distance(&hull, [-0.025, 0.01, -0.03], 0.005); // face
    check_distance(&hull, [0.0, -0.033, 0.044], 0.005); // edge, 3-4-5
    check_distance(&hull, [0.022, 0.033, 0.046], 0.007); // corner, 2-3-6-7
}

#[test]
fn every_point_of_a_grid_on_a_box_leaves_eight_corners() {
    // 2402 points, nearly all within a face or an edge of the others, some three times.
    let mut points = Vec::new();
    let ticks = || (0..=20).map(|k| f64::from(k) * 0.001);
    for u in ticks() {
        for v in ticks() {
            for end in [0.0, 0.02] {
                points.extend([[u, v, end], [end, u, v], [v, end, u]]);
            }
        }
    }
    let hull = hull(&positions(&points)).unwrap();
    assert_eq!(hull.vertices_m.len(), 8);
    assert_eq!(hull.triangles.len(), 12);
    assert!(is_closed(&hull));
    assert!((volume_m3(&hull) - 8e-6).abs() < 1e-18);
    assert!((area_m2(&hull) - 2.4e-3).abs() < 1e-15);
}

#[test]
fn points_of_a_sphere_are_all_corners() {
    // The hull approaches the ball from inside.
    let radius = 0.03;
    let points = fibonacci_sphere(1000, radius);
    let hull = hull(&positions(&points)).unwrap();
    assert_eq!(hull.vertices_m, points);
    assert_eq!(hull.triangles.len(), 2 * points.len() - 4);
    assert!(is_closed(&hull));
    let ball = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let share = volume_m3(&hull) / ball;
    assert!(share > 0.985 && share < 1.0, "{share}");
    let centre = hull_distance_m(&hull, [0.0; 3]);
    assert!(centre > -radius && centre < -0.99 * radius, "{centre}");
}

#[test]
fn planes_point_outwards_and_belong_to_their_triangles() {
    let hull = hull(&positions(&box_corners([0.02, 0.03, 0.05]))).unwrap();
    for ((triangle, normal), offset) in hull
        .triangles
        .iter()
        .zip(&hull.normals)
        .zip(&hull.offsets_m)
    {
        let normal = nalgebra::Vector3::from(*normal);
        assert!((normal.norm() - 1.0).abs() < 1e-15);
        assert!(*offset > 0.0, "the origin is inside");
        for corner in triangle {
            let corner = nalgebra::Vector3::from(hull.vertices_m[*corner as usize]);
            assert!((normal.dot(&corner) - offset).abs() < 1e-17);
        }
    }
}

#[test]
fn tolerance_moves_the_surface_of_inside() {
    let hull = hull(&positions(&box_corners([0.02; 3]))).unwrap();
    assert!(!inside(&hull, [0.0105, 0.0, 0.0], 0.0));
    assert!(inside(&hull, [0.0105, 0.0, 0.0], 0.000_500_1));
    assert!(!inside(&hull, [0.0105, 0.0, 0.0], 0.000_499_9));
    assert!(!inside(&hull, [0.0099, 0.0, 0.0], -0.000_2));
}
