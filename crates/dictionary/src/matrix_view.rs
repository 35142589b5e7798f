//! Matrices in borrowed memory with explicit strides, their product, and the chunks they are cut into.

use std::ops::Range;

use crate::real::Real;

/// Columns that one task handles, roughly: enough to make up for packing the other operand, few
/// enough that 600 columns feed several cores.
const CHUNK_COLUMNS: usize = 192;

/// Columns of a product that are summed together.
pub(crate) const STRIP: usize = 8;

/// Chunks come in multiples of this, so that two and four cores finish together.
const CHUNK_MULTIPLE: usize = 4;

/// Width of the chunks into which `count` columns are cut. It depends on nothing but `count`, so
/// that sums over chunks have the same bits whatever the number of threads. Chunks of many columns hold whole
/// strips of those that a product sums together.
pub(crate) fn chunk_width(count: usize) -> usize {
    let chunks = count
        .div_ceil(CHUNK_COLUMNS)
        .next_multiple_of(CHUNK_MULTIPLE);
    let width = count.div_ceil(chunks.max(1)).max(1);
    if width < STRIP {
        width
    } else {
        width.next_multiple_of(STRIP)
    }
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

/// Neighbouring columns of a matrix, where they are; what lies behind the last one is not told.
pub(crate) enum Strip<'a, T, const C: usize> {
    /// Columns without steps between their numbers.
    Columns([&'a [T]; C]),
    /// Rows without steps between their numbers, of which the first ones count.
    Rows {
        data: &'a [T],
        stride: usize,
        columns: usize,
    },
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

    /// `C` columns from number `column` on, of some of the rows.
    #[inline(always)]
    pub(crate) fn strip<const C: usize>(
        &self,
        rows: Range<usize>,
        column: usize,
    ) -> Strip<'a, T, C> {
        let data = &self.data[rows.start * self.row_stride + column * self.column_stride..];
        let last = self.columns - column - 1;
        if self.row_stride == 1 {
            let column = |place: usize| &data[place.min(last) * self.column_stride..][..rows.len()];
            Strip::Columns(std::array::from_fn(column))
        } else {
            Strip::Rows {
                data,
                stride: self.row_stride,
                columns: C.min(last + 1),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Operands as they are, transposed and cut out of larger ones. Small, so that Miri looks at every access of the call
    /// of matrixmultiply.
    #[test]
    fn products_are_those_of_the_definition() {
        for (m, k, n) in [(1, 1, 1), (2, 3, 4), (5, 1, 3), (9, 7, 5)] {
            let numbers: Vec<f64> = (0..(m + 1) * k.max(n) * k)
                .map(|i| i as f64 - 3.0)
                .collect();
            let left = View::columns(&numbers[..(m + 1) * k], m + 1).row_range(&(1..m + 1));
            let right = View::columns(&numbers[..n * k], n).transposed();
            let mut out = vec![1.0; m * n];
            subtract_product(left, right, &mut out);
            for (at, &found) in out.iter().enumerate() {
                let (i, j) = (at % m, at / m);
                let product = |l: usize| numbers[l * (m + 1) + i + 1] * numbers[l * n + j];
                let sum: f64 = (0..k).map(product).sum();
                assert_eq!(found, 1.0 - sum, "{m} x {k} x {n}");
            }
        }
    }

    #[test]
    #[should_panic(expected = "result inside its slice")]
    fn a_result_that_is_too_small_is_refused() {
        let numbers = [1.0; 4];
        let view = View::columns(&numbers, 2);
        multiply(view, view, &mut [0.0; 3]);
    }
}
