//! Choice of the number of primitives.

use inhand_dictionary::{RankCurve, RankMethod, rank_curve};
use inhand_model::{DictionaryKind, RankPoint, Segments};

use super::nmf_settings;
use crate::error::{Located as _, SessionError};
use crate::settings::Settings;

/// Judges dictionaries of the given ranks, of the kind and with the settings that [`learn`](super::learn())
/// would use, on training takes left out of learning. `progress` is called with each point as it is
/// ready, smallest rank first.
///
/// # Errors
///
/// [`SessionError::At`].
pub fn judge_ranks(
    segments: &Segments,
    settings: &Settings,
    ranks: &[usize],
    progress: &mut dyn FnMut(&RankPoint),
) -> Result<RankCurve, SessionError> {
    let nmf = nmf_settings(segments.len(), settings);
    let method = match settings.learn.kind {
        DictionaryKind::Pca => RankMethod::Pca,
        DictionaryKind::Nmf => RankMethod::Nmf(&nmf),
    };
    rank_curve(segments, method, ranks, progress).during("learning")
}
