//! The same problem by Clarabel's interior-point method.
//!
//! Its unknowns are `h` and the errors of soft targets over their deviations, `r`:
//!
//! ```text
//! minimise  1/2 hᵀ Λ h - (Λ mu)ᵀ h + 1/2 |r|²
//! s.t.      A h / sigma - r = y / sigma   (or E h = e),   h >= 0,   n_j · h >= b_j
//! ```
//!
//! so that the quadratic term stays as sparse as the precision is: diagonal for `paper` (2 to 3 ms
//! with 200 primitives), dense for a full covariance (about 20 ms).

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolution, DefaultSolver, IPSolver, NonnegativeConeT,
    SolverStatus, ZeroConeT,
};
use nalgebra::DVector;

use crate::active_set::{Constraint, Ending};
use crate::problem::{Instance, Problem};
use crate::rows::ActiveRow;

/// Tighter than Clarabel's 1e-8: bounds that are active have to be told from those that are not.
const TOLERANCE: f64 = 1e-10;

/// Clarabel's answer.
pub(crate) struct Solution {
    pub(crate) ending: Ending,
    pub(crate) unknowns: DVector<f64>,
    /// All inequalities with multiplier and slack.
    pub(crate) inequalities: Vec<(Constraint, f64, f64)>,
    pub(crate) iterations: usize,
}

/// A program in Clarabel's form: minimise `1/2 xᵀ P x + qᵀ x` subject to `A x + s = b`, first `s = 0`, then
/// `s >= 0`.
pub(crate) struct Program {
    /// Upper triangle of `P`: row, column, value.
    quadratic: Vec<(usize, usize, f64)>,
    /// `q`.
    linear: Vec<f64>,
    /// `A`: row, column, value.
    matrix: Vec<(usize, usize, f64)>,
    /// `b`.
    pub(crate) right: Vec<f64>,
}

impl Program {
    /// A program of `P` (upper triangle) and `q` without constraints.
    pub(crate) fn new(quadratic: Vec<(usize, usize, f64)>, linear: Vec<f64>) -> Self {
        Self {
            quadratic,
            linear,
            matrix: Vec::new(),
            right: Vec::new(),
        }
    }

    /// Adds `factor * row` and more entries to `A`, and `right` to `b`.
    pub(crate) fn push<'r>(
        &mut self,
        row: impl IntoIterator<Item = &'r f64>,
        factor: f64,
        more: Option<(usize, f64)>,
        right: f64,
    ) {
        let at = self.right.len();
        let entries = (row.into_iter().enumerate()).map(|(column, v)| (column, factor * v));
        let used = entries.filter(|(_, v)| *v != 0.0).chain(more);
        self.matrix
            .extend(used.map(|(column, value)| (at, column, value)));
        self.right.push(right);
    }

    /// Solves it, with `s = 0` for the first `equations` rows; `None` where it cannot be set up or the answer holds
    /// numbers that are none.
    pub(crate) fn solve(self, equations: usize) -> Option<DefaultSolution<f64>> {
        let csc = |rows: usize, entries: Vec<(usize, usize, f64)>| {
            let (mut i, mut j, mut values) = (Vec::new(), Vec::new(), Vec::new());
            for (row, column, value) in entries {
                i.push(row);
                j.push(column);
                values.push(value);
            }
            CscMatrix::new_from_triplets(rows, self.linear.len(), i, j, values)
        };
        let (quadratic, matrix) = (
            csc(self.linear.len(), self.quadratic),
            csc(self.right.len(), self.matrix),
        );
        let inequalities = self.right.len() - equations;
        let cones = [ZeroConeT(equations), NonnegativeConeT(inequalities)];
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .max_threads(1)
            .tol_gap_abs(TOLERANCE)
            .tol_gap_rel(TOLERANCE)
            .tol_feas(TOLERANCE)
            .build()
            .ok()?;
        let mut solver = DefaultSolver::new(
            &quadratic,
            &self.linear,
            &matrix,
            &self.right,
            &cones,
            settings,
        )
        .ok()?;
        solver.solve();
        let found = solver.solution;
        found.x.iter().all(|v| v.is_finite()).then_some(found)
    }
}

/// Solves the problem with the rows `normal · h >= bound`.
pub(crate) fn solve(
    problem: &Problem,
    instance: &Instance,
    signs: bool,
    rows: &[ActiveRow],
) -> Solution {
    // Hard targets are rows like soft ones, but without an error.
    let (targets, roots) = match &problem.equalities {
        Some(equalities) => (&equalities.rows, Vec::new()),
        None => (
            &problem.design,
            problem.weights.iter().map(|w| w.sqrt()).collect(),
        ),
    };
    let (observed, rank) = targets.shape();
    let errors = rank..rank + roots.len();
    let mut quadratic = problem.precision.upper(rank);
    quadratic.extend(errors.clone().map(|error| (error, error, 1.0)));
    let mut linear: Vec<f64> = (-problem.precision.times(&instance.mean)).data.into();
    linear.resize(errors.end, 0.0);
    let mut program = Program::new(quadratic, linear);
    for (k, row) in targets.row_iter().enumerate() {
        let root = roots.get(k).copied().unwrap_or(1.0);
        let error = roots.get(k).map(|_| (rank + k, -1.0));
        program.push(row.iter(), root, error, instance.values[k] * root);
    }
    let signed = if signs { rank } else { 0 };
    for i in 0..signed {
        program.push([], 1.0, Some((i, -1.0)), 0.0);
    }
    for active in rows {
        program.push(active.normal.iter(), -1.0, None, -active.bound);
    }
    let Some(found) = program.solve(observed) else {
        return Solution {
            ending: Ending::Stalled,
            unknowns: DVector::zeros(rank),
            inequalities: Vec::new(),
            iterations: 0,
        };
    };
    let constraints = (0..signed)
        .map(Constraint::Sign)
        .chain((0..rows.len()).map(Constraint::Row));
    Solution {
        ending: match found.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => Ending::Optimal,
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => {
                Ending::Infeasible
            }
            _ => Ending::Stalled,
        },
        unknowns: DVector::from_column_slice(&found.x[..rank]),
        inequalities: constraints
            .zip(&found.z[observed..])
            .zip(&found.s[observed..])
            .map(|((constraint, &multiplier), &slack)| (constraint, multiplier, slack))
            .collect(),
        iterations: found.iterations as usize,
    }
}
