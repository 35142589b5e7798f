//! Map from the unknowns to a segment's rows: `W`, part sparse, part dense.

use nalgebra::{DMatrix, DVector};

/// `W = [S | B]` (rows x n): the smooth curve's few entries a row first, if there are any, then
/// dense primitives.
#[derive(Clone, Debug)]
pub(crate) struct Basis {
    /// How many unknowns are end conditions.
    ends: usize,
    /// Column and value of each row's entries that are not zero.
    smooth: Vec<Vec<(usize, f64)>>,
    primitives: DMatrix<f64>,
}

impl Basis {
    /// Primitives alone.
    pub(crate) fn dense(primitives: DMatrix<f64>) -> Self {
        Self {
            ends: 0,
            smooth: vec![Vec::new(); primitives.nrows()],
            primitives,
        }
    }

    /// The smooth curve through end conditions, and primitives of the deviation from it.
    pub(crate) fn smooth(dense: &DMatrix<f64>, primitives: DMatrix<f64>) -> Self {
        let smooth = dense.row_iter().map(|row| {
            let entries = row.iter().copied().enumerate();
            entries.filter(|(_, v)| *v != 0.0).collect()
        });
        Self {
            ends: dense.ncols(),
            smooth: smooth.collect(),
            primitives,
        }
    }

    /// Number of unknowns (n).
    pub(crate) fn unknowns(&self) -> usize {
        self.ends + self.primitives.ncols()
    }

    /// Adds `factor` times a row of `W` to `normal` (n).
    pub(crate) fn add_row(&self, row: usize, factor: f64, normal: &mut [f64]) {
        for &(column, value) in &self.smooth[row] {
            normal[column] += factor * value;
        }
        // Empty where there are no primitives.
        let column = self.primitives.as_slice().iter().skip(row);
        let column = column.step_by(self.smooth.len());
        for (normal, w) in normal[self.ends..].iter_mut().zip(column) {
            *normal += factor * w;
        }
    }

    /// `base + W h`, mm. Columns whose activation is zero are skipped, the others taken four at a
    /// time, so that the sum is loaded and stored a quarter as often.
    pub(crate) fn motion_mm(&self, base_mm: &[f64], unknowns: &DVector<f64>) -> Vec<f64> {
        let mut motion = base_mm.to_vec();
        let (ends, activations) = unknowns.as_slice().split_at(self.ends);
        for (sum, entries) in motion.iter_mut().zip(&self.smooth) {
            for &(column, value) in entries {
                *sum += value * ends[column];
            }
        }
        let used: Vec<(f64, &[f64])> = activations
            .iter()
            .zip(self.primitives.as_slice().chunks_exact(self.smooth.len()))
            .filter(|(h, _)| **h != 0.0)
            .map(|(h, column)| (*h, column))
            .collect();
        let (fours, rest) = used.as_chunks::<4>();
        for &[(a, wa), (b, wb), (c, wc), (d, wd)] in fours {
            for ((((sum, wa), wb), wc), wd) in motion.iter_mut().zip(wa).zip(wb).zip(wc).zip(wd) {
                *sum += (a * wa + b * wb) + (c * wc + d * wd);
            }
        }
        for &(a, wa) in rest {
            for (sum, wa) in motion.iter_mut().zip(wa) {
                *sum += a * wa;
            }
        }
        motion
    }

    /// `W` written out for its first `rows` rows.
    pub(crate) fn to_dense(&self, rows: usize) -> DMatrix<f64> {
        let mut dense = DMatrix::zeros(rows, self.unknowns());
        for (row, entries) in self.smooth[..rows].iter().enumerate() {
            for &(column, value) in entries {
                dense[(row, column)] = value;
            }
        }
        dense
            .columns_mut(self.ends, self.primitives.ncols())
            .copy_from(&self.primitives.rows(0, rows));
        dense
    }
}
