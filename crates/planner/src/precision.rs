//! Precision of the prior on the unknowns.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::MM_PER_M;
use crate::error::PlanError;

/// Precision `Λ`: the strength with which unknowns are drawn to their mean.
#[derive(Clone, Debug)]
pub(crate) enum Precision {
    /// The same for every unknown, on its own.
    Ridge(f64),
    /// Inverses of covariances along the diagonal, each with the row where it starts.
    Blocks(Vec<(usize, DMatrix<f64>)>),
}

impl Precision {
    /// `Λ v`.
    pub(crate) fn times(&self, v: &DVector<f64>) -> DVector<f64> {
        match self {
            Precision::Ridge(ridge) => v * *ridge,
            Precision::Blocks(blocks) => {
                let mut product = DVector::zeros(v.len());
                for (at, block) in blocks {
                    let n = block.nrows();
                    let mut part = product.rows_mut(*at, n);
                    part.gemv(1.0, block, &v.rows(*at, n), 0.0);
                }
                product
            }
        }
    }

    /// Entries of the upper triangle of `Λ`: row, column, value.
    pub(crate) fn upper(&self, unknowns: usize) -> Vec<(usize, usize, f64)> {
        let mut entries = Vec::new();
        match self {
            Precision::Ridge(ridge) => entries.extend((0..unknowns).map(|i| (i, i, *ridge))),
            Precision::Blocks(blocks) => {
                for (at, block) in blocks {
                    for j in 0..block.ncols() {
                        entries.extend((0..=j).map(|i| (at + i, at + j, block[(i, j)])));
                    }
                }
            }
        }
        entries
    }

    /// Adds `Λ` to a matrix (n x n).
    pub(crate) fn add_to(&self, matrix: &mut DMatrix<f64>) {
        match self {
            Precision::Ridge(ridge) => {
                for i in 0..matrix.nrows() {
                    matrix[(i, i)] += ridge;
                }
            }
            Precision::Blocks(blocks) => {
                for (at, block) in blocks {
                    let mut place = matrix.view_mut((*at, *at), block.shape());
                    place += block;
                }
            }
        }
    }
}

/// Inverse of a covariance, 1/mm².
pub(crate) fn inverse_of_covariance(
    what: &str,
    covariance_m2: &DMatrix<f64>,
) -> Result<DMatrix<f64>, PlanError> {
    let covariance_mm2 = covariance_m2 * (MM_PER_M * MM_PER_M);
    inverse(covariance_mm2.clone()).ok_or_else(|| {
        let smallest_mm2 = covariance_mm2.symmetric_eigenvalues().min();
        PlanError::Model(format!(
            "the covariance of the {} {what} is not positive definite (smallest eigenvalue {:e} m²): \
             learn with shrinkage, fewer primitives or more segments",
            covariance_m2.nrows(),
            smallest_mm2 / (MM_PER_M * MM_PER_M)
        ))
    })
}

/// Inverse of a symmetric positive definite matrix, exactly symmetric; `None` where it is not
/// positive definite.
pub(crate) fn inverse(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut inverse = Cholesky::<f64, Dyn>::new(matrix)?.inverse();
    make_symmetric(&mut inverse);
    inverse.iter().all(|v| v.is_finite()).then_some(inverse)
}

/// Takes the mean of entries across the diagonal, which differ by rounding.
pub(crate) fn make_symmetric(matrix: &mut DMatrix<f64>) {
    for j in 0..matrix.ncols() {
        for i in 0..j {
            let mean = 0.5 * (matrix[(i, j)] + matrix[(j, i)]);
            (matrix[(i, j)], matrix[(j, i)]) = (mean, mean);
        }
    }
}
