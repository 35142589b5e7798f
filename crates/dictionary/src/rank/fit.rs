//! Activations of many segments at once, from some of their rows.

use inhand_model::{Dictionary, DictionaryKind};
use nalgebra::{Cholesky, DMatrix, DVector};

use crate::descent::{Gram, descend_all};
use crate::error::LearnError;
use crate::product::{View, gram, multiply, squared_norm};

/// Most sweeps of coordinate descent.
const MOST_SWEEPS: usize = 1000;
/// Sweeps between two checks for convergence.
const SWEEPS_PER_CHECK: usize = 20;
/// Coordinate descent stops when [`SWEEPS_PER_CHECK`] sweeps change the activations by less than
/// this share of their length: errors over many segments are settled to a thousandth by then.
const SMALLEST_CHANGE: f64 = 1e-5;
/// Added to the diagonal of the normal equations, relative to its mean: rows that are hidden can
/// leave a combination of primitives without any evidence.
const JITTER: f64 = 1e-12;

/// What is expected of the activations before a row is seen.
#[derive(Clone, Copy, Debug)]
pub(super) enum Prior {
    /// Nothing.
    None,
    /// Mean and covariance of the training activations, against rows that are off by the training
    /// error; this many neighbouring samples tell as much as one.
    Training { alike: f64 },
}

/// Activations (rank x segments, metres) that explain the given rows of the segments
/// (`columns_m`, rows x segments, metres) best:
///
/// ```text
/// min_h  1/2 |W_S h - (v_S - offset_S)|² + c s²/2 (h - mu)ᵀ Sigma⁻¹ (h - mu)
/// ```
///
/// over `h >= 0` for NMF and over all `h` for PCA; `S` are the rows, `s²` is the mean square of the
/// training error, `mu` and `Sigma` are the moments of the training activations and `c` is how many
/// samples are alike; without a prior the second term is absent.
pub(super) fn fitted(
    dictionary: &Dictionary,
    columns_m: &DMatrix<f64>,
    rows: &[usize],
    prior: Prior,
) -> Result<DMatrix<f64>, LearnError> {
    let rank = dictionary.rank();
    let too_extreme = || LearnError::NoActivations { rank };
    let basis = dictionary.primitives.select_rows(rows).transpose();
    let mut shifted = columns_m.select_rows(rows);
    let offset_m = dictionary.offset_m.select_rows(rows);
    for mut column in shifted.column_iter_mut() {
        column -= &offset_m;
    }
    let mut quadratic = DMatrix::from_vec(rank, rank, gram(basis.as_slice(), rank));
    let mut linear = DMatrix::zeros(rank, shifted.ncols());
    multiply(
        1.0,
        View::columns(basis.as_slice(), rank),
        View::columns(shifted.as_slice(), rows.len()),
        0.0,
        linear.as_mut_slice(),
        rank,
    );
    if let Prior::Training { alike } = prior {
        let covariance_m2 = dictionary.activation_covariance_m2.clone();
        let variance_m2 = alike * dictionary.learning.rms_m.powi(2);
        let precision = Cholesky::new(covariance_m2).ok_or_else(too_extreme)?;
        let weight = precision.inverse() * variance_m2;
        let pull: DVector<f64> = &weight * &dictionary.activation_mean_m;
        for mut column in linear.column_iter_mut() {
            column += &pull;
        }
        quadratic += weight;
    }
    let jitter = JITTER * quadratic.trace() / rank as f64;
    for j in 0..rank {
        quadratic[(j, j)] += jitter;
    }
    match dictionary.kind {
        DictionaryKind::Pca => {
            let factor = Cholesky::new(quadratic).ok_or_else(too_extreme)?;
            Ok(factor.solve(&linear))
        }
        DictionaryKind::Nmf => Ok(non_negative(
            &quadratic,
            &linear,
            &dictionary.activation_mean_m,
        )),
    }
}

/// Minimises `1/2 hᵀ Q h - pᵀ h` over `h >= 0` for each column of `linear`, from one start.
fn non_negative(
    quadratic: &DMatrix<f64>,
    linear: &DMatrix<f64>,
    start: &DVector<f64>,
) -> DMatrix<f64> {
    let gram = Gram::new(quadratic.as_slice(), quadratic.ncols());
    let mut h = DMatrix::from_fn(linear.nrows(), linear.ncols(), |j, _| start[j].max(0.0));
    let mut previous = h.clone();
    for _ in 0..MOST_SWEEPS / SWEEPS_PER_CHECK {
        descend_all(&gram, linear.as_slice(), h.as_mut_slice(), SWEEPS_PER_CHECK);
        previous -= &h;
        let change = squared_norm(previous.as_slice());
        if change <= SMALLEST_CHANGE * SMALLEST_CHANGE * squared_norm(h.as_slice()) {
            break;
        }
        previous.copy_from(&h);
    }
    h
}

/// Sum of the squared errors over some rows of each segment, m².
pub(super) fn squared_errors_m2(
    dictionary: &Dictionary,
    activations_m: &DMatrix<f64>,
    columns_m: &DMatrix<f64>,
    rows: &[usize],
) -> Vec<f64> {
    let primitives = dictionary.primitives.select_rows(rows);
    let offset_m = dictionary.offset_m.select_rows(rows);
    let mut errors_m = columns_m.select_rows(rows);
    multiply(
        -1.0,
        View::columns(primitives.as_slice(), rows.len()),
        View::columns(activations_m.as_slice(), dictionary.rank()),
        1.0,
        errors_m.as_mut_slice(),
        rows.len(),
    );
    (errors_m.column_iter_mut())
        .map(|mut column| {
            column -= &offset_m;
            column.norm_squared()
        })
        .collect()
}
