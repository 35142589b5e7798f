//! A planned motion of five fingertips.

use std::ops::Range;
use std::sync::Arc;

use thiserror::Error;

use crate::finger::Finger;
use crate::frame::{Hand, Position};
use crate::segments::{Configuration, SEGMENT_COORDINATES, SegmentLayout};

/// Fingertip positions over time in the hand's frame, time-major (t, finger, axis), metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    layout: SegmentLayout,
    /// Plans and methods hold the same motion.
    values_m: Arc<Vec<f64>>,
}

/// Why numbers do not make a trajectory.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TrajectoryError {
    /// Another count of numbers than 15 a sample.
    #[error("a trajectory of {samples} samples has {found} numbers: expected 15 a sample")]
    Length {
        /// Samples it should have.
        samples: usize,
        /// Numbers found.
        found: usize,
    },
    /// A number is NaN or infinite.
    #[error("sample {sample} of a trajectory is not finite ({finger}, axis {axis})")]
    NotFinite {
        /// The sample.
        sample: usize,
        /// The finger.
        finger: Finger,
        /// 0 = x.
        axis: usize,
    },
}

impl Trajectory {
    /// A trajectory from its numbers (15 N, time-major, metres).
    ///
    /// # Errors
    ///
    /// [`TrajectoryError`] for another length or a number that is not finite.
    pub fn new(layout: SegmentLayout, values_m: Vec<f64>) -> Result<Self, TrajectoryError> {
        if values_m.len() != layout.finger_rows() {
            let (samples, found) = (layout.samples, values_m.len());
            return Err(TrajectoryError::Length { samples, found });
        }
        if let Some(row) = values_m.iter().position(|v| !v.is_finite()) {
            let coordinate = row % SEGMENT_COORDINATES;
            return Err(TrajectoryError::NotFinite {
                sample: row / SEGMENT_COORDINATES,
                finger: Finger::ALL[coordinate / 3],
                axis: coordinate % 3,
            });
        }
        Ok(Self {
            layout,
            values_m: values_m.into(),
        })
    }

    /// The motion of some of the samples.
    ///
    /// # Panics
    ///
    /// If there are no such samples.
    #[must_use]
    pub fn slice(&self, samples: Range<usize>) -> Self {
        let numbers = SEGMENT_COORDINATES * samples.start..SEGMENT_COORDINATES * samples.end;
        Self {
            layout: SegmentLayout {
                samples: samples.len(),
                ..self.layout
            },
            values_m: self.values_m[numbers].to_vec().into(),
        }
    }

    /// Samples and rate.
    pub const fn layout(&self) -> SegmentLayout {
        self.layout
    }

    /// All numbers, time-major (t, finger, axis), metres.
    pub fn values_m(&self) -> &[f64] {
        &self.values_m
    }

    /// The configuration at sample `t`, metres.
    ///
    /// # Panics
    ///
    /// If there is no such sample.
    pub fn configuration_m(&self, t: usize) -> Configuration {
        self.values_m.as_chunks().0[t]
    }

    /// Position of a fingertip at sample `t`.
    ///
    /// # Panics
    ///
    /// If there is no such sample.
    pub fn position(&self, t: usize, finger: Finger) -> Position<Hand> {
        let row = SegmentLayout::row(t, finger, 0);
        Position::new(
            self.values_m[row],
            self.values_m[row + 1],
            self.values_m[row + 2],
        )
    }
}
