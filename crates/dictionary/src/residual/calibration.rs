//! How wide corridors have to be.

use inhand_model::{Calibration, Finger, SEGMENT_COORDINATES, SegmentLayout};
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Shares for which a width is measured.
const SHARES: [f64; 2] = [0.5, 0.95];
/// Mahalanobis distances that hold these shares of a normal distribution in three dimensions
/// (square roots of the chi-squared quantiles 2.366 and 7.815), used where nothing could be left
/// out.
const NORMAL: [f64; 2] = [1.538_172_254_455_285_2, 2.795_483_482_915_107];

/// Covariance of each fingertip at each sample (ordered finger, sample), m².
pub(super) fn covariances_m2(
    layout: SegmentLayout,
    primitives: &DMatrix<f64>,
    covariance_m2: &DMatrix<f64>,
    unexplained_m2: f64,
) -> Vec<Matrix3<f64>> {
    (0..layout.samples * Finger::COUNT)
        .map(|i| {
            let (finger, t) = (i / layout.samples, i % layout.samples);
            let rows = primitives.rows(t * SEGMENT_COORDINATES + finger * 3, 3);
            let spread = rows * covariance_m2 * rows.transpose();
            Matrix3::from_fn(|a, b| spread[(a, b)]) + Matrix3::identity() * unexplained_m2
        })
        .collect()
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
    distances.sort_by(f64::total_cmp);
    SHARES
        .into_iter()
        .zip(NORMAL)
        .map(|(share, normal)| Calibration {
            share,
            mahalanobis: quantile(&distances, share).unwrap_or(normal),
        })
        .collect()
}

/// The smallest distance that holds at least this share.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}
