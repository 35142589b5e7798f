//! Fixed blocks of training columns and the sums that an update of the primitives needs.
//!
//! A block is the unit of everything that is summed over segments: it holds its own activations,
//! forms its own sums, and sums of blocks are added in block order. Which process or thread handled
//! a block therefore leaves no trace in the result, and what a block returns is small: `H Hᵀ`
//! (`rank` x `rank`), `H Vᵀ` (`rank` x rows), the residual and the count, whatever its number of
//! columns.

use rayon::prelude::*;

use crate::descent::{Gram, descend};
use crate::multiplicative::{self, Weights};
use crate::product::{
    View, add, chunk_gram, chunk_width, cross, dot, multiply, squared_norm, squared_residual,
    sum_lower,
};
use crate::settings::Update;
use crate::start;

/// Columns of a block: large enough that its sums are small beside it, small enough that a block of
/// 1500 rows takes 25 MB.
pub(crate) const BLOCK_COLUMNS: usize = 2048;

/// Share of the data's squared norm below which the expanded residual
/// `|V|² - 2 <P, H> + <G, H Hᵀ>` has lost too many digits, and the differences are formed instead.
/// Above it, cancellation leaves about 1e-10 of relative error.
const DIRECT_RESIDUAL_BELOW: f64 = 1e-6;

/// The primitives as one half step needs them.
#[derive(Clone, Debug)]
pub(crate) struct Basis {
    /// Number of primitives.
    pub(crate) rank: usize,
    /// Primitives as rows (`rank` x rows).
    pub(crate) rows_of: Vec<f64>,
    /// `W Wᵀ` of these rows (`rank` x `rank`).
    pub(crate) gram: Vec<f64>,
    padded: Gram<f64>,
}

impl Basis {
    /// A basis from its primitives as rows (`rank` x rows).
    pub(crate) fn new(rows_of: Vec<f64>, rank: usize) -> Self {
        let gram = crate::product::gram(&rows_of, rank);
        let padded = Gram::new(&gram, rank, 0.0);
        Self {
            rank,
            rows_of,
            gram,
            padded,
        }
    }
}

/// A block of shifted training columns with their activations.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// Rows of a column.
    pub(crate) rows: usize,
    /// Shifted columns (rows x count).
    pub(crate) data: Vec<f64>,
    /// Activations (`rank` x count).
    pub(crate) activations: Vec<f64>,
    /// Squared Frobenius norm of the data.
    squared_norm: f64,
}

/// What a half step over a block returns.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    /// `H Hᵀ` (`rank` x `rank`).
    pub(crate) activation_gram: Vec<f64>,
    /// Squared Frobenius norm of `V - W H`.
    pub(crate) squared_residual: f64,
}

impl Block {
    /// A block without activations.
    pub(crate) fn new(data: Vec<f64>, rows: usize) -> Self {
        let squared_norm = data.chunks(rows.max(1)).map(squared_norm).sum();
        Self {
            rows,
            data,
            activations: Vec::new(),
            squared_norm,
        }
    }

    /// Number of columns.
    pub(crate) fn count(&self) -> usize {
        self.data.len() / self.rows.max(1)
    }

    /// Squared Frobenius norm of the data.
    pub(crate) const fn squared_norm(&self) -> f64 {
        self.squared_norm
    }

    /// Sets the activations of each column to random numbers around the one number that fits the
    /// column best: the start of the first half step, at the right scale whatever the scale of the
    /// primitives. `first` is the number of the block's first column among all.
    ///
    /// Equal numbers would fit as well, but coordinate descent would then give the first primitives
    /// of each column much to do and the last ones little.
    pub(crate) fn start_activations(&mut self, basis: &Basis, seed: u64, first: usize) {
        let rank = basis.rank;
        let sum: Vec<f64> = basis
            .rows_of
            .chunks_exact(rank)
            .map(|row| row.iter().sum())
            .collect();
        let scale = squared_norm(&sum);
        let fit = |column: &[f64]| {
            if scale > 0.0 {
                dot(column, &sum) / scale
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
                let shares = start::activation_shares(seed, first + place);
                shares.take(rank).map(move |share| fit * share)
            })
            .collect();
    }

    /// Updates the activations for given primitives and measures the fit.
    pub(crate) fn fit(&mut self, basis: &Basis, update: Update, sweeps: usize) -> Fit {
        let (rows, rank) = (self.rows, basis.rank);
        let width = chunk_width(self.count());
        let parts: Vec<(Vec<f64>, f64)> = self
            .data
            .par_chunks(width * rows)
            .zip(self.activations.par_chunks_mut(width * rank))
            .map(|(data, activations)| {
                let mut linear = vec![0.0; activations.len()];
                multiply(
                    1.0,
                    View::columns(&basis.rows_of, rank),
                    View::columns(data, rows),
                    0.0,
                    &mut linear,
                    rank,
                );
                match update {
                    Update::Hals => descend(&basis.padded, &linear, 0.0, activations, sweeps),
                    Update::Multiplicative => {
                        multiplicative::update(
                            &basis.gram,
                            &linear,
                            Weights::default(),
                            activations,
                            rank,
                        );
                    }
                }
                (chunk_gram(activations, rank), dot(&linear, activations))
            })
            .collect();
        let projected: f64 = parts.iter().map(|(_, projected)| projected).sum();
        let activation_gram = sum_lower(parts.into_iter().map(|(gram, _)| gram).collect(), rank);
        let expanded = self.squared_norm - 2.0 * projected + dot(&basis.gram, &activation_gram);
        let squared_residual = if expanded > DIRECT_RESIDUAL_BELOW * self.squared_norm {
            expanded
        } else {
            self.residual(basis)
        };
        Fit {
            activation_gram,
            squared_residual,
        }
    }

    /// Squared Frobenius norm of `V - W H` from the differences themselves.
    pub(crate) fn residual(&self, basis: &Basis) -> f64 {
        squared_residual(
            &self.data,
            self.rows,
            &basis.rows_of,
            &self.activations,
            basis.rank,
        )
    }

    /// `H Vᵀ` (`rank` x rows).
    pub(crate) fn cross(&self, rank: usize) -> Vec<f64> {
        cross(&self.activations, rank, &self.data, self.rows)
    }
}

/// Sums over blocks, added in block order.
#[derive(Clone, Debug)]
pub(crate) struct Sums {
    /// `H Hᵀ` (`rank` x `rank`).
    pub(crate) activation_gram: Vec<f64>,
    /// Squared Frobenius norm of `V - W H`.
    pub(crate) squared_residual: f64,
    /// Number of columns.
    pub(crate) count: usize,
}

impl Sums {
    /// Half a step over all blocks.
    pub(crate) fn of(blocks: &mut [Block], basis: &Basis, update: Update, sweeps: usize) -> Self {
        let mut sums = Self {
            activation_gram: vec![0.0; basis.rank * basis.rank],
            squared_residual: 0.0,
            count: 0,
        };
        for block in blocks {
            let fit = block.fit(basis, update, sweeps);
            add(&mut sums.activation_gram, &fit.activation_gram);
            sums.squared_residual += fit.squared_residual;
            sums.count += block.count();
        }
        sums
    }
}

/// `H Vᵀ` over all blocks.
pub(crate) fn cross_sum(blocks: &[Block], rank: usize) -> Vec<f64> {
    let mut blocks = blocks.iter();
    let Some(first) = blocks.next() else {
        return Vec::new();
    };
    let mut total = first.cross(rank);
    for block in blocks {
        add(&mut total, &block.cross(rank));
    }
    total
}
