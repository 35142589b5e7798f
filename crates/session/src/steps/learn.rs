//! A dictionary from training segments.

use inhand_dictionary::{NmfSettings, Penalty, draw, learn_nmf, learn_pca, learn_residual};
use inhand_model::{
    Demonstrated, Dictionary, DictionaryKind, Motion, Protocol, Residual, SegmentLayout, Segments,
};
use inhand_motion::cut_some;

use super::cut_settings;
use crate::error::{Located as _, SessionError};
use crate::settings::{LearnSection, Role, Settings};

/// Primitives where the settings name no number: as published.
const RANK: usize = 200;

/// Learns the dictionary, and deviations from the smooth curve beside it, those of the held-out protocol from
/// `held_out`.
///
/// # Errors
///
/// [`SessionError::At`].
pub fn learn(
    segments: &Segments,
    held_out: &Segments,
    demonstrated: Demonstrated,
    settings: &Settings,
) -> Result<Dictionary, SessionError> {
    let rank = rank(segments.len(), settings);
    let dictionary = match settings.learn.kind {
        DictionaryKind::Pca => learn_pca(segments, demonstrated, rank),
        DictionaryKind::Nmf => learn_nmf(
            segments,
            demonstrated,
            &nmf_settings(segments.len(), settings),
        ),
    }
    .during("learning")?;
    let published = demonstrations(segments, settings);
    let (residual, residual_held_out) = inhand_parallel::both(
        || deviations(&published, settings),
        || {
            let some = (!held_out.is_empty()).then(|| deviations(held_out, settings));
            some.transpose()
        },
    );
    Ok(Dictionary {
        residual: Some(residual?),
        residual_held_out: residual_held_out?,
        ..dictionary
    })
}

/// Deviations from the smooth curve, learned from the given segments.
///
/// # Errors
///
/// [`SessionError::At`].
pub fn deviations(segments: &Segments, settings: &Settings) -> Result<Residual, SessionError> {
    learn_residual(segments, settings.learn.deviation_primitives).during("learning")
}

/// The segments that deviations of the held-out protocol are learned from, cut from motion before the filter: as
/// many as [`drawn_demonstrations`] says, and those of them that miss nothing.
///
/// # Errors
///
/// As [`segments`](super::segments).
pub fn held_out_demonstrations(
    motions: &[&Motion],
    layout: SegmentLayout,
    settings: &Settings,
) -> Result<Segments, SessionError> {
    let cut = cut_settings(layout, (Role::Train, Protocol::HeldOut), settings);
    let drawn = cut_some(motions, &cut, |count| drawn_demonstrations(count, settings));
    Ok(complete(drawn.during("processing train takes")?))
}

/// Which of `count` segments deviations are learned from, in order.
pub fn drawn_demonstrations(count: usize, settings: &Settings) -> Vec<usize> {
    let mut drawn = draw(
        count,
        settings.learn.deviation_segments,
        settings.learn.seed,
    );
    drawn.sort_unstable();
    drawn
}

/// The segments that deviations are learned from: complete ones, and not more than the settings say.
pub(super) fn demonstrations(segments: &Segments, settings: &Settings) -> Segments {
    let drawn = drawn_demonstrations(segments.len(), settings);
    if drawn.len() == segments.len() {
        return complete(segments.clone());
    }
    complete(segments.select(&drawn))
}

/// The segments that miss nothing.
pub fn complete(segments: Segments) -> Segments {
    let complete: Vec<usize> = (0..segments.len())
        .filter(|&segment| segments.is_complete(segment))
        .collect();
    if complete.len() == segments.len() {
        return segments;
    }
    let mut selected = segments.select(&complete);
    selected.left_out = segments.left_out + segments.len() - complete.len();
    selected
}

/// The number of primitives: as the settings say, else as published or as many as the segments
/// support.
fn rank(segments: usize, settings: &Settings) -> usize {
    let largest = match settings.learn.kind {
        // Components about a mean: one less than there are segments.
        DictionaryKind::Pca => segments.saturating_sub(1),
        DictionaryKind::Nmf => segments,
    };
    settings.learn.rank.unwrap_or(RANK.min(largest).max(1))
}

/// Settings of the factorisation of `segments` segments.
pub fn nmf_settings(segments: usize, settings: &Settings) -> NmfSettings {
    NmfSettings {
        rank: rank(segments, settings),
        may_miss: settings.segments.missing_s > 0.0,
        ..nmf_settings_of(&settings.learn)
    }
}

/// Share of the error of left-out takes that an iteration has to gain.
const LEFT_OUT_CHANGE: f64 = 0.1;

/// What does not depend on the segments.
pub(crate) fn nmf_settings_of(section: &LearnSection) -> NmfSettings {
    let usual = LearnSection::default();
    // Who says when to stop wants no other reason, and multiplicative updates gain little an iteration all along.
    let left_out_change = match section.max_iterations == usual.max_iterations
        && section.stop_rms_mm.is_none()
        && section.update == usual.update
    {
        true => LEFT_OUT_CHANGE,
        false => 0.0,
    };
    NmfSettings {
        seed: section.seed,
        max_iterations: section.max_iterations,
        sweeps: section.sweeps,
        relative_change: section.relative_change,
        left_out_change: section.left_out_change.unwrap_or(left_out_change),
        stop_rms_m: section.stop_rms_mm.map(|mm| mm / 1000.0),
        update: section.update,
        start: section.start,
        activation_penalty: Penalty {
            l1: section.activation_l1,
            l2: section.activation_l2,
        },
        primitive_penalty: Penalty {
            l1: section.primitive_l1,
            l2: section.primitive_l2,
        },
        precision: section.precision,
        restarts: section.restarts,
        ..NmfSettings::default()
    }
}
