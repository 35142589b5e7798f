//! A Cholesky factor that grows and shrinks by one row.

use nalgebra::DVectorView;

/// Lower triangular factor `L` of a symmetric positive definite `K = L Lᵀ`, kept up to date while
/// rows and columns of `K` come and go. Rows are packed one after the other, so each is contiguous.
///
/// Cost: appending k²/2 multiplications (the forward solve), removing row j about 3 (k - j)²,
/// solving k².
#[derive(Clone, Debug, Default)]
pub(crate) struct Factor {
    packed: Vec<f64>,
    order: usize,
}

impl Factor {
    fn row(&self, i: usize) -> &[f64] {
        &self.packed[i * (i + 1) / 2..][..=i]
    }

    /// Replaces `v` by `L⁻¹ v`.
    pub(crate) fn solve_lower(&self, v: &mut [f64]) {
        for i in 0..self.order {
            let row = self.row(i);
            let (done, rest) = v.split_at_mut(i);
            rest[0] = (rest[0] - dot(&row[..i], done)) / row[i];
        }
    }

    /// Replaces `v` by `L⁻ᵀ v`.
    pub(crate) fn solve_lower_transposed(&self, v: &mut [f64]) {
        for i in (0..self.order).rev() {
            let row = self.row(i);
            let (before, rest) = v.split_at_mut(i);
            rest[0] /= row[i];
            add_scaled(before, -rest[0], &row[..i]);
        }
    }

    /// Appends a row to `K`: `lower` is `L⁻¹` times the new row's entries against the present ones,
    /// `pivot_squared` the new diagonal entry less `|lower|²`, which must be positive.
    pub(crate) fn append(&mut self, lower: &[f64], pivot_squared: f64) {
        debug_assert!(lower.len() == self.order && pivot_squared > 0.0);
        self.packed.extend_from_slice(lower);
        self.packed.push(pivot_squared.sqrt());
        self.order += 1;
    }

    /// Removes row and column `j` of `K`.
    ///
    /// Without its row `j`, `L` has one entry too many in each row below. Plane rotations of
    /// neighbouring columns push it to the end of the row, where it vanishes.
    pub(crate) fn remove(&mut self, j: usize) {
        let start = |i: usize| i * (i + 1) / 2;
        let mut rotations: Vec<(f64, f64)> = Vec::with_capacity(self.order - j);
        for i in j + 1..self.order {
            let (from, to) = (start(i), start(i - 1));
            self.packed.copy_within(from..from + j, to);
            let mut carried = self.packed[from + j];
            for (offset, &(c, s)) in rotations.iter().enumerate() {
                let next = self.packed[from + j + offset + 1];
                self.packed[to + j + offset] = c * carried + s * next;
                carried = c * next - s * carried;
            }
            // `carried` now stands in the row's last but one column and meets the old diagonal.
            let diagonal = self.packed[from + i];
            let length = carried.hypot(diagonal);
            rotations.push((carried / length, diagonal / length));
            self.packed[to + i - 1] = length;
        }
        self.order -= 1;
        self.packed.truncate(start(self.order));
    }
}

/// Scalar product, summed in several lanes.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    DVectorView::from_slice(a, a.len()).dot(&DVectorView::from_slice(b, b.len()))
}

/// `y += factor * x`.
pub(crate) fn add_scaled(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    fn matrix(order: usize) -> DMatrix<f64> {
        // Diagonally dominant, hence positive definite.
        DMatrix::from_fn(order, order, |i, j| {
            if i == j {
                order as f64
            } else {
                ((i * j + i + j) as f64).sin() * 0.9
            }
        })
    }

    fn factor(k: &DMatrix<f64>, keep: &[usize]) -> Factor {
        let mut factor = Factor::default();
        for (order, &i) in keep.iter().enumerate() {
            let mut lower: Vec<f64> = keep[..order].iter().map(|&j| k[(i, j)]).collect();
            factor.solve_lower(&mut lower);
            let pivot_squared = k[(i, i)] - dot(&lower, &lower);
            factor.append(&lower, pivot_squared);
        }
        factor
    }

    #[test]
    fn removing_a_row_is_as_if_it_had_never_come() {
        let k = matrix(9);
        for removed in 0..9 {
            let mut shrunk = factor(&k, &[0, 1, 2, 3, 4, 5, 6, 7, 8]);
            shrunk.remove(removed);
            let keep: Vec<usize> = (0..9).filter(|&i| i != removed).collect();
            let fresh = factor(&k, &keep);
            for (a, b) in shrunk.packed.iter().zip(&fresh.packed) {
                assert!((a - b).abs() < 1e-13, "row {removed}: {a} against {b}");
            }
        }
    }

    #[test]
    fn solves_the_system_it_was_built_from() {
        let k = matrix(12);
        let keep = [11, 3, 7, 0, 5];
        let factor = factor(&k, &keep);
        let x: Vec<f64> = (0..5).map(|i| 1.0 + f64::from(i)).collect();
        let mut b: Vec<f64> = keep
            .iter()
            .map(|&i| keep.iter().zip(&x).map(|(&j, x)| k[(i, j)] * x).sum())
            .collect();
        factor.solve_lower(&mut b);
        factor.solve_lower_transposed(&mut b);
        assert!((DVector::from_vec(b) - DVector::from_vec(x)).amax() < 1e-13);
    }
}
