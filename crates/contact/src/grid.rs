//! Nearest of many points, by cells of a grid.

/// Points of a cell that a surface goes through, about.
const POINTS_IN_CELL: f64 = 4.0;

/// Share of a distance that is more than rounding.
const ROUNDING: f64 = 1e-9;

/// Points in cubic cells.
#[derive(Clone, Debug)]
pub(crate) struct PointGrid {
    /// Cell by cell, the last axis fastest.
    points: Vec<[f64; 3]>,
    /// First point of each cell, and their number.
    starts: Vec<usize>,
    low_m: [f64; 3],
    high_m: [f64; 3],
    cells: [usize; 3],
    edge_m: f64,
}

impl PointGrid {
    /// A grid of points on a surface, about `apart_m` from each other.
    pub(crate) fn new(points: &[[f64; 3]], apart_m: f64) -> Self {
        let axis = |fold: fn(f64, f64) -> f64, axis: usize| {
            points.iter().map(|p| p[axis]).reduce(fold).unwrap_or(0.0)
        };
        let mut grid = Self {
            points: Vec::new(),
            starts: Vec::new(),
            low_m: [0, 1, 2].map(|k| axis(f64::min, k)),
            high_m: [0, 1, 2].map(|k| axis(f64::max, k)),
            cells: [usize::MAX; 3],
            edge_m: apart_m * POINTS_IN_CELL.sqrt(),
        };
        grid.cells = [0, 1, 2].map(|k| grid.cell(k, grid.high_m[k]) + 1);
        let place = |p: &[f64; 3]| grid.place([0, 1, 2].map(|k| grid.cell(k, p[k])));
        // Where the points of each cell end, then filled from there backwards.
        let mut starts = vec![0; grid.cells.iter().product::<usize>() + 1];
        points.iter().for_each(|p| starts[place(p)] += 1);
        let mut end = 0;
        for start in &mut starts {
            end += *start;
            *start = end;
        }
        let mut sorted = vec![[0.0; 3]; points.len()];
        for p in points.iter().rev() {
            let start = &mut starts[place(p)];
            *start -= 1;
            sorted[*start] = *p;
        }
        Self {
            points: sorted,
            starts,
            ..grid
        }
    }

    pub(crate) fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// Distance of a finite `p` to the nearest point, which is no nearer than `least_m`; infinite without points.
    pub(crate) fn nearest_m(&self, p: [f64; 3], least_m: f64) -> f64 {
        if self.points.is_empty() {
            return f64::INFINITY;
        }
        let mut more_m = 0.5 * self.edge_m;
        loop {
            let reach_m = least_m + more_m;
            let nearest_m = self.within_m2(p, reach_m * reach_m).sqrt();
            if nearest_m <= reach_m * (1.0 - ROUNDING) || reach_m.is_infinite() {
                return nearest_m;
            }
            more_m *= 2.0;
        }
    }

    /// Squared distance to the nearest point, if it is no more than `reach_m2`; else that or more.
    fn within_m2(&self, p: [f64; 3], reach_m2: f64) -> f64 {
        let beyond_m2 = [0, 1, 2].map(|k| outside_m(p[k], self.low_m[k], self.high_m[k]).powi(2));
        let mut nearest_m2 = f64::INFINITY;
        for x in self.near(0, p[0], reach_m2 - beyond_m2[1] - beyond_m2[2]) {
            let x_m2 = self.off_m(0, x, p[0]).powi(2);
            for y in self.near(1, p[1], reach_m2.min(nearest_m2) - x_m2 - beyond_m2[2]) {
                let y_m2 = self.off_m(1, y, p[1]).powi(2);
                let z = self.near(2, p[2], reach_m2.min(nearest_m2) - x_m2 - y_m2);
                let cells = self.place([x, y, z.start])..self.place([x, y, z.end]);
                for q in &self.points[self.starts[cells.start]..self.starts[cells.end]] {
                    let [x, y, z] = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
                    nearest_m2 = nearest_m2.min(x * x + y * y + z * z);
                }
            }
        }
        nearest_m2
    }

    /// Cells along an axis whose squared distance to a coordinate may be `reach_m2`.
    fn near(&self, axis: usize, at_m: f64, reach_m2: f64) -> std::ops::Range<usize> {
        if reach_m2 < 0.0 {
            return 0..0;
        }
        let reach_m = reach_m2.sqrt();
        self.cell(axis, at_m - reach_m)..self.cell(axis, at_m + reach_m) + 1
    }

    /// Distance of a coordinate to a cell along an axis.
    fn off_m(&self, axis: usize, cell: usize, at_m: f64) -> f64 {
        let low_m = self.low_m[axis] + cell as f64 * self.edge_m;
        outside_m(at_m, low_m, low_m + self.edge_m) * (1.0 - ROUNDING)
    }

    /// The cell of a coordinate, or the one next to it. Never falls as the coordinate rises.
    fn cell(&self, axis: usize, at_m: f64) -> usize {
        let cell = (at_m - self.low_m[axis]) / self.edge_m;
        (cell as usize).min(self.cells[axis] - 1)
    }

    fn place(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.cells[1] + y) * self.cells[2] + z
    }
}

/// Distance of a number to an interval.
fn outside_m(at_m: f64, low_m: f64, high_m: f64) -> f64 {
    (low_m - at_m).max(at_m - high_m).max(0.0)
}
