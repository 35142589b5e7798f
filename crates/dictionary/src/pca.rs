//! Principal components of training segments.

use inhand_model::{Demonstrated, Dictionary, DictionaryKind, Learning, StopReason};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::block::BLOCK_COLUMNS;
use crate::data::{Columns, check_rank, survey};
use crate::error::LearnError;
use crate::matrix_view::{View, chunk_width, multiply};
use crate::product::{add, gram, squared_norm, squared_residual};
use rayon::prelude::*;

/// Share of the largest variance below which a component is rounding, not motion: the components
/// come from squared numbers, so half of a double's digits are theirs.
const SMALLEST_VARIANCE: f64 = 1e-13;

/// Learns a dictionary of principal components from training segments.
///
/// Problem: with the segments as columns of `V` (rows x n, metres; 15 N rows, with the object 21 N),
/// minimise `|V - mean - W H|²` over orthonormal `W` (rows x rank); `offset_m` is the mean column. The
/// components are the leading eigenvectors of the smaller of `X Xᵀ` and `Xᵀ X` (`X = V - mean`),
/// largest variance first, each with its largest number positive. Activations have zero mean and a
/// diagonal covariance (denominator n), the variances of the components, which needs no shrinkage.
///
/// Cost: `rows * n * m` for the products and about `9 m³` for the eigenvectors, `m = min(rows, n)`;
/// memory for a block of columns and `m²` numbers. Columns are read four times.
///
/// # Errors
///
/// [`LearnError`] for no segments, rank 0, a rank above the number of components that the segments
/// have (at most one less than their number), a number that is not finite, a fingertip's coordinate
/// that never changes.
pub fn learn_pca(
    columns: &dyn Columns,
    demonstrated: Demonstrated,
    rank: usize,
) -> Result<Dictionary, LearnError> {
    survey(columns, false)?;
    let layout = columns.layout();
    let (rows, count) = (layout.rows(), columns.count());
    check_rank(rank, (count - 1).min(rows), count, rows, "pca")?;

    let centred = Centred::new(columns)?;
    let (values, vectors) = eigen_descending(centred.products()?);
    let smallest = SMALLEST_VARIANCE * values[0].max(0.0);
    let largest = values.partition_point(|value| *value > smallest);
    check_rank(rank, largest.min(count - 1), count, rows, "pca")?;
    let chosen = vectors.as_slice()[..rank * vectors.nrows()].to_vec();
    let mut components = centred.components(chosen)?;
    orthonormalise(&mut components, rows);
    point_up(&mut components, rows);

    // Activations and the error are measured, not read off the eigenvalues.
    let basis = transpose(&components, rows);
    let mut squares = vec![0.0; rank];
    let (mut residual, mut total) = (0.0, 0.0);
    centred.each_block(|block| {
        let activations = project(&basis, block, rows, rank);
        residual += squared_residual(block, rows, &basis, &activations, rank);
        total += squared_norm(block);
        for column in activations.chunks_exact(rank) {
            for (square, h) in squares.iter_mut().zip(column) {
                *square += h * h;
            }
        }
    })?;
    let variances = squares.into_iter().map(|square| square / count as f64);
    let covariance = DMatrix::from_diagonal(&DVector::from_iterator(rank, variances));
    Ok(Dictionary {
        kind: DictionaryKind::Pca,
        layout,
        offset_m: DVector::from_vec(centred.mean),
        primitives: DMatrix::from_vec(rows, rank, components),
        activation_mean_m: DVector::zeros(rank),
        activation_covariance_m2: covariance,
        covariance_shrinkage: 0.0,
        learning: Learning {
            segments: count,
            rms_m: (residual / (rows * count) as f64).sqrt(),
            relative_error: (residual / total).sqrt(),
            iterations: 0,
            stop_reason: StopReason::ClosedForm,
            objective_history_m2: vec![0.5 * residual],
            seed: 0,
            restarts: Vec::new(),
        },
        demonstrated,
        residual: None,
        residual_held_out: None,
        choice: None,
    })
}

/// Columns less their mean, read block by block.
pub(crate) struct Centred<'a> {
    columns: &'a dyn Columns,
    rows: usize,
    mean: Vec<f64>,
}

impl<'a> Centred<'a> {
    pub(crate) fn new(columns: &'a dyn Columns) -> Result<Self, LearnError> {
        let rows = columns.layout().rows();
        let mut centred = Self {
            columns,
            rows,
            mean: vec![0.0; rows],
        };
        let mut sum = vec![0.0; rows];
        centred.each_block(|block| {
            for column in block.chunks_exact(rows) {
                add(&mut sum, column);
            }
        })?;
        centred.mean = sum
            .into_iter()
            .map(|v| v / columns.count() as f64)
            .collect();
        Ok(centred)
    }

    /// Shows every block of columns, in order.
    pub(crate) fn each_block(&self, mut see: impl FnMut(&[f64])) -> Result<(), LearnError> {
        let count = self.columns.count();
        for first in (0..count).step_by(BLOCK_COLUMNS) {
            let last = (first + BLOCK_COLUMNS).min(count);
            let mut block = vec![0.0; (last - first) * self.rows];
            self.columns.read(first..last, &mut block)?;
            for column in block.chunks_exact_mut(self.rows) {
                for (v, mean) in column.iter_mut().zip(&self.mean) {
                    *v -= mean;
                }
            }
            see(&block);
        }
        Ok(())
    }

    /// Whether there are more rows than columns, so that `Xᵀ X` is the smaller matrix. Then everything
    /// is one block.
    fn is_tall(&self) -> bool {
        self.columns.count() <= self.rows.min(BLOCK_COLUMNS)
    }

    /// Sum of the squares of all numbers.
    pub(crate) fn squared_norm(&self) -> Result<f64, LearnError> {
        let mut sum = 0.0;
        self.each_block(|block| sum += squared_norm(block))?;
        Ok(sum)
    }

    /// The eigenvalues alone, none below zero, in no order.
    pub(crate) fn eigenvalues(&self) -> Result<Vec<f64>, LearnError> {
        let values = self.products()?.symmetric_eigenvalues();
        Ok(values.iter().map(|v| v.max(0.0)).collect())
    }

    /// The smaller of `Xᵀ X` and `X Xᵀ`.
    fn products(&self) -> Result<DMatrix<f64>, LearnError> {
        let size = if self.is_tall() {
            self.columns.count()
        } else {
            self.rows
        };
        let mut products = vec![0.0; size * size];
        self.each_block(|block| {
            if self.is_tall() {
                add(&mut products, &gram(&transpose(block, self.rows), size));
            } else {
                add(&mut products, &gram(block, size));
            }
        })?;
        Ok(DMatrix::from_vec(size, size, products))
    }

    /// Eigenvectors as directions in the space of segments (rows x rank), without scale.
    fn components(&self, vectors: Vec<f64>) -> Result<Vec<f64>, LearnError> {
        if !self.is_tall() {
            return Ok(vectors);
        }
        // Eigenvectors v of Xᵀ X: the components are X v.
        let count = self.columns.count();
        let mut components = vec![0.0; self.rows * vectors.len() / count];
        self.each_block(|block| {
            multiply(
                View::columns(block, self.rows),
                View::columns(&vectors, count),
                &mut components,
            );
        })?;
        Ok(components)
    }
}

/// All eigenvalues of a symmetric matrix, largest first, with their eigenvectors.
pub(crate) fn eigen_descending(symmetric: DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let eigen = SymmetricEigen::new(symmetric);
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let values = order.iter().map(|&i| eigen.eigenvalues[i]).collect();
    (values, eigen.eigenvectors.select_columns(&order))
}

/// Rows as columns.
pub(crate) fn transpose(columns: &[f64], rows: usize) -> Vec<f64> {
    let count = columns.len() / rows;
    (0..rows)
        .flat_map(|row| (0..count).map(move |column| columns[column * rows + row]))
        .collect()
}

/// Modified Gram-Schmidt, twice: orthonormal to rounding even for components of small variance.
fn orthonormalise(columns: &mut [f64], rows: usize) {
    for last in 0..columns.len() / rows {
        let (done, rest) = columns.split_at_mut(last * rows);
        let column = &mut rest[..rows];
        scale_to_unit(column);
        for _ in 0..2 {
            for other in done.chunks_exact(rows) {
                let along = crate::product::dot(other, column);
                for (v, other) in column.iter_mut().zip(other) {
                    *v -= along * other;
                }
            }
            scale_to_unit(column);
        }
    }
}

/// Scales a vector to unit length; a zero vector stays.
fn scale_to_unit(column: &mut [f64]) {
    let length = squared_norm(column).sqrt();
    if length > 0.0 {
        for v in column {
            *v /= length;
        }
    }
}

/// Chooses the sign that makes each column's largest number positive, so that it does not depend on
/// the eigenvalue solver.
pub(crate) fn point_up(columns: &mut [f64], rows: usize) {
    for column in columns.chunks_exact_mut(rows) {
        let largest = column
            .iter()
            .copied()
            .fold(0.0_f64, |a, b| if b.abs() > a.abs() { b } else { a });
        if largest < 0.0 {
            for v in column {
                *v = -*v;
            }
        }
    }
}

/// Activations (`rank` x count) of the centred columns.
fn project(basis: &[f64], centred: &[f64], rows: usize, rank: usize) -> Vec<f64> {
    let count = centred.len() / rows;
    let mut activations = vec![0.0; rank * count];
    let width = chunk_width(count);
    activations
        .par_chunks_mut(width * rank)
        .zip(centred.par_chunks(width * rows))
        .for_each(|(activations, columns)| {
            multiply(
                View::columns(basis, rank),
                View::columns(columns, rows),
                activations,
            );
        });
    activations
}
