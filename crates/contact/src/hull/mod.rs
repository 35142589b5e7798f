//! Convex hulls of positions: how they are made, and how far a point is from one.

mod distance;
mod prefilter;
mod probe;
mod quickhull;
mod vector;

pub use distance::{hull_distance_m, inside};
pub use probe::HullProbe;

use inhand_model::{Frame, Hull, Position};

use crate::error::ContactError;
use prefilter::possible_corners;
use quickhull::{Degenerate, Triangles, coplanar, quickhull};
use vector::{Vec3, add, cross, dot, norm, scale, sub};

/// Points thinner than this span no solid, metres: a nanometre, far below what any camera sees, far
/// above what rounding does to coordinates of a capture volume.
const THINNEST_M: f64 = 1e-9;

/// The largest coordinate accepted, metres: products of three differences stay far from overflow.
const FARTHEST_M: f64 = 1e9;

/// How far a point may lie outside its own hull, relative to the size of the points (at least 1 m).
const CLOSED: f64 = 1e-9;

/// The convex hull of `points`: their corners, triangles that run counter-clockwise seen from
/// outside, and the outward plane of each triangle.
///
/// Corners are points of the input, each a true corner: none lies on an edge or face of the others.
/// Coplanar triangles are not merged. Every point is inside to 1e-9 m (checked); planes touch
/// the corners from outside, so that rounding only ever makes the hull larger. The same points give
/// the same hull, bit by bit.
///
/// Quickhull with exact signs, after all points well inside a coarse hull have been set aside; cost
/// about proportional to the number of points.
///
/// # Errors
///
/// [`ContactError`] for fewer than four points, a coordinate that is not finite or beyond 1e9 m, and
/// points that lie in one plane to 1e-9 m.
///
/// ```
/// use inhand_contact::{hull, hull_distance_m, inside};
/// use inhand_model::{Hand, Position};
///
/// // The corners of a cube of 20 mm, and a point within.
/// let mut points: Vec<Position<Hand>> = (0..8)
///     .map(|k| Position::new(
///         if k & 1 == 0 { -0.01 } else { 0.01 },
///         if k & 2 == 0 { -0.01 } else { 0.01 },
///         if k & 4 == 0 { -0.01 } else { 0.01 },
///     ))
///     .collect();
/// points.push(Position::new(0.001, 0.002, 0.003));
/// let cube = hull(&points)?;
/// assert_eq!(cube.vertices_m.len(), 8);
/// assert_eq!(cube.triangles.len(), 12);
/// assert!(inside(&cube, [0.01, 0.0, 0.0], 1e-9));
/// assert!((hull_distance_m(&cube, [0.013, 0.014, 0.0]) - 0.005).abs() < 1e-12);
/// # Ok::<(), inhand_contact::ContactError>(())
/// ```
pub fn hull<F: Frame>(points: &[Position<F>]) -> Result<Hull, ContactError> {
    let all: Vec<Vec3> = points.iter().map(|p| p.to_array()).collect();
    let size_m = validate(&all)?;
    let flat_or_open = |degenerate| match degenerate {
        Degenerate::Flat { extent, thickness } => ContactError::Flat {
            points: points.len(),
            extent_m: extent,
            thickness_m: thickness,
            needed_m: THINNEST_M,
        },
        Degenerate::Open => ContactError::Inconsistent {
            points: points.len(),
            corners: 0,
            triangles: 0,
            outside_m: f64::NAN,
        },
    };
    let mut candidates = possible_corners(&all, THINNEST_M);
    let mut triangles = quickhull(&candidates, THINNEST_M).map_err(flat_or_open)?;
    let corners = true_corners(&candidates, &triangles);
    let all_candidates = candidates.clone();
    if corners.len() < used(&triangles, candidates.len()).len() {
        candidates = corners.iter().map(|&c| candidates[c as usize]).collect();
        triangles = quickhull(&candidates, THINNEST_M).map_err(flat_or_open)?;
    }

    let hull = with_planes(&candidates, &triangles);
    // Candidates keep the order of the points, so those of a path are near their neighbours.
    let mut probe = HullProbe::new(&hull);
    let outside_m = (all_candidates.iter())
        .map(|&p| probe.distance_m(p))
        .fold(f64::NEG_INFINITY, f64::max);
    let closed = 2 * hull.vertices_m.len() == hull.triangles.len() + 4;
    if !closed || outside_m.is_nan() || outside_m > CLOSED * size_m.max(1.0) {
        return Err(ContactError::Inconsistent {
            points: points.len(),
            corners: hull.vertices_m.len(),
            triangles: hull.triangles.len(),
            outside_m,
        });
    }
    Ok(hull)
}

/// The size of the largest coordinate.
fn validate(points: &[Vec3]) -> Result<f64, ContactError> {
    if points.len() < 4 {
        return Err(ContactError::TooFewPoints {
            found: points.len(),
        });
    }
    let finite = |p: &&Vec3| p.iter().all(|c| c.is_finite());
    let not_finite = points.len() - points.iter().filter(finite).count();
    if not_finite > 0 {
        return Err(ContactError::NotFinite {
            points: points.len(),
            not_finite,
            first: points.iter().position(|p| !finite(&p)).unwrap_or_default(),
        });
    }
    let mut size_m = 0.0;
    for (first, p) in points.iter().enumerate() {
        let found_m = p.iter().fold(0.0_f64, |size, c| size.max(c.abs()));
        if found_m > FARTHEST_M {
            return Err(ContactError::TooFar {
                first,
                found_m,
                limit_m: FARTHEST_M,
            });
        }
        size_m = found_m.max(size_m);
    }
    Ok(size_m)
}

/// Indices of the points that triangles use, ascending.
fn used(triangles: &Triangles, points: usize) -> Vec<u32> {
    let mut is_used = vec![false; points];
    for &corner in triangles.as_flattened() {
        is_used[corner as usize] = true;
    }
    (0..points as u32)
        .filter(|&index| is_used[index as usize])
        .collect()
}

/// Indices of the points that are corners of the hull, ascending: where at least three planes meet.
/// Points within a face or edge can be corners of triangles too, when their face's other points came
/// later.
fn true_corners(points: &[Vec3], triangles: &Triangles) -> Vec<u32> {
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
    for (index, triangle) in triangles.iter().enumerate() {
        for &corner in triangle {
            around[corner as usize].push(index as u32);
        }
    }
    let points_of = |triangle: u32| triangles[triangle as usize].map(|c| points[c as usize]);
    (0..points.len() as u32)
        .filter(|&corner| {
            let mut planes: Vec<u32> = Vec::with_capacity(3);
            for &triangle in &around[corner as usize] {
                let known = |&plane: &u32| {
                    points_of(triangle)
                        .into_iter()
                        .all(|p| coplanar(points_of(plane), p))
                };
                if !planes.iter().any(known) {
                    planes.push(triangle);
                }
                if planes.len() == 3 {
                    return true;
                }
            }
            false
        })
        .collect()
}

/// The hull whose surface is `triangles`, with only the points that it uses.
fn with_planes(points: &[Vec3], triangles: &Triangles) -> Hull {
    let corners = used(triangles, points.len());
    let mut renumbered = vec![0; points.len()];
    for (new, &old) in corners.iter().enumerate() {
        renumbered[old as usize] = new as u32;
    }
    let vertices_m: Vec<Vec3> = corners.iter().map(|&c| points[c as usize]).collect();
    let centre = scale(
        vertices_m.iter().copied().fold([0.0; 3], add),
        1.0 / vertices_m.len() as f64,
    );
    let normals: Vec<Vec3> = (triangles.iter())
        .map(|triangle| {
            let corners = triangle.map(|c| points[c as usize]);
            plane_of(corners).map_or_else(|| outward_of(corners, centre), |(normal, _)| normal)
        })
        .collect();
    let offsets_m = (normals.iter())
        .map(|&normal| {
            (vertices_m.iter())
                .map(|&v| dot(normal, v))
                .fold(f64::NEG_INFINITY, f64::max)
        })
        .collect();
    Hull {
        triangles: (triangles.iter())
            .map(|triangle| triangle.map(|c| renumbered[c as usize]))
            .collect(),
        vertices_m,
        normals,
        offsets_m,
    }
}

/// Unit normal of a triangle and its conditioning: how much larger its error is, in roundings, than
/// that of a triangle with a right angle. `None` for a triangle too thin to tell.
fn plane_of([a, b, c]: [Vec3; 3]) -> Option<(Vec3, f64)> {
    // The two shorter edges: their product loses the fewest digits.
    let (ab, bc, ca) = (sub(b, a), sub(c, b), sub(a, c));
    let (e, f) = match (norm(ab), norm(bc), norm(ca)) {
        (x, y, z) if x >= y && x >= z => (bc, ca),
        (_, y, z) if y >= z => (ca, ab),
        _ => (ab, bc),
    };
    let product = cross(e, f);
    let area = norm(product);
    let conditioning = norm(e) * norm(f) / area;
    (conditioning < 1e12).then(|| (scale(product, 1.0 / area), conditioning))
}

/// A direction in which a thin triangle is outermost; its true plane is that of a neighbour to
/// rounding, so that any supporting plane will do in its place.
fn outward_of([a, b, c]: [Vec3; 3], centre: Vec3) -> Vec3 {
    let out = sub(scale(add(add(a, b), c), 1.0 / 3.0), centre);
    scale(out, 1.0 / norm(out))
}
