//! Distances to a cloud of points on an object's surface, as the paper measures them.

use std::f64::consts::{PI, TAU};

use inhand_model::{Object, Position, Shape};

use crate::grid::PointGrid;
use crate::surface::surface_distance_m;

/// Points spread evenly over the surface of an object.
///
/// Each face has as many points as its share of the area; on it they follow the additive recurrence of the
/// plastic number (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences"), which leaves
/// no clusters and no holes. The same shape and number give the same points.
///
/// ```
/// use inhand_contact::{SurfaceCloud, surface_distance_m};
/// use inhand_model::{Position, Shape};
///
/// let cube = Shape::Cuboid { edges_m: [0.05; 3] };
/// let cloud = SurfaceCloud::new(&cube, 50_000);
/// let tip = Position::new(0.028, 0.004, 0.011);
/// let (near_m, exact_m) = (cloud.distance_m(tip), surface_distance_m(&cube, tip));
/// // Never nearer than the surface, and with points half a millimetre apart hardly farther.
/// assert!(near_m >= exact_m && near_m < exact_m + 5e-5);
/// ```
#[derive(Clone, Debug)]
pub struct SurfaceCloud {
    shape: Shape,
    points: PointGrid,
}

impl SurfaceCloud {
    /// A cloud of so many points.
    pub fn new(shape: &Shape, points: usize) -> Self {
        let faces = faces(shape);
        let area: f64 = faces.iter().map(|face| face.area_m2).sum();
        let (mut on, mut placed) = (Vec::with_capacity(points), 0.0);
        for face in &faces {
            // Rounded as a running total, so that the shares add up.
            placed += face.area_m2;
            let end = (points as f64 * placed / area).round() as usize;
            let wanted = end.saturating_sub(on.len());
            on.extend((0..wanted).map(|k| (face.at)(even(k))));
        }
        Self {
            shape: *shape,
            points: PointGrid::new(&on, (area / points as f64).sqrt()),
        }
    }

    /// Points of the cloud.
    pub fn size(&self) -> usize {
        self.points.points().len()
    }

    /// Distance to the nearest point of the cloud, metres: infinite for a cloud without points, NaN for a
    /// coordinate that is not finite.
    pub fn distance_m(&self, p: Position<Object>) -> f64 {
        if !p.is_finite() {
            return f64::NAN;
        }
        // No point is nearer than the surface.
        let surface_m = surface_distance_m(&self.shape, p).abs();
        self.points.nearest_m(p.to_array(), surface_m)
    }
}

/// A part of the surface: where the points of the unit square go, area by area.
struct Face {
    area_m2: f64,
    at: Box<dyn Fn([f64; 2]) -> [f64; 3]>,
}

fn faces(shape: &Shape) -> Vec<Face> {
    match *shape {
        Shape::Cuboid { edges_m } => (0..6).map(|face| of_box(edges_m, face)).collect(),
        Shape::Cylinder {
            diameter_m,
            height_m,
        } => {
            let (radius, half) = (0.5 * diameter_m, 0.5 * height_m);
            let side = Face {
                area_m2: TAU * radius * height_m,
                at: Box::new(move |[u, v]| {
                    let (sine, cosine) = (TAU * u).sin_cos();
                    [radius * cosine, radius * sine, height_m * (v - 0.5)]
                }),
            };
            let cap = |z: f64| Face {
                area_m2: PI * radius * radius,
                at: Box::new(move |[u, v]| {
                    // Rings of equal area.
                    let (sine, cosine) = (TAU * u).sin_cos();
                    let out = radius * v.sqrt();
                    [out * cosine, out * sine, z]
                }),
            };
            vec![side, cap(-half), cap(half)]
        }
    }
}

/// One of the six faces of a box: two across each axis.
fn of_box(edges_m: [f64; 3], face: usize) -> Face {
    let (across, side) = (face / 2, if face.is_multiple_of(2) { -0.5 } else { 0.5 });
    let (a, b) = ((across + 1) % 3, (across + 2) % 3);
    Face {
        area_m2: edges_m[a] * edges_m[b],
        at: Box::new(move |[u, v]| {
            let mut p = [0.0; 3];
            p[across] = side * edges_m[across];
            p[a] = (u - 0.5) * edges_m[a];
            p[b] = (v - 0.5) * edges_m[b];
            p
        }),
    }
}

/// The plastic number, the real root of `x³ = x + 1`.
const PLASTIC: f64 = 1.324_717_957_244_746;

/// Point `k` of an even sequence on the unit square.
fn even(k: usize) -> [f64; 2] {
    [PLASTIC, PLASTIC * PLASTIC].map(|base| (0.5 + (k + 1) as f64 / base).fract())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface_distance_m;

    const BOX: Shape = Shape::Cuboid {
        edges_m: [0.04, 0.06, 0.08],
    };
    const CYLINDER: Shape = Shape::Cylinder {
        diameter_m: 0.05,
        height_m: 0.08,
    };

    #[test]
    fn points_lie_on_the_surface_by_its_area() {
        for shape in [BOX, CYLINDER] {
            let cloud = SurfaceCloud::new(&shape, 10_000);
            assert_eq!(cloud.size(), 10_000);
            assert!(
                (cloud.points.points().iter()).all(|p| surface_distance_m(
                    &shape,
                    Position::from(*p)
                )
                .abs()
                    < 1e-15)
            );
        }
        // Caps have d²/4 of d²/4 + d h / 2 on each side: 0.05 of 0.05 + 2 * 0.08, for both.
        let on_caps = (SurfaceCloud::new(&CYLINDER, 10_000).points.points().iter())
            .filter(|p| (p[2].abs() - 0.04).abs() < 1e-15)
            .count();
        assert_eq!(on_caps, (10_000.0 * 0.05 / 0.21_f64).round() as usize);
        // The face across x has 6 x 8 of 2 * (4 x 6 + 4 x 8 + 6 x 8) = 208 parts.
        let on_face = (SurfaceCloud::new(&BOX, 10_400).points.points().iter())
            .filter(|p| p[0] == 0.02)
            .count();
        assert_eq!(on_face, 2400);
    }

    /// Any part of a face has its share of the points, to a few.
    #[test]
    fn points_are_spread_evenly() {
        let of_all = |p: [f64; 2], [a, b]: [f64; 2]| p[0] < a && p[1] < b;
        let (n, points) = (8000, (0..8000).map(even).collect::<Vec<_>>());
        for corner in [[0.5, 0.5], [0.1, 0.9], [0.25, 0.33], [1.0, 0.01]] {
            let found = points.iter().filter(|p| of_all(**p, corner)).count() as f64;
            let expected = f64::from(n) * corner[0] * corner[1];
            assert!(
                (found - expected).abs() < 12.0,
                "{corner:?}: {found} {expected}"
            );
        }
    }

    /// The nearest point found by the grid is the nearest of all.
    #[test]
    fn the_grid_leaves_out_no_nearer_point() {
        let plate = Shape::Cuboid {
            edges_m: [0.1, 0.002, 0.0004],
        };
        for shape in [BOX, CYLINDER, plate] {
            let cloud = SurfaceCloud::new(&shape, 3000);
            for k in 0..200 {
                let p = [0.37, 0.61, 0.83].map(|f: f64| 0.16 * ((f * f64::from(k)).fract() - 0.5));
                let p = Position::from(p);
                let nearest = (cloud.points.points().iter())
                    .map(|q| Position::from(*q).distance_m(p))
                    .fold(f64::MAX, f64::min);
                assert!((cloud.distance_m(p) - nearest).abs() < 1e-15);
                // Never nearer than the surface; points are about 2.5 mm apart.
                let exact_m = surface_distance_m(&shape, p).abs();
                let excess_m = nearest - exact_m;
                assert!((-1e-15..0.0025).contains(&excess_m), "{excess_m}");
            }
        }
    }

    #[test]
    fn no_points_and_no_numbers() {
        let none = SurfaceCloud::new(&BOX, 0);
        assert_eq!(none.distance_m(Position::new(0.0, 0.0, 0.0)), f64::INFINITY);
        let one = SurfaceCloud::new(&BOX, 1);
        assert!(one.distance_m(Position::new(0.0, 0.0, 0.1)).is_finite());
        assert!(one.distance_m(Position::new(0.0, f64::NAN, 0.1)).is_nan());
    }
}
