//! Why a dictionary cannot be learned or used.

use inhand_model::Finger;
use thiserror::Error;

/// Why a dictionary cannot be learned or used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LearnError {
    /// There is nothing to learn from.
    #[error(
        "no training segments ({left_out} left out for missing samples): cannot learn primitives"
    )]
    NoSegments {
        /// Segments left out because of missing samples.
        left_out: usize,
    },
    /// A dictionary without primitives.
    #[error("rank 0: a dictionary has at least one primitive")]
    RankZero,
    /// More primitives than the segments support.
    #[error(
        "rank {rank} is too large for {segments} training segments of {rows} numbers: \
         the largest possible {kind} rank is {largest}; lower the rank or the stride"
    )]
    RankTooLarge {
        /// The rank asked for.
        rank: usize,
        /// The largest rank possible.
        largest: usize,
        /// Training segments.
        segments: usize,
        /// Numbers in a segment.
        rows: usize,
        /// Kind of dictionary.
        kind: &'static str,
    },
    /// A segment holds a number that is no number.
    #[error(
        "training segment {segment} (take {take}, sample {sample}): {finger} axis {axis} is \
         {found}, expected a finite number of metres"
    )]
    NotFinite {
        /// The segment.
        segment: usize,
        /// Index of its take in the list that was cut.
        take: usize,
        /// Sample of the take.
        sample: usize,
        /// The finger.
        finger: Finger,
        /// The axis, 0 = x.
        axis: usize,
        /// The number found.
        found: f64,
    },
    /// A coordinate that never changes.
    #[error(
        "{finger} axis {axis} is {value_m} m in every sample of {segments} training segments: \
         expected a fingertip that moves; check the marker, or leave these takes out"
    )]
    ConstantCoordinate {
        /// The finger.
        finger: Finger,
        /// The axis, 0 = x.
        axis: usize,
        /// The value it keeps, metres.
        value_m: f64,
        /// Training segments.
        segments: usize,
    },
    /// A setting out of its range.
    #[error("{name} is {found}: expected {expected}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// The range.
        expected: &'static str,
        /// The value found.
        found: f64,
    },
    /// A column that does not fit the dictionary.
    #[error("a segment of {found} numbers does not fit a dictionary of {expected} rows")]
    ColumnLength {
        /// Rows of the dictionary.
        expected: usize,
        /// Numbers found.
        found: usize,
    },
    /// A column with a number that is no number.
    #[error("number {row} of the segment is {found}: expected a finite number of metres")]
    ColumnNotFinite {
        /// Its row.
        row: usize,
        /// The number found.
        found: f64,
    },
}
