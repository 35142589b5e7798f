//! Strictly convex quadratic programs by a dual active-set method.
//!
//! ```text
//! minimise  1/2 hᵀ P h + qᵀ h   subject to   n_j · h >= b_j
//! ```
//!
//! D. Goldfarb and A. Idnani, "A numerically stable dual method for solving strictly convex
//! quadratic programs", Mathematical Programming 27 (1983): start from the unconstrained minimum,
//! activate one violated row after the other, and drop those whose multiplier would turn negative.
//! The dual objective rises with every step, so no set of rows comes back and the end is reached.
//!
//! Here the inverse `C = P⁻¹` is known beforehand (it is the same for every target), so that the
//! rows' images `C n_j` are columns of `C` for sign constraints, and only the small matrix
//! `K = Nᵀ C N` of the k working rows is factorised: O(n k + k²) a step, where the classical form
//! updates an n x n factor. That squares the condition number of the working rows, which the
//! refinement at the end takes back.

use nalgebra::{DMatrix, DVector};

use crate::cholesky::{Factor, add_scaled, dot};

/// A sign constraint `h_i >= 0` is violated below this, mm: a picometre.
const SIGN_TOLERANCE_MM: f64 = 1e-9;
/// A row is a combination of the working ones where less than this part of its curvature is left.
const DEPENDENT: f64 = 1e-12;
/// The square of what rounding leaves of a direction that is not free.
const NOTHING: f64 = 1e-22;
/// Steps allowed for each row that could be active. Practice needs about one for each that is.
const STEPS_PER_ROW: usize = 20;

/// End of a minimisation, by this method or by Clarabel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// Every row holds, every multiplier is positive.
    Optimal,
    /// A row contradicts the working ones.
    Infeasible,
    /// Too many steps, or no answer.
    Stalled,
}

/// A row `normal · h >= bound` other than a sign constraint.
#[derive(Clone, Debug)]
struct Row {
    normal: DVector<f64>,
    bound: f64,
    /// `|n|²`.
    size: f64,
    /// `C n`, once the row was looked at closely.
    image: Option<DVector<f64>>,
    /// How far the row may be violated.
    tolerance: f64,
}

/// A constraint: the sign of an unknown, or a general row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Constraint {
    /// `h_i >= 0`.
    Sign(usize),
    /// A general row, in the order they were added.
    Row(usize),
}

/// The method's state: an optimum of the rows activated so far. Rows can be added and the
/// minimisation continued.
#[derive(Clone, Debug)]
pub(crate) struct ActiveSet<'a> {
    /// `C` (n x n), symmetric; only semidefinite where equations leave less than n directions free.
    inverse: &'a DMatrix<f64>,
    /// Curvatures of a row of length one below this are rounding: nothing free is in the row.
    least_curvature: f64,
    signs: bool,
    rows: Vec<Row>,
    pub(crate) point: DVector<f64>,
    working: Vec<Constraint>,
    multipliers: Vec<f64>,
    factor: Factor,
    pub(crate) steps: usize,
    /// Why there is no solution, once a minimisation found none.
    pub(crate) contradiction: Option<Contradiction>,
}

/// Proof that no point keeps all rows (Farkas): with these factors, none negative, the rows add up to one
/// in which nothing is free, while their bounds add up to more than its value.
#[derive(Clone, Debug)]
pub(crate) struct Contradiction {
    /// Constraints with their factors.
    pub(crate) factors: Vec<(Constraint, f64)>,
    /// By how much the sum of the bounds is more than the value.
    pub(crate) missing: f64,
}

/// The search for the row with the largest gain.
#[derive(Default)]
struct Contest {
    best: Option<Constraint>,
    gain: f64,
}

impl Contest {
    fn enter(
        &mut self,
        working: &[Constraint],
        constraint: Constraint,
        slack: f64,
        curvature: f64,
    ) {
        // A row in which nothing is free comes first: it shows that there is no solution.
        let curvature = curvature.max(f64::MIN_POSITIVE);
        // Working rows hold, but for rounding: activating one twice would lead nowhere.
        if slack * slack > self.gain * curvature && !working.contains(&constraint) {
            self.gain = slack * slack / curvature;
            self.best = Some(constraint);
        }
    }
}

impl<'a> ActiveSet<'a> {
    /// Starts at the unconstrained minimum `-C q`, with `h >= 0` if `signs`.
    pub(crate) fn new(inverse: &'a DMatrix<f64>, unconstrained: DVector<f64>, signs: bool) -> Self {
        Self {
            inverse,
            least_curvature: NOTHING * inverse.diagonal().max(),
            signs,
            rows: Vec::new(),
            point: unconstrained,
            working: Vec::new(),
            multipliers: Vec::new(),
            factor: Factor::default(),
            steps: 0,
            contradiction: None,
        }
    }

    /// Adds the row `normal · h >= bound`, which may be violated by `tolerance`.
    pub(crate) fn add_row(&mut self, normal: DVector<f64>, bound: f64, tolerance: f64) {
        self.rows.push(Row {
            size: normal.norm_squared(),
            normal,
            bound,
            image: None,
            tolerance,
        });
    }

    /// Constraints that hold with equality, with their multipliers.
    pub(crate) fn working(&self) -> impl Iterator<Item = (Constraint, f64)> {
        self.working
            .iter()
            .copied()
            .zip(self.multipliers.iter().copied())
    }

    /// Moves to the minimum under all rows.
    pub(crate) fn minimise(&mut self) -> Ending {
        let limit = self.steps + STEPS_PER_ROW * (self.point.len() + self.rows.len());
        while let Some(entering) = self.most_violated() {
            match self.activate(entering, limit) {
                Ending::Optimal => {}
                ending => return ending,
            }
        }
        Ending::Optimal
    }

    /// The violated row to activate next: the one whose enforcement alone would raise the objective
    /// most, by slack² / curvature. The curvature `nᵀ C n` of a general row costs n² operations, so
    /// only that of the row with the largest slack² / |n|² is looked at, and kept.
    fn most_violated(&mut self) -> Option<Constraint> {
        let mut sign = Contest::default();
        if self.signs {
            for (i, &h) in self.point.iter().enumerate() {
                if h < -SIGN_TOLERANCE_MM {
                    sign.enter(&self.working, Constraint::Sign(i), h, self.inverse[(i, i)]);
                }
            }
        }
        let mut general = Contest::default();
        for (j, row) in self.rows.iter().enumerate() {
            let slack = row.normal.dot(&self.point) - row.bound;
            if slack < -row.tolerance {
                general.enter(&self.working, Constraint::Row(j), slack, row.size);
            }
        }
        let Some(Constraint::Row(j)) = general.best else {
            return sign.best;
        };
        let row = &mut self.rows[j];
        let image = row.image.get_or_insert_with(|| self.inverse * &row.normal);
        let curvature = row.normal.dot(image).max(f64::MIN_POSITIVE);
        let gain = general.gain * row.size / curvature;
        if sign.gain > gain {
            sign.best
        } else {
            general.best
        }
    }

    /// Makes row `entering` hold with equality, dropping working rows on the way where their
    /// multipliers reach zero.
    fn activate(&mut self, entering: Constraint, limit: usize) -> Ending {
        let mut multiplier = 0.0;
        loop {
            if self.steps >= limit {
                return Ending::Stalled;
            }
            self.steps += 1;
            // Lower solve of the entering row against the working ones: what remains of its
            // curvature, and how the working multipliers answer.
            let (lower, whole) = self.against_working(entering);
            let left = whole - dot(&lower, &lower);
            let mut answer = lower.clone();
            self.factor.solve_lower_transposed(&mut answer);

            let blocking = self
                .multipliers
                .iter()
                .zip(&answer)
                .enumerate()
                .filter(|(_, (_, r))| **r > 0.0)
                .map(|(j, (u, r))| (j, u / r))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let full = if self.is_independent(entering, left, whole) {
                -self.slack(entering) / left
            } else {
                f64::INFINITY
            };
            let length = blocking.map_or(full, |(_, partial)| partial.min(full));
            if length.is_infinite() {
                // The entering row is the working ones times factors that are not positive.
                let working = self.working.iter().zip(&answer);
                self.contradiction = Some(Contradiction {
                    factors: std::iter::once((entering, 1.0))
                        .chain(working.map(|(&constraint, r)| (constraint, -r)))
                        .collect(),
                    missing: -self.slack(entering),
                });
                return Ending::Infeasible;
            }
            if full.is_finite() {
                let mut direction = self.image(entering).to_vec();
                for (&constraint, r) in self.working.iter().zip(&answer) {
                    add_scaled(&mut direction, -r, self.image(constraint));
                }
                add_scaled(self.point.as_mut_slice(), length, &direction);
            }
            add_scaled(&mut self.multipliers, -length, &answer);
            multiplier += length;
            match blocking {
                Some((j, partial)) if partial < full => self.drop_working(j),
                _ => {
                    self.factor.append(&lower, left);
                    self.working.push(entering);
                    self.multipliers.push(multiplier);
                    return Ending::Optimal;
                }
            }
        }
    }

    /// Puts constraints to work, as far as they are independent, with multipliers still at zero:
    /// the next refinement moves to the minimum where they hold with equality.
    pub(crate) fn hold(&mut self, constraints: impl IntoIterator<Item = Constraint>) {
        for constraint in constraints {
            if let Constraint::Row(j) = constraint {
                let row = &mut self.rows[j];
                row.image.get_or_insert_with(|| self.inverse * &row.normal);
            }
            let (lower, whole) = self.against_working(constraint);
            let left = whole - dot(&lower, &lower);
            if self.is_independent(constraint, left, whole) {
                self.factor.append(&lower, left);
                self.working.push(constraint);
                self.multipliers.push(0.0);
            }
        }
    }

    /// One step of iterative refinement of point and working multipliers, from the gradient of the
    /// objective at the present point: solves
    ///
    /// ```text
    /// P dh - N du = N u - gradient,   Nᵀ dh = b - Nᵀ h
    /// ```
    pub(crate) fn refine(&mut self, gradient: DVector<f64>) {
        let mut residual = gradient;
        for (&constraint, &u) in self.working.iter().zip(&self.multipliers) {
            match constraint {
                Constraint::Sign(i) => residual[i] -= u,
                Constraint::Row(j) => residual.axpy(-u, &self.rows[j].normal, 1.0),
            }
        }
        let mut step = -(self.inverse * residual);
        let mut change: Vec<f64> = self
            .working
            .iter()
            .map(|&constraint| -self.slack(constraint) - self.along(constraint, step.as_slice()))
            .collect();
        self.factor.solve_lower(&mut change);
        self.factor.solve_lower_transposed(&mut change);
        for (&constraint, &du) in self.working.iter().zip(&change) {
            add_scaled(step.as_mut_slice(), du, self.image(constraint));
        }
        self.point += step;
        add_scaled(&mut self.multipliers, 1.0, &change);
    }

    /// Sets working activations to exactly zero, as well as others that rounding left below it, and
    /// multipliers likewise.
    pub(crate) fn snap(&mut self) {
        for (&constraint, u) in self.working.iter().zip(&mut self.multipliers) {
            if let Constraint::Sign(i) = constraint {
                self.point[i] = 0.0;
            }
            *u = u.max(0.0);
        }
        if self.signs {
            for h in self.point.iter_mut() {
                if *h < 0.0 && *h >= -SIGN_TOLERANCE_MM {
                    *h = 0.0;
                }
            }
        }
    }

    /// Whether a row is more than a combination of the working ones, with `left` of its curvature
    /// `whole` remaining.
    fn is_independent(&self, constraint: Constraint, left: f64, whole: f64) -> bool {
        let size = match constraint {
            Constraint::Sign(_) => 1.0,
            Constraint::Row(j) => self.rows[j].size,
        };
        left > DEPENDENT * whole && whole > self.least_curvature * size
    }

    fn drop_working(&mut self, j: usize) {
        self.factor.remove(j);
        self.working.remove(j);
        self.multipliers.remove(j);
    }

    /// `L⁻¹ Nᵀ C n` of a constraint against the working ones, and its own `nᵀ C n`.
    fn against_working(&self, constraint: Constraint) -> (Vec<f64>, f64) {
        let image = self.image(constraint);
        let mut lower: Vec<f64> = self
            .working
            .iter()
            .map(|&working| self.along(working, image))
            .collect();
        self.factor.solve_lower(&mut lower);
        (lower, self.along(constraint, image))
    }

    /// `C n` of a constraint.
    fn image(&self, constraint: Constraint) -> &[f64] {
        match constraint {
            Constraint::Sign(i) => {
                let n = self.inverse.nrows();
                &self.inverse.as_slice()[i * n..(i + 1) * n]
            }
            Constraint::Row(j) => self.rows[j]
                .image
                .as_ref()
                .expect("the image is made before a row is activated")
                .as_slice(),
        }
    }

    /// `n · v` of a constraint.
    fn along(&self, constraint: Constraint, v: &[f64]) -> f64 {
        match constraint {
            Constraint::Sign(i) => v[i],
            Constraint::Row(j) => dot(self.rows[j].normal.as_slice(), v),
        }
    }

    /// `n · h - b` of a constraint.
    fn slack(&self, constraint: Constraint) -> f64 {
        let bound = match constraint {
            Constraint::Sign(_) => 0.0,
            Constraint::Row(j) => self.rows[j].bound,
        };
        self.along(constraint, self.point.as_slice()) - bound
    }
}
