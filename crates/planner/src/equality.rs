//! Hard targets: linear equations that hold exactly.

use nalgebra::{ColPivQR, DMatrix, DVector};

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
        for (mut row, &length) in scaled.row_iter_mut().zip(&lengths) {
            row *= if length > DEPENDENT * longest {
                1.0 / length
            } else {
                0.0
            };
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
                for (mut column, &length) in lift.column_iter_mut().zip(&lengths) {
                    column *= if length > DEPENDENT * longest {
                        1.0 / length
                    } else {
                        0.0
                    };
                }
                lift
            }
            _ => DMatrix::zeros(n, rows.nrows()),
        };
        Self { rows, free, lift }
    }

    /// Directions in which the unknowns are free.
    pub(crate) const fn free(&self) -> &DMatrix<f64> {
        &self.free
    }

    /// Moves `h` the shortest way to where the equations hold, or come closest.
    pub(crate) fn restore(&self, unknowns: &mut DVector<f64>, wanted: &DVector<f64>) {
        for _ in 0..2 {
            let missing = wanted - &self.rows * &*unknowns;
            unknowns.gemv(1.0, &self.lift, &missing, 1.0);
        }
    }

    /// Largest miss of an equation, mm or mm/s, relative to max(1, its right side).
    pub(crate) fn violation(&self, unknowns: &DVector<f64>, wanted: &DVector<f64>) -> f64 {
        let found = &self.rows * unknowns;
        (found.iter().zip(wanted.iter()))
            .map(|(found, wanted)| (found - wanted).abs() / wanted.abs().max(1.0))
            .fold(0.0, f64::max)
    }

    /// Whether the equations, at a point where they come closest, hold.
    pub(crate) fn consistent(&self, unknowns: &DVector<f64>, wanted: &DVector<f64>) -> bool {
        self.violation(unknowns, wanted) <= CONSISTENT
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
        assert_eq!(equalities.free().ncols(), 1);
        let mut h = DVector::from_vec(vec![7.0, 7.0, 7.0]);
        let wanted = DVector::from_vec(vec![1.0, 2.0, 3.0, 0.0]);
        equalities.restore(&mut h, &wanted);
        assert!((&h - DVector::from_vec(vec![1.0, 2.0, 7.0])).amax() < 1e-14);
        assert!(equalities.consistent(&h, &wanted));
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
        assert_eq!(equalities.free().ncols(), 0);
        assert_eq!(equalities.remaining(&DVector::repeat(3, 1.0)).norm(), 0.0);
    }
}
