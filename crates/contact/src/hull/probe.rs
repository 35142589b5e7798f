//! Distance to a hull along a path.

use inhand_model::Hull;

use super::distance::{ROUNDING_M, outside_m, planes};
use super::vector::{Vec3, dot, sub};

/// How far a point may move from the anchor of a coarse and of a fine selection of planes before it
/// is made again, metres. Fingertips move 0.1 to 1 mm between samples: the fine one lasts for
/// several, the coarse one for tens.
const COARSE_REACH_M: f64 = 4e-3;
const FINE_REACH_M: f64 = 1e-3;

/// More than rounding can do to a height, and than is asked of it, metres.
const MARGIN_M: f64 = 10.0 * ROUNDING_M;

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
    /// All planes, from the first point on.
    all: PlaneLanes,
    coarse: Selection,
    fine: Selection,
    /// Heights of the planes that a selection is made of.
    heights: Vec<[f64; LANES]>,
}

impl<'h> HullProbe<'h> {
    /// A probe that has seen no point. It costs nothing to make, but its first point costs as much as
    /// [`crate::hull_distance_m`].
    pub fn new(hull: &'h Hull) -> Self {
        Self {
            hull,
            all: PlaneLanes::default(),
            // A fine selection can be made anywhere within reach, and must hold within its own.
            coarse: Selection::new(COARSE_REACH_M, COARSE_REACH_M + FINE_REACH_M),
            fine: Selection::new(FINE_REACH_M, FINE_REACH_M),
            heights: Vec::new(),
        }
    }

    /// [`crate::hull_distance_m`] of the hull.
    pub fn distance_m(&mut self, p: [f64; 3]) -> f64 {
        if !self.fine.reaches(p) {
            self.move_selections(p);
        }
        let highest = largest(self.fine.planes.heights_m(p));
        if highest > 0.0 {
            outside_m(self.hull, self.fine.facets.iter().map(|&f| f as usize), p).unwrap_or(highest)
        } else if highest == f64::NEG_INFINITY {
            // NaN is larger than nothing.
            f64::NAN
        } else {
            highest
        }
    }
    fn move_selections(&mut self, p: Vec3) {
        if !self.coarse.reaches(p) {
            if self.all.is_empty() {
                planes(self.hull).for_each(|plane| self.all.push(plane));
            }
            self.heights.clear();
            self.heights.extend(self.all.heights_m(p));
            let all = planes(self.hull).zip(0..);
            self.coarse.select(p, all, &self.heights);
        }
        self.heights.clear();
        self.heights.extend(self.coarse.planes.heights_m(p));
        let (normals, offsets) = (&self.hull.normals, &self.hull.offsets_m);
        let coarse = (self.coarse.facets.iter())
            .map(|&facet| ((normals[facet as usize], offsets[facet as usize]), facet));
        self.fine.select(p, coarse, &self.heights);
    }
}

/// The planes that matter near an anchor, ascending.
#[derive(Clone, Debug)]
struct Selection {
    /// How far from the anchor it is used.
    reach_m: f64,
    /// How far from the anchor it holds.
    holds_m: f64,
    anchor: Vec3,
    facets: Vec<u32>,
    planes: PlaneLanes,
}

impl Selection {
    fn new(reach_m: f64, holds_m: f64) -> Self {
        Self {
            reach_m,
            holds_m,
            anchor: [f64::NAN; 3],
            facets: Vec::new(),
            planes: PlaneLanes::default(),
        }
    }

    /// Whether `p` is within reach; never for NaN.
    fn reaches(&self, p: Vec3) -> bool {
        let moved = sub(p, self.anchor);
        dot(moved, moved) <= self.reach_m * self.reach_m
    }

    /// Selects those of `planes`, `heights` away from `anchor`, that matter near it.
    fn select(
        &mut self,
        anchor: Vec3,
        planes: impl Iterator<Item = ((Vec3, f64), u32)>,
        heights: &[[f64; LANES]],
    ) {
        self.anchor = anchor;
        // Over a distance the highest one sinks and others rise by no more than that; and a plane
        // above the anchor by less can come to be seen.
        let highest = largest(heights.iter().copied());
        let least = (highest - 2.0 * self.holds_m).min(-self.holds_m) - MARGIN_M;
        self.facets.clear();
        self.planes.clear();
        for (&height, (plane, facet)) in heights.as_flattened().iter().zip(planes) {
            if height >= least {
                self.facets.push(facet);
                self.planes.push(plane);
            }
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

    fn is_empty(&self) -> bool {
        self.count == 0
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
