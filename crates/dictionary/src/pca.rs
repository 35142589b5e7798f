//! Principal components of training segments.

use inhand_model::{Demonstrated, Dictionary, DictionaryKind, Learning, Segments, StopReason};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::data::{check_rank, checked_range};
use crate::error::LearnError;
use crate::product::{View, add, chunk_width, gram, multiply, squared_norm, squared_residual};
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
/// Cost: `rows * n * m` for the products and about `9 m³` for the eigenvectors, `m = min(rows, n)`.
///
/// # Errors
///
/// [`LearnError`] for no segments, rank 0, a rank above the number of components that the segments
/// have (at most one less than their number), a number that is not finite, a fingertip's coordinate
/// that never changes.
pub fn learn_pca(
    segments: &Segments,
    demonstrated: Demonstrated,
    rank: usize,
) -> Result<Dictionary, LearnError> {
    checked_range(segments)?;
    let layout = segments.layout();
    let (rows, count) = (layout.rows(), segments.len());
    check_rank(rank, (count - 1).min(rows), count, rows, "pca")?;

    let (mean, centred) = centre(segments.columns_m().as_slice(), rows);
    let eigen = if count <= rows {
        let transposed = transpose(&centred, rows);
        SymmetricEigen::new(DMatrix::from_vec(count, count, gram(&transposed, count)))
    } else {
        SymmetricEigen::new(DMatrix::from_vec(rows, rows, gram(&centred, rows)))
    };
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let largest = order
        .iter()
        .take_while(|i| {
            eigen.eigenvalues[**i] > SMALLEST_VARIANCE * eigen.eigenvalues[order[0]].max(0.0)
        })
        .count();
    check_rank(rank, largest.min(count - 1), count, rows, "pca")?;
    order.truncate(rank);

    let mut components = components(&eigen.eigenvectors, &order, &centred, rows, count);
    orthonormalise(&mut components, rows);
    point_up(&mut components, rows);

    // Activations and the error are measured, not read off the eigenvalues.
    let basis = transpose(&components, rows);
    let activations = project(&basis, &centred, rows, rank);
    let residual = squared_residual(&centred, rows, &basis, &activations, rank);
    let total = squared_norm(&centred);
    let variances = (0..rank).map(|j| {
        let sum: f64 = activations
            .iter()
            .skip(j)
            .step_by(rank)
            .map(|h| h * h)
            .sum();
        sum / count as f64
    });
    let covariance = DMatrix::from_diagonal(&DVector::from_iterator(rank, variances));
    Ok(Dictionary {
        kind: DictionaryKind::Pca,
        layout,
        offset_m: DVector::from_vec(mean),
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
        choice: None,
    })
}

/// Mean column, and the columns without it.
fn centre(columns: &[f64], rows: usize) -> (Vec<f64>, Vec<f64>) {
    let count = columns.len() / rows;
    let mut mean = vec![0.0; rows];
    for column in columns.chunks_exact(rows) {
        add(&mut mean, column);
    }
    for v in &mut mean {
        *v /= count as f64;
    }
    let mut centred = columns.to_vec();
    for column in centred.chunks_exact_mut(rows) {
        for (v, mean) in column.iter_mut().zip(&mean) {
            *v -= mean;
        }
    }
    (mean, centred)
}

/// Rows as columns.
pub(crate) fn transpose(columns: &[f64], rows: usize) -> Vec<f64> {
    let count = columns.len() / rows;
    (0..rows)
        .flat_map(|row| (0..count).map(move |column| columns[column * rows + row]))
        .collect()
}

/// The chosen eigenvectors as directions in the space of segments (rows x rank), without scale.
fn components(
    vectors: &DMatrix<f64>,
    order: &[usize],
    centred: &[f64],
    rows: usize,
    count: usize,
) -> Vec<f64> {
    let chosen: Vec<f64> = order
        .iter()
        .flat_map(|i| vectors.column(*i).iter().copied().collect::<Vec<_>>())
        .collect();
    if vectors.nrows() == rows && count > rows {
        return chosen;
    }
    // Eigenvectors v of Xᵀ X: the components are X v.
    let mut components = vec![0.0; rows * order.len()];
    multiply(
        1.0,
        View::columns(centred, rows),
        View::columns(&chosen, count),
        0.0,
        &mut components,
        rows,
    );
    components
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
fn point_up(columns: &mut [f64], rows: usize) {
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
                1.0,
                View::columns(basis, rank),
                View::columns(columns, rows),
                0.0,
                activations,
                rank,
            );
        });
    activations
}
