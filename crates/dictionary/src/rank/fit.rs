//! Activations of many segments at once, from some of their rows.

use inhand_model::{Dictionary, DictionaryKind};
use nalgebra::{Cholesky, DMatrix, DVector};

use crate::descent::{Gram, descend_until};
use crate::error::LearnError;
use crate::matrix_view::{View, multiply, subtract_product};
use crate::product::gram;

/// Most checks for convergence of coordinate descent, and sweeps between two.
const CHECKS_AND_SWEEPS: (usize, usize) = (50, 20);
/// Coordinate descent stops when the sweeps between two checks change the activations by less than
/// this share of their length: errors over many segments are settled to a thousandth by then.
const SMALLEST_CHANGE: f64 = 1e-5;
/// Added to the diagonal of the normal equations, relative to its mean: rows that are hidden can
/// leave a combination of primitives without any evidence.
const JITTER: f64 = 1e-12;

/// Activations (rank x segments, metres) that explain the given rows of the segments
/// (`columns_m`, rows x segments, metres) best:
///
/// ```text
/// min_h  1/2 |W_S h - (v_S - offset_S)|² + c s²/2 (h - mu)ᵀ Sigma⁻¹ (h - mu)
/// ```
///
/// over `h >= 0` for NMF and over all `h` for PCA; `S` are the rows, `s²` is the mean square of the
/// training error, `mu` and `Sigma` are the moments of the training activations and `c` is how many
/// samples are alike; without it the second term, the prior, is absent.
pub(super) fn fitted(
    dictionary: &Dictionary,
    columns_m: &DMatrix<f64>,
    rows: &[usize],
    alike: Option<f64>,
) -> Result<DMatrix<f64>, LearnError> {
    let rank = dictionary.rank();
    let too_extreme = || {
        LearnError::Data(format!(
            "the least squares for the activations of {rank} primitives cannot be solved: expected \
             segments of about a metre, found numbers too large or too small to square"
        ))
    };
    let basis = dictionary.primitives.select_rows(rows).transpose();
    let mut shifted = columns_m.select_rows(rows);
    let offset_m = dictionary.offset_m.select_rows(rows);
    for mut column in shifted.column_iter_mut() {
        column -= &offset_m;
    }
    let mut quadratic = DMatrix::from_vec(rank, rank, gram(basis.as_slice(), rank));
    let mut linear = DMatrix::zeros(rank, shifted.ncols());
    multiply(
        View::columns(basis.as_slice(), rank),
        View::columns(shifted.as_slice(), rows.len()),
        linear.as_mut_slice(),
    );
    if let Some(alike) = alike {
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
        DictionaryKind::Nmf => {
            let gram = Gram::new(quadratic.as_slice(), rank, 0.0);
            let start = dictionary.activation_mean_m.map(|h| h.max(0.0));
            let mut h = DMatrix::from_fn(rank, linear.ncols(), |j, _| start[j]);
            let (linear, h_numbers) = (linear.as_slice(), h.as_mut_slice());
            descend_until(&gram, linear, h_numbers, CHECKS_AND_SWEEPS, SMALLEST_CHANGE);
            Ok(h)
        }
    }
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
    subtract_product(
        View::columns(primitives.as_slice(), rows.len()),
        View::columns(activations_m.as_slice(), dictionary.rank()),
        errors_m.as_mut_slice(),
    );
    (errors_m.column_iter_mut())
        .map(|mut column| {
            column -= &offset_m;
            column.norm_squared()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use inhand_model::{Demonstrated, Learning, SegmentLayout, StopReason};

    use super::*;

    const VISIBLE: [usize; 9] = [0, 1, 2, 3, 4, 10, 11, 13, 14];
    const ALIKE: f64 = 3.0;

    /// Four primitives over the 15 rows of one sample.
    fn dictionary(kind: DictionaryKind) -> Dictionary {
        let wave = |row: usize, j: usize| (0.3 + 0.9 * row as f64 * (j + 1) as f64).sin();
        let free = DMatrix::from_fn(15, 4, wave);
        let primitives = match kind {
            DictionaryKind::Pca => free.qr().q(),
            DictionaryKind::Nmf => free.abs(),
        };
        let half = DMatrix::from_fn(4, 4, |i, j| 0.01 * (1.0 + (i * 3 + j) as f64).cos());
        Dictionary {
            kind,
            layout: SegmentLayout {
                samples: 1,
                rate_hz: 100.0,
                object: false,
            },
            offset_m: DVector::from_fn(15, |row, _| 0.001 * row as f64),
            primitives,
            activation_mean_m: DVector::from_vec(vec![0.02, 0.01, 0.03, 0.015]),
            activation_covariance_m2: &half * half.transpose() + DMatrix::identity(4, 4) * 1e-6,
            covariance_shrinkage: 0.0,
            learning: Learning {
                segments: 10,
                rms_m: 0.002,
                relative_error: 0.1,
                iterations: 0,
                stop_reason: StopReason::ClosedForm,
                objective_history_m2: Vec::new(),
                seed: 0,
                restarts: Vec::new(),
            },
            demonstrated: Demonstrated::default(),
            residual: None,
            residual_held_out: None,
            choice: None,
        }
    }

    fn columns() -> DMatrix<f64> {
        DMatrix::from_fn(15, 3, |row, i| 0.03 * (row as f64 * 0.7 + i as f64).sin())
    }

    #[test]
    fn with_a_prior_components_have_their_conditional_mean() {
        let d = dictionary(DictionaryKind::Pca);
        let found = fitted(&d, &columns(), &VISIBLE, Some(ALIKE)).unwrap();
        // The same from the other side, by the covariance of the visible rows.
        let w = d.primitives.select_rows(&VISIBLE);
        let (mean, covariance) = (&d.activation_mean_m, &d.activation_covariance_m2);
        let noise = DMatrix::identity(9, 9) * (ALIKE * d.learning.rms_m.powi(2));
        let gain = covariance * w.transpose();
        let inverse = (&w * &gain + noise).try_inverse().unwrap();
        for (i, column) in columns().column_iter().enumerate() {
            let seen = (column - &d.offset_m).select_rows(&VISIBLE) - &w * mean;
            let expected = mean + &gain * &inverse * seen;
            assert!((found.column(i) - expected).amax() < 1e-9);
        }
    }

    #[test]
    fn non_negative_activations_are_optimal() {
        let d = dictionary(DictionaryKind::Nmf);
        let w = d.primitives.select_rows(&VISIBLE);
        for alike in [None, Some(ALIKE)] {
            let found = fitted(&d, &columns(), &VISIBLE, alike).unwrap();
            let mut at_bound = 0;
            for (i, column) in columns().column_iter().enumerate() {
                let h = found.column(i);
                let seen = (column - &d.offset_m).select_rows(&VISIBLE);
                let mut gradient = w.transpose() * (&w * h - seen);
                if let Some(alike) = alike {
                    let inverse = d.activation_covariance_m2.clone().try_inverse().unwrap();
                    let variance_m2 = alike * d.learning.rms_m.powi(2);
                    gradient += inverse * (h - &d.activation_mean_m) * variance_m2;
                }
                for (h, gradient) in h.iter().zip(&gradient) {
                    assert!(*h >= 0.0 && *gradient > -1e-7, "{h} {gradient}");
                    assert!(*h == 0.0 || gradient.abs() < 1e-7, "{h} {gradient}");
                    at_bound += usize::from(*h == 0.0);
                }
            }
            assert!(at_bound > 0, "a bound is active");
        }
    }

    #[test]
    fn errors_are_those_of_the_rows_asked_for() {
        let d = dictionary(DictionaryKind::Nmf);
        let h = DMatrix::from_fn(4, 3, |j, i| 0.01 * (1 + i + j) as f64);
        let hidden = [5, 6, 12];
        let found = squared_errors_m2(&d, &h, &columns(), &hidden);
        for (i, found) in found.iter().enumerate() {
            let all = columns().column(i) - &d.offset_m - &d.primitives * h.column(i);
            let expected: f64 = hidden.iter().map(|&row| all[row].powi(2)).sum();
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
    }
}
