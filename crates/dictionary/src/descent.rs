//! The inner loop of HALS: exact minimisation over one coordinate after the other.
//!
//! For a factor `X` (`rank` x count) with Gram matrix `G` and linear term `P`, one sweep runs
//! through `j = 0..rank` and sets, in every column,
//!
//! ```text
//! x_j <- max(0, x_j + (p_j - sum_l G_jl x_l) / G_jj)
//! ```
//!
//! which is the minimiser of `1/2 xᵀ G x - pᵀ x` over `x_j >= 0` (Cichocki and Phan 2009; the same
//! update as NNLS by coordinate descent). Columns are independent, so a tile of them fills the lanes
//! of a vector register and goes through the coordinates together. Coordinates are taken in blocks
//! of [`BLOCK`]: the sums over all `l` are formed for a whole block at once, with the numbers as
//! they were before the block, and corrected inside the block for the coordinates already changed.
//! That is the same update in another order of summation, with every loaded number used
//! [`BLOCK`] times.

use rayon::prelude::*;

use crate::lanes::{Aligned, InstructionSet, Kernel, Lanes, lanes_multiply_add, multiply_add};
use crate::matrix_view::chunk_width;
use crate::product::squared_norm;
use crate::real::Real;

/// Coordinates whose gradients are formed together: eight accumulators of one vector each.
const BLOCK: usize = 8;

/// A Gram matrix padded to whole blocks of coordinates, with the inverse of its diagonal.
#[derive(Clone, Debug)]
pub(crate) struct Gram<T> {
    rank: usize,
    padded: usize,
    /// Panels of [`BLOCK`] rows, one after the other, each column by column: the numbers in the
    /// order in which a sweep reads them. `padded` x `padded`, zero outside `rank` x `rank`.
    values: Vec<T>,
    /// `1 / G_jj`; zero where that is not a positive finite number, which leaves the coordinate
    /// as it is.
    inverse_diagonal: Vec<T>,
}

impl<T: Real> Gram<T> {
    /// Pads a symmetric matrix of `rank` x `rank` numbers, with `ridge` added to its diagonal: the
    /// weight of a penalty of half the squares.
    pub(crate) fn new(symmetric: &[T], rank: usize, ridge: T) -> Self {
        let padded = rank.next_multiple_of(BLOCK);
        let mut values = vec![T::ZERO; padded * padded];
        let mut inverse_diagonal = vec![T::ZERO; padded];
        for column in 0..rank {
            let numbers = &symmetric[column * rank..][..rank];
            for (panel, numbers) in values
                .chunks_exact_mut(BLOCK * padded)
                .zip(numbers.chunks(BLOCK))
            {
                panel[column * BLOCK..][..numbers.len()].copy_from_slice(numbers);
            }
            let diagonal = numbers[column] + ridge;
            values[(column - column % BLOCK) * padded + column * BLOCK + column % BLOCK] = diagonal;
            let inverse = diagonal.recip();
            if inverse.is_finite() && inverse > T::ZERO {
                inverse_diagonal[column] = inverse;
            }
        }
        Self {
            rank,
            padded,
            values,
            inverse_diagonal,
        }
    }
}

/// Sweeps over a factor in parallel chunks of columns.
pub(crate) fn descend_all<T: Real>(
    gram: &Gram<T>,
    linear: &[T],
    l1: T,
    factor: &mut [T],
    sweeps: usize,
) {
    let rank = gram.rank;
    let width = chunk_width(factor.len() / rank.max(1));
    factor
        .par_chunks_mut(width * rank)
        .zip(linear.par_chunks(width * rank))
        .for_each(|(factor, linear)| descend(gram, linear, l1, factor, sweeps));
}

/// Minimises `1/2 hᵀ G h - pᵀ h` over `h >= 0` for each column, from the start that `factor` holds, until as
/// many sweeps as lie between two checks change it by less than a share of its length.
pub(crate) fn descend_until(
    gram: &Gram<f64>,
    linear: &[f64],
    factor: &mut [f64],
    (checks, sweeps): (usize, usize),
    smallest_change: f64,
) {
    let mut previous = factor.to_vec();
    for _ in 0..checks {
        descend_all(gram, linear, 0.0, factor, sweeps);
        for (previous, now) in previous.iter_mut().zip(&*factor) {
            *previous -= now;
        }
        let change = squared_norm(&previous);
        if change <= smallest_change * smallest_change * squared_norm(factor) {
            return;
        }
        previous.copy_from_slice(factor);
    }
}

/// Sweeps over the columns of `factor` (`rank` x count) with the linear terms `linear` of the same
/// shape, less the weight `l1` of a penalty on their sum, in place. Each column's result depends on
/// that column alone.
pub(crate) fn descend<T: Real>(
    gram: &Gram<T>,
    linear: &[T],
    l1: T,
    factor: &mut [T],
    sweeps: usize,
) {
    let descent = Descent {
        gram,
        linear,
        l1,
        factor,
        sweeps,
    };
    // Lanes do not change a column's numbers: all instruction sets with fused multiply-add agree to the bit.
    InstructionSet::of_this_cpu().run::<T, 2, _>(descent);
}

/// The arguments of [`descend`].
struct Descent<'a, T> {
    gram: &'a Gram<T>,
    linear: &'a [T],
    l1: T,
    factor: &'a mut [T],
    sweeps: usize,
}

impl<T: Real> Kernel for Descent<'_, T> {
    /// Cuts the columns into tiles of `L * V`; the last one is filled up with zeros, which stay zeros.
    #[inline(always)]
    fn run<const L: usize, const V: usize, const FUSED: bool>(self) {
        let rank = self.gram.rank;
        let mut x = Aligned::zeros(self.gram.padded * L * V);
        let mut p = Aligned::zeros(self.gram.padded * L * V);
        let (x, p) = (x.lanes_mut::<L, V>(), p.lanes_mut::<L, V>());
        let width = L * V * rank;
        for (factor, linear) in self.factor.chunks_mut(width).zip(self.linear.chunks(width)) {
            load(x, factor, rank);
            load(p, linear, rank);
            for p in p.iter_mut().take(rank).flatten().flatten() {
                *p -= self.l1;
            }
            for _ in 0..self.sweeps {
                sweep_tile::<T, L, V, FUSED>(self.gram, p, x);
            }
            for (place, column) in factor.chunks_exact_mut(rank).enumerate() {
                for (to, from) in column.iter_mut().zip(&*x) {
                    *to = from[place / L][place % L];
                }
            }
        }
    }
}

/// Columns into lanes.
#[inline(always)]
fn load<T: Real, const L: usize, const V: usize>(
    tile: &mut [Lanes<T, L, V>],
    columns: &[T],
    rank: usize,
) {
    for place in 0..L * V {
        if let Some(column) = columns.get(place * rank..(place + 1) * rank) {
            for (to, from) in tile.iter_mut().zip(column) {
                to[place / L][place % L] = *from;
            }
        } else {
            for to in tile.iter_mut() {
                to[place / L][place % L] = T::ZERO;
            }
        }
    }
}

/// One sweep over all coordinates of a tile.
#[inline(always)]
fn sweep_tile<T: Real, const L: usize, const V: usize, const FUSED: bool>(
    gram: &Gram<T>,
    p: &[Lanes<T, L, V>],
    x: &mut [Lanes<T, L, V>],
) {
    let panels = gram.values.chunks_exact(BLOCK * gram.padded.max(1));
    for (block, panel) in panels.enumerate() {
        let first = block * BLOCK;
        // Products G x of the block's coordinates.
        let (panel, _) = panel.as_chunks::<BLOCK>();
        let mut product = [[[T::ZERO; L]; V]; BLOCK];
        for (g, x) in panel.iter().zip(x.iter()) {
            for (product, g) in product.iter_mut().zip(g) {
                lanes_multiply_add::<T, L, V, FUSED>(*g, x, product);
            }
        }
        // Written out: a loop over the coordinates leaves the products in memory.
        macro_rules! descend {
            ($row:expr, $product:ident $(, $later:ident)*) => {
                let j = first + $row;
                let _change = coordinate::<T, L, V, FUSED>(
                    gram.inverse_diagonal[j], &p[j], &$product, &mut x[j],
                );
                correct!(&panel[j], _change, $row + 1 $(, $later)*);
                descend!($row + 1 $(, $later)*);
            };
            ($row:expr) => {};
        }
        macro_rules! correct {
            ($gram:expr, $change:ident, $later:expr, $product:ident $(, $rest:ident)*) => {
                lanes_multiply_add::<T, L, V, FUSED>($gram[$later], &$change, &mut $product);
                correct!($gram, $change, $later + 1 $(, $rest)*);
            };
            ($gram:expr, $change:ident, $later:expr) => {};
        }
        let [a, mut b, mut c, mut d, mut e, mut f, mut g, mut h] = product;
        descend!(0, a, b, c, d, e, f, g, h);
    }
}

/// Sets one coordinate of all columns to its minimiser, and returns by how much it changed.
#[inline(always)]
fn coordinate<T: Real, const L: usize, const V: usize, const FUSED: bool>(
    inverse: T,
    p: &Lanes<T, L, V>,
    product: &Lanes<T, L, V>,
    x: &mut Lanes<T, L, V>,
) -> Lanes<T, L, V> {
    let mut change = [[T::ZERO; L]; V];
    for v in 0..V {
        for lane in 0..L {
            let old = x[v][lane];
            let free = multiply_add::<T, FUSED>(p[v][lane] - product[v][lane], inverse, old);
            let new = if free > T::ZERO { free } else { T::ZERO };
            change[v][lane] = new - old;
            x[v][lane] = new;
        }
    }
    change
}

#[cfg(test)]
mod tests {
    use super::{Descent, Gram, Kernel as _};

    #[test]
    fn every_instruction_set_gives_the_same_numbers() {
        // A diagonally dominant matrix, with linear terms of both signs.
        let rank = 21_usize;
        let gram: Vec<f64> = (0..rank * rank)
            .map(|i| match (i / rank).abs_diff(i % rank) {
                0 => 3.0,
                distance => 1.0 / (1 + distance) as f64,
            })
            .collect();
        let gram = Gram::new(&gram, rank, 0.25);
        let linear: Vec<f64> = (0..rank * 13).map(|i| (0.7 * i as f64).sin()).collect();
        let run = |run: fn(Descent<'_, f64>)| {
            let mut factor = vec![0.3; linear.len()];
            run(Descent {
                gram: &gram,
                linear: &linear,
                l1: 0.125,
                factor: &mut factor,
                sweeps: 5,
            });
            factor
        };
        let eight = run(|descent| descent.run::<8, 2, true>());
        let four = run(|descent| descent.run::<4, 1, true>());
        assert_eq!(eight, four, "AVX-512 and AVX2");
        let two = run(|descent| descent.run::<2, 1, true>());
        assert_eq!(eight, two, "NEON");
        assert!(eight.contains(&0.0));
        let plain = run(|descent| descent.run::<2, 1, false>());
        for (fused, plain) in eight.iter().zip(plain) {
            assert!((fused - plain).abs() < 1e-14, "{fused} {plain}");
        }
    }
}
