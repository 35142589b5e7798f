//! Activations of a segment for a given dictionary.

use inhand_model::{Dictionary, DictionaryKind};
use nalgebra::DVector;

use crate::descent::{Gram, descend};
use crate::error::LearnError;
use crate::product::{dot, gram, squared_norm};

/// Most sweeps of coordinate descent. Smooth primitives are nearly dependent, and far before this
/// the reconstruction no longer changes by a micrometre.
const MOST_SWEEPS: usize = 2000;

/// Sweeps between two checks for convergence.
const SWEEPS_PER_CHECK: usize = 10;

/// Coordinate descent stops when ten sweeps change the activations by less than this share of their
/// length.
const SMALLEST_CHANGE: f64 = 1e-9;

/// Projects segments onto one dictionary; what depends on the dictionary alone is computed once.
#[derive(Clone, Debug)]
pub struct Projection<'a> {
    dictionary: &'a Dictionary,
    /// Gram matrix of non-negative primitives; orthonormal ones need none.
    gram: Option<Gram<f64>>,
}

impl<'a> Projection<'a> {
    /// Prepares to project onto `dictionary`.
    pub fn new(dictionary: &'a Dictionary) -> Self {
        let gram = (dictionary.kind == DictionaryKind::Nmf).then(|| {
            let rows_of = dictionary.primitives.transpose();
            let rank = dictionary.rank();
            Gram::new(&gram(rows_of.as_slice(), rank), rank, 0.0)
        });
        Self { dictionary, gram }
    }

    /// Activations of one segment (15 N numbers, with the object 21 N, metres), metres.
    ///
    /// # Errors
    ///
    /// As [`activations`].
    pub fn activations(&self, column_m: &[f64]) -> Result<DVector<f64>, LearnError> {
        let dictionary = self.dictionary;
        let rows = dictionary.primitives.nrows();
        if column_m.len() != rows {
            return Err(LearnError::ColumnLength {
                expected: rows,
                found: column_m.len(),
            });
        }
        if let Some(row) = column_m.iter().position(|v| !v.is_finite()) {
            return Err(LearnError::ColumnNotFinite {
                row,
                found: column_m[row],
            });
        }
        let shifted: Vec<f64> = column_m
            .iter()
            .zip(&dictionary.offset_m)
            .map(|(v, offset)| v - offset)
            .collect();
        let linear: Vec<f64> = dictionary
            .primitives
            .as_slice()
            .chunks_exact(rows.max(1))
            .map(|primitive| dot(primitive, &shifted))
            .collect();
        Ok(DVector::from_vec(match &self.gram {
            None => linear,
            Some(gram) => self.non_negative(gram, &linear),
        }))
    }

    /// Minimises `1/2 hᵀ G h - pᵀ h` over `h >= 0`, starting from the mean of the training
    /// activations.
    fn non_negative(&self, gram: &Gram<f64>, linear: &[f64]) -> Vec<f64> {
        let mut h: Vec<f64> = self
            .dictionary
            .activation_mean_m
            .iter()
            .map(|h| h.max(0.0))
            .collect();
        let mut previous = h.clone();
        for _ in 0..MOST_SWEEPS / SWEEPS_PER_CHECK {
            descend(gram, linear, 0.0, &mut h, SWEEPS_PER_CHECK);
            let change: Vec<f64> = h.iter().zip(&previous).map(|(a, b)| a - b).collect();
            if squared_norm(&change) <= SMALLEST_CHANGE * SMALLEST_CHANGE * squared_norm(&h) {
                break;
            }
            previous.copy_from_slice(&h);
        }
        h
    }
}

/// Activations (`rank`, metres) with which a dictionary comes nearest to a segment (15 N numbers,
/// with the object 21 N, metres, in the order of [`SegmentLayout`](inhand_model::SegmentLayout)): non-negative least squares by coordinate descent for NMF, the product with
/// the transposed primitives for PCA.
///
/// For many segments, a [`Projection`] saves the repeated preparation.
///
/// # Errors
///
/// [`LearnError::ColumnLength`] for a segment of another size, [`LearnError::ColumnNotFinite`] for
/// one with a number that is not finite.
pub fn activations(dictionary: &Dictionary, column_m: &[f64]) -> Result<DVector<f64>, LearnError> {
    Projection::new(dictionary).activations(column_m)
}
