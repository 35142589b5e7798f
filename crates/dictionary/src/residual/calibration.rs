//! Calibration of the width of prediction regions.

use inhand_model::Calibration;
use nalgebra::{DMatrix, Matrix3, Vector3};

use super::primitives::Primitives;

/// Shares for which a width is measured.
const SHARES: [f64; 2] = [0.5, 0.95];
/// Mahalanobis distances that hold these shares of a normal distribution in three dimensions
/// (square roots of the chi-squared quantiles 2.366 and 7.815), used where nothing could be left
/// out.
const NORMAL: [f64; 2] = [1.538_172_254_455_285_2, 2.795_483_482_915_107];

/// Covariance of each fingertip at each sample (ordered finger, sample), m².
pub(super) fn covariances_m2(
    primitives: &Primitives,
    covariance_m2: &DMatrix<f64>,
    unexplained_m2: f64,
) -> Vec<Matrix3<f64>> {
    let mut covariances = Vec::new();
    for (first, block) in primitives.finger_blocks() {
        // A fingertip moves by its own primitives alone.
        let size = block.ncols();
        let spread = block * covariance_m2.view((first, first), (size, size));
        for t in 0..block.nrows() / 3 {
            let here = spread.rows(3 * t, 3) * block.rows(3 * t, 3).transpose();
            covariances
                .push(Matrix3::from_fn(|a, b| here[(a, b)]) + Matrix3::identity() * unexplained_m2);
        }
    }
    covariances
}

/// Widths from errors of predictions of left-out segments, one column each in the order of the
/// covariances, three coordinates each, metres.
pub(super) fn calibrate(
    errors_m: &DMatrix<f64>,
    covariances_m2: &[Matrix3<f64>],
) -> Vec<Calibration> {
    let inverses: Vec<_> = covariances_m2.iter().map(|c| c.try_inverse()).collect();
    let mut distances: Vec<f64> = Vec::new();
    let errors = errors_m.as_slice().as_chunks::<3>().0.iter();
    for (error, inverse) in errors.zip(inverses.iter().cycle()) {
        // Without a spread there is nothing to measure by.
        if let Some(inverse) = inverse {
            let error = Vector3::from(*error);
            distances.push(error.dot(&(inverse * error)).max(0.0).sqrt());
        }
    }
    SHARES
        .into_iter()
        .zip(NORMAL)
        .map(|(share, normal)| Calibration {
            share,
            mahalanobis: quantile(&mut distances, share).unwrap_or(normal),
        })
        .collect()
}

/// The smallest distance that holds at least this share; leaves the distances in another order.
fn quantile(distances: &mut [f64], share: f64) -> Option<f64> {
    let rank = (share * distances.len() as f64).ceil() as usize;
    let index = rank.saturating_sub(1);
    (index < distances.len()).then(|| *distances.select_nth_unstable_by(index, f64::total_cmp).1)
}
