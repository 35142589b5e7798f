//! Data quality helpers shared by parts of a report.

use inhand_model::{Severity, TakeQuality};

/// Findings of a take that may affect a number.
pub(crate) fn warnings(quality: &TakeQuality) -> usize {
    quality
        .findings
        .iter()
        .filter(|finding| finding.severity == Severity::Warning)
        .count()
}
