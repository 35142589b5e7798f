//! Distance to a hull along a path.

use inhand_model::Hull;

use super::distance::{outside_m, planes};
use super::vector::{Vec3, dot, sub};

/// How far a point may move from the anchor of a coarse and of a fine selection of planes before it
/// is made again, metres. Fingertips move 0.1 to 1 mm between samples: the fine one lasts for
/// several, the coarse one for tens.
const REACH_M: [f64; 2] = [4e-3, 1e-3];

/// More than rounding can do to a distance within a capture volume, metres.
const ROUNDING_M: f64 = 1e-9;

/// [`crate::hull_distance_m`] for points of which each is near the one before, such as those of a
/// trajectory; the results are the same, bit by bit.
///
/// Distances to planes change by no more than the point moves. So of all planes only those that come
/// near the highest at one point (the anchor), or near the point itself, can matter within a
/// millimetre of it, and only they are looked at until the points leave it.
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
    coarse: Selection,
    fine: Selection,
    heights: Vec<[f64; LANES]>,
}

impl<'h> HullProbe<'h> {
    /// A probe that has seen no point. Costs nothing; one for each trajectory is fine.
    pub fn new(hull: &'h Hull) -> Self {
        let [coarse, fine] = REACH_M.map(Selection::new);
        Self {
            hull,
            coarse,
            fine,
            heights: Vec::new(),
        }
    }

    /// [`crate::hull_distance_m`] of the hull.
    pub fn distance_m(&mut self, p: [f64; 3]) -> f64 {
        if !self.fine.reaches(p) {
            if !self.coarse.reaches(p) {
                let highest = largest(planes(self.hull).map(|plane| [height_m(plane, p)]));
                self.coarse.start(p, highest);
                for (facet, plane) in planes(self.hull).enumerate() {
                    self.coarse.offer(facet, plane, height_m(plane, p));
                }
            }
            self.heights.clear();
            self.heights.extend(self.coarse.planes.heights_m(p));
            self.fine.start(p, largest(self.heights.iter().copied()));
            let heights = self.heights.as_flattened();
            for (&facet, height) in self.coarse.facets.iter().zip(heights) {
                let (normal, offset) = (self.hull.normals[facet], self.hull.offsets_m[facet]);
                self.fine.offer(facet, (normal, offset), *height);
            }
        }
        let highest = largest(self.fine.planes.heights_m(p));
        if highest > 0.0 {
            outside_m(self.hull, self.fine.facets.iter().copied(), p).unwrap_or(highest)
        } else if highest == f64::NEG_INFINITY {
            // NaN is larger than nothing.
            f64::NAN
        } else {
            highest
        }
    }
}

fn height_m((normal, offset): (Vec3, f64), p: Vec3) -> f64 {
    dot(normal, p) - offset
}

/// The planes that matter near an anchor, ascending.
#[derive(Clone, Debug)]
struct Selection {
    reach_m: f64,
    anchor: Vec3,
    least_m: f64,
    facets: Vec<usize>,
    planes: PlaneLanes,
}

impl Selection {
    fn new(reach_m: f64) -> Self {
        Self {
            reach_m,
            anchor: [f64::NAN; 3],
            least_m: f64::NAN,
            facets: Vec::new(),
            planes: PlaneLanes::default(),
        }
    }

    /// Whether the selection holds at `p`; never for NaN.
    fn reaches(&self, p: Vec3) -> bool {
        let moved = sub(p, self.anchor);
        dot(moved, moved) <= self.reach_m * self.reach_m
    }

    /// Empties the selection; from now on it is for points near `anchor`, where the highest plane is
    /// `highest_m` away.
    fn start(&mut self, anchor: Vec3, highest_m: f64) {
        self.anchor = anchor;
        // Within reach the highest one sinks and others rise by as much as the reach; and a plane
        // below the anchor by less can come to be seen.
        self.least_m = (highest_m - 2.0 * self.reach_m).min(-self.reach_m) - ROUNDING_M;
        self.facets.clear();
        self.planes.clear();
    }

    fn offer(&mut self, facet: usize, plane: (Vec3, f64), height_m: f64) {
        if height_m >= self.least_m {
            self.facets.push(facet);
            self.planes.push(plane);
        }
    }
}

/// Planes side by side, for the processor to look at several at once.
const LANES: usize = 4;

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

    /// Signed distances of `p` to the planes, lane by lane.
    fn heights_m(&self, [x, y, z]: Vec3) -> impl Iterator<Item = [f64; LANES]> {
        self.lanes.iter().map(move |[nx, ny, nz, offset]| {
            let mut heights = [0.0; LANES];
            for i in 0..LANES {
                heights[i] = nx[i] * x + ny[i] * y + nz[i] * z - offset[i];
            }
            heights
        })
    }
}

/// The largest number; minus infinity where there is none.
fn largest<const N: usize>(values: impl Iterator<Item = [f64; N]>) -> f64 {
    let mut largest = [f64::NEG_INFINITY; N];
    for values in values {
        for i in 0..N {
            largest[i] = if values[i] > largest[i] {
                values[i]
            } else {
                largest[i]
            };
        }
    }
    let mut highest = f64::NEG_INFINITY;
    for value in largest {
        highest = if value > highest { value } else { highest };
    }
    highest
}
