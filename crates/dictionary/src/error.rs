//! Errors of learning and using dictionaries.

use std::fmt;

use inhand_model::Finger;
use thiserror::Error;

/// One of the coordinates of a segment's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Of a fingertip.
    Fingertip {
        /// The finger.
        finger: Finger,
        /// The axis, 0 = x.
        axis: usize,
    },
    /// Of the object's position.
    ObjectPosition {
        /// The axis, 0 = x.
        axis: usize,
    },
    /// Of the object's rotation vector.
    ObjectRotation {
        /// The axis, 0 = x.
        axis: usize,
    },
}

impl fmt::Display for Coordinate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Coordinate::Fingertip { finger, axis } => write!(f, "{finger} axis {axis}"),
            Coordinate::ObjectPosition { axis } => write!(f, "object position axis {axis}"),
            Coordinate::ObjectRotation { axis } => write!(f, "object rotation axis {axis}"),
        }
    }
}

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
        "training segment {segment} (take {take}, sample {sample}): {coordinate} is {found}, \
         expected a finite number of metres"
    )]
    NotFinite {
        /// The segment.
        segment: usize,
        /// Index of its take in the list that was cut.
        take: usize,
        /// Sample of the take.
        sample: usize,
        /// Which of the sample's coordinates.
        coordinate: Coordinate,
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
    /// Nothing can be left out of learning, to see how well the rest predicts it.
    #[error(
        "{segments} training segments are too few to leave any out and judge ranks by them: \
         name one rank, or give more takes"
    )]
    NothingLeftOut {
        /// Training segments.
        segments: usize,
    },
    /// No rank of a list can be learned without the takes that are left out.
    #[error(
        "rank {smallest} and above are too large: without the takes left out in turn, {segments} \
         training segments support ranks up to {largest}; lower the ranks or the stride"
    )]
    NoRankFits {
        /// Smallest rank asked for.
        smallest: usize,
        /// Largest rank possible.
        largest: usize,
        /// Training segments.
        segments: usize,
    },
    /// Least squares whose numbers leave the range of floating point.
    #[error(
        "the least squares for the activations of {rank} primitives cannot be solved: expected \
         segments of about a metre, found numbers too large or too small to square"
    )]
    NoActivations {
        /// Number of primitives.
        rank: usize,
    },
    /// A segment without the object's poses, where its layout has the object.
    #[error(
        "training segment {segment} has no object pose at its ends, but its layout has the object: \
         cut segments that carry it, or learn without the object"
    )]
    ObjectEnds {
        /// The segment.
        segment: usize,
    },
    /// An end condition of a segment that is no number.
    #[error(
        "training segment {segment} (take {take}): the {condition} of {coordinate} is {found}, \
         expected a finite number"
    )]
    EndNotFinite {
        /// The segment.
        segment: usize,
        /// Index of its take in the list that was cut.
        take: usize,
        /// Which of the end conditions.
        condition: &'static str,
        /// Of which coordinate.
        coordinate: Coordinate,
        /// The number found.
        found: f64,
    },
    /// End conditions that are not those of the segment.
    #[error(
        "training segment {segment} (take {take}, sample {sample}): {coordinate} is {expected_m} m, \
         but the end conditions say {found_m} m: give each segment its own end conditions"
    )]
    EndsElsewhere {
        /// The segment.
        segment: usize,
        /// Index of its take in the list that was cut.
        take: usize,
        /// First or last sample of the segment, in the take.
        sample: usize,
        /// Which of the sample's coordinates.
        coordinate: Coordinate,
        /// Where the segment has it, metres.
        expected_m: f64,
        /// Where the end conditions have it, metres.
        found_m: f64,
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
    /// A penalty that the scale of the other factor would undo.
    #[error(
        "{penalised} are penalised and {other} are not: their scale would move to the {other} until \
         the penalty is nothing; penalise both"
    )]
    PenaltyOfOneFactor {
        /// The factor that is penalised.
        penalised: &'static str,
        /// The one that is not.
        other: &'static str,
    },
    /// Penalties under which nothing is the best factorisation.
    #[error(
        "the penalties are so heavy that every activation is zero: lower them (weights from 1e-7 to \
         1e-5 change a hand's dictionary without emptying it)"
    )]
    PenaltyOfEverything,
    /// An offset that leaves data below zero.
    #[error(
        "the offset of row {row} is {offset_m} m, but a training segment has {found_m} m there: \
         non-negative primitives need data above the offset; give the offset that the primitives \
         were learned with, and takes like those they were learned from"
    )]
    OffsetAboveData {
        /// The row of a segment.
        row: usize,
        /// The offset, metres.
        offset_m: f64,
        /// A number of the data, metres.
        found_m: f64,
    },
    /// Training columns that cannot be had.
    #[error("training segments cannot be read: {message}")]
    Read {
        /// What happened, and where.
        message: String,
    },
    /// Activations of another block, round or precision.
    #[error(
        "activations of block {block} do not fit round {round}: expected those of the round before, \
         none in round 0, in the precision of the run"
    )]
    Activations {
        /// The block.
        block: usize,
        /// The round.
        round: usize,
    },
    /// Sums over blocks that do not follow one another, or not over all.
    #[error(
        "sums go on at block {found}, expected block {expected}: blocks are missing or there twice"
    )]
    BlockOrder {
        /// The block expected.
        expected: usize,
        /// The block found.
        found: usize,
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
