//! Hard targets: linear equations that hold exactly.

use nalgebra::{ColPivQR, DMatrix, DVector};

use crate::precision::{inverse, make_symmetric};

/// A row of `E` follows from the others where less than this part of its length is left.
const DEPENDENT: f64 = 1e-10;
/// Equations contradict each other where more than this is left of the right side (mm, mm/s),
/// relative to max(1, its size).
const CONSISTENT: f64 = 1e-9;

/// `E h = e`, prepared: independent directions of its rows, and all others.
///
/// Equations may follow from one another; whether they contradict each other depends on `e`.
#[derive(Clone, Debug)]
pub(crate) struct Equalities {
    /// `E` (k x n).
    pub(crate) rows: DMatrix<f64>,
    /// Orthonormal directions in which `h` is free (n x (n - rank)).
    free: DMatrix<f64>,
    /// `E⁺` (n x k): the shortest change of `h` that changes `E h` by its argument.
    lift: DMatrix<f64>,
}

impl Equalities {
    pub(crate) fn new(rows: DMatrix<f64>) -> Self {
        let n = rows.ncols();
        let lengths: Vec<f64> = rows.row_iter().map(|row| row.norm()).collect();
        let longest = lengths.iter().fold(0.0_f64, |a, &b| a.max(b));
        // Rows of unit length, but for those that are rounding alone.
        let mut scaled = rows.clone();
        let factors: Vec<f64> = (lengths.iter())
            .map(|&length| {
                if length > DEPENDENT * longest {
                    1.0 / length
                } else {
                    0.0
                }
            })
            .collect();
        for (mut row, factor) in scaled.row_iter_mut().zip(&factors) {
            row *= *factor;
        }
        let factor = ColPivQR::new(scaled.transpose());
        let triangle = factor.r();
        let rank = (0..triangle.nrows().min(triangle.ncols()))
            .take_while(|&i| triangle[(i, i)].abs() > DEPENDENT)
            .count();
        let mut whole = DMatrix::identity(n, n);
        factor.q_tr_mul(&mut whole);
        let whole = whole.transpose();
        let range = whole.columns(0, rank);
        let free = whole.columns(rank, n - rank).into_owned();
        // E = D S with unit rows S; S⁺ = Q (S Q)⁺, where S Q has full column rank.
        let small = &scaled * range;
        let lift = match small.clone().qr() {
            qr if rank > 0 => {
                let mut solution = qr.q().transpose();
                qr.r().solve_upper_triangular_mut(&mut solution);
                let mut lift = range * solution;
                for (mut column, factor) in lift.column_iter_mut().zip(&factors) {
                    column *= *factor;
                }
                lift
            }
            _ => DMatrix::zeros(n, rows.nrows()),
        };
        Self { rows, free, lift }
    }

    /// Inverse of a second derivative within the equations (n x n); `None` where rounding leaves none.
    pub(crate) fn inverse_within(&self, hessian: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let within = inverse(self.free.tr_mul(&(hessian * &self.free)))?;
        let mut inverse = &self.free * within * self.free.transpose();
        make_symmetric(&mut inverse);
        Some(inverse)
    }

    /// Moves `h` the shortest way to where the equations hold, or come closest.
    pub(crate) fn restore(&self, unknowns: &mut DVector<f64>, right: &DVector<f64>) {
        for _ in 0..2 {
            let missing = right - &self.rows * &*unknowns;
            unknowns.gemv(1.0, &self.lift, &missing, 1.0);
        }
    }

    /// Largest miss of an equation, mm or mm/s, relative to max(1, its right side).
    pub(crate) fn violation(&self, unknowns: &DVector<f64>, right: &DVector<f64>) -> f64 {
        let found = &self.rows * unknowns;
        (found.iter().zip(right.iter()))
            .map(|(found, right)| (found - right).abs() / right.abs().max(1.0))
            .fold(0.0, f64::max)
    }

    /// Whether the equations, at a point where they come closest, hold.
    pub(crate) fn consistent(&self, unknowns: &DVector<f64>, right: &DVector<f64>) -> bool {
        self.violation(unknowns, right) <= CONSISTENT
    }

    /// What is left of a gradient when the best multipliers of the equations (in the least-squares
    /// sense) are taken off: its part in free directions.
    pub(crate) fn remaining(&self, gradient: &DVector<f64>) -> DVector<f64> {
        &self.free * self.free.tr_mul(gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_equations_count_once_and_contradictions_show() {
        // x = 1, 2 x = 2, x + y = 3, and a row of nothing.
        let rows = DMatrix::from_row_slice(
            4,
            3,
            &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        );
        let equalities = Equalities::new(rows);
        assert_eq!(equalities.free.ncols(), 1);
        let mut h = DVector::from_vec(vec![7.0, 7.0, 7.0]);
        let right = DVector::from_vec(vec![1.0, 2.0, 3.0, 0.0]);
        equalities.restore(&mut h, &right);
        assert!((&h - DVector::from_vec(vec![1.0, 2.0, 7.0])).amax() < 1e-14);
        assert!(equalities.consistent(&h, &right));
        let contrary = DVector::from_vec(vec![1.0, 2.1, 3.0, 0.0]);
        equalities.restore(&mut h, &contrary);
        assert!(!equalities.consistent(&h, &contrary));
        // Only the third direction is free.
        let gradient = DVector::from_vec(vec![5.0, -4.0, 3.0]);
        let left = equalities.remaining(&gradient);
        assert!((left - DVector::from_vec(vec![0.0, 0.0, 3.0])).amax() < 1e-14);
    }

    #[test]
    fn everything_fixed_leaves_nothing_free() {
        let equalities = Equalities::new(DMatrix::identity(3, 3) * 2.0);
        assert_eq!(equalities.free.ncols(), 0);
        assert_eq!(equalities.remaining(&DVector::repeat(3, 1.0)).norm(), 0.0);
    }
}
