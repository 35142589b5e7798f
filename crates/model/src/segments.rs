//! One-second pieces of motion, the columns that dictionaries learn from.

use nalgebra::DMatrix;
use thiserror::Error;

use crate::finger::Finger;
use crate::frame::{Hand, Position};

/// Numbers in one configuration: five fingertips, three coordinates each.
pub const SEGMENT_COORDINATES: usize = 3 * Finger::COUNT;

/// Fingertip positions at one instant, hand frame, metres, ordered finger then axis; also used for
/// their velocities in m/s.
pub type Configuration = [f64; SEGMENT_COORDINATES];

/// Shape of a segment: how many samples, how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentLayout {
    /// Samples in a segment (N).
    pub samples: usize,
    /// Samples per second.
    pub rate_hz: f64,
}

impl SegmentLayout {
    /// Segments of one second at `rate_hz`.
    pub fn one_second(rate_hz: f64) -> Self {
        Self {
            samples: rate_hz.round() as usize,
            rate_hz,
        }
    }

    /// Rows of a segment's column: 15 N.
    pub const fn rows(&self) -> usize {
        SEGMENT_COORDINATES * self.samples
    }

    /// Row of a finger's coordinate (`axis` 0 = x) at sample `t`.
    pub const fn row(t: usize, finger: Finger, axis: usize) -> usize {
        t * SEGMENT_COORDINATES + finger.index() * 3 + axis
    }

    /// Time from the first to the last sample, seconds: (N - 1) / rate.
    pub fn duration_s(&self) -> f64 {
        self.samples.saturating_sub(1) as f64 / self.rate_hz
    }
}

/// What a planner may know of a segment: its ends, and the velocities there, taken outside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndConditions {
    /// First configuration, metres.
    pub first_m: Configuration,
    /// Last configuration, metres.
    pub last_m: Configuration,
    /// Velocity on arriving at the first configuration, m/s.
    pub first_velocity_m_s: Configuration,
    /// Velocity on leaving the last configuration, m/s.
    pub last_velocity_m_s: Configuration,
}

/// Where a segment was cut from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SegmentOrigin {
    /// Index of the take in the list that was cut.
    pub take: usize,
    /// Sample of the take at which the segment starts.
    pub start: usize,
}

/// Segments as columns, with where they come from.
#[derive(Clone, Debug)]
pub struct Segments {
    layout: SegmentLayout,
    columns_m: DMatrix<f64>,
    origins: Vec<SegmentOrigin>,
    ends: Vec<EndConditions>,
    /// Segments that a take without gaps would have given in addition.
    pub left_out: usize,
}

/// Why parts do not make segments.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SegmentsError {
    /// Lists of different lengths, or columns of another height.
    #[error("segments do not fit together: {what} is {found}, expected {expected}")]
    Shape {
        /// Which size.
        what: &'static str,
        /// The size it should have.
        expected: usize,
        /// The size it has.
        found: usize,
    },
}

impl Segments {
    /// Segments from their columns (15 N x n, metres, hand frame).
    ///
    /// # Errors
    ///
    /// [`SegmentsError::Shape`] where the sizes disagree.
    pub fn new(
        layout: SegmentLayout,
        columns_m: DMatrix<f64>,
        origins: Vec<SegmentOrigin>,
        ends: Vec<EndConditions>,
        left_out: usize,
    ) -> Result<Self, SegmentsError> {
        let count = columns_m.ncols();
        for (what, expected, found) in [
            ("rows of a column", layout.rows(), columns_m.nrows()),
            ("number of origins", count, origins.len()),
            ("number of end conditions", count, ends.len()),
        ] {
            if expected != found {
                return Err(SegmentsError::Shape {
                    what,
                    expected,
                    found,
                });
            }
        }
        Ok(Self {
            layout,
            columns_m,
            origins,
            ends,
            left_out,
        })
    }

    /// Shape of each segment.
    pub const fn layout(&self) -> SegmentLayout {
        self.layout
    }

    /// Number of segments (n).
    pub fn len(&self) -> usize {
        self.columns_m.ncols()
    }

    /// Whether there is no segment.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// All segments, one a column (15 N x n), metres, hand frame.
    pub const fn columns_m(&self) -> &DMatrix<f64> {
        &self.columns_m
    }

    /// One segment's numbers, time-major (t, finger, axis), metres.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    pub fn column_m(&self, segment: usize) -> &[f64] {
        let rows = self.layout.rows();
        &self.columns_m.as_slice()[segment * rows..(segment + 1) * rows]
    }

    /// Where each segment comes from.
    pub fn origins(&self) -> &[SegmentOrigin] {
        &self.origins
    }

    /// End conditions of each segment.
    pub fn ends(&self) -> &[EndConditions] {
        &self.ends
    }

    /// Position of a fingertip at sample `t` of a segment.
    ///
    /// # Panics
    ///
    /// If there is no such segment or sample.
    pub fn position(&self, segment: usize, t: usize, finger: Finger) -> Position<Hand> {
        let row = SegmentLayout::row(t, finger, 0);
        let column = self.column_m(segment);
        Position::new(column[row], column[row + 1], column[row + 2])
    }
}
