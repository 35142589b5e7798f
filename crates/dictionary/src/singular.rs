//! Leading singular vectors of data that is read block by block.

use nalgebra::DMatrix;

use crate::matrix_view::View;
use crate::packed::Packed;
use crate::pca::{eigen_descending, transpose};
use crate::product::{add, cross, dot, gram, squared_norm};
use crate::random::{keyed, uniform};

/// Directions carried along beside those wanted: the last ones wanted settle by the gap to the first one
/// that is not carried (Halko, Martinsson and Tropp 2011, section 4.2).
const OVERSAMPLING: usize = 10;

/// Keeps the random numbers of directions apart from others of the same seed.
const DIRECTION_KEYS: u64 = 0x5349_4e47_554c_4152;

/// The `wanted` leading left singular vectors of a matrix `V` (rows x n) as orthonormal rows (wanted x rows) and
/// the squares of their singular values, largest first, by randomised subspace iteration (Halko, Martinsson
/// and Tropp 2011, "Finding structure with randomness", algorithm 4.4, with `V Vᵀ` as the matrix):
/// `powers` times the directions are multiplied by `V Vᵀ` and made orthonormal, then turned so that
/// they diagonalise it. `pass` shows every block of columns to its argument, in block order; it is
/// called `powers + 1` times. `count` is the number of columns.
///
/// Exact to rounding where `wanted` and ten more reach the smaller side of `V`; otherwise direction
/// `j` is wrong by about `(s_l / s_j)^(2 powers)`, `s_l` the first singular value not carried along. Vectors of
/// singular values below 1e-8 of the largest are rounding.
///
/// Cost: `powers + 1` times `4 rows n wanted` operations.
pub(crate) fn leading<E>(
    rows: usize,
    count: usize,
    wanted: usize,
    powers: usize,
    seed: u64,
    mut pass: impl FnMut(&mut dyn FnMut(&[f64])) -> Result<(), E>,
) -> Result<(Vec<f64>, Vec<f64>), E> {
    let smaller = rows.min(count);
    let carried = (wanted + OVERSAMPLING).min(smaller);
    let wanted = wanted.min(carried);
    // As rows (carried x rows): what the products with the data take.
    let mut directions: Vec<f64> = (0..rows)
        .flat_map(|row| {
            let mut random = keyed(seed ^ DIRECTION_KEYS, row);
            let numbers = (0..carried).map(move |_| 2.0 * uniform(&mut random) - 1.0);
            numbers.collect::<Vec<_>>()
        })
        .collect();
    for _ in 0..powers {
        let packed = Packed::new(&directions, carried);
        let mut image: Vec<f64> = vec![0.0; carried * rows];
        pass(&mut |data| {
            let projected = project(&packed, data, rows, carried);
            add(&mut image, &cross(&projected, carried, data, rows));
        })?;
        let mut columns = transpose(&image, carried);
        orthonormalise(&mut columns, rows);
        directions = transpose(&columns, rows);
    }
    let packed = Packed::new(&directions, carried);
    let mut squares: Vec<f64> = vec![0.0; carried * carried];
    pass(&mut |data| {
        let projected = project(&packed, data, rows, carried);
        add(&mut squares, &gram(&projected, carried));
    })?;
    let (values, turns) = eigen_descending(DMatrix::from_vec(carried, carried, squares));
    let turn = turns.columns(0, wanted).transpose();
    let mut vectors = vec![0.0; wanted * rows];
    Packed::new(turn.as_slice(), wanted).times(View::columns(&directions, carried), &mut vectors);
    let squared_values = values[..wanted].iter().map(|v| v.max(0.0));
    Ok((vectors, squared_values.collect()))
}

/// Share of a direction that is left when those before it are taken away, below which it is
/// rounding: the data have no further direction.
const SMALLEST_SHARE: f64 = 1e-12;

/// Gram-Schmidt, twice. Directions that depend on those before become zero.
fn orthonormalise(columns: &mut [f64], rows: usize) {
    for last in 0..columns.len() / rows {
        let (done, rest) = columns.split_at_mut(last * rows);
        let column = &mut rest[..rows];
        let mut least = SMALLEST_SHARE * squared_norm(column).sqrt();
        for _ in 0..2 {
            for other in done.chunks_exact(rows) {
                let along = dot(other, column);
                for (v, other) in column.iter_mut().zip(other) {
                    *v -= along * other;
                }
            }
            let length = squared_norm(column).sqrt();
            let scale = if length > least { length.recip() } else { 0.0 };
            for v in column.iter_mut() {
                *v *= scale;
            }
            least = SMALLEST_SHARE;
        }
    }
}

/// Directions times the data of a block (number of directions x columns).
pub(crate) fn project(packed: &Packed<f64>, data: &[f64], rows: usize, number: usize) -> Vec<f64> {
    let mut out = vec![0.0; data.len() / rows.max(1) * number];
    packed.times_all(View::columns(data, rows), &mut out);
    out
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use nalgebra::DMatrix;

    use super::leading;

    /// A matrix with these singular values, and the vectors to the left.
    fn with_values(rows: usize, count: usize, values: &[f64]) -> (DMatrix<f64>, DMatrix<f64>) {
        let some = |n: usize, step: f64| {
            let numbers = DMatrix::from_fn(n, values.len(), |r, c| {
                (step * (r * values.len() + c + 1) as f64).sin()
            });
            numbers.qr().q()
        };
        let (u, v) = (some(rows, 1.3), some(count, 0.9));
        let diagonal = DMatrix::from_diagonal(&nalgebra::DVector::from_column_slice(values));
        (&u * diagonal * v.transpose(), u)
    }

    fn check(rows: usize, count: usize, values: &[f64], wanted: usize, powers: usize) {
        let (data, u) = with_values(rows, count, values);
        // In blocks of seven columns.
        let (vectors, squared_values) = leading(rows, count, wanted, powers, 3, |see| {
            data.as_slice().chunks(7 * rows).for_each(see);
            Ok::<(), Infallible>(())
        })
        .unwrap();
        let vectors = DMatrix::from_column_slice(wanted, rows, &vectors);
        let unit = &vectors * vectors.transpose();
        assert!((unit - DMatrix::identity(wanted, wanted)).amax() < 1e-12);
        for (j, value) in values.iter().enumerate().take(wanted) {
            let relative = squared_values[j] / (value * value) - 1.0;
            assert!(relative.abs() < 1e-10, "{j}: {relative}");
            let cosine = (vectors.row(j) * u.column(j))[(0, 0)].abs();
            assert!((cosine - 1.0).abs() < 1e-9, "{j}: {cosine}");
        }
    }

    #[test]
    fn known_values_and_vectors_are_found() {
        // Everything is carried along: exact.
        check(12, 30, &[5.0, 3.0, 1.0, 0.2], 4, 1);
        check(40, 11, &[5.0, 3.0, 1.0, 0.2], 4, 2);
        // Of falling singular values the leading ones settle by the gap to those not carried.
        let falling: Vec<f64> = (0..40).map(|j| 0.7_f64.powi(j)).collect();
        check(60, 50, &falling, 5, 4);
        check(50, 60, &falling, 5, 4);
    }
}
