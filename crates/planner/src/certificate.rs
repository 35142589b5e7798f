//! Proof of optimality, recomputed from the problem's own data.
//!
//! Nothing of the solver's is used but its answer: gradient, slacks and multipliers are put into
//! the optimality conditions over all rows, also those that were never handed to it.

use inhand_model::{Certificate, PerFamily};
use nalgebra::DVector;

use crate::model::MotionModel;
use crate::problem::{Instance, Problem};
use crate::rows::{Row, Worst};

/// An answer to be judged.
pub(crate) struct Answer<'a> {
    /// Unknowns, mm and mm/s.
    pub(crate) unknowns: &'a DVector<f64>,
    /// The motion they make, mm (all rows).
    pub(crate) motion_mm: &'a [f64],
    /// Gradient of the minimised function there.
    pub(crate) gradient: &'a DVector<f64>,
    /// Multipliers of the unknowns' signs, where they are not zero.
    pub(crate) signs: &'a [(usize, f64)],
    /// Multipliers of the rows that were taken up, where they are not zero.
    pub(crate) rows: &'a [(&'a Row, f64)],
    /// Largest violation of each family over all its rows.
    pub(crate) worst: &'a PerFamily<Option<Worst>>,
}

/// The four residuals of the optimality conditions.
///
/// With `q` the gradient of the minimised function at zero: stationarity, dual and complementarity
/// are relative to max(1, |q|). Multipliers of equations are those that leave least of the gradient.
/// Primal is the largest of: violation of a sign (mm), miss of an equation (mm or mm/s, relative to
/// max(1, its right side)), and violation of a row, relative to its bound as its family has it.
/// For fingertips kept apart or near contact points that is the true distance, not its
/// linearisation, while multipliers belong to linearised rows.
pub(crate) fn certificate(
    model: &MotionModel,
    problem: &Problem,
    instance: &Instance,
    answer: &Answer<'_>,
) -> Certificate {
    let scale = instance.gradient_at_zero.norm().max(1.0);
    let mut lagrangian = answer.gradient.clone();
    let mut dual = 0.0_f64;
    let mut complementarity = 0.0_f64;
    for &(i, multiplier) in answer.signs {
        lagrangian[i] -= multiplier;
        dual = dual.max(-multiplier);
        complementarity = complementarity.max((multiplier * answer.unknowns[i]).abs());
    }
    for &(row, multiplier) in answer.rows {
        lagrangian.axpy(-multiplier, &row.normal(model), 1.0);
        dual = dual.max(-multiplier);
        complementarity = complementarity.max((multiplier * row.slack(answer.motion_mm)).abs());
    }
    let mut primal = 0.0_f64;
    if model.signs {
        primal = primal.max(-answer.unknowns.min());
    }
    if let Some(equalities) = &problem.equalities {
        primal = primal.max(equalities.violation(answer.unknowns, &instance.wanted));
        lagrangian = equalities.remaining(&lagrangian);
    }
    for (_, worst) in answer.worst.iter() {
        primal = primal.max(worst.map_or(0.0, |worst| worst.relative));
    }
    Certificate {
        stationarity: lagrangian.norm() / scale,
        primal,
        dual: dual / scale,
        complementarity: complementarity / scale,
    }
}
