//! Widths and weights by predicting left-out takes.

use inhand_model::{
    Bandwidths, Calibration, DeviationPredictor, PredictorWeights, SegmentLayout, SegmentOrigin,
    Segments, Validation,
};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rayon::prelude::*;

use super::blend::{Points, blend};
use super::folds::{Fold, folds};
use super::primitives::{Demonstrations, Primitives};
use super::profile::Sums;
use crate::covariance::moments_about_zero;
use crate::prediction_error::{mean, mean_distance_m, standard_error};

/// Kernel widths that are tried, over the features of the hand: narrower ones follow single
/// demonstrations, wider ones forget what is special.
const HAND_WIDTHS: [f64; 4] = [1.4, 2.0, 2.8, 4.0];
/// The same over the features of one finger.
const FINGER_WIDTHS: [f64; 4] = [0.35, 0.5, 0.7, 1.0];
/// Smallest variance of an activation, m²: no marker is known better than a micrometre, and a
/// spread of zero could not be inverted.
const SMALLEST_VARIANCE_M2: f64 = 1e-12;
/// Fewest left-out segments that can speak for anything but the cubic Hermite baseline: five numbers (two
/// widths, three weights) are chosen on them, and their gains' spread is estimated from them.
const LEAST_SEGMENTS: usize = 10;
/// Instants of a segment at which predictions are compared; neighbouring ones tell the same.
const INSTANTS: usize = 12;

/// Left-out segments with their predictions, and what was recorded of them.
struct LeftOut<'a> {
    demonstrations: &'a Demonstrations<'a>,
    segments: Vec<usize>,
    /// Predicted activations (r x segments), metres: of the profile and, for each width, of the kernels.
    profile: DMatrix<f64>,
    hand: [DMatrix<f64>; HAND_WIDTHS.len()],
    finger: [DMatrix<f64>; FINGER_WIDTHS.len()],
    /// Samples at which predictions are compared.
    instants: Vec<usize>,
    /// Deviations of the fingertips there, as [`Primitives::fingertips_of`] orders them, metres.
    wanted_m: DMatrix<f64>,
}

/// Widths, weights and errors from the left-out takes.
pub(super) struct Chosen {
    pub(super) bandwidths: Bandwidths,
    pub(super) weights: PredictorWeights,
    pub(super) covariance_m2: DMatrix<f64>,
    pub(super) calibration: Vec<Calibration>,
    pub(super) validation: Validation,
}

/// One way to predict: which of the widths, and the weights of profile, hand and finger.
#[derive(Clone, Copy, Debug)]
struct Choice {
    hand: usize,
    finger: usize,
    weights: [f64; 3],
}

pub(super) fn validate(
    demonstrations: &Demonstrations<'_>,
    sums: &Sums,
    origins: &[SegmentOrigin],
    unexplained_m2: f64,
) -> Chosen {
    let folds = folds(origins, demonstrations.layout.samples);
    let left_out = LeftOut::new(demonstrations, sums, &folds);
    let best = left_out.choose();
    let with_weights = |weights| Choice { weights, ..best };
    let errors = |choice| left_out.errors_m(choice);
    let smooth = errors(with_weights([0.0; 3]));
    let trust = trust(&smooth, &errors(best));
    let choice = with_weights(best.weights.map(|weight| weight * trust));

    let known = (demonstrations.activations_m).select_columns(&left_out.segments);
    let remainders = &known - left_out.expected_m(choice);
    let covariance_m2 = covariance_m2(if left_out.segments.is_empty() {
        // Nothing was predicted: the cubic Hermite baseline is all that is expected.
        demonstrations.activations_m
    } else {
        &remainders
    });
    // What is left of the fingertips' deviations at every sample: expressed less expected is the remainder,
    // so recorded - expressed + remainder, what no activations express included.
    let every: Vec<usize> = (0..demonstrations.layout.samples).collect();
    let recorded =
        Primitives::fingertips_of(demonstrations.deviations_m, &left_out.segments, &every);
    let left = recorded + (demonstrations.primitives).fingertips_m(&(&remainders - known), &every);
    let covariances = covariances_m2(demonstrations.primitives, &covariance_m2, unexplained_m2);
    let error = errors(choice);
    Chosen {
        bandwidths: Bandwidths {
            hand: HAND_WIDTHS[choice.hand],
            finger: FINGER_WIDTHS[choice.finger],
        },
        weights: PredictorWeights {
            profile: choice.weights[0],
            hand: choice.weights[1],
            finger: choice.weights[2],
        },
        covariance_m2,
        calibration: calibrate(&left, &covariances),
        validation: Validation {
            folds: folds.len(),
            segments: left_out.segments.len(),
            smooth_error_m: mean(&smooth),
            error_m: mean(&error),
            standard_error_m: standard_error(&gains(&smooth, &error)),
        },
    }
}

/// Mean distance that deviations are, over left-out segments, fingers and compared instants, metres; over all segments
/// where none is left out.
pub(super) fn mean_deviation_m(deviations_m: &DMatrix<f64>, segments: &Segments) -> f64 {
    let layout = segments.layout();
    let folds = folds(segments.origins(), layout.samples);
    let mut left_out: Vec<_> = folds.iter().flat_map(|f| f.left_out.clone()).collect();
    if left_out.is_empty() {
        left_out = (0..segments.len()).collect();
    }
    let left = Primitives::fingertips_of(deviations_m, &left_out, &compared(layout));
    let none = vec![0.0; left.nrows()];
    let errors = left
        .column_iter()
        .map(|column| mean_distance_m(column.as_slice(), &none));
    mean(&errors.collect::<Vec<_>>())
}

/// Samples at which predictions are compared.
fn compared(layout: SegmentLayout) -> Vec<usize> {
    let step = layout.samples.div_ceil(INSTANTS);
    (step / 2..layout.samples).step_by(step).collect()
}

/// Mean square of errors of activations (r x n), shrunk, m².
fn covariance_m2(errors_m: &DMatrix<f64>) -> DMatrix<f64> {
    let rank = errors_m.nrows();
    if rank == 0 {
        return DMatrix::zeros(0, 0);
    }
    let moments = moments_about_zero(errors_m.as_slice(), rank);
    let mut covariance_m2 = moments.covariance;
    // No eigenvalue is smaller than the share of the identity.
    let smallest = moments.shrinkage * covariance_m2.trace() / rank as f64;
    let missing = (SMALLEST_VARIANCE_M2 - smallest).max(0.0);
    for i in 0..rank {
        covariance_m2[(i, i)] += missing;
    }
    covariance_m2
}

/// Predicted activations of the left-out segments of a fold (r x segments), metres.
struct FoldParts {
    profile: DMatrix<f64>,
    /// For each pair of widths the predictions of hand and finger.
    kernels: Vec<[DMatrix<f64>; 2]>,
}

fn predict_fold(demonstrations: &Demonstrations<'_>, sums: &Sums, fold: &Fold) -> FoldParts {
    let profile = sums.fit(demonstrations, &fold.known);
    let ends = demonstrations.ends.select_columns(&fold.known);
    let answers = demonstrations.activations_m.select_columns(&fold.known) - &profile * &ends;
    let left_out = demonstrations.ends.select_columns(&fold.left_out);
    let by_profile = &profile * &left_out;
    let sizes = demonstrations.primitives.sizes();
    let predictor = DeviationPredictor::new(demonstrations.layout, sizes, profile, ends, answers);
    let distances: Vec<_> = (0..left_out.ncols())
        .into_par_iter()
        .map(|segment| predictor.distances(&left_out.column(segment).into_owned()))
        .collect();
    let kernels = (HAND_WIDTHS.par_iter().zip(&FINGER_WIDTHS))
        .map(|(&hand, &finger)| predictor.kernel_parts_m(&distances, Bandwidths { hand, finger }))
        .collect();
    FoldParts {
        profile: by_profile,
        kernels,
    }
}

impl<'a> LeftOut<'a> {
    fn new(demonstrations: &'a Demonstrations<'a>, sums: &Sums, folds: &[Fold]) -> Self {
        let parts: Vec<FoldParts> = (folds.par_iter())
            .map(|fold| predict_fold(demonstrations, sums, fold))
            .collect();
        let rank = demonstrations.primitives.rank();
        let gather = |part: &dyn Fn(&FoldParts) -> &DMatrix<f64>| {
            let columns = parts.iter().flat_map(|fold| part(fold).as_slice());
            let numbers: Vec<f64> = columns.copied().collect();
            DMatrix::from_vec(rank, folds.iter().map(|f| f.left_out.len()).sum(), numbers)
        };
        let segments: Vec<_> = folds.iter().flat_map(|f| f.left_out.clone()).collect();
        let instants = compared(demonstrations.layout);
        let deviations_m = demonstrations.deviations_m;
        Self {
            demonstrations,
            profile: gather(&|fold| &fold.profile),
            hand: std::array::from_fn(|i| gather(&|fold| &fold.kernels[i][0])),
            finger: std::array::from_fn(|i| gather(&|fold| &fold.kernels[i][1])),
            wanted_m: Primitives::fingertips_of(deviations_m, &segments, &instants),
            segments,
            instants,
        }
    }

    /// Fingertips at the compared instants that activations stand for.
    fn at_instants(&self, activations_m: &DMatrix<f64>) -> DMatrix<f64> {
        (self.demonstrations.primitives).fingertips_m(activations_m, &self.instants)
    }

    /// The widths that predict best by themselves, then the weights of all three parts together.
    fn choose(&self) -> Choice {
        let wanted = Points::new(self.wanted_m.as_slice());
        let at_instants = |part: &DMatrix<f64>| Points::new(self.at_instants(part).as_slice());
        let profile = at_instants(&self.profile);
        let best = |candidates: &[DMatrix<f64>; HAND_WIDTHS.len()]| {
            let tried: Vec<(f64, Points)> = candidates
                .par_iter()
                .map(|candidate| {
                    let candidate = at_instants(candidate);
                    (blend(&wanted, [&profile, &candidate]).1, candidate)
                })
                .collect();
            let numbered = tried.into_iter().enumerate();
            let smallest = numbered.min_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b));
            smallest.map_or((0, Points::new(&[])), |(i, (_, best))| (i, best))
        };
        let (hand, by_hand) = best(&self.hand);
        let (finger, by_finger) = best(&self.finger);
        let (weights, _) = blend(&wanted, [&profile, &by_hand, &by_finger]);
        Choice {
            hand,
            finger,
            weights,
        }
    }

    /// Predicted activations, metres.
    fn expected_m(&self, choice: Choice) -> DMatrix<f64> {
        let [profile, hand, finger] = choice.weights;
        &self.profile * profile
            + &self.hand[choice.hand] * hand
            + &self.finger[choice.finger] * finger
    }

    /// Mean distance over fingers and compared instants of each left-out segment, metres.
    fn errors_m(&self, choice: Choice) -> Vec<f64> {
        let expected_m = self.at_instants(&self.expected_m(choice));
        (self.wanted_m.column_iter().zip(expected_m.column_iter()))
            .map(|(wanted, expected)| mean_distance_m(wanted.as_slice(), expected.as_slice()))
            .collect()
    }
}

/// Share of the weights to keep, by the gain's ratio `t` to its own standard error over
/// segments: `1 - 1/t²`, nothing for `t` below 1 (the positive part of James and Stein's factor for
/// a single number). Nothing as well for fewer segments than [`LEAST_SEGMENTS`].
fn trust(smooth: &[f64], full: &[f64]) -> f64 {
    let gains = gains(smooth, full);
    let (gain, error) = (mean(&gains), standard_error(&gains));
    if gains.len() < LEAST_SEGMENTS || gain <= 0.0 {
        return 0.0;
    }
    (1.0 - (error / gain).powi(2)).max(0.0)
}

fn gains(smooth: &[f64], other: &[f64]) -> Vec<f64> {
    smooth.iter().zip(other).map(|(s, o)| s - o).collect()
}

/// Shares for which a width is measured.
const SHARES: [f64; 2] = [0.5, 0.95];
/// Mahalanobis distances that hold these shares of a normal distribution in three dimensions
/// (square roots of the chi-squared quantiles 2.366 and 7.815), used where nothing could be left
/// out.
const NORMAL: [f64; 2] = [1.538_172_254_455_285_2, 2.795_483_482_915_107];

/// Covariance of each fingertip at each sample (ordered finger, sample), m².
fn covariances_m2(
    primitives: &Primitives,
    covariance_m2: &DMatrix<f64>,
    unexplained_m2: f64,
) -> Vec<Matrix3<f64>> {
    let mut covariances = Vec::new();
    for (first, block) in primitives.finger_blocks() {
        // A fingertip moves by its own primitives alone.
        let size = block.ncols();
        let spread = block * covariance_m2.view((first, first), (size, size));
        for t in 0..block.nrows() / 3 {
            let here = spread.rows(3 * t, 3) * block.rows(3 * t, 3).transpose();
            covariances
                .push(Matrix3::from_fn(|a, b| here[(a, b)]) + Matrix3::identity() * unexplained_m2);
        }
    }
    covariances
}

/// Widths from errors of predictions of left-out segments, one column each in the order of the
/// covariances, three coordinates each, metres.
fn calibrate(errors_m: &DMatrix<f64>, covariances_m2: &[Matrix3<f64>]) -> Vec<Calibration> {
    let inverses: Vec<_> = covariances_m2.iter().map(|c| c.try_inverse()).collect();
    let mut distances: Vec<f64> = Vec::new();
    let errors = errors_m.as_slice().as_chunks::<3>().0.iter();
    for (error, inverse) in errors.zip(inverses.iter().cycle()) {
        // Without a spread there is nothing to measure by.
        if let Some(inverse) = inverse {
            let error = Vector3::from(*error);
            distances.push(error.dot(&(inverse * error)).max(0.0).sqrt());
        }
    }
    SHARES
        .into_iter()
        .zip(NORMAL)
        .map(|(share, normal)| Calibration {
            share,
            mahalanobis: quantile(&mut distances, share).unwrap_or(normal),
        })
        .collect()
}

/// The smallest distance that holds at least this share; leaves the distances in another order.
fn quantile(distances: &mut [f64], share: f64) -> Option<f64> {
    let rank = (share * distances.len() as f64).ceil() as usize;
    let index = rank.saturating_sub(1);
    (index < distances.len()).then(|| *distances.select_nth_unstable_by(index, f64::total_cmp).1)
}
