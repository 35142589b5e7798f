//! Learning deviations from the cubic Hermite baseline.
//!
//! `ends` (boundary conditions as numbers, checked), `primitives` (principal components of each finger's
//! deviation), `profile` (what all coordinates share), `folds` (which takes are left out of what),
//! `validation` (kernel widths, weights and widths of prediction regions by predicting left-out takes), `blend` (the weights
//! themselves).

mod blend;
mod ends;
mod folds;
mod primitives;
mod profile;
mod validation;

use inhand_model::{DeviationPredictor, Protocol, Residual, SegmentLayout, Segments, SmoothCurve};
use nalgebra::DMatrix;
use rayon::prelude::*;

pub use folds::{Fold, folds};

use crate::data::{check_any_rank, survey};
use crate::error::LearnError;
use ends::{check_layout, ends_matrix, ends_moments};
use folds::apart;
use primitives::{Demonstrations, Primitives};
use profile::Sums;
use validation::{mean_deviation_m, validate};

/// Primitives of each finger's deviation where nothing else is asked for, 140 in all: about 0.04 mm of a
/// session's deviations are left out.
pub const DEVIATION_PRIMITIVES: usize = 28;

/// Learns how motion deviates from the cubic Hermite baseline through its boundary conditions, with at most
/// as many primitives of each finger's deviation, and of the object's; fewer where the segments have no more
/// to show.
///
/// Deviations are the segments less [`SmoothCurve::basis`] times their boundary conditions. Primitives are the
/// principal components (about zero) of each finger's deviations, and of the object's where the
/// layout has it; there is none where a finger follows the cubic Hermite baseline to a nanometre. What to
/// expect of a deviation is learned as [`DeviationPredictor`] says; kernel widths
/// and weights are those that predict segments of left-out takes best (mean distance over fingers
/// and instants), drawn back towards the cubic Hermite baseline as far as the gain could be chance
/// ([`Validation`](inhand_model::Validation)). The covariance of the activations and the calibration
/// of prediction regions come from the same predictions, so they show what is not known beforehand.
///
/// Under [`Protocol::HeldOut`] a segment does not begin where its boundary conditions say, and the cubic is not the
/// best curve through them. Where a straight line or minimum jerk is better on left-out takes than the cubic
/// with its deviation, deviations are those from that curve.
///
/// Nothing is random and nothing depends on the number of threads.
///
/// Cost: `n (3 N)²` a finger for the primitives; predictions of about 600 left-out segments from
/// n demonstrations.
///
/// # Errors
///
/// [`LearnError::Setting`] for no primitives, and for segments of a single sample or
/// without a rate; [`LearnError::Data`] for no segments, numbers that are not finite, a fingertip that
/// never moves, and boundary conditions without the object of the layout, that are no numbers, or not those
/// of the segment.
pub fn learn_residual(segments: &Segments, primitives: usize) -> Result<Residual, LearnError> {
    let residual = deviations_from(segments, primitives, SmoothCurve::Hermite)?;
    if segments.protocol() == Protocol::Published {
        return Ok(residual);
    }
    let ends = ends_matrix(segments)?;
    let curves = SmoothCurve::ALL.map(|curve| {
        let deviations_m = deviations_m(segments, &ends, curve);
        (curve, mean_deviation_m(&deviations_m, segments))
    });
    let best = curves.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    let validation = &residual.validation;
    match best {
        // With less to learn than curves differ by, the best curve is better than a little of the cubic's deviation.
        Some((curve, error_m))
            if curve != SmoothCurve::Hermite
                && (validation.segments == 0 || error_m < validation.error_m) =>
        {
            deviations_from(segments, primitives, curve)
        }
        _ => Ok(residual),
    }
}

/// Learns deviations from one curve.
fn deviations_from(
    segments: &Segments,
    primitives: usize,
    curve: SmoothCurve,
) -> Result<Residual, LearnError> {
    survey(segments, false)?;
    let layout = segments.layout();
    check_layout(layout)?;
    check_any_rank(primitives)?;
    let ends = ends_matrix(segments)?;
    let deviations_m = deviations_m(segments, &ends, curve);
    let most = supported(segments, primitives);
    let (primitives, activations_m) = Primitives::of(&deviations_m, layout, most);
    // A micrometre at least: no marker is known better, and a spread of zero could not be inverted.
    let unexplained_m2 = primitives
        .unexplained_m2(&deviations_m, &activations_m)
        .max(1e-12);

    let demonstrations = Demonstrations {
        layout,
        primitives: &primitives,
        ends: &ends,
        deviations_m: &deviations_m,
        activations_m: &activations_m,
    };
    let sums = Sums::of(&demonstrations);
    let chosen = validate(&demonstrations, &sums, segments.origins(), unexplained_m2);
    let every: Vec<usize> = (0..segments.len()).collect();
    let profile = sums.fit(&demonstrations, &every);
    let answers = &activations_m - &profile * &ends;
    let (ends_mean, ends_covariance) = ends_moments(&ends)?;
    Ok(Residual {
        layout,
        curve,
        ends_mean,
        expectation: DeviationPredictor::new(layout, primitives.sizes(), profile, ends, answers)
            .weighted(chosen.bandwidths, chosen.weights),
        ends_covariance,
        primitives: primitives.matrix(),
        covariance_m2: chosen.covariance_m2,
        unexplained_m2,
        calibration: chosen.calibration,
        validation: chosen.validation,
    })
}

/// Primitives that the segments support: a quarter of the segments that would fit side by side into
/// the recorded time. As many primitives as segments would express the training segments exactly
/// and say nothing about others.
fn supported(segments: &Segments, most: usize) -> usize {
    let every: Vec<usize> = (0..segments.len()).collect();
    let apart = apart(&every, segments.origins(), segments.layout().samples);
    most.min((apart.len() / 4).max(1))
}

/// The segments less the curves through their boundary conditions (rows x n), metres.
fn deviations_m(segments: &Segments, ends: &DMatrix<f64>, curve: SmoothCurve) -> DMatrix<f64> {
    let layout = segments.layout();
    let basis = curve.basis(layout);
    // Four numbers of a row at most are not zero: as many products instead of d.
    let basis: Vec<Vec<(usize, f64)>> = (basis.row_iter())
        .map(|row| {
            (row.iter().copied().enumerate())
                .filter(|(_, v)| *v != 0.0)
                .collect()
        })
        .collect();
    let mut deviations_m = segments.columns_m().clone();
    (deviations_m.as_mut_slice().par_chunks_mut(layout.rows()))
        .zip(ends.as_slice().par_chunks(ends.nrows()))
        .for_each(|(column, ends)| {
            for (value, row) in column.iter_mut().zip(&basis) {
                *value -= row.iter().map(|&(i, weight)| weight * ends[i]).sum::<f64>();
            }
        });
    // Exact at the ends by definition, where rounding leaves some 1e-17; under the held-out protocol what is left
    // there is noise, which boundary conditions say nothing about.
    clear_ends(&mut deviations_m, layout);
    deviations_m
}

/// Sets the deviation at both end samples to zero.
fn clear_ends(deviations_m: &mut DMatrix<f64>, layout: SegmentLayout) {
    let fingers = layout.finger_rows();
    let ranges = [(0, fingers), (fingers, layout.object_rows())];
    for (start, len) in ranges {
        let width = len / layout.samples;
        deviations_m.rows_mut(start, width).fill(0.0);
        if len > 0 {
            deviations_m.rows_mut(start + len - width, width).fill(0.0);
        }
    }
}
