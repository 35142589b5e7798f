//! Errors on segments that were left out of learning, and how far they can be trusted.

use std::collections::BTreeMap;

use inhand_model::HeldOut;

/// Squared errors by group: a take, or a interval of the only one.
#[derive(Clone, Debug, Default)]
pub(super) struct Errors {
    groups: BTreeMap<usize, Sum>,
}

/// Squared errors of one group.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    squares_m2: f64,
    numbers: usize,
}

impl Errors {
    /// Adds a segment: the sum of its squared errors, over how many numbers, and its group.
    pub(super) fn add(&mut self, group: usize, squares_m2: f64, numbers: usize) {
        let sum = self.groups.entry(group).or_default();
        sum.squares_m2 += squares_m2;
        sum.numbers += numbers;
    }

    /// Root mean square over all numbers, with its standard error over groups.
    ///
    /// The mean square is a ratio of sums over K groups, so its variance is
    /// `K / (K - 1) sum_k w_k² (m_k - m)²`, with the groups' mean squares `m_k` and shares of the
    /// numbers `w_k` (Cochran, Sampling Techniques, 1977, section 6.3; for groups of one size the
    /// usual variance of a mean). The root's standard error is half of that over the root.
    pub(super) fn summary(&self) -> HeldOut {
        let groups = || self.groups.values();
        let numbers = groups().map(|sum| sum.numbers).sum::<usize>().max(1) as f64;
        let mean_m2 = groups().map(|sum| sum.squares_m2).sum::<f64>() / numbers;
        let spread_m4: f64 = groups()
            .map(|sum| ((sum.squares_m2 - sum.numbers as f64 * mean_m2) / numbers).powi(2))
            .sum();
        let count = self.groups.len();
        let rms_m = mean_m2.sqrt();
        let standard_error_m = (count > 1).then(|| {
            let error_m2 = (spread_m4 * count as f64 / (count - 1) as f64).sqrt();
            if rms_m > 0.0 {
                0.5 * error_m2 / rms_m
            } else {
                0.0
            }
        });
        HeldOut {
            rms_m,
            standard_error_m,
        }
    }

    /// Number of groups.
    pub(super) fn groups(&self) -> usize {
        self.groups.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_of_one_size_have_the_standard_error_of_a_mean() {
        let mut errors = Errors::default();
        for (group, square) in [(0, 1.0), (1, 4.0), (2, 7.0), (0, 1.0), (1, 4.0), (2, 7.0)] {
            errors.add(group, 5.0 * square, 5);
        }
        let summary = errors.summary();
        assert!((summary.rms_m - 2.0).abs() < 1e-12);
        // Mean squares 1, 4, 7: standard deviation 3, of their mean 3 / sqrt(3), of its root a
        // quarter of that.
        let expected = 3.0_f64.sqrt() / 4.0;
        assert!((summary.standard_error_m.unwrap() - expected).abs() < 1e-12);
        assert_eq!(errors.groups(), 3);
    }

    #[test]
    fn one_group_has_no_standard_error() {
        let mut errors = Errors::default();
        errors.add(3, 8.0, 2);
        let summary = errors.summary();
        assert_eq!((summary.rms_m, summary.standard_error_m), (2.0, None));
    }
}
