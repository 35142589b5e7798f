//! Widths and weights by predicting left-out takes.

use inhand_model::{
    Bandwidths, Calibration, Expectation, ExpectationWeights, SegmentLayout, SegmentOrigin,
    Validation,
};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::blend::{Points, blend, mean_distance};
use super::calibration::{calibrate, covariances_m2};
use super::folds::{Fold, folds};
use super::primitives::Primitives;
use super::profile;
use crate::covariance::moments;

/// Kernel widths that are tried, over the features of the hand: narrower ones follow single
/// demonstrations, wider ones forget what is special.
const HAND_WIDTHS: [f64; 4] = [1.4, 2.0, 2.8, 4.0];
/// The same over the features of one finger.
const FINGER_WIDTHS: [f64; 4] = [0.35, 0.5, 0.7, 1.0];
/// Instants of a segment at which predictions are compared; neighbouring ones tell the same.
const INSTANTS: usize = 12;

/// Everything that is learned from, by segment.
pub(super) struct Demonstrations<'a> {
    pub(super) layout: SegmentLayout,
    pub(super) primitives: &'a Primitives,
    /// End conditions (d x n).
    pub(super) ends: &'a DMatrix<f64>,
    /// Deviations from the smooth curve (rows x n), metres.
    pub(super) deviations_m: &'a DMatrix<f64>,
    /// Their activations (r x n), metres.
    pub(super) activations_m: &'a DMatrix<f64>,
}

/// What the left-out takes say.
pub(super) struct Chosen {
    pub(super) bandwidths: Bandwidths,
    pub(super) weights: ExpectationWeights,
    pub(super) covariance_m2: DMatrix<f64>,
    pub(super) calibration: Vec<Calibration>,
    pub(super) validation: Validation,
}

/// Left-out segments with their predictions: activations (r x segments), metres.
struct Predicted {
    segments: Vec<usize>,
    profile: DMatrix<f64>,
    hand: [DMatrix<f64>; HAND_WIDTHS.len()],
    finger: [DMatrix<f64>; FINGER_WIDTHS.len()],
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
    origins: &[SegmentOrigin],
    unexplained_m2: f64,
) -> Chosen {
    let folds = folds(origins, demonstrations.layout.samples);
    let predicted = predict(demonstrations, &folds);
    let best = choose(demonstrations, &predicted);
    let with_weights = |weights| Choice { weights, ..best };
    let errors = |choice| segment_errors_m(demonstrations, &predicted, choice);
    let smooth = errors(with_weights([0.0; 3]));
    let trust = trust(&smooth, &errors(best));
    let choice = with_weights(best.weights.map(|weight| weight * trust));

    let remainders = remainders_m(demonstrations, &predicted, choice);
    let rank = demonstrations.primitives.rank();
    let spread = if predicted.segments.is_empty() {
        demonstrations.activations_m
    } else {
        &remainders
    };
    let covariance_m2 = moments(&[spread.as_slice()], rank).covariance;
    let left = left_m(demonstrations, &predicted, &remainders);
    let covariances = covariances_m2(
        demonstrations.layout,
        &demonstrations.primitives.matrix(),
        &covariance_m2,
        unexplained_m2,
    );
    let error = errors(choice);
    Chosen {
        bandwidths: Bandwidths {
            hand: HAND_WIDTHS[choice.hand],
            finger: FINGER_WIDTHS[choice.finger],
        },
        weights: ExpectationWeights {
            profile: choice.weights[0],
            hand: choice.weights[1],
            finger: choice.weights[2],
        },
        covariance_m2,
        calibration: calibrate(&left, &covariances),
        validation: Validation {
            folds: folds.len(),
            segments: predicted.segments.len(),
            smooth_error_m: mean(&smooth),
            error_m: mean(&error),
            standard_error_m: standard_error(&gains(&smooth, &error)),
        },
    }
}

fn predict(demonstrations: &Demonstrations<'_>, folds: &[Fold]) -> Predicted {
    let parts: Vec<Vec<[DMatrix<f64>; HAND_WIDTHS.len()]>> = folds
        .par_iter()
        .map(|fold| predict_fold(demonstrations, fold))
        .collect();
    let parts = parts.concat();
    let rank = demonstrations.primitives.rank();
    let gather = |width: usize, column: usize| {
        let mut matrix = DMatrix::zeros(rank, parts.len());
        for (mut place, part) in matrix.column_iter_mut().zip(&parts) {
            place.copy_from(&part[width].column(column));
        }
        matrix
    };
    Predicted {
        segments: folds.iter().flat_map(|f| f.left_out.clone()).collect(),
        profile: gather(0, 0),
        hand: std::array::from_fn(|i| gather(i, 1)),
        finger: std::array::from_fn(|i| gather(i, 2)),
    }
}

/// The parts of the expectation (r x 3) for each left-out segment and pair of widths.
fn predict_fold(
    demonstrations: &Demonstrations<'_>,
    fold: &Fold,
) -> Vec<[DMatrix<f64>; HAND_WIDTHS.len()]> {
    let profile = profile::fit(demonstrations, &fold.known);
    let ends = demonstrations.ends.select_columns(&fold.known);
    let answers = demonstrations.activations_m.select_columns(&fold.known) - &profile * &ends;
    let sizes = demonstrations.primitives.sizes();
    let expectation = Expectation::new(demonstrations.layout, sizes, profile, ends, answers);
    (fold.left_out.par_iter())
        .map(|&segment| {
            let ends = demonstrations.ends.column(segment).into_owned();
            let distances = expectation.distances(&ends);
            std::array::from_fn(|i| {
                let widths = Bandwidths {
                    hand: HAND_WIDTHS[i],
                    finger: FINGER_WIDTHS[i],
                };
                expectation.parts_m(&ends, &distances, widths)
            })
        })
        .collect()
}

/// The samples at which predictions are compared.
fn instants(layout: SegmentLayout) -> Vec<usize> {
    let step = layout.samples.div_ceil(INSTANTS);
    (step / 2..layout.samples).step_by(step).collect()
}

/// The widths that predict best by themselves, then the weights of all three parts together.
fn choose(demonstrations: &Demonstrations<'_>, predicted: &Predicted) -> Choice {
    let instants = instants(demonstrations.layout);
    let at_instants = |a: &DMatrix<f64>| demonstrations.primitives.fingertips_m(a, &instants);
    let wanted =
        Primitives::fingertips_of(demonstrations.deviations_m, &predicted.segments, &instants);
    let profile = at_instants(&predicted.profile);
    let best = |candidates: Vec<DMatrix<f64>>| {
        let errors: Vec<f64> = candidates
            .par_iter()
            .map(|candidate| {
                let points = Points {
                    wanted: wanted.as_slice(),
                    predictions: &[profile.as_slice(), candidate.as_slice()],
                };
                blend(&points).1
            })
            .collect();
        let smallest = (0..errors.len()).min_by(|&a, &b| errors[a].total_cmp(&errors[b]));
        smallest.map_or((0, DMatrix::zeros(0, 0)), |i| (i, candidates[i].clone()))
    };
    let (hand, by_hand) = best(predicted.hand.iter().map(at_instants).collect());
    let (finger, by_finger) = best(predicted.finger.iter().map(at_instants).collect());
    let points = Points {
        wanted: wanted.as_slice(),
        predictions: &[profile.as_slice(), by_hand.as_slice(), by_finger.as_slice()],
    };
    let weights = blend(&points).0;
    Choice {
        hand,
        finger,
        weights: [weights[0], weights[1], weights[2]],
    }
}

/// How much of the weights to keep, by the gain's ratio `t` to its own standard error over
/// segments: `1 - 1/t²`, nothing for `t` below 1 (the positive part of James and Stein's factor for
/// a single number).
fn trust(smooth: &[f64], full: &[f64]) -> f64 {
    let gains = gains(smooth, full);
    let (gain, error) = (mean(&gains), standard_error(&gains));
    if gains.len() < 2 || gain <= 0.0 {
        return 0.0;
    }
    (1.0 - (error / gain).powi(2)).max(0.0)
}

fn expected_m(predicted: &Predicted, choice: Choice) -> DMatrix<f64> {
    let [profile, hand, finger] = choice.weights;
    &predicted.profile * profile
        + &predicted.hand[choice.hand] * hand
        + &predicted.finger[choice.finger] * finger
}

/// Mean distance over fingers and compared instants of each left-out segment, metres.
fn segment_errors_m(
    demonstrations: &Demonstrations<'_>,
    predicted: &Predicted,
    choice: Choice,
) -> Vec<f64> {
    let instants = instants(demonstrations.layout);
    let wanted =
        Primitives::fingertips_of(demonstrations.deviations_m, &predicted.segments, &instants);
    let expected =
        (demonstrations.primitives).fingertips_m(&expected_m(predicted, choice), &instants);
    (wanted.column_iter().zip(expected.column_iter()))
        .map(|(wanted, expected)| {
            let points = Points {
                wanted: wanted.as_slice(),
                predictions: &[expected.as_slice()],
            };
            mean_distance(&points, &[1.0])
        })
        .collect()
}

/// What is left of the activations after the prediction (r x left-out segments), metres.
fn remainders_m(
    demonstrations: &Demonstrations<'_>,
    predicted: &Predicted,
    choice: Choice,
) -> DMatrix<f64> {
    let known = demonstrations
        .activations_m
        .select_columns(&predicted.segments);
    known - expected_m(predicted, choice)
}

/// What is left of the fingertips' deviations, at every sample: what is left of the activations,
/// and what no activations express.
fn left_m(
    demonstrations: &Demonstrations<'_>,
    predicted: &Predicted,
    remainders: &DMatrix<f64>,
) -> DMatrix<f64> {
    let every: Vec<usize> = (0..demonstrations.layout.samples).collect();
    let known = demonstrations
        .activations_m
        .select_columns(&predicted.segments);
    let recorded =
        Primitives::fingertips_of(demonstrations.deviations_m, &predicted.segments, &every);
    // Expressed less expected is the remainder: recorded - expressed + remainder.
    recorded + (demonstrations.primitives).fingertips_m(&(remainders - known), &every)
}

fn gains(smooth: &[f64], other: &[f64]) -> Vec<f64> {
    smooth.iter().zip(other).map(|(s, o)| s - o).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn standard_error(values: &[f64]) -> f64 {
    let count = values.len();
    if count < 2 {
        return 0.0;
    }
    let mean = mean(values);
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (squares / (count - 1) as f64 / count as f64).sqrt()
}
