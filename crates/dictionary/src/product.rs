//! Dense products with explicit strides, split over fixed chunks of columns.
//!
//! Everything is column-major. A transposed operand is a stride, never a copy, and never nalgebra's
//! `tr_mul`, which is several times slower than the product itself.

use rayon::prelude::*;

use crate::matrix_view::{View, chunk_width, subtract_product};
use crate::packed::{Packed, mirror_lower};
use crate::real::Real;

/// `factor * factorᵀ` (`rank` x `rank`) for a factor of `rank` rows.
pub(crate) fn gram<T: Real>(factor: &[T], rank: usize) -> Vec<T> {
    Packed::new(factor, rank).gram(factor)
}

/// Sums lower triangles in order and mirrors the result.
pub(crate) fn sum_lower<T: Real>(parts: Vec<Vec<T>>, rank: usize) -> Vec<T> {
    let mut parts = parts.into_iter();
    let mut total = parts.next().unwrap_or_else(|| vec![T::ZERO; rank * rank]);
    for part in parts {
        add(&mut total, &part);
    }
    mirror_lower(&mut total, rank);
    total
}

/// `activations * dataᵀ` (`rank` x rows of `data`), rows of the data in parallel.
pub(crate) fn cross<T: Real>(activations: &[T], rank: usize, data: &[T], rows: usize) -> Vec<T> {
    let mut out = vec![T::ZERO; rank * rows];
    let (left, right) = (Packed::new(activations, rank), View::columns(data, rows));
    let width = chunk_width(rows);
    out.par_chunks_mut(width * rank)
        .enumerate()
        .for_each(|(chunk, out)| {
            let range = chunk * width..(chunk * width + out.len() / rank);
            left.times(right.row_range(&range).transposed(), out);
        });
    out
}

/// Squared Frobenius norm of `data - basisᵀ * activations`, computed from the differences
/// themselves, summed in chunk order. `basis` is `rank` x rows, `activations` `rank` x columns.
pub(crate) fn squared_residual<T: Real>(
    data: &[T],
    rows: usize,
    basis: &[T],
    activations: &[T],
    rank: usize,
) -> f64 {
    let width = chunk_width(data.len() / rows.max(1));
    let parts: Vec<f64> = data
        .par_chunks(width * rows)
        .zip(activations.par_chunks(width * rank))
        .map(|(data, activations)| {
            let mut difference = data.to_vec();
            subtract_product(
                View::columns(basis, rank).transposed(),
                View::columns(activations, rank),
                &mut difference,
            );
            squared_norm(&difference)
        })
        .collect();
    parts.iter().sum()
}

/// `into += from`, element by element; sums of either kind of number from either.
pub(crate) fn add<A: Real, B: Real>(into: &mut [A], from: &[B]) {
    for (into, from) in into.iter_mut().zip(from) {
        *into += A::of(from.to_f64());
    }
}

/// Independent partial sums of [`dot`]; eight keep the vector units busy and shorten the chain of
/// roundings.
const LANES: usize = 8;

/// Scalar product with [`LANES`] partial sums, in an order that depends on the length alone, and in
/// double precision whatever the numbers.
pub(crate) fn dot<T: Real>(a: &[T], b: &[T]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a_lanes, a_rest) = a.as_chunks::<LANES>();
    let (b_lanes, b_rest) = b.as_chunks::<LANES>();
    for (a, b) in a_lanes.iter().zip(b_lanes) {
        for lane in 0..LANES {
            sums[lane] += a[lane].to_f64() * b[lane].to_f64();
        }
    }
    let rest: f64 = a_rest
        .iter()
        .zip(b_rest)
        .map(|(a, b)| a.to_f64() * b.to_f64())
        .sum();
    sums.iter().sum::<f64>() + rest
}

/// Sum of all numbers, as [`dot`] adds.
pub(crate) fn sum<T: Real>(a: &[T]) -> f64 {
    let mut sums = [0.0; LANES];
    let (lanes, rest) = a.as_chunks::<LANES>();
    for numbers in lanes {
        for lane in 0..LANES {
            sums[lane] += numbers[lane].to_f64();
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|v| v.to_f64()).sum::<f64>()
}

/// Sum of squares, in double precision whatever the numbers.
pub(crate) fn squared_norm<T: Real>(a: &[T]) -> f64 {
    dot(a, a)
}
