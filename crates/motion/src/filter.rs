//! Filters without delay, on one coordinate of one stretch of present samples.
//!
//! Each takes a stretch without gaps and gives one as long; nothing is assumed beyond its ends (no
//! zeros, no repeated samples). What each does there instead is its edge rule.

mod butterworth;
mod median;
mod savitzky_golay;
mod tracks;

pub use butterworth::Butterworth;
pub use median::Median;
pub use savitzky_golay::SavitzkyGolay;
pub(crate) use tracks::{smooth_points, smooth_poses};

use crate::error::MotionError;
use crate::settings::Filter;

/// The sliding median, ready to use.
///
/// # Errors
///
/// [`MotionError::Setting`] for a window of no sample.
pub fn median(window: usize) -> Result<Median, MotionError> {
    Median::new(window)
}

/// The sliding polynomial of least squares, ready to use.
///
/// # Errors
///
/// [`MotionError::Setting`] for an even window and for an order that the window does not allow.
pub fn savitzky_golay(window: usize, order: usize) -> Result<SavitzkyGolay, MotionError> {
    SavitzkyGolay::new(window, order)
}

/// The Butterworth low-pass without delay, ready to use.
///
/// # Errors
///
/// [`MotionError::Setting`] for an order outside 1 to 10 and for a cut-off that is not between zero
/// and half the rate.
pub fn butterworth(cutoff_hz: f64, order: usize, rate_hz: f64) -> Result<Butterworth, MotionError> {
    Butterworth::new(cutoff_hz, order, rate_hz)
}

/// A filter with everything computed that does not depend on the data.
#[derive(Clone, Debug)]
pub(crate) enum Smoother {
    None,
    Median(Median),
    SavitzkyGolay(SavitzkyGolay),
    Butterworth(Butterworth),
}

impl Smoother {
    pub(crate) fn new(filter: Filter, rate_hz: f64) -> Result<Self, MotionError> {
        Ok(match filter {
            Filter::None => Smoother::None,
            Filter::Median { window } => Smoother::Median(median(window)?),
            Filter::SavitzkyGolay { window, order } => {
                Smoother::SavitzkyGolay(savitzky_golay(window, order)?)
            }
            Filter::Butterworth { cutoff_hz, order } => {
                Smoother::Butterworth(butterworth(cutoff_hz, order, rate_hz)?)
            }
        })
    }

    /// Filters a stretch.
    fn apply(&self, stretch: &[f64]) -> Vec<f64> {
        match self {
            Smoother::None => stretch.to_vec(),
            Smoother::Median(filter) => filter.apply(stretch),
            Smoother::SavitzkyGolay(filter) => filter.apply(stretch),
            Smoother::Butterworth(filter) => filter.apply(stretch),
        }
    }
}
