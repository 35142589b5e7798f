//! Products of a factor with the data, the factor packed once and shared by all chunks.
//!
//! A general matrix product copies both operands into the order in which its kernel reads them, each time it is
//! called. With 200 rows on one side and chunks of 150 columns on the other that takes a fifth of its time.
//! Here the factor is packed once for each half step, and the data is read where it is.

use rayon::prelude::*;

use crate::lanes::{Aligned, InstructionSet, Kernel, Lanes, lanes_multiply_add};
use crate::matrix_view::{STRIP, Strip, View, chunk_width};
use crate::real::Real;

/// Terms that are summed before the result is written: a strip of the right operand this deep stays
/// in the first cache, the left operand's slice in the second.
const DEPTH: usize = 256;

/// Registers of rows that are summed together with AVX-512: as many as it has for [`STRIP`] times their
/// number.
const WIDE: usize = 3;

/// A left operand (`rows` x `depth`) in panels of as many rows as one pass of the kernel sums, each
/// column by column, filled up with zeros.
#[derive(Clone, Debug)]
pub(crate) struct Packed<T> {
    set: InstructionSet,
    rows: usize,
    depth: usize,
    numbers: Aligned<T>,
}

impl<T: Real> Packed<T> {
    /// Packs whole columns of `rows` numbers.
    pub(crate) fn new(columns: &[T], rows: usize) -> Self {
        Self::for_set(columns, rows, InstructionSet::of_this_cpu())
    }

    fn for_set(columns: &[T], rows: usize, set: InstructionSet) -> Self {
        let (bytes, registers) = set.registers(WIDE);
        let width = registers * bytes / size_of::<T>();
        let depth = columns.len().checked_div(rows).unwrap_or(0);
        let length = rows.next_multiple_of(width) * depth;
        let numbers = Aligned::filled(length, |to| match width {
            48 => pack::<T, 48>(columns, rows, to),
            24 => pack::<T, 24>(columns, rows, to),
            8 => pack::<T, 8>(columns, rows, to),
            4 => pack::<T, 4>(columns, rows, to),
            _ => pack::<T, 2>(columns, rows, to),
        });
        Self {
            set,
            rows,
            depth,
            numbers,
        }
    }

    /// `out = self * right`, the columns of `out` one after the other.
    ///
    /// Each number of `out` is summed in an order that depends on the depth alone, the same for
    /// every CPU with fused multiply-add.
    pub(crate) fn times(&self, right: View<'_, T>, out: &mut [T]) {
        self.times_from(right, out, |_| 0);
    }

    /// The same, columns in parallel.
    pub(crate) fn times_all(&self, right: View<'_, T>, out: &mut [T]) {
        let width = chunk_width(right.columns);
        out.par_chunks_mut((width * self.rows).max(1))
            .enumerate()
            .for_each(|(chunk, out)| {
                let first = chunk * width;
                let columns = first..first + out.len() / self.rows;
                self.times(right.transposed().row_range(&columns).transposed(), out);
            });
    }

    /// `factor * factorᵀ` for the very factor that is packed.
    pub(crate) fn gram(&self, factor: &[T]) -> Vec<T> {
        let rank = self.rows;
        let mut out = vec![T::ZERO; rank * rank];
        let (width, factor) = (chunk_width(rank), View::columns(factor, rank));
        out.par_chunks_mut((width * rank).max(1))
            .enumerate()
            .for_each(|(chunk, out)| {
                let first = chunk * width;
                let columns = first..first + out.len() / rank;
                let right = factor.row_range(&columns).transposed();
                self.times_from(right, out, |column| first + column);
            });
        mirror_lower(&mut out, rank);
        out
    }

    /// The same as [`times`](Self::times), but of each strip of columns only from the panel on that holds row
    /// `first_row(column)` of its first column.
    fn times_from(&self, right: View<'_, T>, out: &mut [T], first_row: impl Fn(usize) -> usize) {
        assert_eq!(self.depth, right.rows, "inner sizes of a product agree");
        assert_eq!(out.len(), self.rows * right.columns, "size of a product");
        let product = Product {
            left: self,
            right,
            out,
            first_row: &first_row,
        };
        self.set.run::<T, WIDE, _>(product);
    }
}

/// Panels of `W` rows. The width is a constant so that a row of a panel is moved by a few instructions.
fn pack<T: Real, const W: usize>(columns: &[T], rows: usize, to: &mut Vec<T>) {
    for first in (0..rows).step_by(W) {
        for column in columns.chunks_exact(rows) {
            let from = &column[first..];
            if let Some(from) = from.first_chunk::<W>() {
                to.extend(from);
            } else {
                to.extend_from_slice(from);
                to.resize(to.len() + W - from.len(), T::ZERO);
            }
        }
    }
}

/// `factor * factorᵀ` (`rank` x `rank`) for a factor of `rank` rows: the lower triangle, and some of what
/// lies above it.
pub(crate) fn gram_lower<T: Real>(factor: &[T], rank: usize) -> Vec<T> {
    let mut out = vec![T::ZERO; rank * rank];
    let right = View::columns(factor, rank).transposed();
    Packed::new(factor, rank).times_from(right, &mut out, |column| column);
    out
}

/// Copies the lower triangle of a square matrix into the upper one.
pub(crate) fn mirror_lower<T: Real>(matrix: &mut [T], rank: usize) {
    for column in 0..rank {
        for row in column + 1..rank {
            matrix[row * rank + column] = matrix[column * rank + row];
        }
    }
}

/// The arguments of [`Packed::times_from`].
struct Product<'a, T> {
    left: &'a Packed<T>,
    right: View<'a, T>,
    out: &'a mut [T],
    first_row: &'a dyn Fn(usize) -> usize,
}

impl<T: Real> Kernel for Product<'_, T> {
    /// The product by slices of [`DEPTH`] terms, strips of [`STRIP`] columns, panels of rows.
    #[inline(always)]
    fn run<const L: usize, const V: usize, const FUSED: bool>(self) {
        let (rows, depth) = (self.left.rows, self.left.depth);
        let width = L * V;
        if rows == 0 || depth == 0 {
            self.out.fill(T::ZERO);
            return;
        }
        let panels = self.left.numbers.lanes::<L, V>();
        for start in (0..depth).step_by(DEPTH) {
            let count = DEPTH.min(depth - start);
            for (place, out) in self.out.chunks_mut(STRIP * rows).enumerate() {
                let column = place * STRIP;
                let skipped = (self.first_row)(column) / width;
                let strip = PanelStrip {
                    panels: &panels[skipped * depth..],
                    first_row: skipped * width,
                    depth,
                    start,
                    rows,
                    out,
                };
                match self.right.strip::<STRIP>(start..start + count, column) {
                    Strip::Columns(columns) => {
                        strip.sum::<FUSED>(count, |k| columns.map(|column| column[k]));
                    }
                    Strip::Rows {
                        data,
                        stride,
                        columns,
                    } if columns == STRIP => {
                        strip.sum::<FUSED>(count, |k| {
                            *data[k * stride..].first_chunk().expect("whole rows")
                        });
                    }
                    Strip::Rows {
                        data,
                        stride,
                        columns,
                    } => {
                        strip.sum::<FUSED>(count, |k| {
                            let mut numbers = [T::ZERO; STRIP];
                            numbers[..columns].copy_from_slice(&data[k * stride..][..columns]);
                            numbers
                        });
                    }
                }
            }
        }
    }
}

/// A strip of the result and the panels that it is summed from.
struct PanelStrip<'a, T, const L: usize, const V: usize> {
    panels: &'a [Lanes<T, L, V>],
    /// Row of the result that the first panel starts at.
    first_row: usize,
    /// Columns of a panel.
    depth: usize,
    /// The first of them that counts.
    start: usize,
    /// Rows of the result.
    rows: usize,
    out: &'a mut [T],
}

impl<T: Real, const L: usize, const V: usize> PanelStrip<'_, T, L, V> {
    /// Adds `count` terms; `right` gives the right operand's numbers of one.
    #[inline(always)]
    fn sum<const FUSED: bool>(self, count: usize, right: impl Fn(usize) -> [T; STRIP]) {
        for (panel, left) in self.panels.chunks_exact(self.depth).enumerate() {
            let left = &left[self.start..][..count];
            let first = self.first_row + panel * L * V;
            // The last panel may need one register only.
            if first + L < self.rows {
                let sums = tile::<T, L, V, V, FUSED>(left, &right);
                write(&sums, first, self.start, self.rows, self.out);
            } else {
                let sums = tile::<T, L, V, 1, FUSED>(left, &right);
                write(&sums, first, self.start, self.rows, self.out);
            }
        }
    }
}

/// Adds a tile to the result, from row number `first` on; the terms from 0 on are the first.
#[inline(always)]
fn write<T: Real, const L: usize, const U: usize>(
    sums: &[Lanes<T, L, U>; STRIP],
    first: usize,
    start: usize,
    rows: usize,
    out: &mut [T],
) {
    for (out, sums) in out.chunks_exact_mut(rows).zip(sums) {
        let (out, sums) = (out[first..].iter_mut(), sums.as_flattened());
        if start == 0 {
            out.zip(sums).for_each(|(out, sum)| *out = *sum);
        } else {
            out.zip(sums).for_each(|(out, sum)| *out += *sum);
        }
    }
}

/// Sums of one tile of the result, of the first `U` registers of rows. The columns are written out, because a loop over them leaves the
/// sums in memory.
#[inline(always)]
fn tile<T: Real, const L: usize, const V: usize, const U: usize, const FUSED: bool>(
    left: &[Lanes<T, L, V>],
    right: &impl Fn(usize) -> [T; STRIP],
) -> [Lanes<T, L, U>; STRIP] {
    let zero = [[T::ZERO; L]; U];
    let [mut a, mut b, mut c, mut d, mut e, mut f, mut g, mut h] = [zero; STRIP];
    for (k, left) in left.iter().enumerate() {
        let right = right(k);
        let left = left.first_chunk().expect("U is not above V");
        lanes_multiply_add::<T, L, U, FUSED>(right[0], left, &mut a);
        lanes_multiply_add::<T, L, U, FUSED>(right[1], left, &mut b);
        lanes_multiply_add::<T, L, U, FUSED>(right[2], left, &mut c);
        lanes_multiply_add::<T, L, U, FUSED>(right[3], left, &mut d);
        lanes_multiply_add::<T, L, U, FUSED>(right[4], left, &mut e);
        lanes_multiply_add::<T, L, U, FUSED>(right[5], left, &mut f);
        lanes_multiply_add::<T, L, U, FUSED>(right[6], left, &mut g);
        lanes_multiply_add::<T, L, U, FUSED>(right[7], left, &mut h);
    }
    [a, b, c, d, e, f, g, h]
}

#[cfg(test)]
mod tests {
    use super::{DEPTH, Packed, gram_lower};
    use crate::lanes::InstructionSet;
    use crate::matrix_view::{View, multiply};
    use crate::real::Real;

    fn numbers<T: Real>(count: usize, step: f64) -> Vec<T> {
        (0..count).map(|i| T::of((step * i as f64).sin())).collect()
    }

    fn sets() -> Vec<InstructionSet> {
        let mut sets = vec![InstructionSet::of_this_cpu()];
        #[cfg(target_arch = "x86_64")]
        if sets[0] == InstructionSet::Avx512 {
            sets.push(InstructionSet::Fma);
        }
        sets.push(InstructionSet::Base);
        sets
    }

    /// The product by every instruction set against the general one, both ways round of the right operand.
    fn check<T: Real>(rows: usize, depth: usize, columns: usize, tolerance: f64) {
        let left: Vec<T> = numbers(rows * depth, 0.7);
        let right: Vec<T> = numbers(depth * columns, 0.3);
        let turned: Vec<T> = (0..depth * columns)
            .map(|i| right[i / columns + i % columns * depth])
            .collect();
        let straight = View::columns(&right, depth);
        let mut expected = vec![T::ZERO; rows * columns];
        multiply(View::columns(&left, rows), straight, &mut expected);
        let mut first: Option<Vec<T>> = None;
        for set in sets() {
            let packed = Packed::for_set(&left, rows, set);
            let mut found = vec![T::of(f64::NAN); rows * columns];
            packed.times(straight, &mut found);
            for (found, expected) in found.iter().zip(&expected) {
                let difference = (*found - *expected).to_f64().abs();
                assert!(difference < tolerance, "{set:?}: {found:?} {expected:?}");
            }
            let mut other = vec![T::of(f64::NAN); rows * columns];
            packed.times(View::columns(&turned, columns).transposed(), &mut other);
            assert_eq!(found, other, "{set:?}, transposed");
            // Fused multiply-add rounds the same whatever the width of the registers.
            if set != InstructionSet::Base {
                assert_eq!(*first.get_or_insert(found.clone()), found, "{set:?}");
            }
        }
    }

    #[test]
    fn agrees_with_the_general_product() {
        // Around the sizes of panels, strips, groups of strips and slices.
        for (rows, depth, columns) in [
            (1, 1, 1),
            (2, 3, 9),
            (23, 7, 8),
            (24, DEPTH, 65),
            (25, DEPTH + 1, 17),
            (49, 2 * DEPTH + 30, 71),
            (200, 40, 130),
        ] {
            check::<f64>(rows, depth, columns, 1e-12);
            check::<f32>(rows, depth, columns, 2e-4);
        }
    }

    #[test]
    fn an_empty_factor_makes_an_empty_product() {
        let mut out: Vec<f64> = Vec::new();
        Packed::new(&[], 3).times(View::columns(&[], 0), &mut out);
        assert!(out.is_empty());
        assert!(gram_lower::<f64>(&[], 2).iter().all(|v| *v == 0.0));
    }

    #[test]
    fn lower_triangles_are_symmetric_products() {
        for (rank, count) in [(1, 5), (8, 3), (30, 300), (57, 40)] {
            let factor: Vec<f64> = numbers(rank * count, 0.9);
            let view = View::columns(&factor, rank);
            let mut expected = vec![0.0; rank * rank];
            multiply(view, view.transposed(), &mut expected);
            let found = gram_lower(&factor, rank);
            for column in 0..rank {
                for row in column..rank {
                    let i = column * rank + row;
                    assert!((found[i] - expected[i]).abs() < 1e-12, "{row} {column}");
                }
            }
        }
    }
}
