//! Sample clock of a take.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::names::named;

named! {
    /// What is known of a take's start time.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum StartTime {
        /// The source states it with its zone.
        Stated = "stated",
        /// The source states it without a zone; taken as UTC.
        AssumedUtc = "assumed_utc",
        /// The source states none; the take starts at the epoch.
        Unknown = "unknown",
    }
}

/// Why a clock cannot be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("the sample rate is {rate_hz} Hz: expected a positive number")]
pub struct ClockError {
    /// The rate found.
    pub rate_hz: f64,
}

/// Evenly spaced sample times: sample `k` is taken at `start + k / rate`.
///
/// A file's own time column is often rounded to a millisecond, so it is only ever a check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    start_unix_nanos: u64,
    start_time: StartTime,
    rate_hz: f64,
}

impl Clock {
    /// A clock that starts at `start_unix_nanos` (nanoseconds since 1970-01-01 UTC).
    ///
    /// # Errors
    ///
    /// [`ClockError`] unless the rate is a positive finite number.
    pub fn new(
        start_unix_nanos: u64,
        start_time: StartTime,
        rate_hz: f64,
    ) -> Result<Self, ClockError> {
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(ClockError { rate_hz });
        }
        Ok(Self {
            start_unix_nanos,
            start_time,
            rate_hz,
        })
    }

    /// Samples per second.
    pub const fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Whether both clocks have one rate, to a millionth: files round it.
    pub fn has_rate_of(&self, other: Self) -> bool {
        (self.rate_hz - other.rate_hz).abs() <= 1e-6 * other.rate_hz
    }

    /// What is known of the start time.
    pub const fn start_time(&self) -> StartTime {
        self.start_time
    }

    /// Time of sample 0, nanoseconds since 1970-01-01 UTC.
    pub const fn start_unix_nanos(&self) -> u64 {
        self.start_unix_nanos
    }

    /// Time of sample `k` since sample 0, seconds.
    pub fn time_s(&self, k: usize) -> f64 {
        k as f64 / self.rate_hz
    }

    /// Time of sample `k`, nanoseconds since 1970-01-01 UTC.
    pub fn unix_nanos(&self, k: usize) -> u64 {
        self.start_unix_nanos
            .saturating_add((k as f64 * 1e9 / self.rate_hz).round() as u64)
    }

    /// The clock of a take that starts at this one's sample `k`.
    #[must_use]
    pub fn starting_at(&self, k: usize) -> Self {
        Self {
            start_unix_nanos: self.unix_nanos(k),
            ..*self
        }
    }

    /// The sample nearest to `time_s` seconds after sample 0, not below 0.
    pub fn nearest_sample(&self, time_s: f64) -> usize {
        (time_s * self.rate_hz).round().max(0.0) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_do_not_drift() {
        let clock = Clock::new(1_000, StartTime::Unknown, 120.0).unwrap();
        // One hour of samples at 120 Hz, where 1/120 s is no whole number of nanoseconds.
        assert_eq!(clock.unix_nanos(432_000), 1_000 + 3_600_000_000_000);
        assert_eq!(clock.unix_nanos(1), 1_000 + 8_333_333);
        assert_eq!(clock.nearest_sample(clock.time_s(7)), 7);
    }

    #[test]
    fn refuses_a_rate_that_is_none() {
        for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Clock::new(0, StartTime::Unknown, rate_hz).is_err());
        }
    }
}
