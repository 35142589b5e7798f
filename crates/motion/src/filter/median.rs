//! The sliding median.

use crate::error::MotionError;

/// Below this many values, counting the smaller ones without a branch is faster than bisection.
const COUNTING_LIMIT: usize = 128;

/// The sliding median of `window` samples.
///
/// The window of sample `k` is centred for odd sizes, `k - (n - 1) / 2 ..= k + (n - 1) / 2`, and
/// `k - n / 2 ..= k + n / 2 - 1` for even ones. Edge rule: at the ends of an interval the window is
/// truncated. The median of an even number of values is the mean of the two middle ones. That is
/// MATLAB's `medfilt1(x, n, 'truncate')`.
///
/// ```
/// # fn main() -> Result<(), inhand_motion::MotionError> {
/// let median = inhand_motion::filter::Median::new(4)?;
/// // Windows: [9 1], [9 1 2], [9 1 2 8], [1 2 8 3], [2 8 3].
/// assert_eq!(median.apply(&[9.0, 1.0, 2.0, 8.0, 3.0]), [5.0, 2.0, 5.0, 2.5, 3.0]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Median {
    window: usize,
}

impl Median {
    /// The sliding median, ready to use.
    ///
    /// # Errors
    ///
    /// [`MotionError::Setting`] for a window of no sample.
    pub fn new(window: usize) -> Result<Self, MotionError> {
        let expected = "a number of samples, 1 or more";
        MotionError::unless(window > 0, "filter.window", window, expected)?;
        Ok(Self { window })
    }

    /// Filters an interval of numbers. Cost: a binary search or count and a move of less than the
    /// window for each sample (the window is kept sorted). A NaN, which no track holds, makes the
    /// values around it meaningless.
    pub fn apply(&self, interval: &[f64]) -> Vec<f64> {
        let (behind, ahead) = (self.window / 2, self.window.div_ceil(2));
        let len = interval.len();
        let mut sorted = Vec::with_capacity(self.window.min(len));
        let (mut start, mut end) = (0, 0);
        (0..len)
            .map(|k| {
                let wanted_start = k.saturating_sub(behind);
                let wanted_end = k.saturating_add(ahead).min(len);
                if end - start == self.window && wanted_end == end + 1 {
                    replace(&mut sorted, interval[start], interval[end]);
                    (start, end) = (start + 1, end + 1);
                }
                for &value in &interval[end..wanted_end] {
                    let place = rank(&sorted, value);
                    sorted.insert(place, value);
                }
                for &value in &interval[start..wanted_start] {
                    let place = rank(&sorted, value);
                    sorted.remove(place);
                }
                (start, end) = (wanted_start, wanted_end);
                middle(&sorted)
            })
            .collect()
    }
}

/// The median of ascending values, of which there is at least one: a window holds its own sample.
fn middle(sorted: &[f64]) -> f64 {
    let half = sorted.len() / 2;
    if sorted.len() % 2 == 1 {
        sorted[half]
    } else {
        0.5 * (sorted[half - 1] + sorted[half])
    }
}

/// How many of the ascending values are smaller: the place of the first that is not.
fn rank(sorted: &[f64], value: f64) -> usize {
    if sorted.len() <= COUNTING_LIMIT {
        sorted.iter().map(|&other| usize::from(other < value)).sum()
    } else {
        sorted.partition_point(|&other| other < value)
    }
}

/// Takes `old` out of ascending values and puts `new` in, moving only what lies between.
fn replace(sorted: &mut [f64], old: f64, new: f64) {
    let from = rank(sorted, old);
    let to = rank(sorted, new);
    if to > from {
        // `old` was counted among the smaller ones.
        sorted.copy_within(from + 1..to, from);
        sorted[to - 1] = new;
    } else {
        sorted.copy_within(to..from, to + 1);
        sorted[to] = new;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The definition, word for word.
    fn by_definition(interval: &[f64], n: usize) -> Vec<f64> {
        let last = interval.len() as isize - 1;
        let n = n as isize;
        (0..=last)
            .map(|k| {
                let (from, to) = if n % 2 == 0 {
                    (k - n / 2, k + n / 2 - 1)
                } else {
                    (k - (n - 1) / 2, k + (n - 1) / 2)
                };
                let mut window = interval[from.max(0) as usize..=to.min(last) as usize].to_vec();
                window.sort_by(f64::total_cmp);
                let half = window.len() / 2;
                if window.len() % 2 == 1 {
                    window[half]
                } else {
                    0.5 * (window[half - 1] + window[half])
                }
            })
            .collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]

        /// Few different values, so that ties and signed zeros are the rule.
        #[test]
        fn is_the_definition(
            interval in prop::collection::vec(prop_oneof![(-3..3).prop_map(f64::from), -1.0..1.0, Just(-0.0)], 0..300),
            window in prop_oneof![1_usize..12, 1_usize..400],
        ) {
            let found = Median::new(window).unwrap().apply(&interval);
            // `==`, for a signed zero may come out with either sign.
            prop_assert_eq!(found, by_definition(&interval, window));
        }

        #[test]
        fn leaves_a_monotone_signal_alone_away_from_its_ends(
            mut interval in prop::collection::vec(-1.0..1.0, 30..80), half in 1_usize..10,
        ) {
            interval.sort_by(f64::total_cmp);
            let found = Median::new(2 * half + 1).unwrap().apply(&interval);
            let inside = half..interval.len() - half;
            prop_assert_eq!(&found[inside.clone()], &interval[inside]);
        }
    }

    #[test]
    fn a_spike_shorter_than_half_the_window_is_gone() {
        let mut interval = [1.0; 40];
        interval[18..22].fill(100.0);
        assert_eq!(Median::new(9).unwrap().apply(&interval), [1.0; 40]);
    }

    #[test]
    fn a_window_of_one_changes_nothing_and_none_is_refused() {
        let interval = [3.0, 1.0, 2.0];
        assert_eq!(Median::new(1).unwrap().apply(&interval), interval);
        assert_eq!(Median::new(usize::MAX).unwrap().apply(&interval), [2.0; 3]);
        assert!(matches!(
            Median::new(0),
            Err(MotionError::Setting {
                setting: "filter.window",
                ..
            })
        ));
    }
}
