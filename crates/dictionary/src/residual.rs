//! Learning deviations from the smooth curve.
//!
//! `primitives` (principal components of each finger's deviation), `profile` (what all coordinates
//! share), `folds` (which takes are left out of what), `validation` (kernel widths and weights by
//! predicting left-out takes), `blend` (the weights themselves), `calibration` (corridors).

mod blend;
mod calibration;
mod folds;
mod primitives;
mod profile;
mod validation;

use inhand_model::{
    EndConditions, Expectation, Residual, SegmentLayout, Segments, ends_len, smooth_basis,
};
use nalgebra::{DMatrix, DVector};

use crate::covariance::moments;
use crate::data::checked_range;
use crate::error::LearnError;
use primitives::Primitives;
use validation::{Demonstrations, validate};

/// Settings of deviations from the smooth curve.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualSettings {
    /// Primitives of each finger's deviation, and of the object's: fewer where the segments have no
    /// more to show.
    pub primitives: usize,
}

impl Default for ResidualSettings {
    /// 28 primitives a finger, 140 in all: about 0.04 mm of a session's deviations are left out.
    fn default() -> Self {
        Self { primitives: 28 }
    }
}

/// Learns how motion deviates from the smooth curve through its end conditions.
///
/// Deviations are the segments less [`smooth_basis`] times their end conditions. Primitives are the
/// principal components (about zero) of each finger's deviations, and of the object's where the
/// layout has it. What to expect of a deviation is learned as [`Expectation`] says; kernel widths
/// and weights are those that predict segments of left-out takes best (mean distance over fingers
/// and instants), drawn back towards the smooth curve as far as the gain could be chance
/// ([`Validation`](inhand_model::Validation)). The covariance of the activations and the corridors'
/// calibration come from the same predictions, so they show what is not known beforehand.
///
/// Nothing is random and nothing depends on the number of threads.
///
/// Cost: `n (3 N)²` a finger for the primitives; predictions of at most 600 left-out segments from
/// n demonstrations.
///
/// # Errors
///
/// [`LearnError::NoSegments`], [`LearnError::NotFinite`], [`LearnError::RankZero`];
/// [`LearnError::ObjectEnds`] where the layout has the object and a segment's end conditions do not.
pub fn learn_residual(
    segments: &Segments,
    settings: &ResidualSettings,
) -> Result<Residual, LearnError> {
    checked_range(segments)?;
    if settings.primitives == 0 {
        return Err(LearnError::RankZero);
    }
    let layout = segments.layout();
    let ends = ends_matrix(segments.ends(), layout)?;
    let mut deviations_m = segments.columns_m() - smooth_basis(layout) * &ends;
    // Exact at the ends by definition, where rounding leaves some 1e-17.
    clear_ends(&mut deviations_m, layout);
    let most = supported(segments, settings.primitives);
    let primitives = Primitives::of(&deviations_m, layout, most);
    let activations_m = primitives.activations_m(&deviations_m);
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
    let chosen = validate(&demonstrations, segments.origins(), unexplained_m2);
    let profile = profile::fit(&demonstrations, &(0..segments.len()).collect::<Vec<_>>());
    let answers = &activations_m - &profile * &ends;
    let (ends_mean, ends_covariance) = ends_moments(&ends);
    Ok(Residual {
        layout,
        ends_mean,
        expectation: Expectation::new(layout, primitives.sizes(), profile, ends, answers)
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
    let samples = segments.layout().samples;
    let mut starts: Vec<_> = (segments.origins().iter())
        .map(|origin| (origin.take, origin.start))
        .collect();
    starts.sort_unstable();
    let mut apart = 0;
    let mut last = None;
    for (take, start) in starts {
        if last.is_none_or(|(t, s)| t != take || s + samples <= start) {
            apart += 1;
            last = Some((take, start));
        }
    }
    most.min((apart / 4).max(1))
}

fn ends_matrix(ends: &[EndConditions], layout: SegmentLayout) -> Result<DMatrix<f64>, LearnError> {
    let mut matrix = DMatrix::zeros(ends_len(layout), ends.len());
    for (segment, (mut column, ends)) in matrix.column_iter_mut().zip(ends).enumerate() {
        let numbers = (ends.to_vector(layout)).ok_or(LearnError::ObjectEnds { segment })?;
        column.copy_from(&numbers);
    }
    Ok(matrix)
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

/// Mean and covariance of the end conditions, shrunk in units of their standard deviations:
/// positions and velocities have no common scale.
fn ends_moments(ends: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let deviation = ends.column_variance().map(|variance| {
        // A coordinate that never changed is taken to be known to a micrometre (or micrometre a
        // second).
        variance.max(0.0).sqrt().max(1e-6)
    });
    let mut scaled = ends.clone();
    for mut column in scaled.column_iter_mut() {
        column.component_div_assign(&deviation);
    }
    let moments = moments(&[scaled.as_slice()], ends.nrows());
    let mut covariance = moments.covariance;
    for j in 0..covariance.ncols() {
        for i in 0..covariance.nrows() {
            covariance[(i, j)] *= deviation[i] * deviation[j];
        }
    }
    (moments.mean.component_mul(&deviation), covariance)
}
