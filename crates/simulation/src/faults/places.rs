//! Free places for faults.

use std::ops::Range;

use crate::error::SimulationError;
use crate::random::Random;

/// Draws before a fault is said to find no place.
const MAX_DRAWS: usize = 1000;

/// Which of how many faults is being placed, for the error.
pub(super) struct Wanted {
    pub(super) kind: &'static str,
    pub(super) number: usize,
    pub(super) of: usize,
}

/// A length between the two, log-uniform.
pub(super) fn log_uniform((low, high): (f64, f64), random: &mut Random) -> f64 {
    (low.ln() + (high.ln() - low.ln()) * random.unit()).exp()
}

/// A stretch of `len` samples, not at the very ends of the take and `apart` from each of `taken`.
pub(super) fn free_stretch<'a>(
    samples: usize,
    len: usize,
    apart: usize,
    taken: impl Fn() -> Box<dyn Iterator<Item = &'a Range<usize>> + 'a>,
    wanted: &Wanted,
    random: &mut Random,
) -> Result<Range<usize>, SimulationError> {
    let places = samples.saturating_sub(len + 2 * apart);
    for _ in 0..MAX_DRAWS {
        if places == 0 {
            break;
        }
        let start = apart + random.below(places);
        let stretch = start..start + len;
        let clear =
            |other: &Range<usize>| other.end + apart <= start || stretch.end + apart <= other.start;
        if taken().all(clear) {
            return Ok(stretch);
        }
    }
    Err(SimulationError::Crowded {
        kind: wanted.kind,
        number: wanted.number,
        wanted: wanted.of,
        samples,
    })
}
