//! The alternation of primitives and activations.

use inhand_model::StopReason;

use crate::block::{Basis, Block, Sums, cross_sum};
use crate::descent::{Gram, descend_all};
use crate::multiplicative::{self, Weights};
use crate::product::squared_norm;
use crate::settings::{NmfSettings, Update};
use crate::start::{column, drawn_segment};

/// Error relative to the data, as norms, at which a fit is exact: what is left is rounding, and
/// further iterations would only stir it.
const EXACT_FIT: f64 = 1e-13;

/// How a factorisation went.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    /// Half the squared Frobenius norm of the error after the start and after each iteration.
    pub(crate) objective_history: Vec<f64>,
    /// Iterations done.
    pub(crate) iterations: usize,
    /// Why they ended.
    pub(crate) stop_reason: StopReason,
}

/// Minimises `1/2 |V - W H|²` over `W, H >= 0`, `V` the data of the blocks, from the primitives in
/// `basis` and the activations in the blocks, both updated in place.
///
/// One iteration updates the primitives from sums over all blocks and then the activations of each
/// block; the activations are updated once more before the first iteration, so that on return they
/// always belong to the primitives returned. Neither half step can raise the objective by more than
/// rounding; should rounding do so, learning has converged.
pub(crate) fn factorise(blocks: &mut [Block], basis: &mut Basis, settings: &NmfSettings) -> Course {
    let numbers: usize = blocks.iter().map(|block| block.data.len()).sum();
    let target = settings
        .stop_rms_m
        .map_or(f64::NEG_INFINITY, |rms| 0.5 * rms * rms * numbers as f64);
    let data: f64 = blocks.iter().map(Block::squared_norm).sum();
    let exact = 0.5 * EXACT_FIT * EXACT_FIT * data;
    let mut sums = Sums::of(blocks, basis, settings.update, settings.sweeps);
    let mut course = Course {
        objective_history: vec![0.5 * sums.squared_residual],
        iterations: 0,
        stop_reason: StopReason::IterationLimit,
    };
    let mut objective = 0.5 * sums.squared_residual;
    if objective <= target {
        course.stop_reason = StopReason::TargetReached;
        return course;
    }
    for iteration in 0..settings.max_iterations {
        if objective <= exact {
            course.stop_reason = StopReason::Converged;
            break;
        }
        let rows_of = update_primitives(blocks, basis, &sums, settings);
        *basis = Basis::new(rows_of, basis.rank);
        revive(blocks, basis, settings.seed, iteration);
        sums = Sums::of(blocks, basis, settings.update, settings.sweeps);
        let previous = objective;
        objective = 0.5 * sums.squared_residual;
        course.objective_history.push(objective);
        course.iterations = iteration + 1;
        if objective <= target {
            course.stop_reason = StopReason::TargetReached;
            break;
        }
        if previous - objective < settings.relative_change * previous {
            course.stop_reason = StopReason::Converged;
            break;
        }
    }
    course
}

/// The primitives (`rank` x rows) after their half step.
fn update_primitives(
    blocks: &[Block],
    basis: &Basis,
    sums: &Sums,
    settings: &NmfSettings,
) -> Vec<f64> {
    let rank = basis.rank;
    let cross = cross_sum(blocks, rank);
    let mut rows_of = basis.rows_of.clone();
    match settings.update {
        Update::Hals => {
            let gram = Gram::new(&sums.activation_gram, rank, 0.0);
            descend_all(&gram, &cross, 0.0, &mut rows_of, settings.sweeps);
        }
        Update::Multiplicative => {
            multiplicative::update_all(
                &sums.activation_gram,
                &cross,
                Weights::default(),
                &mut rows_of,
                rank,
            );
        }
    }
    rows_of
}

/// Replaces primitives that have become zero by a training segment of unit length with activations
/// zero: the product, and with it the objective, stays as it was, and the next half step is free to
/// use them. Without this a zero primitive would stay zero for ever, and could not be scaled to unit
/// length.
fn revive(blocks: &mut [Block], basis: &mut Basis, seed: u64, iteration: usize) {
    let rank = basis.rank;
    let dead: Vec<usize> = (0..rank)
        .filter(|j| !basis.gram[j * rank + j].is_normal())
        .collect();
    if dead.is_empty() {
        return;
    }
    let mut rows_of = std::mem::take(&mut basis.rows_of);
    for j in dead {
        let segment = drawn_segment(blocks, seed, iteration * rank + j);
        let data = column(blocks, segment);
        let norm = squared_norm(data).sqrt();
        for (row, numbers) in rows_of.chunks_exact_mut(rank).enumerate() {
            numbers[j] = if norm > 0.0 {
                data[row] / norm
            } else {
                (data.len() as f64).sqrt().recip()
            };
        }
        for block in blocks.iter_mut() {
            for activations in block.activations.chunks_exact_mut(rank) {
                activations[j] = 0.0;
            }
        }
    }
    *basis = Basis::new(rows_of, rank);
}

/// Scales the primitives to unit length and the activations by the inverse, which leaves their
/// product as it is.
pub(crate) fn normalise(blocks: &mut [Block], basis: &mut Basis) {
    let rank = basis.rank;
    let lengths: Vec<f64> = (0..rank)
        .map(|j| {
            basis
                .rows_of
                .iter()
                .skip(j)
                .step_by(rank)
                .map(|v| v * v)
                .sum::<f64>()
                .sqrt()
        })
        .collect();
    let mut rows_of = std::mem::take(&mut basis.rows_of);
    for numbers in rows_of.chunks_exact_mut(rank) {
        for (number, length) in numbers.iter_mut().zip(&lengths) {
            *number /= length;
        }
    }
    for block in blocks {
        for activations in block.activations.chunks_exact_mut(rank) {
            for (number, length) in activations.iter_mut().zip(&lengths) {
                *number *= length;
            }
        }
    }
    *basis = Basis::new(rows_of, rank);
}
