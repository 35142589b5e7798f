//! A block of training columns and the half step over it.
//!
//! A block is the unit of everything that is summed over segments: it has its own activations and
//! forms its own sums. Which process or thread handled it leaves no trace in the result, and what it
//! returns is small: `H Hᵀ` (`rank` x `rank`), `H Vᵀ` (`rank` x rows), the residual and the count,
//! whatever its number of columns.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::descent::{Gram, descend};
use crate::matrix_view::{View, chunk_width};
use crate::missing::Missing;
use crate::multiplicative;
use crate::packed::{Packed, gram_lower};
use crate::product::{cross, dot, gram, squared_norm, squared_residual, sum, sum_lower};
use crate::random;
use crate::real::Real;
use crate::settings::{Penalty, Update};
use crate::sums::Sums;

/// Columns of a block: large enough that its sums are small beside it, small enough that a block of
/// 1500 rows takes 25 MB.
pub(crate) const BLOCK_COLUMNS: usize = 2048;

/// The primitives as a half step over activations needs them.
#[derive(Clone, Debug)]
pub(crate) struct Basis<'a, T: Real> {
    /// Number of primitives.
    pub(crate) rank: usize,
    /// Primitives as rows (`rank` x rows).
    pub(crate) rows_of: Cow<'a, [T]>,
    /// `W Wᵀ` of these rows (`rank` x `rank`).
    pub(crate) gram: Vec<T>,
    padded: Gram<T>,
    /// The primitives as the product with the data reads them.
    packed: Packed<T>,
    /// Penalty of activations.
    penalty: Penalty,
}

impl<'a, T: Real> Basis<'a, T> {
    /// A basis from its primitives as rows (`rank` x rows), and what activations cost.
    pub(crate) fn new(rows_of: &'a [f64], rank: usize, penalty: Penalty) -> Self {
        let rows_of = T::all_of(rows_of);
        let packed = Packed::new(&rows_of, rank);
        let gram = packed.gram(&rows_of);
        let padded = Gram::new(&gram, rank, T::of(penalty.l2));
        Self {
            rank,
            rows_of,
            gram,
            padded,
            packed,
            penalty,
        }
    }
}

/// A block of shifted training columns with their activations.
#[derive(Clone, Debug)]
pub(crate) struct Block<T> {
    /// Rows of a column.
    pub(crate) rows: usize,
    /// Shifted columns (rows x count); what is missing holds what was last expected there.
    pub(crate) data: Vec<T>,
    /// Activations (`rank` x count).
    pub(crate) activations: Vec<T>,
    /// Places of missing numbers.
    missing: Missing,
    /// Squared Frobenius norm of the data that is there.
    squared_norm: f64,
}

impl<T: Real> Block<T> {
    /// A block of complete columns without activations.
    #[cfg(test)]
    pub(crate) fn new(data: Vec<T>, rows: usize) -> Self {
        Self::with_missing(data, rows, Missing::default())
    }

    /// A block without activations; the data holds first guesses where they are missing.
    pub(crate) fn with_missing(data: Vec<T>, rows: usize, missing: Missing) -> Self {
        let all: f64 = data.chunks(rows.max(1)).map(squared_norm).sum();
        let guessed = missing.squared_norm(&data, rows);
        Self {
            rows,
            data,
            activations: Vec::new(),
            missing,
            squared_norm: all - guessed,
        }
    }

    /// Number of columns.
    pub(crate) fn count(&self) -> usize {
        self.data.len() / self.rows.max(1)
    }

    /// Sets the activations of each column to random numbers around the one number that fits the
    /// column best: the start of the first half step, at the right scale whatever the scale of the
    /// primitives. `first` is the number of the block's first column among all.
    ///
    /// Equal numbers would fit as well, but coordinate descent would then give the first primitives
    /// of each column much to do and the last ones little.
    pub(crate) fn start_activations(&mut self, basis: &Basis<'_, T>, seed: u64, first: usize) {
        let rank = basis.rank;
        let sum: Vec<T> = basis
            .rows_of
            .chunks_exact(rank)
            .map(|row| row.iter().copied().sum())
            .collect();
        let scale = squared_norm(&sum);
        let fit = |column: &[T]| {
            if scale > 0.0 {
                (dot(column, &sum) / scale).max(0.0)
            } else {
                0.0
            }
        };
        self.activations = self
            .data
            .par_chunks_exact(self.rows)
            .enumerate()
            .flat_map_iter(|(place, column)| {
                let fit = fit(column);
                let shares = random::activation_shares(seed, first + place);
                shares.take(rank).map(move |share| T::of(fit * share))
            })
            .collect();
    }

    /// Sets some activations of every column to zero.
    pub(crate) fn clear_activations(&mut self, primitives: &[usize], rank: usize) {
        for activations in self.activations.chunks_exact_mut(rank) {
            for &j in primitives {
                activations[j] = T::ZERO;
            }
        }
    }

    /// Puts what primitives and activations make of it wherever data is missing. With these numbers
    /// the error over all data is that over the data that is there, and a step that lowers the one
    /// lowers the other at least as much (expectation maximisation; Zhang, Wang, Ford and Makedon
    /// 2006, "Learning from incomplete ratings using non-negative matrix factorization").
    pub(crate) fn expect_missing(&mut self, basis: &Basis<'_, T>) {
        self.missing
            .expect(&mut self.data, self.rows, &basis.rows_of, &self.activations);
    }

    /// Updates the activations for given primitives and measures the fit, without the products with the
    /// data. What is missing is then what these activations expect.
    pub(crate) fn fit(&mut self, basis: &Basis<'_, T>, update: Update, sweeps: usize) -> Sums {
        let (rows, rank) = (self.rows, basis.rank);
        let width = chunk_width(self.count());
        let l1 = T::of(basis.penalty.l1);
        let parts: Vec<(Vec<T>, f64)> = self
            .data
            .par_chunks(width * rows)
            .zip(self.activations.par_chunks_mut(width * rank))
            .map(|(data, activations)| {
                let mut linear = vec![T::ZERO; activations.len()];
                basis.packed.times(View::columns(data, rows), &mut linear);
                match update {
                    Update::Hals => descend(&basis.padded, &linear, l1, activations, sweeps),
                    Update::Multiplicative => {
                        let (gram, penalty) = (&basis.gram, basis.penalty);
                        multiplicative::update(gram, &linear, penalty, activations, rank);
                    }
                }
                (gram_lower(activations, rank), dot(&linear, activations))
            })
            .collect();
        let projected: f64 = parts.iter().map(|(_, projected)| projected).sum();
        let activation_gram = sum_lower(parts.into_iter().map(|(gram, _)| gram).collect(), rank);
        let guessed = self.missing.squared_norm(&self.data, rows);
        let squares = (0..rank)
            .map(|j| activation_gram[j * rank + j].to_f64())
            .sum();
        let expanded =
            self.squared_norm + guessed - 2.0 * projected + dot(&basis.gram, &activation_gram);
        let everywhere = if expanded > T::DIRECT_RESIDUAL_BELOW * self.squared_norm {
            expanded
        } else {
            squared_residual(&self.data, rows, &basis.rows_of, &self.activations, rank)
        };
        let changed = self
            .missing
            .expect(&mut self.data, rows, &basis.rows_of, &self.activations);
        Sums {
            count: self.count(),
            squared_norm_m2: self.squared_norm,
            squared_residual_m2: (everywhere - changed).max(0.0),
            left_out_residual_m2: 0.0,
            activation_sum_m: sum(&self.activations),
            activation_squares_m2: squares,
            activation_gram_m2: activation_gram.into_iter().map(T::to_f64).collect(),
            cross_m2: Vec::new(),
        }
    }

    /// `H Vᵀ` (`rank` x rows) of all columns but those set aside.
    pub(crate) fn cross(&self, rank: usize, set_aside: &[usize]) -> Vec<f64> {
        let activations = self.without(rank, set_aside);
        let cross = cross(&activations, rank, &self.data, self.rows);
        cross.into_iter().map(T::to_f64).collect()
    }

    /// `H Hᵀ` (`rank` x `rank`) of all columns but those set aside.
    pub(crate) fn gram(&self, rank: usize, set_aside: &[usize]) -> Vec<f64> {
        let gram = gram(&self.without(rank, set_aside), rank);
        gram.into_iter().map(T::to_f64).collect()
    }

    /// The activations, zero for the columns set aside.
    fn without(&self, rank: usize, set_aside: &[usize]) -> Cow<'_, [T]> {
        let mut activations = Cow::Borrowed(self.activations.as_slice());
        for column in set_aside {
            activations.to_mut()[column * rank..][..rank].fill(T::ZERO);
        }
        activations
    }

    /// Squared Frobenius norm of the error of some columns.
    pub(crate) fn squared_residual_of(&self, columns: &[usize], basis: &Basis<'_, T>) -> f64 {
        let of = |numbers: &[T], size: usize| -> Vec<T> {
            let columns = columns
                .iter()
                .map(|column| &numbers[column * size..][..size]);
            columns.flatten().copied().collect()
        };
        let (data, activations) = (of(&self.data, self.rows), of(&self.activations, basis.rank));
        squared_residual(&data, self.rows, &basis.rows_of, &activations, basis.rank)
    }
}
