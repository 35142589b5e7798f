//! End conditions that a target does not give, from all that it does.

use inhand_model::{Residual, ends_len};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::MM_PER_M;
use crate::target_values::TargetPart;

/// Standard deviation (metres, m/s) that is added to positions and velocities on the way when end
/// conditions are concluded from them. As sharp as targets usually are; keeps those that follow
/// from one another from making the problem singular.
const SHARPEST: f64 = 1e-4;

/// Regression of the end conditions that a target does not give on what it does: the end conditions
/// among it, and positions and velocities on the way, which are those of the smooth curve plus a
/// deviation:
///
/// ```text
/// y = S_y x + B_y z,    x_open = m_open + C Oᵀ (O C Oᵀ + R)⁻¹ (y - O m - B_y mean)
/// ```
///
/// with `O` the given end conditions and `S_y`, and `R = B_y Σ B_yᵀ` for what lies on the way.
#[derive(Clone, Debug)]
pub(crate) struct Completion {
    /// End condition and place among the given values, of each known number.
    known: Vec<(usize, usize)>,
    /// End conditions that are not given.
    open: Vec<usize>,
    /// Place among the given values of each number of what lies on the way, if anything is open.
    places: Vec<usize>,
    /// `S_y` (numbers on the way x end conditions).
    smooth: DMatrix<f64>,
    /// `B_y` (numbers on the way x activations).
    deviation: DMatrix<f64>,
    /// `C Oᵀ (O C Oᵀ + R)⁻¹` (open x (known + on the way)).
    regression: DMatrix<f64>,
}

impl Completion {
    /// `observe` says what a number of something given is as a linear function of the unknowns.
    pub(crate) fn new(
        residual: &Residual,
        pattern: &[TargetPart],
        observe: impl Fn(TargetPart, usize) -> Vec<f64>,
    ) -> Self {
        let layout = residual.layout;
        let ends = ends_len(layout);
        let mut known = Vec::new();
        for (index, part) in pattern.iter().enumerate() {
            if let Some(first) = part.end_condition(layout) {
                known.extend((0..3).map(|axis| (first + axis, 3 * index + axis)));
            }
        }
        let open: Vec<usize> = (0..ends)
            .filter(|i| known.iter().all(|(k, _)| k != i))
            .collect();
        let (mut places, mut rows) = (Vec::new(), Vec::new());
        for (index, &part) in pattern.iter().enumerate() {
            if !open.is_empty() && part.end_condition(layout).is_none() {
                for axis in 0..3 {
                    places.push(3 * index + axis);
                    rows.push(observe(part, axis));
                }
            }
        }
        let columns = ends + residual.primitives.ncols();
        let rows = DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]);
        let smooth = rows.columns(0, ends).into_owned();
        let deviation = rows.columns_range(ends..).into_owned();

        let mut observed = DMatrix::zeros(known.len() + places.len(), ends);
        for (row, &(end, _)) in known.iter().enumerate() {
            observed[(row, end)] = 1.0;
        }
        let tail = known.len()..observed.nrows();
        observed.rows_range_mut(tail.clone()).copy_from(&smooth);
        let across = &observed * &residual.ends_covariance;
        let mut own = &across * observed.transpose();
        let mut spread = own.view_range_mut(tail.clone(), tail);
        spread += &deviation * &residual.covariance_m2 * deviation.transpose();
        for i in 0..spread.nrows() {
            spread[(i, i)] += SHARPEST * SHARPEST;
        }
        // A part of a positive definite covariance is one too.
        let regression = match Cholesky::<f64, Dyn>::new(own) {
            Some(factor) => factor.solve(&across.select_columns(&open)).transpose(),
            None => DMatrix::zeros(open.len(), observed.nrows()),
        };
        Self {
            known,
            open,
            places,
            smooth,
            deviation,
            regression,
        }
    }

    /// All end conditions (m, m/s): the given ones, and the conditional mean of the others.
    pub(crate) fn likely(&self, residual: &Residual, values: &[f64]) -> DVector<f64> {
        let straight = self.likely_with(residual, values, None);
        if self.places.is_empty() {
            return straight;
        }
        // On the way motion is off the smooth curve by what is expected there.
        let expected = residual.expected_m(&straight);
        self.likely_with(residual, values, Some(&expected))
    }

    fn likely_with(
        &self,
        residual: &Residual,
        values: &[f64],
        expected_m: Option<&DVector<f64>>,
    ) -> DVector<f64> {
        let mean = &residual.ends_mean;
        let mut ends = mean.clone();
        for &(end, place) in &self.known {
            ends[end] = values[place] / MM_PER_M;
        }
        let mut way = -(&self.smooth * mean);
        if let Some(expected_m) = expected_m {
            way -= &self.deviation * expected_m;
        }
        for (way, &place) in way.iter_mut().zip(&self.places) {
            *way += values[place] / MM_PER_M;
        }
        let away = DVector::from_iterator(
            self.regression.ncols(),
            (self.known.iter())
                .map(|&(end, _)| ends[end] - mean[end])
                .chain(way.iter().copied()),
        );
        for (&end, change) in self.open.iter().zip((&self.regression * away).iter()) {
            ends[end] += change;
        }
        ends
    }
}
