//! Errors of bootstrap intervals.

use thiserror::Error;

/// Why intervals cannot be computed from rows, or with these settings.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BootstrapError {
    /// A row is NaN or infinite.
    #[error(
        "row {row} of cluster {cluster} is {found}: expected a finite number, leave missing rows out and count them"
    )]
    NotFinite {
        /// Place of the cluster, from 0.
        cluster: usize,
        /// Place of the row in its cluster, from 0.
        row: usize,
        /// What it is.
        found: f64,
    },
    /// More rows or clusters than are counted with 32 bits.
    #[error("{found} rows or clusters: expected at most {limit}, bootstrap over larger parts")]
    TooMany {
        /// How many there are.
        found: usize,
        /// How many there may be.
        limit: usize,
    },
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
