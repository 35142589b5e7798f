//! Proof of optimality, recomputed from the problem's own data.
//!
//! Nothing of the solver's is used but its answer: gradient, slacks and multipliers are put into
//! the optimality conditions over all rows, also those that were never handed to it.

use inhand_model::Certificate;
use nalgebra::{DMatrix, DVector};

use crate::velocity::{VelocityLimits, VelocityRow};

/// An answer to be judged.
pub(crate) struct Answer<'a> {
    /// Activations, mm.
    pub(crate) activations_mm: &'a DVector<f64>,
    /// The motion they make, mm (15 N).
    pub(crate) motion_mm: &'a [f64],
    /// Multipliers of the activations' signs, where they are not zero.
    pub(crate) signs: &'a [(usize, f64)],
    /// Multipliers of the velocity rows, where they are not zero.
    pub(crate) velocity: &'a [(VelocityRow, f64)],
}

/// The four residuals of the optimality conditions.
///
/// With `q` the gradient of the minimised function at zero activations: stationarity, dual and
/// complementarity are relative to max(1, |q|); primal is the largest violation of a sign in mm, or
/// of a velocity bound relative to max(1 mm/s, |bound|).
pub(crate) fn certificate(
    primitives: &DMatrix<f64>,
    limits: &VelocityLimits,
    must_be_positive: bool,
    gradient: &DVector<f64>,
    gradient_at_zero: &DVector<f64>,
    answer: &Answer<'_>,
) -> Certificate {
    let scale = gradient_at_zero.norm().max(1.0);
    let mut lagrangian = gradient.clone();
    let mut dual = 0.0_f64;
    let mut complementarity = 0.0_f64;
    for &(i, multiplier) in answer.signs {
        lagrangian[i] -= multiplier;
        dual = dual.max(-multiplier);
        complementarity = complementarity.max((multiplier * answer.activations_mm[i]).abs());
    }
    for &(row, multiplier) in answer.velocity {
        lagrangian.axpy(-multiplier, &limits.normal(primitives, row), 1.0);
        dual = dual.max(-multiplier);
        let slack_mm = limits.slack_mm(answer.motion_mm, row);
        complementarity = complementarity.max((multiplier * slack_mm).abs());
    }
    let sign_violation = if must_be_positive {
        (-answer.activations_mm.min()).max(0.0)
    } else {
        0.0
    };
    Certificate {
        stationarity: lagrangian.norm() / scale,
        primal: sign_violation.max(limits.worst_violation(answer.motion_mm)),
        dual: dual / scale,
        complementarity: complementarity / scale,
    }
}
