//! The same problems written out plainly, with every row present, for Clarabel and for closed forms.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT,
    SolverStatus, SupportedConeT, ZeroConeT,
};
use inhand_model::{
    Dictionary, DictionaryKind, EndConditions, Finger, Residual, SEGMENT_COORDINATES,
    SegmentLayout, SmoothCurve,
};
use nalgebra::{DMatrix, DVector};

/// `v = base + W h`, `h ~ N(mean, covariance)`, mm and mm/s.
#[derive(Clone)]
pub(crate) struct Gaussian {
    pub(crate) layout: SegmentLayout,
    pub(crate) w: DMatrix<f64>,
    pub(crate) base: DVector<f64>,
    pub(crate) mean: DVector<f64>,
    pub(crate) covariance: DMatrix<f64>,
    signs: bool,
}

/// Rows of factors of the unknowns, with what they are where these are zero.
pub(crate) struct Rows {
    pub(crate) factors: DMatrix<f64>,
    pub(crate) base: DVector<f64>,
}

impl Gaussian {
    pub(crate) fn of_dictionary(dictionary: &Dictionary) -> Self {
        Self {
            layout: dictionary.layout,
            w: dictionary.primitives.clone(),
            base: &dictionary.offset_m * 1e3,
            mean: &dictionary.activation_mean_m * 1e3,
            covariance: &dictionary.activation_covariance_m2 * 1e6,
            signs: dictionary.kind == DictionaryKind::Nmf,
        }
    }

    /// With what is expected of the deviation at these end conditions.
    pub(crate) fn of_residual(residual: &Residual, ends: &DVector<f64>) -> Self {
        let layout = residual.layout;
        let (d, r) = (residual.ends_mean.len(), residual.primitives.ncols());
        let mut w = DMatrix::zeros(layout.rows(), d + r);
        w.columns_mut(0, d)
            .copy_from(&SmoothCurve::Hermite.basis(layout));
        w.columns_mut(d, r).copy_from(&residual.primitives);
        let mut mean = DVector::zeros(d + r);
        mean.rows_mut(0, d).copy_from(&residual.ends_mean);
        mean.rows_mut(d, r).copy_from(&residual.expected_m(ends));
        let mut covariance = DMatrix::zeros(d + r, d + r);
        covariance
            .view_mut((0, 0), (d, d))
            .copy_from(&residual.ends_covariance);
        covariance
            .view_mut((d, d), (r, r))
            .copy_from(&residual.covariance_m2);
        Self {
            layout,
            w,
            base: DVector::zeros(layout.rows()),
            mean: mean * 1e3,
            covariance: covariance * 1e6,
            signs: false,
        }
    }

    /// Trajectory coordinates.
    pub(crate) fn coordinates(&self, places: &[usize]) -> Rows {
        Rows {
            factors: self.w.select_rows(places),
            base: self.base.select_rows(places),
        }
    }

    /// One fingertip at a sample.
    pub(crate) fn tip(&self, sample: usize, finger: Finger) -> Rows {
        let at = SegmentLayout::row(sample, finger, 0);
        self.coordinates(&[at, at + 1, at + 2])
    }

    /// First and last configuration, with what is wanted of them, mm.
    pub(crate) fn ends(&self, ends: &EndConditions) -> (Rows, DVector<f64>) {
        let last = self.layout.finger_rows() - SEGMENT_COORDINATES;
        let places: Vec<usize> = (0..SEGMENT_COORDINATES)
            .chain(last..last + SEGMENT_COORDINATES)
            .collect();
        let wanted = [ends.first_m, ends.last_m].concat();
        (self.coordinates(&places), DVector::from_vec(wanted) * 1e3)
    }

    /// First (order 1) or second differences of every coordinate, times the rate as often: mm/s.
    pub(crate) fn differences(&self, order: usize) -> Rows {
        let rate = self.layout.rate_hz;
        let c = SEGMENT_COORDINATES;
        let count = (self.layout.samples - order) * c;
        let part = |matrix: &DMatrix<f64>, k: usize| matrix.rows(k * c, count).into_owned();
        let combine = |matrix: &DMatrix<f64>| match order {
            1 => (part(matrix, 1) - part(matrix, 0)) * rate,
            _ => (part(matrix, 2) - part(matrix, 1) * 2.0 + part(matrix, 0)) * rate * rate,
        };
        let base = DMatrix::from_column_slice(self.base.len(), 1, self.base.as_slice());
        Rows {
            factors: combine(&self.w),
            base: combine(&base).column(0).into_owned(),
        }
    }

    /// Mean and covariance of the unknowns once `rows` were seen to be `wanted` with standard
    /// deviation `sigma` (mm), by the formula for Gaussians.
    pub(crate) fn given(&self, rows: &Rows, wanted: &DVector<f64>, sigma: f64) -> Self {
        let a = &rows.factors;
        let noise = DMatrix::identity(a.nrows(), a.nrows()) * sigma * sigma;
        let spread = a * &self.covariance * a.transpose() + noise;
        let solved = spread.clone().lu();
        let across = &self.covariance * a.transpose();
        let missing = wanted - &rows.base - a * &self.mean;
        let mean = &self.mean + &across * solved.solve(&missing).expect("spread out");
        let covariance =
            &self.covariance - &across * solved.solve(&across.transpose()).expect("spread out");
        Self {
            mean,
            covariance,
            ..self.clone()
        }
    }

    /// The mean motion, mm.
    pub(crate) fn motion(&self) -> DVector<f64> {
        &self.base + &self.w * &self.mean
    }
}

/// `1/2 hᵀ P h + qᵀ h + c` under equations, inequalities and balls.
pub(crate) struct Plain {
    signs: bool,
    p: DMatrix<f64>,
    q: DVector<f64>,
    c: f64,
    equations: Vec<(DVector<f64>, f64)>,
    /// `row · h >= bound`.
    inequalities: Vec<(DVector<f64>, f64)>,
    /// `|rows h + offset| <= radius`.
    balls: Vec<(DMatrix<f64>, DVector<f64>, f64)>,
}

/// What the plain problem's solver says.
#[derive(Debug)]
pub(crate) enum Answer {
    Solved(DVector<f64>),
    Infeasible,
}

impl Plain {
    pub(crate) fn new(gaussian: &Gaussian) -> Self {
        let p = gaussian.covariance.clone().try_inverse().expect("regular");
        let q = -(&p * &gaussian.mean);
        Self {
            signs: gaussian.signs,
            c: -0.5 * q.dot(&gaussian.mean),
            p,
            q,
            equations: Vec::new(),
            inequalities: Vec::new(),
            balls: Vec::new(),
        }
    }

    /// A ridge about zero instead of the prior.
    pub(crate) fn with_ridge(gaussian: &Gaussian, ridge: f64) -> Self {
        let n = gaussian.mean.len();
        Self {
            p: DMatrix::identity(n, n) * ridge,
            q: DVector::zeros(n),
            c: 0.0,
            ..Self::new(gaussian)
        }
    }

    pub(crate) fn soft(&mut self, rows: &Rows, wanted: &DVector<f64>, sigma: f64) {
        let y = wanted - &rows.base;
        let weight = sigma.powi(-2);
        self.p += rows.factors.transpose() * &rows.factors * weight;
        self.q -= rows.factors.transpose() * &y * weight;
        self.c += 0.5 * weight * y.norm_squared();
    }

    pub(crate) fn hard(&mut self, rows: &Rows, wanted: &DVector<f64>) {
        for (k, row) in rows.factors.row_iter().enumerate() {
            self.equations
                .push((row.transpose(), wanted[k] - rows.base[k]));
        }
    }

    /// Every row between these bounds, taken in turn.
    pub(crate) fn between(&mut self, rows: &Rows, lower: &[f64], upper: &[f64]) {
        for (k, row) in rows.factors.row_iter().enumerate() {
            let (lower, upper) = (lower[k % lower.len()], upper[k % upper.len()]);
            self.at_least(row.transpose(), lower - rows.base[k]);
            self.at_least(-row.transpose(), rows.base[k] - upper);
        }
    }

    pub(crate) fn at_least(&mut self, row: DVector<f64>, bound: f64) {
        self.inequalities.push((row, bound));
    }

    pub(crate) fn near(&mut self, rows: &Rows, centre: &DVector<f64>, radius: f64) {
        self.balls
            .push((rows.factors.clone(), &rows.base - centre, radius));
    }

    pub(crate) fn objective(&self, h: &DVector<f64>) -> f64 {
        0.5 * h.dot(&(&self.p * h)) + self.q.dot(h) + self.c
    }

    /// Clarabel on all of it, without any of the planner's shortcuts; as exactly as it gets.
    pub(crate) fn solve(&self) -> Answer {
        let tolerances = [1e-11, 1e-9, 1e-8];
        let answers = tolerances
            .into_iter()
            .map(|tolerance| self.solve_to(tolerance));
        let mut failures = String::new();
        for answer in answers {
            match answer {
                Ok(answer) => return answer,
                Err(status) => failures += &format!(" {status:?}"),
            }
        }
        panic!("the plain problem ended with{failures}");
    }

    fn solve_to(&self, tolerance: f64) -> Result<Answer, SolverStatus> {
        let n = self.q.len();
        let mut rows: Vec<(DVector<f64>, f64)> = self.equations.clone();
        let mut cones: Vec<SupportedConeT<f64>> = vec![ZeroConeT(rows.len())];
        // A x + s = b with s >= 0.
        rows.extend(self.inequalities.iter().map(|(row, bound)| (-row, -bound)));
        if self.signs {
            rows.extend((0..n).map(|i| {
                (
                    DVector::from_fn(n, |j, _| if i == j { -1.0 } else { 0.0 }),
                    0.0,
                )
            }));
        }
        cones.push(NonnegativeConeT(rows.len() - self.equations.len()));
        for (factors, offset, radius) in &self.balls {
            rows.push((DVector::zeros(n), *radius));
            for (k, row) in factors.row_iter().enumerate() {
                rows.push((-row.transpose(), offset[k]));
            }
            cones.push(SecondOrderConeT(1 + factors.nrows()));
        }
        let (mut i, mut j, mut v) = (Vec::new(), Vec::new(), Vec::new());
        for (at, (row, _)) in rows.iter().enumerate() {
            for (column, &value) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                i.push(at);
                j.push(column);
                v.push(value);
            }
        }
        let a = CscMatrix::new_from_triplets(rows.len(), n, i, j, v);
        let (mut i, mut j, mut v) = (Vec::new(), Vec::new(), Vec::new());
        for column in 0..n {
            for row in 0..=column {
                i.push(row);
                j.push(column);
                v.push(self.p[(row, column)]);
            }
        }
        let p = CscMatrix::new_from_triplets(n, n, i, j, v);
        let right: Vec<f64> = rows.iter().map(|(_, right)| *right).collect();
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .tol_gap_abs(tolerance)
            .tol_gap_rel(tolerance)
            .tol_feas(tolerance)
            .build()
            .expect("the tolerances are in range");
        let mut solver = DefaultSolver::new(&p, self.q.as_slice(), &a, &right, &cones, settings)
            .expect("the sizes fit");
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => Ok(Answer::Solved(
                DVector::from_column_slice(&solver.solution.x),
            )),
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
                Ok(Answer::Infeasible)
            }
            status => Err(status),
        }
    }
}
