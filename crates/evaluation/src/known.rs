//! Statistics over values that are known.

use inhand_model::{PerFinger, Statistics};
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
    /// Instants that there would be without gaps and failures.
    pub(crate) fn instants(self) -> usize {
        self.samples * self.segments_without_gaps
    }

    /// How many of them are not among `n`.
    pub(crate) fn left_out(self, n: usize) -> usize {
        self.instants().saturating_sub(n)
    }
}

/// Statistics of the finite ones among values, each with whether it was filled, of which there would be `whole`
/// without gaps and failures.
pub(crate) fn known_statistics(
    values: impl IntoIterator<Item = (f64, bool)>,
    whole: usize,
) -> Statistics {
    let known = (values.into_iter()).filter(|(value, _)| value.is_finite());
    let (known, filled): (Vec<f64>, Vec<bool>) = known.unzip();
    let n_filled = filled.into_iter().filter(|&filled| filled).count();
    let n_left_out = whole.saturating_sub(known.len());
    statistics(known, n_filled, n_left_out)
}

/// Statistics of each finger over all instants at which its value is known.
pub(crate) fn finger_statistics(
    values: &[PerFinger<f64>],
    filled: &[PerFinger<bool>],
    counts: Counts,
) -> PerFinger<Statistics> {
    PerFinger::from_fn(|finger| {
        let values = values.iter().zip(filled);
        let of_finger = values.map(|(value, filled)| (value[finger], filled[finger]));
        known_statistics(of_finger, counts.instants())
    })
}
