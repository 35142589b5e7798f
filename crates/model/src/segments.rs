//! One-second pieces of motion, the columns that dictionaries learn from.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::finger::Finger;
use crate::frame::{Hand, Object, Pose, Position};
use crate::protocol::Protocol;

/// Numbers in one configuration: five fingertips, three coordinates each.
pub const SEGMENT_COORDINATES: usize = 3 * Finger::COUNT;

/// Numbers in a vector of end conditions without the object: four configurations.
pub(crate) const FINGER_ENDS: usize = 4 * SEGMENT_COORDINATES;
/// Numbers for the object: first position, last position, rotation between them.
const OBJECT_ENDS: usize = 9;

/// Fingertip positions at one instant, hand frame, metres, ordered finger then axis; also used for
/// their velocities in m/s.
pub type Configuration = [f64; SEGMENT_COORDINATES];

/// Numbers for the object at one instant, where segments carry it: its position in the hand frame
/// and its rotation since the segment's first sample.
pub const OBJECT_COORDINATES: usize = 6;

/// How many metres a radian of the object's rotation counts in a segment's column, so that all its
/// numbers are lengths: the way of a point on the surface of an object of 5 cm.
pub const ROTATION_LEVER_M: f64 = 0.025;

/// Shape of a segment: how many samples, how fast, and whether the object is in it.
///
/// A column holds the fingertips, time-major (t, finger, axis): 15 N numbers. With the object,
/// 6 N follow, time-major (t, coordinate): its position in the hand frame and, times
/// [`ROTATION_LEVER_M`], the rotation vector (hand frame) that turned it since the first sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SegmentLayout {
    /// Samples in a segment (N).
    pub samples: usize,
    /// Samples per second.
    pub rate_hz: f64,
    /// Whether the object's motion follows that of the fingertips.
    pub object: bool,
}

impl SegmentLayout {
    /// Segments of one second at `rate_hz`, fingertips only.
    pub fn one_second(rate_hz: f64) -> Self {
        Self {
            samples: rate_hz.round() as usize,
            rate_hz,
            object: false,
        }
    }

    /// Rows of a segment's column: 15 N, with the object 21 N.
    pub const fn rows(&self) -> usize {
        self.finger_rows() + self.object_rows()
    }

    /// Rows for the fingertips: 15 N.
    pub const fn finger_rows(&self) -> usize {
        SEGMENT_COORDINATES * self.samples
    }

    /// Rows for the object: 6 N, or none.
    pub const fn object_rows(&self) -> usize {
        if self.object {
            OBJECT_COORDINATES * self.samples
        } else {
            0
        }
    }

    /// Row of one of the object's six coordinates at sample `t`; there is none without the object.
    pub const fn object_row(&self, t: usize, coordinate: usize) -> usize {
        self.finger_rows() + t * OBJECT_COORDINATES + coordinate
    }

    /// Row of a finger's coordinate (`axis` 0 = x) at sample `t`.
    pub const fn row(t: usize, finger: Finger, axis: usize) -> usize {
        t * SEGMENT_COORDINATES + finger.index() * 3 + axis
    }

    /// Parts of a column: each finger and, where it is there, the object.
    pub fn parts(&self) -> usize {
        Finger::COUNT + usize::from(self.object)
    }

    /// Rows of one part, sample by sample.
    pub fn part_rows(self, part: usize) -> impl Iterator<Item = usize> {
        let (start, stride, width) = if part < Finger::COUNT {
            (3 * part, SEGMENT_COORDINATES, 3)
        } else {
            (self.finger_rows(), OBJECT_COORDINATES, OBJECT_COORDINATES)
        };
        (0..self.samples).flat_map(move |t| {
            let first = start + t * stride;
            first..first + width
        })
    }

    /// Time from the first to the last sample, seconds: (N - 1) / rate.
    pub fn duration_s(&self) -> f64 {
        self.samples.saturating_sub(1) as f64 / self.rate_hz
    }
}

/// Boundary conditions of a segment, all that a planner may know of it: positions at its ends, and velocities there.
///
/// Under [`Protocol::Published`] they are taken from the filtered motion, so that half the filter's window of the
/// segment is in them; under [`Protocol::HeldOut`] they rest on samples outside the segment and its first and last.
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
    /// Where the object starts and ends, where that is known.
    pub object: Option<ObjectEnds>,
}

/// Poses of the object at the ends of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectEnds {
    /// At the first sample.
    pub first: Pose<Hand, Object>,
    /// At the last sample.
    pub last: Pose<Hand, Object>,
}

impl ObjectEnds {
    /// Where the object is at the first and at the last sample, in a column's six coordinates
    /// (metres; see [`SegmentLayout`]). The first rotation is none by definition.
    pub fn coordinates_m(&self) -> [[f64; OBJECT_COORDINATES]; 2] {
        [self.first, self.last].map(|pose| object_coordinates_m(self.first, pose))
    }
}

/// The object's six coordinates in a column (metres; see [`SegmentLayout`]): where `pose` lies and
/// how far it is turned from `first`. The rotation vector is the shortest one, so the object must
/// not have turned by more than half a turn.
pub fn object_coordinates_m(
    first: Pose<Hand, Object>,
    pose: Pose<Hand, Object>,
) -> [f64; OBJECT_COORDINATES] {
    let [x, y, z] = pose.origin().to_array();
    let turned = pose.isometry().rotation * first.isometry().rotation.inverse();
    let [a, b, c]: [f64; 3] = (turned.scaled_axis() * ROTATION_LEVER_M).into();
    [x, y, z, a, b, c]
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
    protocol: Protocol,
    /// Segments that a take without gaps would have given in addition.
    pub left_out: usize,
}

/// Lists of different lengths, or columns of another height.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("segments do not fit together: {what} is {found}, expected {expected}")]
pub struct SegmentsError {
    /// Which size.
    pub what: &'static str,
    /// The size it should have.
    pub expected: usize,
    /// The size it has.
    pub found: usize,
}

impl Segments {
    /// Segments from their columns (15 N x n, with the object 21 N x n, metres, hand frame).
    ///
    /// # Errors
    ///
    /// [`SegmentsError`] where the sizes disagree.
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
                return Err(SegmentsError {
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
            protocol: Protocol::Published,
            left_out,
        })
    }

    /// The same segments as those of a protocol; [`Protocol::Published`] unless stated.
    #[must_use]
    pub fn under(self, protocol: Protocol) -> Self {
        Self { protocol, ..self }
    }

    /// The protocol that reference and boundary conditions are of.
    pub const fn protocol(&self) -> Protocol {
        self.protocol
    }

    /// Some of the segments, in the given order; nothing counts as left out.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    #[must_use]
    pub fn select(&self, segments: &[usize]) -> Self {
        Self {
            layout: self.layout,
            columns_m: self.columns_m.select_columns(segments),
            origins: segments.iter().map(|&s| self.origins[s]).collect(),
            ends: segments.iter().map(|&s| self.ends[s]).collect(),
            protocol: self.protocol,
            left_out: 0,
        }
    }

    /// Whether a segment has all its numbers; what is missing is NaN.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    pub fn is_complete(&self, segment: usize) -> bool {
        self.column_m(segment).iter().all(|v| !v.is_nan())
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

    /// All segments, one a column (15 N x n, with the object 21 N x n), metres, hand frame.
    pub const fn columns_m(&self) -> &DMatrix<f64> {
        &self.columns_m
    }

    /// The fingertips of one segment (15 N), time-major (t, finger, axis), metres.
    ///
    /// # Panics
    ///
    /// If there is no such segment.
    pub fn fingertips_m(&self, segment: usize) -> &[f64] {
        &self.column_m(segment)[..self.layout.finger_rows()]
    }

    /// One segment's numbers in the order of [`SegmentLayout`], metres.
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

/// Numbers in a vector of end conditions: 60, with the object 69.
pub const fn ends_len(layout: SegmentLayout) -> usize {
    FINGER_ENDS + if layout.object { OBJECT_ENDS } else { 0 }
}
