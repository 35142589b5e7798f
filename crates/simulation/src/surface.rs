//! The sides of a cuboid or cylinder, where fingertips touch.
//!
//! The ends (z = ±half the height) are left alone: one lies towards the palm, the other carries
//! the object's markers.

use inhand_contact::surface_distance_m;
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
pub(crate) struct Solid(Shape);

impl Solid {
    pub(crate) fn new(shape: Shape) -> Result<Self, SimulationError> {
        let check = |dimension, found_m: f64, (min_m, max_m): (f64, f64)| {
            if (min_m..=max_m).contains(&found_m) {
                Ok(())
            } else {
                Err(SimulationError::Object(format!(
                    "the simulated hand does not hold {shape}: {dimension} is {found_m} m, \
                     expected {min_m} to {max_m} m"
                )))
            }
        };
        let height_m = match shape {
            Shape::Cuboid { edges_m: [x, y, z] } => {
                check("edge along x", x, WIDTH_RANGE_M)?;
                check("edge along y", y, WIDTH_RANGE_M)?;
                z
            }
            Shape::Cylinder {
                diameter_m,
                height_m,
            } => {
                check("diameter", diameter_m, WIDTH_RANGE_M)?;
                height_m
            }
        };
        check("height along z", height_m, HEIGHT_RANGE_M)?;
        Ok(Self(shape))
    }

    /// Half the extent along x, y, z, metres.
    pub(crate) fn half_extent_m(&self) -> Vector3<f64> {
        match self.0 {
            Shape::Cuboid { edges_m } => Vector3::from(edges_m) / 2.0,
            Shape::Cylinder {
                diameter_m,
                height_m,
            } => Vector3::new(diameter_m, diameter_m, height_m) / 2.0,
        }
    }

    /// Where the side is met on the way from the axis towards `toward`, at its height; moved along
    /// the face to keep the margin from the edges. A point on the axis itself leads to +x.
    pub(crate) fn side_contact(&self, toward: Position<Object>) -> Contact {
        let [x, y, z] = toward.to_array();
        let half = self.half_extent_m();
        let max = half.add_scalar(-EDGE_MARGIN_M);
        let z = z.clamp(-max.z, max.z);
        match self.0 {
            Shape::Cuboid { .. } => {
                let on_x_face = x.abs() * half.y >= y.abs() * half.x;
                if on_x_face {
                    let side = 1f64.copysign(x);
                    let y = if x == 0.0 { 0.0 } else { y * half.x / x.abs() };
                    Contact {
                        point: Position::new(side * half.x, y.clamp(-max.y, max.y), z),
                        normal: side * Vector3::x(),
                    }
                } else {
                    let side = 1f64.copysign(y);
                    let x = x * half.y / y.abs();
                    Contact {
                        point: Position::new(x.clamp(-max.x, max.x), side * half.y, z),
                        normal: side * Vector3::y(),
                    }
                }
            }
            Shape::Cylinder { .. } => {
                let normal = Vector3::new(x, y, 0.0)
                    .try_normalize(0.0)
                    .unwrap_or(Vector3::x());
                Contact {
                    point: Position::new(half.x * normal.x, half.x * normal.y, z),
                    normal,
                }
            }
        }
    }

    /// Distance to the surface, metres, negative inside.
    pub(crate) fn signed_distance_m(&self, point: Position<Object>) -> f64 {
        surface_distance_m(&self.0, point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid(text: &str) -> Solid {
        Solid::new(text.parse().unwrap()).unwrap()
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
                assert!(point.coords_m().z.abs() <= solid.half_extent_m().z - EDGE_MARGIN_M);
            }
            for axis_point in [[0.0, 0.0, 0.0], [-0.0, 0.0, 0.0]] {
                let contact = solid.side_contact(axis_point.into());
                assert!(solid.signed_distance_m(contact.point).abs() < 1e-15);
            }
        }
    }
}
