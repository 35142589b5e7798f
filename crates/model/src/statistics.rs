//! Statistics of a distribution, as documents hold them.

use serde::{Deserialize, Serialize};

use crate::units::{AsIs, Numbers, Unit};

/// A distribution of lengths, metres, or, where a field says so, of angles, radians. Quantiles are
/// type 7 (linear interpolation).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Values.
    pub n: usize,
    /// Values among `n` that rest on a filled sample.
    pub n_filled: usize,
    /// Values that a take without gaps, and plans without failures, would have given in addition.
    pub n_left_out: usize,
    /// Arithmetic mean.
    #[serde(with = "AsIs")]
    pub mean: f64,
    /// Root of the mean square.
    #[serde(with = "AsIs")]
    pub rmse: f64,
    /// Smallest value.
    #[serde(with = "AsIs")]
    pub min: f64,
    /// 5 % quantile.
    #[serde(with = "AsIs")]
    pub p5: f64,
    /// First quartile.
    #[serde(with = "AsIs")]
    pub p25: f64,
    /// Median.
    #[serde(with = "AsIs")]
    pub p50: f64,
    /// Third quartile.
    #[serde(with = "AsIs")]
    pub p75: f64,
    /// 95 % quantile.
    #[serde(with = "AsIs")]
    pub p95: f64,
    /// Largest value.
    #[serde(with = "AsIs")]
    pub max: f64,
    /// Smallest value not below the first quartile by more than 1.5 interquartile ranges.
    #[serde(with = "AsIs")]
    pub whisker_low: f64,
    /// Largest value not above the third quartile by more than 1.5 interquartile ranges.
    #[serde(with = "AsIs")]
    pub whisker_high: f64,
}

impl Statistics {
    /// Mean of all values behind several statistics; NaN without any.
    pub fn pooled_mean<'a>(statistics: impl Iterator<Item = &'a Self>) -> f64 {
        let (n, sum) = (statistics.filter(|own| own.n > 0)).fold((0.0, 0.0), |(n, sum), own| {
            (n + own.n as f64, sum + own.mean * own.n as f64)
        });
        sum / n
    }

    fn map(mut self, mut change: impl FnMut(f64) -> f64) -> Self {
        for value in [
            &mut self.mean,
            &mut self.rmse,
            &mut self.min,
            &mut self.p5,
            &mut self.p25,
            &mut self.p50,
            &mut self.p75,
            &mut self.p95,
            &mut self.max,
            &mut self.whisker_low,
            &mut self.whisker_high,
        ] {
            *value = change(*value);
        }
        self
    }
}

/// Quantiles of nothing do not exist: with n = 0 every number is null, whatever the struct holds.
impl Numbers for Statistics {
    type Written = Statistics;

    fn write(&self, unit: fn(f64) -> f64) -> Statistics {
        self.map(|value| if self.n > 0 { unit(value) } else { f64::NAN })
    }

    fn read(written: Statistics, unit: fn(f64) -> f64) -> Self {
        written.map(unit)
    }
}
