//! Multiplicative updates (Lee and Seung 2001), for comparison with older work.

use rayon::prelude::*;

use crate::product::{View, chunk_width, multiply};
use crate::real::Real;

/// What a zero denominator is replaced by: the single-precision machine epsilon, as scikit-learn
/// does, so that the two can be compared number by number.
const ZERO_DENOMINATOR: f64 = f32::EPSILON as f64;

/// Weights of the penalty `l1 x + l2 x² / 2` on every number `x` of a factor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Weights<T> {
    /// Of the numbers themselves.
    pub(crate) l1: T,
    /// Of half their squares.
    pub(crate) l2: T,
}

/// One update `x <- x * p / (G x + l1 + l2 x)`, element by element, of every column of `factor`
/// (`rank` x count) with the Gram matrix `gram` (`rank` x `rank`) and the linear terms `linear` (as
/// `factor`). Numbers that are zero stay zero.
pub(crate) fn update_all<T: Real>(
    gram: &[T],
    linear: &[T],
    weights: Weights<T>,
    factor: &mut [T],
    rank: usize,
) {
    let width = chunk_width(factor.len() / rank.max(1));
    factor
        .par_chunks_mut(width * rank)
        .zip(linear.par_chunks(width * rank))
        .for_each(|(factor, linear)| update(gram, linear, weights, factor, rank));
}

/// The update of [`update_all`] for one chunk of columns.
pub(crate) fn update<T: Real>(
    gram: &[T],
    linear: &[T],
    weights: Weights<T>,
    factor: &mut [T],
    rank: usize,
) {
    let mut denominator = vec![T::ZERO; factor.len()];
    multiply(
        T::ONE,
        View::columns(gram, rank),
        View::columns(factor, rank),
        T::ZERO,
        &mut denominator,
        rank,
    );
    for ((x, p), d) in factor.iter_mut().zip(linear).zip(denominator) {
        let d = d + (weights.l1 + weights.l2 * *x);
        *x *= *p
            / if d == T::ZERO {
                T::of(ZERO_DENOMINATOR)
            } else {
                d
            };
    }
}
