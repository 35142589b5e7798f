//! Settings of processing and cutting. No defaults: these are physical choices.

use inhand_model::{Protocol, SegmentLayout};
use serde::{Deserialize, Serialize};

use crate::error::MotionError;

/// How a recording becomes a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct ProcessSettings {
    /// Longest gap that is filled, seconds (0.1 in the method): `floor(max_gap_s * rate)` missing
    /// samples.
    pub max_gap_s: f64,
    /// How gaps up to that length are filled.
    pub fill: GapFill,
    /// How fingertips and object are smoothed, in the hand's frame.
    pub filter: Filter,
    /// Where the object's centre lies in the frame of its tracked body, metres.
    pub object_offset_m: [f64; 3],
}

/// What takes the place of missing samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GapFill {
    /// The cubic through the two samples before and the two after the gap.
    Cubic,
    /// The straight line between the samples before and after; for orientations slerp.
    Linear,
    /// Nothing: missing stays missing.
    None,
}

/// A filter without delay, applied to each coordinate of each interval of present samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The samples as they are.
    None,
    /// The median of `window` samples (50 in the paper); see [`Median`](crate::filter::Median).
    Median {
        /// Samples in the window, 1 or more.
        window: usize,
    },
    /// The polynomial of least squares through `window` samples; see
    /// [`SavitzkyGolay`](crate::filter::SavitzkyGolay).
    SavitzkyGolay {
        /// Samples in the window, odd.
        window: usize,
        /// Degree of the polynomial, below `window`.
        order: usize,
    },
    /// A Butterworth low-pass run forwards and backwards; see
    /// [`Butterworth`](crate::filter::Butterworth).
    Butterworth {
        /// Where both passes together have lost 3 dB, Hz; below half the sample rate.
        cutoff_hz: f64,
        /// Order of each pass, 1 to 10; both together fall off like twice that.
        order: usize,
    },
}

/// How motions are cut into segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentSettings {
    /// Samples of a segment, two or more, the rate of the takes, and whether the object is in the
    /// columns.
    pub layout: SegmentLayout,
    /// Samples from the start of one segment to the start of the next, 1 or more.
    pub stride: usize,
    /// Source of boundary conditions, and with it the time kept free at both ends of every interval.
    pub ends: EndsRule,
    /// How much of a segment may be missing between its ends, seconds; 0 leaves out every segment
    /// with a missing sample.
    pub missing_s: f64,
}

/// Source of the boundary conditions of segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EndsRule {
    /// [`Protocol::Published`]: the motion at the segment's first and last sample, and its mean velocity over this
    /// time before and after, seconds (0.04 in the method); rounded to whole samples, one at least.
    Differences {
        /// The time, seconds.
        margin_s: f64,
    },
    /// [`Protocol::HeldOut`]: least-squares lines over measured samples of this time up to the segment's first and
    /// from its last on, seconds; rounded to whole samples, three at least. No sample between the segment's first
    /// and last counts. Half of the samples of a line have to be measured.
    Lines {
        /// The time, seconds.
        ends_s: f64,
    },
}

impl EndsRule {
    /// The protocol that takes boundary conditions so.
    pub const fn protocol(self) -> Protocol {
        match self {
            Self::Differences { .. } => Protocol::Published,
            Self::Lines { .. } => Protocol::HeldOut,
        }
    }

    /// Samples on each side of a segment.
    ///
    /// # Errors
    ///
    /// [`MotionError::Setting`] for a time that is not positive or no time.
    pub fn samples(self, rate_hz: f64) -> Result<usize, MotionError> {
        let (name, time_s, least) = match self {
            Self::Differences { margin_s } => ("margin_s", margin_s, 1.0),
            Self::Lines { ends_s } => ("ends_s", ends_s, 3.0),
        };
        let samples = (time_s * rate_hz).round();
        let expected = format!(
            "{} s or more, a sample at {rate_hz} Hz: end velocities are taken over it",
            1.0 / rate_hz
        );
        let in_range = samples >= 1.0 && samples.is_finite();
        MotionError::unless(in_range, name, time_s, &expected)?;
        Ok(samples.max(least) as usize)
    }
}

/// Missing samples in the longest gap that is filled, by a setting in seconds.
///
/// # Errors
///
/// [`MotionError::Setting`] for a time that is negative or not finite.
pub fn gap_samples(
    setting: &'static str,
    longest_s: f64,
    rate_hz: f64,
) -> Result<usize, MotionError> {
    let in_range = longest_s.is_finite() && longest_s >= 0.0;
    let expected = "a time in seconds, 0 or more";
    MotionError::unless(in_range, setting, longest_s, expected)?;
    // A whole number of samples must not be lost to rounding: 0.29 s * 100 Hz is 28.999...96.
    const SLACK_SAMPLES: f64 = 1e-6;
    Ok((longest_s * rate_hz + SLACK_SAMPLES) as usize)
}
