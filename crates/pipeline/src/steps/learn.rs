//! From training segments to a dictionary.

use inhand_contact::hull;
use inhand_dictionary::{NmfSettings, ResidualSettings, learn_nmf, learn_pca, learn_residual};
use inhand_model::{Demonstrated, Dictionary, Finger, Motion, PerFinger, Segments};
use inhand_trajectory::velocity;
use rayon::prelude::*;

use crate::error::PipelineError;
use crate::settings::Settings;

/// Primitives where the settings name no number: as published.
const RANK: usize = 200;

/// What training motions show: hulls and velocity extremes.
///
/// # Errors
///
/// [`PipelineError::Hull`] where a fingertip was never seen, or does not move.
pub fn demonstrated(motions: &[&Motion]) -> Result<Demonstrated, PipelineError> {
    let hulls: Vec<_> = Finger::ALL
        .into_par_iter()
        .map(|finger| {
            let tracks = motions.iter().map(|motion| &motion.fingertips[finger]);
            let points: Vec<_> = tracks.flat_map(|track| track.iter().flatten()).collect();
            hull(&points).map_err(|source| PipelineError::Hull {
                finger,
                source: source.into(),
            })
        })
        .collect();
    let mut hulls = hulls.into_iter();
    let hulls = PerFinger::try_from_fn(|_| {
        hulls
            .next()
            .expect("one hull was computed for each of the five fingers")
    })?;
    // A hull needs points, so there are neighbouring samples unless every other one is missing.
    let velocity = velocity::extremes(motions.iter().copied()).ok_or_else(|| {
        let message = "no two neighbouring samples are present in the training takes".to_owned();
        PipelineError::Take {
            path: "training takes".into(),
            message,
        }
    })?;
    Ok(Demonstrated { hulls, velocity })
}

/// Learns the dictionary, and deviations from the smooth curve beside it.
///
/// # Errors
///
/// [`PipelineError::Learn`].
pub fn learn(
    segments: &Segments,
    demonstrated: Demonstrated,
    settings: &Settings,
) -> Result<Dictionary, PipelineError> {
    let primitives = settings.learn.deviation_primitives;
    let (dictionary, residual) = rayon::join(
        || match settings.learn.kind.as_str() {
            "pca" => learn_pca(segments, demonstrated, rank(segments, settings)),
            _ => learn_nmf(segments, demonstrated, &nmf_settings(segments, settings)),
        },
        || learn_residual(segments, &ResidualSettings { primitives }),
    );
    let failed = |source: inhand_dictionary::LearnError| PipelineError::Learn(source.into());
    Ok(Dictionary {
        residual: Some(residual.map_err(failed)?),
        ..dictionary.map_err(failed)?
    })
}

/// The number of primitives: as the settings say, else as published or as many as the segments
/// support.
fn rank(segments: &Segments, settings: &Settings) -> usize {
    let largest = match settings.learn.kind.as_str() {
        // Components about a mean: one less than there are segments.
        "pca" => segments.len().saturating_sub(1),
        _ => segments.len(),
    };
    settings.learn.rank.unwrap_or(RANK.min(largest).max(1))
}

fn nmf_settings(segments: &Segments, settings: &Settings) -> NmfSettings {
    let section = &settings.learn;
    NmfSettings {
        rank: rank(segments, settings),
        seed: section.seed,
        max_iterations: section.max_iterations,
        sweeps: section.sweeps,
        relative_change: section.relative_change,
        stop_rms_m: section.stop_rms_mm.map(|mm| mm / 1000.0),
        ..NmfSettings::default()
    }
}
