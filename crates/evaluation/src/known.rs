//! Statistics over the instants at which values are known.

use inhand_model::{Finger, PerFinger, Statistics};
use inhand_statistics::quantiles::statistics;

/// The sizes that every count of an evaluation rests on.
#[derive(Clone, Copy)]
pub(crate) struct Counts {
    /// Samples in a segment.
    pub(crate) samples: usize,
    /// Segments that a take without gaps would have given.
    pub(crate) segments_without_gaps: usize,
}

impl Counts {
    /// How many of the instants that there would be without gaps and failures are not among `n`.
    pub(crate) fn left_out(self, n: usize) -> usize {
        (self.samples * self.segments_without_gaps).saturating_sub(n)
    }
}

/// One finger's values at the instants where they are known.
#[derive(Clone)]
pub(crate) struct Known {
    pub(crate) values: Vec<f64>,
    pub(crate) n_filled: usize,
}

impl Known {
    pub(crate) fn new(
        values: &[PerFinger<f64>],
        filled: &[PerFinger<bool>],
        finger: Finger,
        instants: impl ExactSizeIterator<Item = usize>,
    ) -> Self {
        let mut known = Self {
            values: Vec::with_capacity(instants.len()),
            n_filled: 0,
        };
        for k in instants {
            let value = values[k][finger];
            if value.is_finite() {
                known.values.push(value);
                known.n_filled += usize::from(filled[k][finger]);
            }
        }
        known
    }

    pub(crate) fn statistics(self, counts: Counts) -> Statistics {
        let n_left_out = counts.left_out(self.values.len());
        statistics(self.values, self.n_filled, n_left_out)
    }
}

/// Statistics of each finger over all instants at which its value is known.
pub(crate) fn finger_statistics(
    values: &[PerFinger<f64>],
    filled: &[PerFinger<bool>],
    counts: Counts,
) -> PerFinger<Statistics> {
    PerFinger::from_fn(|finger| {
        Known::new(values, filled, finger, 0..values.len()).statistics(counts)
    })
}
