//! What several parts of a report ask of a take's quality.

use inhand_model::{Severity, TakeQuality};

/// Findings of a take that may affect a number.
pub(crate) fn warnings(quality: &TakeQuality) -> usize {
    quality
        .findings
        .iter()
        .filter(|finding| finding.severity == Severity::Warning)
        .count()
}
