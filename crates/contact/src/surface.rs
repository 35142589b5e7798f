//! Distance of a fingertip to the surface of an object.

use inhand_model::{Finger, Object, PerFinger, Position, Shape};
use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::Cylinder;

/// Signed distance of `p` to the surface of `shape`, metres: positive outside, 0 on the surface,
/// negative inside (minus the distance to the nearest point of the surface).
///
/// The length of the way to parry's projection onto the surface, exact to rounding. A NaN coordinate
/// gives NaN, an infinite one infinity.
///
/// P1 (arXiv 2308.15153) measures to a cloud of surface points instead: always a positive number,
/// never less than the size of this one and at most half a point spacing more.
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
///
/// // The axis of a cylinder is z: 6 mm beside its side of 20 mm radius and 8 mm above its cap at
/// // 35 mm are 10 mm from the rim.
/// let cylinder = Shape::Cylinder { diameter_m: 0.04, height_m: 0.07 };
/// let d = surface_distance_m(&cylinder, Position::new(0.0, 0.026, 0.043));
/// assert!((d - 0.010).abs() < 1e-15);
/// ```
pub fn surface_distance_m(shape: &Shape, p: Position<Object>) -> f64 {
    let [x, y, z] = p.to_array();
    // Comparisons would turn an unknown coordinate into a distance, differences an infinite one into
    // no number.
    if x.is_nan() || y.is_nan() || z.is_nan() {
        return f64::NAN;
    }
    if x.is_infinite() || y.is_infinite() || z.is_infinite() {
        return f64::INFINITY;
    }
    let (p, on_surface, is_inside) = projected(shape, [x, y, z]);
    let distance_m = on_surface.distance(p);
    if is_inside { -distance_m } else { distance_m }
}

/// A point and its projection onto the surface, from inside too, in parry's frame ([`along_parry_cylinder`]), and
/// whether it is inside.
fn projected(shape: &Shape, p: [f64; 3]) -> (Vector, Vector, bool) {
    match *shape {
        Shape::Cuboid { edges_m } => {
            let (on_surface, is_inside) = on_box(edges_m.map(|edge_m| edge_m / 2.0), p);
            (p.into(), on_surface.into(), is_inside)
        }
        Shape::Cylinder {
            diameter_m,
            height_m,
        } => {
            let p = along_parry_cylinder(height_m, p);
            let cylinder = Cylinder::new(height_m / 2.0, diameter_m / 2.0);
            let found = cylinder.project_local_point(p, false);
            (p, found.point, found.is_inside)
        }
    }
}

/// The nearest point of a box's surface, and whether `p` is inside: what parry's `Cuboid` gives, bit by bit, but
/// compiled into the caller.
fn on_box(half_m: [f64; 3], p: [f64; 3]) -> ([f64; 3], bool) {
    let clamped = std::array::from_fn(|k| {
        p[k] + ((-half_m[k] - p[k]).max(0.0) - (p[k] - half_m[k]).max(0.0))
    });
    if clamped != p {
        return (clamped, false);
    }
    let depth_m: [f64; 3] = std::array::from_fn(|k| half_m[k] - p[k].abs());
    let least_m = depth_m[0].min(depth_m[1]).min(depth_m[2]);
    let mut on_surface = p;
    if let Some(axis) = depth_m.iter().position(|&depth| depth == least_m) {
        on_surface[axis] += least_m.copysign(p[axis]);
    }
    (on_surface, true)
}

/// A point of the object in the frame of parry's cylinder, or its mirror image at the same distance.
///
/// The axis of the cylinder is z in the object and y in parry. The axes move on by one place, which is
/// a rotation by 120 degrees about their diagonal: (3, 4, 5) mm in the object is (4, 5, 3) mm in parry.
///
/// Parry 0.31 takes a point as far from one cap as from the other to be nearest to the side, which
/// makes the centre of a disc of 40 mm diameter and 10 mm height 20 mm deep instead of 5 mm. So the
/// point is mirrored into the upper half and kept off the plane in the middle, by no more than rounding
/// does to its distance from the cap.
fn along_parry_cylinder(height_m: f64, [x, y, z]: [f64; 3]) -> Vector {
    Vector::new(y, z.abs().max(f64::EPSILON * height_m), x)
}

/// The point of the surface nearest to `p`; `None` for a coordinate that is not finite. One of those equally
/// near.
fn surface_point(shape: &Shape, p: Position<Object>) -> Option<Position<Object>> {
    if !p.is_finite() {
        return None;
    }
    let (_, q, _) = projected(shape, p.to_array());
    Some(match shape {
        Shape::Cuboid { .. } => Position::new(q.x, q.y, q.z),
        // Back from the mirror image, and the axes back by one place.
        Shape::Cylinder { .. } => Position::new(q.z, q.x, q.y.copysign(p.to_array()[2])),
    })
}

/// Apparent slip of a pad during a contact: the straight distance (the chord) between its first and last known
/// positions on the surface, metres. `pad` holds its position in the object's frame at every sample of the contact
/// (`object_from_hand * hand_tip`), `None` where tip or object is missing.
///
/// A pad that holds a point of the object stays where it is in the object's frame, however hand and object
/// move. What it does move there is sliding, rolling of the round fingertip and give of its pulp together, which
/// a marker cannot distinguish, and noise. Every position is moved to its nearest point on the surface first, so
/// that pressing the pulp in counts nothing. Noise makes a path longer with every sample but this chord only once.
///
/// `None` unless two neighbouring samples are known.
///
/// ```
/// use inhand_contact::slip_m;
/// use inhand_model::{Position, Shape};
///
/// // A pad 1 mm above the top of a cube goes 3 mm along x and 4 mm along y in two steps.
/// let pad = [[0.0, 0.0], [0.003, 0.0], [0.003, 0.004]]
///     .map(|[x, y]| Some(Position::new(x, y, 0.026)));
/// let cube = Shape::Cuboid { edges_m: [0.05; 3] };
/// assert!((slip_m(&cube, &pad).unwrap() - 0.005).abs() < 1e-12);
/// ```
pub fn slip_m(shape: &Shape, pad: &[Option<Position<Object>>]) -> Option<f64> {
    let is_known = |pad: &Option<Position<Object>>| pad.is_some_and(Position::is_finite);
    if !pad.windows(2).any(|pair| pair.iter().all(is_known)) {
        return None;
    }
    let mut known = pad.iter().filter(|pad| is_known(pad)).flatten();
    let (first, last) = (known.next()?, known.next_back()?);
    let on_surface = |pad| surface_point(shape, pad);
    Some(on_surface(*last)?.distance_m(on_surface(*first)?))
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
    fn boxes_are_those_of_parry() {
        let half_m = [0.02, 0.03, 0.04];
        let cuboid = parry3d::shape::Cuboid::new(half_m.into());
        let steps = || (-9..=9).map(|k| f64::from(k) * 0.005 + 1e-4 * f64::from(k % 2));
        for (x, y, z) in
            steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| (x, y, z))))
        {
            let expected = cuboid.project_local_point([x, y, z].into(), false);
            let (found, is_inside) = on_box(half_m, [x, y, z]);
            assert_eq!(
                (Vector::from(found), is_inside),
                (expected.point, expected.is_inside)
            );
        }
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

    /// The nearest point is on the surface and as far as the distance says, on the side of the point.
    #[test]
    fn nearest_points_lie_on_the_surface() {
        let steps = || (-6..=6).map(|k| f64::from(k) * 0.009 + 0.0007);
        for shape in [BOX, CYLINDER] {
            for (x, y, z) in
                steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| (x, y, z))))
            {
                let p = Position::new(x, y, z);
                let q = surface_point(&shape, p).expect("the point is finite");
                assert!(surface_distance_m(&shape, q).abs() < 1e-15, "{shape} {p:?}");
                let distance_m = surface_distance_m(&shape, p).abs();
                assert!(
                    (q.distance_m(p) - distance_m).abs() < 1e-15,
                    "{shape} {p:?} {q:?}"
                );
            }
            assert_eq!(
                surface_point(&shape, Position::new(0.0, f64::NAN, 0.0)),
                None
            );
        }
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
