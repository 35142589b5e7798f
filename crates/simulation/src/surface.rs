//! The sides of a cuboid or cylinder, where fingertips touch, and the distance to the whole solid.
//!
//! The ends (z = ±half the height) are left alone: one lies towards the palm, the other carries
//! the object's markers.

use inhand_model::{Object, Position, Shape};
use nalgebra::Vector3;

use crate::error::SimulationError;

/// Cross-sections that five fingertips fit around and that the hand spans, metres.
const WIDTH_RANGE_M: (f64, f64) = (0.035, 0.08);
/// Heights on which fingertips find a place, metres.
const HEIGHT_RANGE_M: (f64, f64) = (0.03, 0.10);
/// Distance kept from every edge, metres: about half a fingertip.
const EDGE_MARGIN_M: f64 = 0.005;

/// A point on the object's side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    pub(crate) point: Position<Object>,
    /// Outward unit normal.
    pub(crate) normal: Vector3<f64>,
}

/// A solid that the simulated hand can hold.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solid {
    section: Section,
    half_height_m: f64,
}

/// Cross-section, perpendicular to z.
#[derive(Clone, Copy, Debug)]
enum Section {
    Rectangle { half_m: [f64; 2] },
    Circle { radius_m: f64 },
}

impl Solid {
    pub(crate) fn new(shape: Shape) -> Result<Self, SimulationError> {
        let check = |dimension, found_m: f64, (min_m, max_m): (f64, f64)| {
            if (min_m..=max_m).contains(&found_m) {
                Ok(())
            } else {
                Err(SimulationError::Size {
                    shape,
                    dimension,
                    min_m,
                    max_m,
                    found_m,
                })
            }
        };
        let (section, height_m) = match shape {
            Shape::Cuboid { edges_m: [x, y, z] } => {
                check("edge along x", x, WIDTH_RANGE_M)?;
                check("edge along y", y, WIDTH_RANGE_M)?;
                let half_m = [x / 2.0, y / 2.0];
                (Section::Rectangle { half_m }, z)
            }
            Shape::Cylinder {
                diameter_m,
                height_m,
            } => {
                check("diameter", diameter_m, WIDTH_RANGE_M)?;
                let radius_m = diameter_m / 2.0;
                (Section::Circle { radius_m }, height_m)
            }
        };
        check("height along z", height_m, HEIGHT_RANGE_M)?;
        Ok(Self {
            section,
            half_height_m: height_m / 2.0,
        })
    }

    /// Half the extent along x, y, z, metres.
    pub(crate) fn half_extent_m(&self) -> Vector3<f64> {
        match self.section {
            Section::Rectangle { half_m: [x, y] } => Vector3::new(x, y, self.half_height_m),
            Section::Circle { radius_m } => Vector3::new(radius_m, radius_m, self.half_height_m),
        }
    }

    /// Where the side is met on the way from the axis towards `toward`, at its height; moved along
    /// the face to keep the margin from the edges. A point on the axis itself leads to +x.
    pub(crate) fn side_contact(&self, toward: Position<Object>) -> Contact {
        let [x, y, z] = toward.to_array();
        let z_max = self.half_height_m - EDGE_MARGIN_M;
        let z = z.clamp(-z_max, z_max);
        match self.section {
            Section::Rectangle { half_m: [a, b] } => {
                let on_x_face = x.abs() * b >= y.abs() * a;
                if on_x_face {
                    let (side, max) = (1f64.copysign(x), b - EDGE_MARGIN_M);
                    let y = if x == 0.0 { 0.0 } else { y * a / x.abs() };
                    Contact {
                        point: Position::new(side * a, y.clamp(-max, max), z),
                        normal: side * Vector3::x(),
                    }
                } else {
                    let (side, max) = (1f64.copysign(y), a - EDGE_MARGIN_M);
                    let x = x * b / y.abs();
                    Contact {
                        point: Position::new(x.clamp(-max, max), side * b, z),
                        normal: side * Vector3::y(),
                    }
                }
            }
            Section::Circle { radius_m } => {
                let normal = Vector3::new(x, y, 0.0)
                    .try_normalize(0.0)
                    .unwrap_or(Vector3::x());
                Contact {
                    point: Position::new(radius_m * normal.x, radius_m * normal.y, z),
                    normal,
                }
            }
        }
    }

    /// Distance to the surface, metres, negative inside.
    pub(crate) fn signed_distance_m(&self, point: Position<Object>) -> f64 {
        let [x, y, z] = point.to_array();
        let beyond_z = z.abs() - self.half_height_m;
        match self.section {
            Section::Rectangle { half_m: [a, b] } => {
                let beyond = Vector3::new(x.abs() - a, y.abs() - b, beyond_z);
                beyond.sup(&Vector3::zeros()).norm() + beyond.max().min(0.0)
            }
            Section::Circle { radius_m } => {
                let beyond_side = x.hypot(y) - radius_m;
                beyond_side.max(0.0).hypot(beyond_z.max(0.0)) + beyond_side.max(beyond_z).min(0.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid(text: &str) -> Solid {
        Solid::new(text.parse().unwrap()).unwrap()
    }

    #[test]
    fn distances_of_known_points() {
        let check = |shape: &str, point: [f64; 3], expected: f64| {
            let found = solid(shape).signed_distance_m(point.into());
            assert!(
                (found - expected).abs() < 1e-15,
                "{shape} {point:?} {found}"
            );
        };
        check("cube:0.05", [0.0, 0.0, 0.0], -0.025);
        check("cube:0.05", [0.025, 0.0, 0.0], 0.0);
        check("cube:0.05", [0.028, -0.029, 0.0], 0.005);
        check("cube:0.05", [0.026, -0.027, 0.027], 0.003);
        check("box:0.04x0.06x0.08", [0.0, 0.028, 0.0], -0.002);
        check("cylinder:0.05x0.06", [0.0, 0.0, 0.01], -0.02);
        check("cylinder:0.05x0.06", [0.03, 0.04, 0.0], 0.025);
        check("cylinder:0.05x0.06", [0.028, 0.0, 0.034], 0.005);
    }

    #[test]
    fn contacts_lie_on_the_side_away_from_edges() {
        for shape in ["cube:0.05", "box:0.04x0.06x0.08", "cylinder:0.05x0.03"] {
            let solid = solid(shape);
            for k in 0..1000 {
                let (angle, z) = (f64::from(k), f64::from(k % 7 - 3) * 0.02);
                let toward = Position::new(0.1 * angle.cos(), 0.1 * angle.sin(), z);
                let Contact { point, normal } = solid.side_contact(toward);
                assert!(solid.signed_distance_m(point).abs() < 1e-15);
                let out = Position::from_coords(point.coords_m() + normal * 0.01);
                assert!((solid.signed_distance_m(out) - 0.01).abs() < 1e-15);
                assert!(point.coords_m().z.abs() <= solid.half_height_m - EDGE_MARGIN_M);
            }
            for axis_point in [[0.0, 0.0, 0.0], [-0.0, 0.0, 0.0]] {
                let contact = solid.side_contact(axis_point.into());
                assert!(solid.signed_distance_m(contact.point).abs() < 1e-15);
            }
        }
    }
}
