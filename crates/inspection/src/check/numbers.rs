//! Order statistics of what is measured.

use inhand_statistics::quantiles::quantile;

/// Values in ascending order, those that are not finite left out.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sorted(Vec<f64>);

impl Sorted {
    pub(crate) fn new(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<_> = values.into_iter().filter(|v| v.is_finite()).collect();
        values.sort_by(f64::total_cmp);
        Self(values)
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// The type 7 quantile; NaN without values.
    pub(crate) fn quantile(&self, q: f64) -> f64 {
        quantile(&self.0, q).unwrap_or(f64::NAN)
    }

    pub(crate) fn median(&self) -> f64 {
        self.quantile(0.5)
    }
}

/// At most `wanted` of the samples, evenly spread.
pub(crate) fn thinned(samples: &[usize], wanted: usize) -> Vec<usize> {
    let step = samples.len().div_ceil(wanted.max(1)).max(1);
    samples.iter().step_by(step).copied().collect()
}
