//! Membership in a hull and distance to its surface.

use inhand_model::Hull;

use super::vector::{Vec3, add, cross, dot, norm, scale, sub};

/// How far a [`HullProbe`] lets a point move before it looks at all planes again, metres. Fingertips
/// move a few tenths of a millimetre between samples: this lasts for several.
const REACH_M: f64 = 1e-3;

/// More than rounding can do to a distance within a capture volume, metres.
const ROUNDING_M: f64 = 1e-9;

/// Signed distance of `p` to the surface of `hull`, metres: positive outside, negative inside.
///
/// Exact to rounding: inside it is the largest of the signed distances to the planes, outside the
/// distance to the nearest point of a face, edge or corner. NaN for a NaN coordinate or a hull
/// without planes. Cost proportional to the number of planes; for points that follow one another
/// closely see [`HullProbe`].
pub fn hull_distance_m(hull: &Hull, p: [f64; 3]) -> f64 {
    let highest = highest_plane_m(hull, p);
    if highest > 0.0 {
        outside_m(hull, p).unwrap_or(highest)
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

fn planes(hull: &Hull) -> impl Iterator<Item = (Vec3, f64)> {
    (hull.normals.iter().copied()).zip(hull.offsets_m.iter().copied())
}

/// The largest signed distance to a plane; NaN for a NaN coordinate and without planes.
pub(super) fn highest_plane_m(hull: &Hull, p: Vec3) -> f64 {
    highest_m(planes(hull), p)
}

fn highest_m(planes: impl Iterator<Item = (Vec3, f64)>, p: Vec3) -> f64 {
    let mut highest = f64::NEG_INFINITY;
    for (normal, offset) in planes {
        let height = dot(normal, p) - offset;
        highest = if height > highest { height } else { highest };
    }
    // NaN compares as not greater and would leave minus infinity.
    if highest == f64::NEG_INFINITY {
        f64::NAN
    } else {
        highest
    }
}

/// Distance to the nearest point of the surface, for a point beyond at least one plane. The nearest
/// point lies on a triangle that the point sees.
fn outside_m(hull: &Hull, p: Vec3) -> Option<f64> {
    let mut nearest = f64::INFINITY;
    for ((normal, offset), triangle) in planes(hull).zip(&hull.triangles) {
        let height = dot(normal, p) - offset;
        if height > 0.0 && height < nearest {
            let [a, b, c] = triangle.map(|corner| hull.vertices_m.get(corner as usize).copied());
            nearest = nearest.min(triangle_distance_m([a?, b?, c?], normal, height, p));
        }
    }
    nearest.is_finite().then_some(nearest)
}

/// Distance of a point at `height` above a triangle's plane to the triangle.
fn triangle_distance_m(corners: [Vec3; 3], normal: Vec3, height: f64, p: Vec3) -> f64 {
    let edges = [0, 1, 2].map(|i| (corners[i], corners[(i + 1) % 3]));
    let is_above = edges
        .iter()
        .all(|&(a, b)| dot(cross(sub(b, a), sub(p, a)), normal) >= 0.0);
    if is_above {
        return height;
    }
    edges
        .into_iter()
        .map(|(a, b)| edge_distance_m(a, b, p))
        .fold(f64::INFINITY, f64::min)
}

fn edge_distance_m(a: Vec3, b: Vec3, p: Vec3) -> f64 {
    let (along, from) = (sub(b, a), sub(p, a));
    let share = (dot(from, along) / dot(along, along)).clamp(0.0, 1.0);
    norm(sub(p, add(a, scale(along, share))))
}

/// [`hull_distance_m`] for points of which each is near the one before, such as those of a
/// trajectory; the results are the same, bit by bit.
///
/// Distances to planes change by no more than the point moves. So of all planes only those that come
/// near the highest at one point (the anchor) can be the highest within a millimetre of it, and only
/// they are looked at until the points leave it.
///
/// ```
/// use inhand_contact::{HullProbe, hull, hull_distance_m};
/// # use inhand_model::{Hand, Position};
/// # let corners = [[0.0; 3], [0.02, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.02]];
/// # let hull = hull(&corners.map(Position::<Hand>::from))?;
/// let mut probe = HullProbe::new(&hull);
/// for k in 0..100 {
///     let p = [0.005, 0.004, 1e-4 * f64::from(k)];
///     assert_eq!(probe.distance_m(p), hull_distance_m(&hull, p));
/// }
/// # Ok::<(), inhand_contact::ContactError>(())
/// ```
#[derive(Clone, Debug)]
pub struct HullProbe<'h> {
    hull: &'h Hull,
    planes: PlaneLanes,
    anchor: Vec3,
    /// Planes that can be the highest within reach of the anchor.
    candidates: PlaneLanes,
    heights: Vec<[f64; LANES]>,
}

impl<'h> HullProbe<'h> {
    /// A probe that has seen no point.
    pub fn new(hull: &'h Hull) -> Self {
        let mut lanes = PlaneLanes::default();
        planes(hull).for_each(|plane| lanes.push(plane));
        Self {
            hull,
            planes: lanes,
            anchor: [f64::NAN; 3],
            candidates: PlaneLanes::default(),
            heights: Vec::new(),
        }
    }

    /// [`hull_distance_m`] of the hull.
    pub fn distance_m(&mut self, p: [f64; 3]) -> f64 {
        let moved = sub(p, self.anchor);
        // The NaN of a new probe is not near either.
        let is_near = dot(moved, moved) <= REACH_M * REACH_M;
        if !is_near {
            self.move_anchor(p);
        }
        let highest = self.candidates.highest_m(p);
        if highest > 0.0 {
            outside_m(self.hull, p).unwrap_or(highest)
        } else {
            highest
        }
    }

    fn move_anchor(&mut self, p: Vec3) {
        self.anchor = p;
        self.heights.clear();
        self.heights.extend(self.planes.heights_m(p));
        let highest = largest(self.heights.iter().copied());
        let least = highest - 2.0 * REACH_M - ROUNDING_M;
        self.candidates.clear();
        for (height, plane) in self.heights.as_flattened().iter().zip(planes(self.hull)) {
            if *height >= least {
                self.candidates.push(plane);
            }
        }
    }
}

/// Planes side by side, for the processor to look at several at once.
const LANES: usize = 8;

#[derive(Clone, Debug, Default)]
struct PlaneLanes {
    /// x, y, z of the normals, then the offsets; the last lanes are filled with planes infinitely far
    /// above any point.
    lanes: Vec<[[f64; LANES]; 4]>,
    count: usize,
}

impl PlaneLanes {
    fn clear(&mut self) {
        self.lanes.clear();
        self.count = 0;
    }

    fn push(&mut self, ([x, y, z], offset): (Vec3, f64)) {
        let lane = self.count % LANES;
        if lane == 0 {
            let none = [0.0; LANES];
            self.lanes.push([none, none, none, [f64::INFINITY; LANES]]);
        }
        if let Some(last) = self.lanes.last_mut() {
            for (row, value) in last.iter_mut().zip([x, y, z, offset]) {
                row[lane] = value;
            }
        }
        self.count += 1;
    }

    fn heights_m(&self, [x, y, z]: Vec3) -> impl Iterator<Item = [f64; LANES]> {
        self.lanes.iter().map(move |[nx, ny, nz, offset]| {
            std::array::from_fn(|i| nx[i] * x + ny[i] * y + nz[i] * z - offset[i])
        })
    }

    fn highest_m(&self, p: Vec3) -> f64 {
        let highest = largest(self.heights_m(p));
        // NaN is larger than nothing and leaves minus infinity.
        if highest == f64::NEG_INFINITY {
            f64::NAN
        } else {
            highest
        }
    }
}

/// The largest number; minus infinity where there is none.
fn largest(values: impl Iterator<Item = [f64; LANES]>) -> f64 {
    let mut largest = [f64::NEG_INFINITY; LANES];
    for lanes in values {
        for (largest, value) in largest.iter_mut().zip(lanes) {
            *largest = if value > *largest { value } else { *largest };
        }
    }
    (largest.into_iter()).fold(f64::NEG_INFINITY, f64::max)
}
