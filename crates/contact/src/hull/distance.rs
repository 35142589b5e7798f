//! Membership in a hull and distance to its surface, one point at a time.
//!
//! Inside, the planes say it all. Outside, parry measures to the triangles that a point sees. Its solids
//! were tried in place of both (0.31.1, f64): the `ConvexPolyhedron` of a cube of 20 mm is up to 7 mm
//! off where several faces are nearest, and its `TriMesh`, which is exact, takes several times as long
//! as the planes inside, where nearly all points are.

use inhand_model::Hull;
use parry3d::query::PointQuery;
use parry3d::shape::Triangle;

use super::vector::{Vec3, dot};

/// Signed distance of `p` to the surface of `hull`, metres: positive outside, negative inside.
///
/// Exact to rounding: inside it is the largest of the signed distances to the planes, outside the
/// distance to the nearest point of a face, edge or corner. NaN for a NaN coordinate or a hull
/// without planes. Cost proportional to the number of planes; for points that follow one another
/// closely see [`crate::HullProbe`].
pub fn hull_distance_m(hull: &Hull, p: [f64; 3]) -> f64 {
    let highest = highest_plane_m(hull, p);
    if highest > 0.0 {
        outside_m(hull, 0..hull.normals.len(), p).unwrap_or(highest)
    } else {
        highest
    }
}

/// Whether `p` is in `hull`, or beyond none of its planes by more than `tolerance_m`.
///
/// With a tolerance of 0 the same as `hull_distance_m(hull, p) <= 0`, without the distance: it stops
/// at the first plane that shuts `p` out. Beyond an edge or corner the tolerance reaches a little
/// farther than as a distance. `false` for a NaN coordinate and for a hull without planes.
pub fn inside(hull: &Hull, p: [f64; 3], tolerance_m: f64) -> bool {
    !hull.normals.is_empty()
        && planes(hull).all(|(normal, offset)| dot(normal, p) - offset <= tolerance_m)
}

pub(super) fn planes(hull: &Hull) -> impl Iterator<Item = (Vec3, f64)> + Clone {
    (hull.normals.iter().copied()).zip(hull.offsets_m.iter().copied())
}

/// The largest signed distance to a plane; NaN for a NaN coordinate and without planes.
fn highest_plane_m(hull: &Hull, p: Vec3) -> f64 {
    let mut highest = f64::NEG_INFINITY;
    for (normal, offset) in planes(hull) {
        let height = dot(normal, p) - offset;
        highest = if height > highest { height } else { highest };
    }
    // NaN is larger than nothing and leaves minus infinity.
    if highest == f64::NEG_INFINITY {
        f64::NAN
    } else {
        highest
    }
}

/// A plane this little above a point may be beside it or below but for rounding, metres. Triangles of
/// one face have planes that differ by rounding: the one that a point lies on need not be one of
/// those that it seems to be beyond.
pub(super) const ROUNDING_M: f64 = 1e-10;

/// Distance to the nearest point of the surface, for a point beyond at least one plane. The nearest
/// point lies on a triangle that the point sees; `facets` are, in ascending order, at least all of
/// those whose planes are no more than [`ROUNDING_M`] above it.
pub(super) fn outside_m(hull: &Hull, facets: impl Iterator<Item = usize>, p: Vec3) -> Option<f64> {
    let mut nearest_m = f64::INFINITY;
    let mut highest_m = 0.0_f64;
    for facet in facets {
        let normal = *hull.normals.get(facet)?;
        let height = dot(normal, p) - hull.offsets_m.get(facet)?;
        if height >= -ROUNDING_M {
            let triangle = hull.triangles.get(facet)?;
            let [a, b, c] = triangle.map(|corner| hull.vertices_m.get(corner as usize).copied());
            let triangle = Triangle::new(a?.into(), b?.into(), c?.into());
            nearest_m = nearest_m.min(triangle.distance_to_local_point(p.into(), true));
            highest_m = highest_m.max(height);
        }
    }
    // No nearer than the highest plane: a point just outside must not round to the surface.
    nearest_m.is_finite().then(|| nearest_m.max(highest_m))
}
