//! Activations of a segment for a given dictionary.

use inhand_model::{Dictionary, DictionaryKind};
use nalgebra::DVector;

use crate::descent::{Gram, descend_until};
use crate::error::LearnError;
use crate::product::{dot, gram};

/// Most checks for convergence of coordinate descent, and sweeps between two. Smooth primitives are nearly
/// dependent, and far before the last one the reconstruction no longer changes by a micrometre.
const CHECKS_AND_SWEEPS: (usize, usize) = (200, 10);

/// Coordinate descent stops when ten sweeps change the activations by less than this share of their
/// length.
const SMALLEST_CHANGE: f64 = 1e-9;

/// Activations (`rank`, metres) with which a dictionary comes nearest to a segment (15 N numbers,
/// with the object 21 N, metres, in the order of [`SegmentLayout`](inhand_model::SegmentLayout)):
/// non-negative least squares by coordinate descent for NMF, the product with the transposed primitives
/// for PCA.
///
/// # Errors
///
/// [`LearnError::Data`] for a segment of another size, or with a number that is not finite.
pub fn activations(dictionary: &Dictionary, column_m: &[f64]) -> Result<DVector<f64>, LearnError> {
    let (rows, rank) = dictionary.primitives.shape();
    if column_m.len() != rows {
        return Err(LearnError::column_length(rows, column_m.len()));
    }
    if let Some(row) = column_m.iter().position(|v| !v.is_finite()) {
        return Err(LearnError::Data(format!(
            "number {row} of the segment is {}: expected a finite number of metres",
            column_m[row]
        )));
    }
    let shifted: Vec<f64> = (column_m.iter().zip(&dictionary.offset_m))
        .map(|(v, offset)| v - offset)
        .collect();
    let linear: Vec<f64> = (dictionary.primitives.as_slice())
        .chunks_exact(rows.max(1))
        .map(|primitive| dot(primitive, &shifted))
        .collect();
    if dictionary.kind == DictionaryKind::Pca {
        return Ok(DVector::from_vec(linear));
    }
    let rows_of = dictionary.primitives.transpose();
    let gram = Gram::new(&gram(rows_of.as_slice(), rank), rank, 0.0);
    // From the mean of the training activations.
    let mut h = dictionary.activation_mean_m.map(|h| h.max(0.0));
    let h_numbers = h.as_mut_slice();
    descend_until(
        &gram,
        &linear,
        h_numbers,
        CHECKS_AND_SWEEPS,
        SMALLEST_CHANGE,
    );
    Ok(h)
}
