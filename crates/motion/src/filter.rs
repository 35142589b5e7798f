//! Filters without delay, on one coordinate of one interval of present samples.
//!
//! Each takes an interval without gaps and gives one as long; nothing is assumed beyond its ends (no
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

/// A filter with everything computed that does not depend on the data: from an interval to one as long.
pub(crate) type Smoother = Box<dyn Fn(&[f64]) -> Vec<f64> + Send + Sync>;

/// The filter that settings ask for.
pub(crate) fn smoother(filter: Filter, rate_hz: f64) -> Result<Smoother, MotionError> {
    Ok(match filter {
        Filter::None => Box::new(<[f64]>::to_vec),
        Filter::Median { window } => {
            let filter = Median::new(window)?;
            Box::new(move |interval| filter.apply(interval))
        }
        Filter::SavitzkyGolay { window, order } => {
            let filter = SavitzkyGolay::new(window, order)?;
            Box::new(move |interval| filter.apply(interval))
        }
        Filter::Butterworth { cutoff_hz, order } => {
            let filter = Butterworth::new(cutoff_hz, order, rate_hz)?;
            Box::new(move |interval| filter.apply(interval))
        }
    })
}
