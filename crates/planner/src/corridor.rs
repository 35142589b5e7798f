//! Prediction regions of a plan: the conditional covariance of each fingertip.

use inhand_model::{Corridor, PerFinger, SegmentLayout};
use nalgebra::DMatrix;

use crate::model::{MM_PER_M, MotionModel};

/// `W_t C W_tᵀ + unexplained` for each fingertip and sample, with the covariance `C` of the unknowns
/// given the target. Cost: a product of (15 N x n) and (n x n).
pub(crate) fn corridor(model: &MotionModel, covariance: &DMatrix<f64>) -> Corridor {
    let layout = model.layout;
    let basis = model.basis.to_dense(layout.finger_rows());
    let spread = &basis * covariance;
    let squared = MM_PER_M * MM_PER_M;
    let covariance_m2 = (0..layout.samples)
        .map(|t| {
            PerFinger::from_fn(|finger| {
                let at = SegmentLayout::row(t, finger, 0);
                let mut block = spread.rows(at, 3) * basis.rows(at, 3).transpose();
                for axis in 0..3 {
                    block[(axis, axis)] += model.unexplained_mm2;
                }
                [0, 1, 2]
                    .map(|i| [0, 1, 2].map(|j| 0.5 * (block[(i, j)] + block[(j, i)]) / squared))
            })
        })
        .collect();
    Corridor {
        layout,
        covariance_m2,
    }
}
