//! Order statistics: a tenth of wrong samples must not move them.

use inhand_statistics::quantiles;

/// A quantile of the finite values, 0 for none: the value at `share` of the way.
pub(crate) fn quantile(values: impl IntoIterator<Item = f64>, share: f64) -> f64 {
    let mut values: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
    if values.is_empty() {
        return 0.0;
    }
    let at = (share * (values.len() - 1) as f64).round() as usize;
    let (_, value, _) = values.select_nth_unstable_by(at, f64::total_cmp);
    *value
}

/// The median of the finite values, 0 for none.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    quantile(values, 0.5)
}

/// Median and the standard deviation that normal values of the same median distance would have.
pub(crate) fn median_and_deviation(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    /// Of a normal distribution, the standard deviation is this times the median distance.
    const NORMAL: f64 = 1.4826;
    let middle = median(values.clone());
    (
        middle,
        NORMAL * median(values.map(|value| (value - middle).abs())),
    )
}

/// Finite values, of which quantiles are taken.
#[derive(Clone, Debug, Default)]
pub(crate) struct Finite(Vec<f64>);

impl Finite {
    pub(crate) fn new(values: impl IntoIterator<Item = f64>) -> Self {
        Self(values.into_iter().filter(|v| v.is_finite()).collect())
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// The type 7 quantile; NaN without values. Linear in the values, which change their order.
    pub(crate) fn quantile(&mut self, q: f64) -> f64 {
        if self.0.is_empty() {
            return f64::NAN;
        }
        let place = (self.0.len() - 1) as f64 * q;
        let below = place as usize;
        let (_, &mut low, above) = self.0.select_nth_unstable_by(below, f64::total_cmp);
        let next = above.iter().copied().min_by(f64::total_cmp).unwrap_or(low);
        quantiles::quantile(&[low, next], place - below as f64).unwrap_or(f64::NAN)
    }

    pub(crate) fn median(&mut self) -> f64 {
        self.quantile(0.5)
    }
}

/// At most `wanted` of the samples, evenly spread.
pub(crate) fn thinned(samples: &[usize], wanted: usize) -> Vec<usize> {
    let step = samples.len().div_ceil(wanted.max(1)).max(1);
    samples.iter().step_by(step).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outliers_do_not_matter() {
        assert_eq!(median([3.0, 1.0, 2.0, 1e9, 0.0]), 2.0);
        let (middle, deviation) = median_and_deviation([1.0, 2.0, 3.0, 4.0, 1e9].into_iter());
        assert_eq!(middle, 3.0);
        assert!((deviation - 1.4826).abs() < 1e-12);
        assert_eq!(median([]), 0.0);
    }

    #[test]
    fn quantiles_are_those_of_sorted_values() {
        let values: Vec<f64> = (0..50).map(|k| f64::from(k * 31 % 50).sqrt()).collect();
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        let mut finite = Finite::new(values.into_iter().chain([f64::NAN, f64::INFINITY]));
        assert_eq!(finite.len(), 50);
        for q in [0.5, 0.0, 0.95, 0.9, 1.0, 0.5] {
            assert_eq!(Some(finite.quantile(q)), quantiles::quantile(&sorted, q));
        }
        assert_eq!(Finite::new([3.0]).median(), 3.0);
        assert!(Finite::default().median().is_nan());
    }
}
