//! Dense products with explicit strides, split over fixed chunks of columns.
//!
//! Everything is column-major. A transposed operand is a stride, never a copy, and never nalgebra's
//! `tr_mul`, which is several times slower than the product itself.

use std::ops::Range;

use rayon::prelude::*;

use crate::packed::{Packed, gram_lower};
use crate::real::Real;

/// Columns that one task handles, roughly: enough to make up for packing the other operand, few
/// enough that 600 columns feed several cores.
const CHUNK_COLUMNS: usize = 192;

/// Chunks come in multiples of this, so that two and four cores finish together.
const CHUNK_MULTIPLE: usize = 4;

/// Width of the chunks into which `count` columns are cut. It depends on nothing but `count`, so
/// that sums over chunks have the same bits whatever the number of threads.
pub(crate) fn chunk_width(count: usize) -> usize {
    let chunks = count
        .div_ceil(CHUNK_COLUMNS)
        .next_multiple_of(CHUNK_MULTIPLE);
    count.div_ceil(chunks.max(1)).max(1)
}

/// A matrix in borrowed memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View<'a, T> {
    data: &'a [T],
    rows: usize,
    columns: usize,
    row_stride: usize,
    column_stride: usize,
}

impl<'a, T: Real> View<'a, T> {
    /// Whole columns of `rows` numbers, one after the other.
    pub(crate) fn columns(data: &'a [T], rows: usize) -> Self {
        Self {
            data,
            rows,
            columns: data.len().checked_div(rows).unwrap_or(0),
            row_stride: 1,
            column_stride: rows,
        }
    }

    /// The same numbers with rows and columns exchanged.
    pub(crate) const fn transposed(self) -> Self {
        Self {
            data: self.data,
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
        }
    }

    /// Some of the rows.
    pub(crate) fn row_range(self, range: &Range<usize>) -> Self {
        assert!(range.end <= self.rows, "row range inside the matrix");
        Self {
            data: &self.data[range.start * self.row_stride..],
            rows: range.len(),
            ..self
        }
    }

    /// Number of rows.
    pub(crate) const fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub(crate) const fn column_count(&self) -> usize {
        self.columns
    }

    /// Copies columns from number `column` on, `C` at a time, of `count` rows from number `row` on, into
    /// strips one after the other: row after row, with zeros for columns that do not exist. Strips without any
    /// column stay as they are.
    #[inline(always)]
    pub(crate) fn strips<const C: usize>(
        &self,
        row: usize,
        column: usize,
        strips: &mut [[T; C]],
        count: usize,
    ) {
        let columns = self.columns - column;
        let data = &self.data[row * self.row_stride + column * self.column_stride..];
        if self.column_stride == 1 {
            for (k, from) in data.chunks(self.row_stride).take(count).enumerate() {
                let from = &from[..columns.min(strips.len() / count * C)];
                let (whole, rest) = from.as_chunks();
                for (to, from) in strips.iter_mut().skip(k).step_by(count).zip(whole) {
                    *to = *from;
                }
                if !rest.is_empty() {
                    let to = &mut strips[whole.len() * count + k];
                    *to = [T::ZERO; C];
                    to[..rest.len()].copy_from_slice(rest);
                }
            }
        } else {
            for (strip, to) in strips.chunks_exact_mut(count).enumerate() {
                let Some(left) = columns.checked_sub(strip * C).filter(|left| *left > 0) else {
                    break;
                };
                // All columns at once: their cache lines arrive together.
                let from: [&[T]; C] = std::array::from_fn(|place| {
                    let column = strip * C + place.min(left - 1);
                    &data[column * self.column_stride..][..(count - 1) * self.row_stride + 1]
                });
                for (k, to) in to.iter_mut().enumerate() {
                    for place in 0..C {
                        to[place] = from[place][k * self.row_stride];
                    }
                }
                if left < C {
                    for to in to {
                        to[left..].fill(T::ZERO);
                    }
                }
            }
        }
    }

    /// Where the numbers are, with the strides of rows and columns.
    const fn pointer(&self) -> (*const T, isize, isize) {
        (
            self.data.as_ptr(),
            self.row_stride as isize,
            self.column_stride as isize,
        )
    }

    /// One past the last index that is read.
    fn extent(&self) -> usize {
        if self.rows == 0 || self.columns == 0 {
            0
        } else {
            (self.rows - 1) * self.row_stride + (self.columns - 1) * self.column_stride + 1
        }
    }
}

/// `out = alpha * a * b + beta * out`, where the columns of `out` start `out_stride` numbers apart.
///
/// Each number of `out` is summed in an order that depends on the common size of `a` and `b` alone.
pub(crate) fn multiply<T: Real>(
    alpha: T,
    a: View<'_, T>,
    b: View<'_, T>,
    beta: T,
    out: &mut [T],
    out_stride: usize,
) {
    assert_eq!(a.columns, b.rows, "inner sizes of a product agree");
    assert!(a.extent() <= a.data.len(), "left operand inside its slice");
    assert!(b.extent() <= b.data.len(), "right operand inside its slice");
    if a.rows == 0 || b.columns == 0 {
        return;
    }
    assert!(a.rows <= out_stride, "columns of the result do not overlap");
    assert!(
        (b.columns - 1) * out_stride + a.rows <= out.len(),
        "result inside its slice"
    );
    #[expect(
        unsafe_code,
        reason = "matrixmultiply takes pointers; the three assertions above are its contract"
    )]
    // SAFETY: every index that the call reads or writes was checked against its slice above, and
    // `out` is borrowed mutably, so that it overlaps neither operand.
    unsafe {
        T::gemm(
            a.rows,
            a.columns,
            b.columns,
            alpha,
            a.pointer(),
            b.pointer(),
            beta,
            (out.as_mut_ptr(), 1, out_stride as isize),
        );
    }
}

/// `factor * factorᵀ` (`rank` x `rank`) for a factor of `rank` rows, summed in chunk order.
pub(crate) fn gram<T: Real>(factor: &[T], rank: usize) -> Vec<T> {
    let width = chunk_width(factor.len() / rank.max(1));
    let parts: Vec<Vec<T>> = factor
        .par_chunks(width * rank)
        .map(|chunk| gram_lower(chunk, rank))
        .collect();
    sum_lower(parts, rank)
}

/// Sums lower triangles in order and mirrors the result.
pub(crate) fn sum_lower<T: Real>(parts: Vec<Vec<T>>, rank: usize) -> Vec<T> {
    let mut parts = parts.into_iter();
    let mut total = parts.next().unwrap_or_else(|| vec![T::ZERO; rank * rank]);
    for part in parts {
        add(&mut total, &part);
    }
    for column in 0..rank {
        for row in column + 1..rank {
            total[row * rank + column] = total[column * rank + row];
        }
    }
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
            multiply(
                -T::ONE,
                View::columns(basis, rank).transposed(),
                View::columns(activations, rank),
                T::ONE,
                &mut difference,
                rows,
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

/// Sum of squares, in double precision whatever the numbers.
pub(crate) fn squared_norm<T: Real>(a: &[T]) -> f64 {
    dot(a, a)
}
