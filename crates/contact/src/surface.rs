//! Distance of a fingertip to the surface of an object.

use inhand_model::{Finger, Object, PerFinger, Position, Shape};

/// Signed distance of `p` to the surface of `shape`, metres: positive outside, 0 on the surface,
/// negative inside (minus the distance to the nearest face).
///
/// Exact to rounding, by the closed form of the solid: for a box with `q = |p| - half edges` it is
/// `|max(q, 0)| + min(max_i q_i, 0)`; a cylinder is a box in the plane of radius and height.
/// A NaN coordinate gives NaN, an infinite one infinity.
///
/// P1 (arXiv 2308.15153) measures to a cloud of surface points instead, which is never less and at
/// most half a point spacing more.
///
/// ```
/// use inhand_contact::surface_distance_m;
/// use inhand_model::{Position, Shape};
///
/// let cube = Shape::Cuboid { edges_m: [0.05; 3] };
/// // 3 mm and 4 mm beyond two faces: 5 mm from the edge between them.
/// let d = surface_distance_m(&cube, Position::new(0.028, 0.029, 0.0));
/// assert!((d - 0.005).abs() < 1e-15);
/// assert_eq!(surface_distance_m(&cube, Position::new(0.0, 0.0, 0.0)), -0.025);
/// ```
pub fn surface_distance_m(shape: &Shape, p: Position<Object>) -> f64 {
    let [x, y, z] = p.to_array();
    // `f64::max` prefers a number to NaN and would turn an unknown position into a distance.
    if x.is_nan() || y.is_nan() || z.is_nan() {
        return f64::NAN;
    }
    match *shape {
        Shape::Cuboid { edges_m: [a, b, c] } => {
            solid_distance_m([x.abs() - a / 2.0, y.abs() - b / 2.0, z.abs() - c / 2.0])
        }
        Shape::Cylinder {
            diameter_m,
            height_m,
        } => solid_distance_m([x.hypot(y) - diameter_m / 2.0, z.abs() - height_m / 2.0]),
    }
}

/// Distance from how far a point lies beyond each of a solid's perpendicular pairs of faces.
fn solid_distance_m<const N: usize>(beyond_m: [f64; N]) -> f64 {
    let deepest = beyond_m.into_iter().fold(f64::NEG_INFINITY, f64::max);
    if deepest <= 0.0 {
        return deepest;
    }
    let outside = beyond_m.map(|d| d.max(0.0));
    outside.into_iter().map(|d| d * d).sum::<f64>().sqrt()
}

/// How far the pad of each finger reaches beyond its marker towards the object, metres.
///
/// A marker sits on the nail side: its distance to the object is that of the pad plus the thickness
/// of the fingertip. The offset is taken off the measured distance. It is a model: exact where the
/// pad lies between marker and nearest surface point. 0 by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FingerOffsets(
    /// Offset of each finger, metres.
    pub PerFinger<f64>,
);

impl FingerOffsets {
    /// Signed distance from the pad of `finger` to the object, metres, with its marker at `p`:
    /// [`surface_distance_m`] less the finger's offset.
    pub fn pad_distance_m(&self, shape: &Shape, finger: Finger, p: Position<Object>) -> f64 {
        surface_distance_m(shape, p) - self.0[finger]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Shape = Shape::Cuboid {
        edges_m: [0.04, 0.06, 0.08],
    };
    const CYLINDER: Shape = Shape::Cylinder {
        diameter_m: 0.05,
        height_m: 0.08,
    };

    fn check(shape: Shape, p: [f64; 3], expected_m: f64) {
        let found = surface_distance_m(&shape, p.into());
        assert!(
            (found - expected_m).abs() < 1e-15,
            "{shape} at {p:?}: expected {expected_m}, found {found}"
        );
    }

    #[test]
    fn box_faces_edges_and_corners() {
        check(BOX, [0.0, 0.0, 0.0], -0.02);
        check(BOX, [0.0, 0.029, 0.0], -0.001);
        check(BOX, [0.02, 0.0, 0.0], 0.0);
        check(BOX, [-0.025, 0.01, -0.03], 0.005);
        check(BOX, [0.0, -0.033, 0.044], 0.005); // edge, 3-4-5
        check(BOX, [0.022, 0.033, 0.046], 0.007); // corner, 2-3-6-7
    }

    #[test]
    fn cylinder_side_caps_and_rims() {
        check(CYLINDER, [0.0, 0.0, 0.0], -0.025);
        check(CYLINDER, [0.0, 0.0, 0.039], -0.001);
        check(CYLINDER, [0.0, 0.0, -0.05], 0.01);
        check(CYLINDER, [0.018, -0.024, 0.01], 0.005); // radius 30 mm
        check(CYLINDER, [0.0168, 0.0224, 0.044], 0.005); // radius 28 mm, 4 mm above the rim
        check(CYLINDER, [0.015, 0.02, 0.04], 0.0); // on the rim
    }

    #[test]
    fn unknown_stays_unknown() {
        for shape in [BOX, CYLINDER] {
            for axis in 0..3 {
                let mut p = [0.0; 3];
                p[axis] = f64::NAN;
                assert!(surface_distance_m(&shape, p.into()).is_nan());
                p[axis] = f64::NEG_INFINITY;
                assert_eq!(surface_distance_m(&shape, p.into()), f64::INFINITY);
            }
        }
    }

    #[test]
    fn offset_comes_off_the_distance() {
        let mut offsets = FingerOffsets::default();
        offsets.0[Finger::Ring] = 0.008;
        let p = Position::new(0.03, 0.0, 0.0);
        assert!((offsets.pad_distance_m(&BOX, Finger::Thumb, p) - 0.01).abs() < 1e-15);
        assert!((offsets.pad_distance_m(&BOX, Finger::Ring, p) - 0.002).abs() < 1e-15);
    }
}
