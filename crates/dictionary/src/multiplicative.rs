//! Multiplicative updates (Lee and Seung 2001), for comparison with older work.

use rayon::prelude::*;

use crate::product::{View, chunk_width, multiply};

/// What a zero denominator is replaced by: the single-precision machine epsilon, as scikit-learn
/// does, so that the two can be compared number by number.
const ZERO_DENOMINATOR: f64 = f32::EPSILON as f64;

/// One update `x <- x * p / (G x)`, element by element, of every column of `factor` (`rank` x
/// count) with the Gram matrix `gram` (`rank` x `rank`) and the linear terms `linear` (as
/// `factor`). Numbers that are zero stay zero.
pub(crate) fn update_all(gram: &[f64], linear: &[f64], factor: &mut [f64], rank: usize) {
    let width = chunk_width(factor.len() / rank.max(1));
    factor
        .par_chunks_mut(width * rank)
        .zip(linear.par_chunks(width * rank))
        .for_each(|(factor, linear)| update(gram, linear, factor, rank));
}

/// The update of [`update_all`] for one chunk of columns.
pub(crate) fn update(gram: &[f64], linear: &[f64], factor: &mut [f64], rank: usize) {
    let mut denominator = vec![0.0; factor.len()];
    multiply(
        1.0,
        View::columns(gram, rank),
        View::columns(factor, rank),
        0.0,
        &mut denominator,
        rank,
    );
    for ((x, p), d) in factor.iter_mut().zip(linear).zip(denominator) {
        *x *= p / if d == 0.0 { ZERO_DENOMINATOR } else { d };
    }
}
