//! Membership in a hull and distance to its surface, one point at a time.

use inhand_model::Hull;

use super::vector::{Vec3, cross, dot, scale, sub};

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
    let mut nearest_m2 = f64::INFINITY;
    for facet in facets {
        let normal = *hull.normals.get(facet)?;
        let height = dot(normal, p) - hull.offsets_m.get(facet)?;
        if height >= -ROUNDING_M {
            let triangle = hull.triangles.get(facet)?;
            let [a, b, c] = triangle.map(|corner| hull.vertices_m.get(corner as usize).copied());
            let edges = [(a?, b?), (b?, c?), (c?, a?)];
            let is_over = edges
                .iter()
                .all(|&(a, b)| dot(cross(sub(b, a), sub(p, a)), normal) >= 0.0);
            if is_over && height > 0.0 {
                // The foot of the perpendicular is on the surface, and all of the hull beyond it.
                return Some(height);
            } else if is_over {
                nearest_m2 = nearest_m2.min(height * height);
            } else {
                for (a, b) in edges {
                    nearest_m2 = nearest_m2.min(squared_distance_to_edge_m2(a, b, p));
                }
            }
        }
    }
    nearest_m2.is_finite().then(|| nearest_m2.sqrt())
}

fn squared_distance_to_edge_m2(a: Vec3, b: Vec3, p: Vec3) -> f64 {
    let (along, from) = (sub(b, a), sub(p, a));
    let share = (dot(from, along) / dot(along, along)).clamp(0.0, 1.0);
    let across = sub(from, scale(along, share));
    dot(across, across)
}
