//! Errors of bootstrap intervals.

use thiserror::Error;

/// Reasons why intervals cannot be computed from rows, or with these settings.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BootstrapError {
    /// Rows that are NaN or infinite, or too many to be counted.
    #[error("{0}")]
    Rows(String),
    /// Two samples that are to be drawn together do not have the same clusters.
    #[error(
        "{first} clusters are paired with {second}: expected the same clusters in the same order, one without rows is an empty list"
    )]
    Unpaired {
        /// Clusters of the first.
        first: usize,
        /// Clusters of the second.
        second: usize,
    },
    /// A confidence that is no share between 0 and 1.
    #[error("a confidence of {found}: expected a share above 0 and below 1, such as 0.95")]
    Confidence {
        /// What was asked for.
        found: f64,
    },
    /// No draws.
    #[error("0 draws were asked for: expected at least 1, 2000 are usual")]
    NoDraws,
}
