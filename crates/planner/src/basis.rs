//! Map from the unknowns to a segment's rows: `W`, part sparse, part dense.

use inhand_model::{SegmentLayout, smooth_basis};
use nalgebra::{DMatrix, DVector};

/// `W = [S | B]` (rows x n): the smooth curve's few entries a row first, if there are any, then
/// dense primitives.
#[derive(Clone, Debug)]
pub(crate) struct Basis {
    rows: usize,
    smooth: Option<SparseRows>,
    primitives: DMatrix<f64>,
}

/// Rows of which few entries are not zero.
#[derive(Clone, Debug)]
struct SparseRows {
    columns: usize,
    /// Where each row's entries start; one more than rows.
    starts: Vec<usize>,
    /// Column and value.
    entries: Vec<(usize, f64)>,
}

impl Basis {
    /// Primitives alone.
    pub(crate) fn dense(primitives: DMatrix<f64>) -> Self {
        Self {
            rows: primitives.nrows(),
            smooth: None,
            primitives,
        }
    }

    /// The smooth curve through end conditions, and primitives of the deviation from it.
    pub(crate) fn smooth(layout: SegmentLayout, primitives: DMatrix<f64>) -> Self {
        let dense = smooth_basis(layout);
        let (mut starts, mut entries) = (vec![0], Vec::new());
        for row in dense.row_iter() {
            let used = row.iter().copied().enumerate().filter(|(_, v)| *v != 0.0);
            entries.extend(used);
            starts.push(entries.len());
        }
        Self {
            rows: dense.nrows(),
            smooth: Some(SparseRows {
                columns: dense.ncols(),
                starts,
                entries,
            }),
            primitives,
        }
    }

    /// Number of unknowns (n).
    pub(crate) fn unknowns(&self) -> usize {
        self.ends() + self.primitives.ncols()
    }

    /// How many unknowns are end conditions.
    fn ends(&self) -> usize {
        self.smooth.as_ref().map_or(0, |smooth| smooth.columns)
    }

    /// Adds `factor` times a row of `W` to `normal` (n).
    pub(crate) fn add_row(&self, row: usize, factor: f64, normal: &mut [f64]) {
        if let Some(smooth) = &self.smooth {
            for &(column, value) in smooth.row(row) {
                normal[column] += factor * value;
            }
        }
        // Empty where there are no primitives.
        let column = self
            .primitives
            .as_slice()
            .iter()
            .skip(row)
            .step_by(self.rows);
        for (normal, w) in normal[self.ends()..].iter_mut().zip(column) {
            *normal += factor * w;
        }
    }

    /// `base + W h`, mm. Columns whose activation is zero are skipped, the others taken four at a
    /// time, so that the sum is loaded and stored a quarter as often.
    pub(crate) fn motion_mm(&self, base_mm: &[f64], unknowns: &DVector<f64>) -> Vec<f64> {
        let mut motion = base_mm.to_vec();
        let (ends, activations) = unknowns.as_slice().split_at(self.ends());
        if let Some(smooth) = &self.smooth {
            for (row, sum) in motion.iter_mut().enumerate() {
                for &(column, value) in smooth.row(row) {
                    *sum += value * ends[column];
                }
            }
        }
        let used: Vec<(f64, &[f64])> = activations
            .iter()
            .zip(self.primitives.as_slice().chunks_exact(self.rows))
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
        if let Some(smooth) = &self.smooth {
            for row in 0..rows {
                for &(column, value) in smooth.row(row) {
                    dense[(row, column)] = value;
                }
            }
        }
        dense
            .columns_mut(self.ends(), self.primitives.ncols())
            .copy_from(&self.primitives.rows(0, rows));
        dense
    }
}

impl SparseRows {
    fn row(&self, row: usize) -> &[(usize, f64)] {
        &self.entries[self.starts[row]..self.starts[row + 1]]
    }
}
