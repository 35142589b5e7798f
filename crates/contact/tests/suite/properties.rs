//! Properties for any points, drawn so that many repeat, line up or share a plane.

use std::collections::BTreeSet;

use inhand_contact::{ContactError, HullProbe, hull, hull_distance_m, inside, surface_distance_m};
use inhand_model::{Hull, Object, Position, Shape};
use proptest::prelude::*;

use crate::{fibonacci_sphere, is_closed, positions, volume_m3};

/// How far rounding may carry a point out of its own hull, metres.
const ROUNDING_M: f64 = 1e-9;

/// Points of a small integer grid, in millimetres.
fn grid_points() -> impl Strategy<Value = Vec<[i64; 3]>> {
    prop::collection::vec(prop::array::uniform3(-2_i64..=2), 4..14)
}

/// A wandering path in small steps, some of them none.
fn path() -> impl Strategy<Value = Vec<[f64; 3]>> {
    prop::collection::vec(prop::array::uniform3(-3_i32..=3), 150..1500).prop_map(|steps| {
        let mut at = [0_i32; 3];
        (steps.into_iter())
            .map(|step| {
                for axis in 0..3 {
                    at[axis] += step[axis];
                }
                at.map(|c| f64::from(c) * 1e-4)
            })
            .collect()
    })
}

fn cloud() -> impl Strategy<Value = Vec<[f64; 3]>> {
    prop::collection::vec(prop::array::uniform3(-0.03..0.03), 4..60)
}

fn metres(points: &[[i64; 3]]) -> Vec<[f64; 3]> {
    // Exact in binary, so that what is coplanar stays coplanar.
    points
        .iter()
        .map(|p| p.map(|c| c as f64 / 1024.0))
        .collect()
}

/// Normal and offset in lowest terms.
type IntegerPlane = [i64; 4];

/// The outward plane through three points, unless they are in line.
fn integer_plane([a, b, c]: [[i64; 3]; 3]) -> Option<IntegerPlane> {
    let (u, v) = (
        [0, 1, 2].map(|i| b[i] - a[i]),
        [0, 1, 2].map(|i| c[i] - a[i]),
    );
    let n = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    let gcd = |mut a: i64, mut b: i64| {
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a.abs()
    };
    let divisor = n.into_iter().fold(0, gcd);
    (divisor != 0).then(|| {
        let n = n.map(|c| c / divisor);
        [n[0], n[1], n[2], n[0] * a[0] + n[1] * a[1] + n[2] * a[2]]
    })
}

fn height([x, y, z, offset]: IntegerPlane, p: [i64; 3]) -> i64 {
    x * p[0] + y * p[1] + z * p[2] - offset
}

/// Every plane through three points that has all points on or below it, found by trying them all.
fn supporting_planes(points: &[[i64; 3]]) -> BTreeSet<IntegerPlane> {
    let mut planes = BTreeSet::new();
    for &a in points {
        for &b in points {
            for &c in points {
                planes.extend(
                    integer_plane([a, b, c])
                        .filter(|&plane| points.iter().all(|&p| height(plane, p) <= 0)),
                );
            }
        }
    }
    planes
}

fn check_hull(hull: &Hull, points: &[[f64; 3]]) {
    assert!(is_closed(hull));
    assert!(volume_m3(hull) > 0.0);
    for &p in points {
        assert!(inside(hull, p, ROUNDING_M), "{p:?}");
        assert!(hull_distance_m(hull, p) <= ROUNDING_M, "{p:?}");
    }
    for corner in &hull.vertices_m {
        assert!(points.contains(corner));
        assert!(
            hull_distance_m(hull, *corner).abs() <= ROUNDING_M,
            "{corner:?}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn hull_of_grid_points_is_that_of_brute_force(points in grid_points()) {
        let expected = supporting_planes(&points);
        let in_metres = metres(&points);
        let hull = match hull(&positions(&in_metres)) {
            Ok(hull) => hull,
            Err(ContactError::Flat { .. }) => {
                // All in one plane: it supports them from both sides. Or in a line: there is none.
                let both_sides = expected.iter().any(|plane| expected.contains(&plane.map(|c| -c)));
                prop_assert!(expected.is_empty() || both_sides);
                return Ok(());
            }
            Err(other) => return Err(TestCaseError::fail(other.to_string())),
        };
        check_hull(&hull, &in_metres);
        let grid = |corner: &u32| hull.vertices_m[*corner as usize].map(|c| (c * 1024.0) as i64);
        let found: BTreeSet<IntegerPlane> = (hull.triangles.iter())
            .map(|[a, b, c]| integer_plane([grid(a), grid(b), grid(c)]).expect("triangles have an area"))
            .collect();
        prop_assert_eq!(&found, &expected);
        // Corners are where three planes or more meet.
        let corners: BTreeSet<[i64; 3]> = (points.iter().copied())
            .filter(|&p| expected.iter().filter(|&&plane| height(plane, p) == 0).count() >= 3)
            .collect();
        let found: BTreeSet<[i64; 3]> = (0..hull.vertices_m.len() as u32).map(|c| grid(&c)).collect();
        prop_assert_eq!(found, corners);
    }

    #[test]
    fn hull_of_a_cloud_holds_all_its_points(points in cloud()) {
        check_hull(&hull(&positions(&points)).unwrap(), &points);
    }

    #[test]
    fn distance_to_a_hull_is_a_distance(
        points in cloud(),
        p in prop::array::uniform3(-0.08..0.08),
        step in prop::array::uniform3(-0.002..0.002),
        weights in prop::collection::vec(0.0..1.0, 60),
    ) {
        let hull = hull(&positions(&points)).unwrap();
        let d = hull_distance_m(&hull, p);
        prop_assert_eq!(d <= 0.0, inside(&hull, p, 0.0));
        // No farther than any point of the hull.
        let total: f64 = weights.iter().take(points.len()).sum();
        prop_assume!(total > 1e-3);
        let mut mixed = nalgebra::Vector3::zeros();
        for (point, weight) in points.iter().zip(&weights) {
            mixed += nalgebra::Vector3::from(*point) * (weight / total);
        }
        prop_assert!(d <= (mixed - nalgebra::Vector3::from(p)).norm() + 1e-15);
        for corner in &hull.vertices_m {
            let to_corner = nalgebra::Vector3::from(*corner) - nalgebra::Vector3::from(p);
            prop_assert!(d.abs() <= to_corner.norm() + 1e-15);
        }
        // Changes by no more than the point moves.
        let moved = [0, 1, 2].map(|i| p[i] + step[i]);
        let change = (hull_distance_m(&hull, moved) - d).abs();
        prop_assert!(change <= nalgebra::Vector3::from(step).norm() + 1e-15);
    }

    #[test]
    fn distance_to_a_shape_is_a_distance(
        edges_m in prop::array::uniform3(0.01..0.08),
        is_box in any::<bool>(),
        p in prop::array::uniform3(-0.08..0.08),
        q in prop::array::uniform3(-0.08..0.08),
        on in prop::array::uniform3(-1.0..1.0),
        face in 0..3_usize,
    ) {
        let [a, b, c] = edges_m;
        let shape = if is_box {
            Shape::Cuboid { edges_m }
        } else {
            Shape::Cylinder { diameter_m: a, height_m: c }
        };
        // A point of the surface.
        let mut on: [f64; 3] = on;
        if is_box {
            on[face] = on[face].signum();
            on = [on[0] * a / 2.0, on[1] * b / 2.0, on[2] * c / 2.0];
        } else {
            let angle = on[0] * std::f64::consts::PI;
            let (radius, z) = if face == 0 { (1.0, on[2]) } else { (on[1].abs(), on[2].signum()) };
            on = [radius * a / 2.0 * angle.cos(), radius * a / 2.0 * angle.sin(), z * c / 2.0];
        }
        let distance = |p: [f64; 3]| surface_distance_m(&shape, Position::<Object>::from(p));
        let between = |p: [f64; 3], q: [f64; 3]| {
            (nalgebra::Vector3::from(p) - nalgebra::Vector3::from(q)).norm()
        };
        prop_assert!(distance(on).abs() < 1e-15, "{shape} {on:?}");
        prop_assert!(distance(p).abs() <= between(p, on) + 1e-15, "{shape} {p:?} {on:?}");
        prop_assert!((distance(p) - distance(q)).abs() <= between(p, q) + 1e-15);
        let within = if is_box {
            (0..3).all(|i| p[i].abs() <= edges_m[i] / 2.0)
        } else {
            p[0].hypot(p[1]) <= a / 2.0 && p[2].abs() <= c / 2.0
        };
        prop_assert_eq!(distance(p) <= 0.0, within);
    }
}

proptest! {
    // Each case has hundreds of points.
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn hull_of_a_path_holds_it_in_any_order(points in path()) {
        let forward = match hull(&positions(&points)) {
            Ok(hull) => hull,
            Err(ContactError::Flat { .. }) => return Ok(()),
            Err(other) => return Err(TestCaseError::fail(other.to_string())),
        };
        check_hull(&forward, &points);
        let reversed: Vec<_> = points.iter().rev().copied().collect();
        let backward = hull(&positions(&reversed)).unwrap();
        let sorted = |hull: &Hull| {
            let mut corners = hull.vertices_m.clone();
            corners.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
            corners.dedup();
            corners
        };
        prop_assert_eq!(sorted(&forward), sorted(&backward));
        prop_assert_eq!(sorted(&forward).len(), forward.vertices_m.len());
    }

    #[test]
    fn a_probe_gives_the_same_as_a_look_at_every_plane(points in path(), queries in path()) {
        let Ok(hull) = hull(&positions(&points)) else { return Ok(()) };
        let mut probe = HullProbe::new(&hull);
        for p in queries {
            prop_assert_eq!(probe.distance_m(p), hull_distance_m(&hull, p));
        }
    }

    #[test]
    fn faces_of_many_triangles_are_at_no_distance(
        turn in prop::array::uniform3(-3.0..3.0),
        corners in 5..40_u32,
        weights in prop::collection::vec(0.0..1.0, 40),
    ) {
        // A prism turned so that rounding leaves the triangles of a face nearly in one plane.
        let turn = nalgebra::Rotation3::new(nalgebra::Vector3::from(turn));
        let corner = |k: u32, z: f64| {
            let angle = f64::from(k) * std::f64::consts::TAU / f64::from(corners);
            turn * nalgebra::Vector3::new(0.03 * angle.cos(), 0.03 * angle.sin(), z)
        };
        let ends: Vec<[f64; 3]> = (0..corners)
            .flat_map(|k| [corner(k, 0.02).into(), corner(k, -0.02).into()])
            .collect();
        let hull = hull(&positions(&ends)).unwrap();
        let weights = &weights[..corners as usize];
        let total: f64 = weights.iter().sum();
        prop_assume!(total > 1e-3);
        let mut on_face = nalgebra::Vector3::zeros();
        for (k, weight) in weights.iter().enumerate() {
            on_face += corner(k as u32, 0.02) * (weight / total);
        }
        let distance = hull_distance_m(&hull, on_face.into());
        prop_assert!(distance.abs() < 1e-15, "{}", distance);
        let above = on_face + turn * nalgebra::Vector3::new(0.0, 0.0, 0.004);
        prop_assert!((hull_distance_m(&hull, above.into()) - 0.004).abs() < 1e-15);
        for corner in &hull.vertices_m {
            prop_assert!(hull_distance_m(&hull, *corner).abs() < 1e-15);
        }
        // Rounding errors beside the surface too, outside is outside.
        for k in -20..20 {
            let beside = on_face + turn * nalgebra::Vector3::new(0.0, 0.0, f64::from(k) * 1e-18);
            let distance = hull_distance_m(&hull, beside.into());
            prop_assert_eq!(distance <= 0.0, inside(&hull, beside.into(), 0.0));
        }
    }
}

#[test]
fn a_probe_misses_no_plane_on_the_way_through() {
    // Through the middle of a ball the highest plane changes to the opposite one within a step.
    let hull = hull(&positions(&fibonacci_sphere(1000, 0.03))).unwrap();
    for direction in [[1.0, 0.0, 0.0], [0.48, -0.6, 0.64], [0.0, 0.8, 0.6]] {
        for start in 0..40 {
            let mut probe = HullProbe::new(&hull);
            for step in 0..60 {
                let along_m = -0.011 + f64::from(start) * 1e-4 + f64::from(step) * 2.5e-4;
                let p = direction.map(|c| c * along_m);
                assert_eq!(probe.distance_m(p), hull_distance_m(&hull, p), "{p:?}");
            }
        }
    }
}
