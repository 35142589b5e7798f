//! The least relaxation as one program for Clarabel: slower, for where the active set has no answer.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT};
use inhand_model::ConstraintFamily;
use nalgebra::DVector;

use super::family_of;
use crate::interior_point;
use crate::model::MM_PER_M;
use crate::precision::Precision;
use crate::solve::{Taken, Task};

/// Weight of the distance from the expected unknowns (over their largest precision), which keeps
/// the others where they are; small enough not to cost any of the relaxation (a linear program
/// plus a small enough quadratic term has a solution of the linear program as its own).
const ANCHOR: f64 = 1e-8;

/// Unknowns and the least relaxation (mm of rows that move by `unit_mm` for one unit) under the
/// given rows.
pub(super) fn elastic(
    task: &Task<'_>,
    rows: &[Taken],
    families: &[ConstraintFamily],
    unit_mm: f64,
) -> Option<(DVector<f64>, f64)> {
    let n = task.model.unknowns();
    let relaxed = |family| families.contains(&family);
    let mut matrix = Rows::default();

    // Clarabel's form is A x + s = b: first the equations, s = 0.
    let mut moved: Vec<(&DVector<f64>, f64, f64)> = Vec::new();
    let mut equations: Vec<(DVector<f64>, f64, ConstraintFamily)> = Vec::new();
    if let Some(equalities) = &task.problem.equalities {
        for (k, row) in equalities.rows.row_iter().enumerate() {
            let family = family_of(task.problem.given[k / 3]);
            equations.push((row.transpose(), task.instance.wanted[k], family));
        }
    }
    for (row, right, family) in &equations {
        if relaxed(*family) {
            moved.push((row, *right, MM_PER_M / unit_mm));
        } else {
            matrix.push(row, 1.0, None, *right);
        }
    }
    let hard = matrix.right.len();
    // Then the inequalities, s >= 0.
    for (row, right, yielding) in moved {
        matrix.push(row, 1.0, Some((n, -yielding)), right);
        matrix.push(row, -1.0, Some((n, -yielding)), -right);
    }
    for taken in rows {
        let yielding = taken.row.yielding / unit_mm;
        let slack = relaxed(taken.row.family).then_some((n, -yielding));
        matrix.push(&taken.normal, -1.0, slack, -taken.bound);
    }
    matrix.push(&DVector::zeros(0), 1.0, Some((n, -1.0)), 0.0);
    if task.model.signs {
        for i in 0..n {
            matrix.push(&DVector::zeros(0), 1.0, Some((i, -1.0)), 0.0);
        }
    }

    let constraints = matrix.right.len();
    let (quadratic, mut linear) = anchor(task);
    linear.push(1.0);
    let a =
        CscMatrix::new_from_triplets(constraints, n + 1, matrix.row, matrix.column, matrix.value);
    let cones = [ZeroConeT(hard), NonnegativeConeT(constraints - hard)];
    let settings = interior_point::settings()?;
    let mut solver =
        DefaultSolver::new(&quadratic, &linear, &a, &matrix.right, &cones, settings).ok()?;
    solver.solve();
    let found = &solver.solution;
    let solved = matches!(
        found.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved
    );
    (solved && found.x.iter().all(|v| v.is_finite()))
        .then(|| (DVector::from_column_slice(&found.x[..n]), found.x[n]))
}

/// The small pull towards the expected unknowns: upper triangle of its second derivative, with an
/// empty column for the relaxation, and its gradient at zero.
fn anchor(task: &Task<'_>) -> (CscMatrix<f64>, Vec<f64>) {
    let n = task.model.unknowns();
    let precision = &task.problem.precision;
    let largest = match precision {
        Precision::Ridge(ridge) => *ridge,
        Precision::Blocks(blocks) => (blocks.iter())
            .flat_map(|block| block.diagonal().data.as_vec().clone())
            .fold(f64::MIN_POSITIVE, f64::max),
    };
    let weight = ANCHOR / largest;
    let (mut row, mut column, mut value) = (Vec::new(), Vec::new(), Vec::new());
    let mut push = |i, j, v| {
        row.push(i);
        column.push(j);
        value.push(weight * v);
    };
    match precision {
        Precision::Ridge(ridge) => (0..n).for_each(|i| push(i, i, *ridge)),
        Precision::Blocks(blocks) => {
            let mut at = 0;
            for block in blocks {
                for j in 0..block.ncols() {
                    (0..=j).for_each(|i| push(at + i, at + j, block[(i, j)]));
                }
                at += block.ncols();
            }
        }
    }
    let quadratic = CscMatrix::new_from_triplets(n + 1, n + 1, row, column, value);
    let pull = precision.times(&task.instance.mean) * -weight;
    (quadratic, pull.data.into())
}

/// Rows of a sparse matrix with their right sides.
#[derive(Default)]
struct Rows {
    row: Vec<usize>,
    column: Vec<usize>,
    value: Vec<f64>,
    right: Vec<f64>,
}

impl Rows {
    /// `factor * row` and one more entry.
    fn push(&mut self, row: &DVector<f64>, factor: f64, entry: Option<(usize, f64)>, right: f64) {
        let at = self.right.len();
        let entries = row.iter().map(|v| factor * v).enumerate();
        for (column, value) in entries.filter(|(_, v)| *v != 0.0).chain(entry) {
            self.row.push(at);
            self.column.push(column);
            self.value.push(value);
        }
        self.right.push(right);
    }
}
