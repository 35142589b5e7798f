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
    DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT,
    SolverStatus, ZeroConeT,
};
use nalgebra::{DMatrix, DVector};

use crate::active_set::Constraint;
use crate::precision::Precision;
use crate::problem::{Instance, Problem};
use crate::solve::Taken;

/// Tighter than Clarabel's 1e-8: bounds that are active have to be told from those that are not.
const TOLERANCE: f64 = 1e-10;

/// How Clarabel ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    Optimal,
    Infeasible,
    Failed,
}

/// What Clarabel found.
pub(crate) struct Solution {
    pub(crate) ending: Ending,
    pub(crate) unknowns: DVector<f64>,
    /// All inequalities with multiplier and slack.
    pub(crate) inequalities: Vec<(Constraint, f64, f64)>,
    pub(crate) iterations: usize,
}

/// Solves the problem with the rows `normal · h >= bound`.
pub(crate) fn solve(
    problem: &Problem,
    instance: &Instance,
    signs: bool,
    rows: &[Taken],
) -> Solution {
    // Hard targets are rows like soft ones, but without an error.
    let (targets, errors) = match &problem.equalities {
        Some(equalities) => (&equalities.rows, 0),
        None => (&problem.design, problem.design.nrows()),
    };
    let (observed, rank) = targets.shape();
    let unknowns = rank + errors;
    let quadratic = quadratic_term(&problem.precision, rank, errors);
    let mut linear = vec![0.0; unknowns];
    let pull = problem.precision.times(&instance.mean);
    for (q, pull) in linear.iter_mut().zip(pull.iter()) {
        *q = -pull;
    }

    let signed = if signs { rank } else { 0 };
    let roots: Vec<f64> = match errors {
        0 => vec![1.0; observed],
        _ => problem.weights.iter().map(|w| w.sqrt()).collect(),
    };
    let matrix = constraint_matrix(targets, &roots, signed, rows, errors);
    let right: Vec<f64> = instance
        .wanted
        .iter()
        .zip(&roots)
        .map(|(y, root)| y * root)
        .chain(std::iter::repeat_n(0.0, signed))
        .chain(rows.iter().map(|taken| -taken.bound))
        .collect();
    let cones = [ZeroConeT(observed), NonnegativeConeT(signed + rows.len())];

    let failed = |iterations| Solution {
        ending: Ending::Failed,
        unknowns: DVector::zeros(rank),
        inequalities: Vec::new(),
        iterations,
    };
    let Some(settings) = settings() else {
        return failed(0);
    };
    let Ok(mut solver) = DefaultSolver::new(&quadratic, &linear, &matrix, &right, &cones, settings)
    else {
        return failed(0);
    };
    solver.solve();
    let found = &solver.solution;
    let iterations = found.iterations as usize;
    let ending = match found.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved => Ending::Optimal,
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Ending::Infeasible,
        _ => Ending::Failed,
    };
    if found.x.iter().any(|v| !v.is_finite()) {
        return failed(iterations);
    }
    let names = (0..signed)
        .map(Constraint::Sign)
        .chain((0..rows.len()).map(Constraint::Row));
    Solution {
        ending,
        unknowns: DVector::from_column_slice(&found.x[..rank]),
        inequalities: names
            .zip(&found.z[observed..])
            .zip(&found.s[observed..])
            .map(|((name, &multiplier), &slack)| (name, multiplier, slack))
            .collect(),
        iterations,
    }
}

/// `A` of Clarabel's form `A x + s = b` with `s` in the cone: `s = 0` for the target rows, then `s >= 0`
/// for the signs and for `rows`. Its columns are the unknowns `h`, then the errors `r`.
fn constraint_matrix(
    targets: &DMatrix<f64>,
    roots: &[f64],
    signed: usize,
    rows: &[Taken],
    errors: usize,
) -> CscMatrix {
    let (observed, rank) = targets.shape();
    let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    let mut push = |row: usize, value: f64| {
        if value != 0.0 {
            indices.push(row);
            values.push(value);
        }
        indices.len()
    };
    for i in 0..rank {
        // Where nothing is pushed, the column is empty.
        let mut end = *starts.last().unwrap_or(&0);
        for (k, root) in roots.iter().enumerate() {
            end = push(k, targets[(k, i)] * root);
        }
        if signed > 0 {
            end = push(observed + i, -1.0);
        }
        for (j, taken) in rows.iter().enumerate() {
            end = push(observed + signed + j, -taken.normal[i]);
        }
        starts.push(end);
    }
    for k in 0..errors {
        starts.push(push(k, -1.0));
    }
    let constraints = observed + signed + rows.len();
    CscMatrix::new(constraints, rank + errors, starts, indices, values)
}

/// Upper triangle of `diag(Λ, 1)`.
fn quadratic_term(precision: &Precision, rank: usize, errors: usize) -> CscMatrix<f64> {
    let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    let mut at = 0;
    match precision {
        Precision::Ridge(ridge) => {
            for j in 0..rank {
                indices.push(j);
                values.push(*ridge);
                starts.push(indices.len());
            }
        }
        Precision::Blocks(blocks) => {
            for block in blocks {
                for j in 0..block.ncols() {
                    indices.extend(at..=at + j);
                    values.extend((0..=j).map(|i| block[(i, j)]));
                    starts.push(indices.len());
                }
                at += block.ncols();
            }
        }
    }
    for j in rank..rank + errors {
        indices.push(j);
        values.push(1.0);
        starts.push(indices.len());
    }
    CscMatrix::new(rank + errors, rank + errors, starts, indices, values)
}

pub(crate) fn settings() -> Option<DefaultSettings<f64>> {
    DefaultSettingsBuilder::default()
        .verbose(false)
        .max_threads(1)
        .tol_gap_abs(TOLERANCE)
        .tol_gap_rel(TOLERANCE)
        .tol_feas(TOLERANCE)
        .build()
        .ok()
}
