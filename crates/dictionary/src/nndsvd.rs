//! A start from the singular vectors of the data.

use crate::block::Block;
use crate::data::Columns;
use crate::error::LearnError;
use crate::packed::Packed;
use crate::rounds::NmfProblem;
use crate::singular::{leading, project};

/// Products with `V Vᵀ` that the singular vectors get: the start of an iteration needs them to some
/// digits only.
const POWERS: usize = 4;

/// Numbers below this share of a primitive's largest are zeros.
const ZERO: f64 = 1e-6;

impl NmfProblem {
    /// Primitives as rows (rank x rows) by NNDSVD with filled zeros (Boutsidis and Gallopoulos 2008,
    /// "SVD based initialization: a head start for nonnegative matrix factorization", Pattern
    /// Recognition 41, table 1 and section 2.3, variant "a"): of each pair of singular vectors
    /// the parts of one sign whose product is larger, scaled to carry it; zeros take the mean of
    /// the data, because multiplicative updates would keep them.
    pub(crate) fn nndsvd_primitives(
        &self,
        columns: &dyn Columns,
        seed: u64,
    ) -> Result<Vec<f64>, LearnError> {
        let (rank, rows) = (self.settings.rank, self.layout.rows());
        let pass = |see: &mut dyn FnMut(&[f64])| -> Result<(), LearnError> {
            for block in 0..self.blocks() {
                let block: Block<f64> = self.shifted(self.read(columns, self.block(block))?);
                see(&block.data);
            }
            Ok(())
        };
        nndsvd(rows, self.count, rank, seed, pass)
    }
}

/// The primitives for non-negative data shown block by block by `pass`.
fn nndsvd<E>(
    rows: usize,
    count: usize,
    rank: usize,
    seed: u64,
    mut pass: impl FnMut(&mut dyn FnMut(&[f64])) -> Result<(), E>,
) -> Result<Vec<f64>, E> {
    let (vectors, squared_values) = leading(rows, count, rank, POWERS, seed, &mut pass)?;
    // The other singular vectors are never formed: of `s_j v_j` only the lengths of its parts count.
    let packed = Packed::new(&vectors, rank);
    let mut squares = vec![[0.0; 2]; rank];
    let mut sum = 0.0;
    pass(&mut |data| {
        sum += data.iter().sum::<f64>();
        for column in project(&packed, data, rows, rank).chunks_exact(rank) {
            for (squares, v) in squares.iter_mut().zip(column) {
                squares[usize::from(*v < 0.0)] += v * v;
            }
        }
    })?;
    let mean = sum / (rows * count) as f64;

    let mut primitives = vec![mean; rank * rows];
    for (j, [positive, negative]) in squares.into_iter().enumerate() {
        let vector = || vectors.iter().skip(j).step_by(rank);
        let value = squared_values[j].sqrt();
        // The first pair is of one sign by Perron and Frobenius.
        let (sign, scale) = if j == 0 {
            (vector().sum::<f64>().signum(), value.sqrt())
        } else {
            let length = |sign: f64| {
                let part = vector().map(|u| (sign * u).max(0.0).powi(2));
                part.sum::<f64>().sqrt()
            };
            let (up, down) = (length(1.0), length(-1.0));
            // `value` times the product of the lengths, as `s v` has it in it already.
            let (with_up, with_down) = (up * positive.sqrt(), down * negative.sqrt());
            if with_up > with_down {
                (1.0, with_up.sqrt() / up)
            } else if with_down > 0.0 {
                (-1.0, with_down.sqrt() / down)
            } else {
                (1.0, 0.0)
            }
        };
        let largest = vector().fold(0.0_f64, |a, u| a.max(sign * u));
        for (numbers, u) in primitives.chunks_exact_mut(rank).zip(vector()) {
            let part = sign * u;
            if scale > 0.0 && part > ZERO * largest {
                numbers[j] = scale * part;
            }
        }
    }
    Ok(primitives)
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use serde_json::Value;

    use super::nndsvd;

    fn start(data: &[f64], rows: usize, rank: usize) -> Vec<f64> {
        nndsvd(rows, data.len() / rows, rank, 1, |see| {
            data.chunks(4 * rows).for_each(see);
            Ok::<(), Infallible>(())
        })
        .unwrap()
    }

    #[test]
    fn data_of_rank_one_come_back() {
        let (w, h) = ([0.5, 2.0, 1.0], [1.0, 3.0, 0.25, 2.0, 0.5]);
        let data: Vec<f64> = h.iter().flat_map(|h| w.map(|w| w * h)).collect();
        let found = start(&data, 3, 1);
        for (found, w) in found.iter().zip(w) {
            // V = s u vᵀ, and the primitive is sqrt(s) u.
            let norm = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
            let expected = w * (norm(&h) / norm(&[0.5, 2.0, 1.0])).sqrt();
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
        // What has no second direction starts as the mean.
        let mean = data.iter().sum::<f64>() / data.len() as f64;
        let two = start(&data, 3, 2);
        let scale = data.iter().fold(0.0_f64, |a, v| a.max(*v)).sqrt();
        for v in two.iter().skip(1).step_by(2) {
            assert!((v - mean).abs() < 1e-14 || *v < 1e-7 * scale, "{v} {mean}");
        }
    }

    #[test]
    fn blocks_of_one_sign_come_back() {
        // Two primitives that share no row and no segment: the singular vectors themselves.
        let w = [[3.0, 0.0], [4.0, 0.0], [0.0, 1.0], [0.0, 1.0]];
        let h = [[2.0, 0.0], [1.0, 0.0], [0.0, 0.5], [2.0, 0.0], [0.0, 1.5]];
        let data: Vec<f64> = h
            .iter()
            .flat_map(|h| w.map(|w| w[0] * h[0] + w[1] * h[1]))
            .collect();
        let mean = data.iter().sum::<f64>() / data.len() as f64;
        let found = start(&data, 4, 2);
        let (first, second) = (
            (3.0_f64 / 5.0).sqrt(),
            (2.5_f64.sqrt() / 2.0_f64.sqrt()).sqrt(),
        );
        for row in 0..4 {
            for j in 0..2 {
                let expected = match w[row][j] {
                    0.0 => mean,
                    w => w * if j == 0 { first } else { second },
                };
                let found = found[row * 2 + j];
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{row} {j}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn agrees_with_scikit_learn() {
        let text = include_str!("../tests/reference/reference.json");
        let reference = &serde_json::from_str::<Value>(text).unwrap()["nndsvd"];
        let numbers = |value: &Value| -> Vec<f64> {
            let columns = value.as_array().unwrap().iter();
            columns
                .flat_map(|column| column.as_array().unwrap())
                .map(|v| v.as_f64().unwrap())
                .collect()
        };
        let data = numbers(&reference["data"]);
        let expected = numbers(&reference["primitives_as_rows"]);
        let found = start(&data, 20, 4);
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-10, "{found} {expected}");
        }
    }
}
