//! End conditions that a target does not give, from those that it does.

use inhand_model::{Residual, ends_len};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::given::Given;
use crate::model::MM_PER_M;

/// The end conditions that a target gives, and how those it does not give follow from them.
#[derive(Clone, Debug)]
pub(crate) struct Completion {
    /// End condition and place among the given values, of each known number.
    known: Vec<(usize, usize)>,
    /// End conditions that are not given.
    open: Vec<usize>,
    /// `C_ok C_kk⁻¹` (open x known).
    regression: DMatrix<f64>,
}

impl Completion {
    pub(crate) fn new(residual: &Residual, given: &[Given]) -> Self {
        let layout = residual.layout;
        let mut known = Vec::new();
        for (index, given) in given.iter().enumerate() {
            if let Some(first) = given.end_condition(layout) {
                known.extend((0..3).map(|axis| (first + axis, 3 * index + axis)));
            }
        }
        let open: Vec<usize> = (0..ends_len(layout))
            .filter(|i| known.iter().all(|(k, _)| k != i))
            .collect();
        let columns: Vec<usize> = known.iter().map(|(k, _)| *k).collect();
        let covariance = &residual.ends_covariance;
        let across = covariance.select_rows(&open).select_columns(&columns);
        let own = covariance.select_rows(&columns).select_columns(&columns);
        // A part of a positive definite covariance is one too.
        let regression = match Cholesky::<f64, Dyn>::new(own) {
            Some(factor) => factor.solve(&across.transpose()).transpose(),
            None => DMatrix::zeros(open.len(), columns.len()),
        };
        Self {
            known,
            open,
            regression,
        }
    }

    /// All end conditions (m, m/s): the given ones, and the conditional mean of the others.
    pub(crate) fn likely(&self, mean: &DVector<f64>, values: &[f64]) -> DVector<f64> {
        let mut ends = mean.clone();
        for &(end, place) in &self.known {
            ends[end] = values[place] / MM_PER_M;
        }
        let away = DVector::from_iterator(
            self.known.len(),
            self.known.iter().map(|&(end, _)| ends[end] - mean[end]),
        );
        for (&end, change) in self.open.iter().zip((&self.regression * away).iter()) {
            ends[end] += change;
        }
        ends
    }
}
