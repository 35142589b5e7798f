//! Wall times of steps that run beside each other.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Steps with their times, in the order in which they ended, on whichever thread.
#[derive(Debug, Default)]
pub(super) struct Times(Mutex<Vec<(&'static str, Duration)>>);

impl Times {
    pub(super) fn time<T>(&self, step: &'static str, work: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let result = work();
        let mut steps = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        steps.push((step, begin.elapsed()));
        result
    }

    pub(super) fn into_steps(self) -> Vec<(&'static str, Duration)> {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}
