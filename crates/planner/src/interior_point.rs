//! The same problem by Clarabel's interior-point method.
//!
//! Unknowns are the activations `h` and the scaled target errors `r = W_S h - y` over sigma:
//!
//! ```text
//! minimise  1/2 hᵀ Λ h - (Λ mu)ᵀ h + 1/2 |r|²
//! s.t.      W_S h / sigma - r = y / sigma,   h >= 0,   n_j · h >= b_j
//! ```
//!
//! so that the quadratic term stays as sparse as the precision is: diagonal for `paper` (2 to 3 ms
//! with 200 primitives), dense for a full covariance (about 20 ms).

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT,
    SolverStatus, ZeroConeT,
};
use nalgebra::DVector;

use crate::active_set::Constraint;
use crate::objective::{Objective, Precision};

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
    pub(crate) activations_mm: DVector<f64>,
    /// All inequalities with multiplier and slack.
    pub(crate) inequalities: Vec<(Constraint, f64, f64)>,
    pub(crate) iterations: usize,
}

/// Solves the problem with the rows `normal · h >= bound`.
pub(crate) fn solve(
    objective: &Objective,
    wanted_mm: &DVector<f64>,
    mean_mm: &DVector<f64>,
    signs: bool,
    rows: &[(DVector<f64>, f64)],
) -> Solution {
    let (observed, rank) = objective.design.shape();
    let unknowns = rank + observed;
    let quadratic = quadratic_term(&objective.precision, rank, observed);
    let mut linear = vec![0.0; unknowns];
    let pull = objective.precision.times(mean_mm);
    for (q, pull) in linear.iter_mut().zip(pull.iter()) {
        *q = -pull;
    }

    // Clarabel's form is A x + s = b with s in the cone: s = 0 for the target rows, s >= 0 below.
    let signed = if signs { rank } else { 0 };
    let constraints = observed + signed + rows.len();
    let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    let mut push = |row: usize, value: f64| {
        if value != 0.0 {
            indices.push(row);
            values.push(value);
        }
        indices.len()
    };
    let roots: Vec<f64> = objective.weights.iter().map(|w| w.sqrt()).collect();
    for i in 0..rank {
        let mut end = 0;
        for (k, root) in roots.iter().enumerate() {
            end = push(k, objective.design[(k, i)] * root);
        }
        if signs {
            end = push(observed + i, -1.0);
        }
        for (j, (normal, _)) in rows.iter().enumerate() {
            end = push(observed + signed + j, -normal[i]);
        }
        starts.push(end);
    }
    for k in 0..observed {
        starts.push(push(k, -1.0));
    }
    let matrix = CscMatrix::new(constraints, unknowns, starts, indices, values);
    let right: Vec<f64> = wanted_mm
        .iter()
        .zip(&roots)
        .map(|(y, root)| y * root)
        .chain(std::iter::repeat_n(0.0, signed))
        .chain(rows.iter().map(|(_, bound)| -bound))
        .collect();
    let cones = [ZeroConeT(observed), NonnegativeConeT(signed + rows.len())];

    let failed = |iterations| Solution {
        ending: Ending::Failed,
        activations_mm: DVector::zeros(rank),
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
        activations_mm: DVector::from_column_slice(&found.x[..rank]),
        inequalities: names
            .zip(&found.z[observed..])
            .zip(&found.s[observed..])
            .map(|((name, &multiplier), &slack)| (name, multiplier, slack))
            .collect(),
        iterations,
    }
}

/// Upper triangle of `diag(Λ, 1)`.
fn quadratic_term(precision: &Precision, rank: usize, observed: usize) -> CscMatrix<f64> {
    let unknowns = rank + observed;
    let (mut starts, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..unknowns {
        match precision {
            Precision::Full(matrix) if j < rank => {
                indices.extend(0..=j);
                values.extend((0..=j).map(|i| matrix[(i, j)]));
            }
            Precision::Ridge(ridge) if j < rank => {
                indices.push(j);
                values.push(*ridge);
            }
            _ => {
                indices.push(j);
                values.push(1.0);
            }
        }
        starts.push(indices.len());
    }
    CscMatrix::new(unknowns, unknowns, starts, indices, values)
}

fn settings() -> Option<DefaultSettings<f64>> {
    DefaultSettingsBuilder::default()
        .verbose(false)
        .max_threads(1)
        .tol_gap_abs(TOLERANCE)
        .tol_gap_rel(TOLERANCE)
        .tol_feas(TOLERANCE)
        .build()
        .ok()
}
