//! Matrices in borrowed memory with explicit strides, their product, and the chunks they are cut into.

use std::ops::Range;

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
    pub(crate) rows: usize,
    pub(crate) columns: usize,
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

/// `out = a * b`.
///
/// Each number of `out` is summed in an order that depends on the common size of `a` and `b` alone.
pub(crate) fn multiply<T: Real>(a: View<'_, T>, b: View<'_, T>, out: &mut [T]) {
    gemm(T::ONE, a, b, T::ZERO, out);
}

/// `out -= a * b`, summed as [`multiply`] does.
pub(crate) fn subtract_product<T: Real>(a: View<'_, T>, b: View<'_, T>, out: &mut [T]) {
    gemm(-T::ONE, a, b, T::ONE, out);
}

/// `out = alpha * a * b + beta * out`.
fn gemm<T: Real>(alpha: T, a: View<'_, T>, b: View<'_, T>, beta: T, out: &mut [T]) {
    assert_eq!(a.columns, b.rows, "inner sizes of a product agree");
    assert!(a.extent() <= a.data.len(), "left operand inside its slice");
    assert!(b.extent() <= b.data.len(), "right operand inside its slice");
    if a.rows == 0 || b.columns == 0 {
        return;
    }
    assert!(b.columns * a.rows <= out.len(), "result inside its slice");
    #[expect(
        unsafe_code,
        reason = "matrixmultiply takes pointers; the three assertions above are its contract"
    )]
    // SAFETY: every index that the call reads or writes was checked against its slice above, and
    // `out` is borrowed mutably, so that it overlaps neither operand.
    unsafe {
        let out = (out.as_mut_ptr(), 1, a.rows as isize);
        let (a_at, b_at) = (a.pointer(), b.pointer());
        T::gemm(a.rows, a.columns, b.columns, alpha, a_at, b_at, beta, out);
    }
}
