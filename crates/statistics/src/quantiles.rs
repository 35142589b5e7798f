//! Quantiles and summaries of a distribution.

use inhand_model::Statistics;

use crate::sort::sort_by_number;

/// Whiskers reach to the farthest value within this many interquartile ranges of the box: Tukey's
/// convention, the default of every box plot library.
const WHISKER_RANGES: f64 = 1.5;

/// The shares a [`Statistics`] lists.
const SHARES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// The type 7 quantile (linear interpolation; the default of NumPy and R) of ascending values: with
/// `h = (n - 1) q`, the value at place `h`, interpolated between its neighbours.
/// Hyndman and Fan, *Sample quantiles in statistical packages*, Am. Stat. 50(4), 1996.
///
/// `None` without values and for `q` outside 0 to 1. The values must be sorted; that is not checked.
///
/// ```
/// use inhand_statistics::quantiles::quantile;
///
/// // h = 3 * 0.25 = 0.75: three quarters of the way from the first to the second value.
/// assert_eq!(quantile(&[10.0, 20.0, 30.0, 40.0], 0.25), Some(17.5));
/// ```
pub fn quantile(sorted: &[f64], q: f64) -> Option<f64> {
    if sorted.is_empty() || !(0.0..=1.0).contains(&q) {
        return None;
    }
    Some(interpolated(sorted, q))
}

/// Summarises values (any order, any unit).
///
/// `n_filled` and `n_left_out` are passed on. `n` counts the values; without any, and where one of
/// them is NaN or infinite, every other field is NaN, so that a summary of nothing cannot pass for
/// a number.
///
/// Quantiles are of type 7 ([`quantile`]); whiskers are values that occur.
pub fn statistics(mut values: Vec<f64>, n_filled: usize, n_left_out: usize) -> Statistics {
    // In the order given, whatever sorting makes of it.
    let sums = sums(&values);
    sort_by_number(&mut values, |&value| value);
    summary(&values, sums, n_filled, n_left_out)
}

/// The same of values that ascend already, which nobody checks: no copy, one pass.
///
/// Sums are taken in that order, so that the mean may differ from that of [`statistics`] by rounding.
pub fn sorted_statistics(sorted: &[f64], n_filled: usize, n_left_out: usize) -> Statistics {
    summary(sorted, sums(sorted), n_filled, n_left_out)
}

/// Sum of the values, and of their squares.
fn sums(values: &[f64]) -> (f64, f64) {
    (values.iter()).fold((0.0, 0.0), |(sum, squares), value| {
        (sum + value, squares + value * value)
    })
}

fn summary(
    sorted: &[f64],
    (sum, sum_of_squares): (f64, f64),
    n_filled: usize,
    n_left_out: usize,
) -> Statistics {
    let n = sorted.len();
    let (Some(&min), Some(&max)) = (sorted.first(), sorted.last()) else {
        return undefined(n, n_filled, n_left_out);
    };
    // NaN and infinities are at the ends.
    if !(min.is_finite() && max.is_finite()) {
        return undefined(n, n_filled, n_left_out);
    }
    let [p5, p25, p50, p75, p95] = SHARES.map(|share| interpolated(sorted, share));
    let reach = WHISKER_RANGES * (p75 - p25);
    let low = sorted.partition_point(|value| *value < p25 - reach);
    let high = sorted.partition_point(|value| *value <= p75 + reach);
    Statistics {
        n,
        n_filled,
        n_left_out,
        mean: sum / n as f64,
        rmse: (sum_of_squares / n as f64).sqrt(),
        min,
        p5,
        p25,
        p50,
        p75,
        p95,
        max,
        whisker_low: sorted[low.min(n - 1)],
        whisker_high: sorted[high.max(1) - 1],
    }
}

fn undefined(n: usize, n_filled: usize, n_left_out: usize) -> Statistics {
    Statistics {
        n,
        n_filled,
        n_left_out,
        mean: f64::NAN,
        rmse: f64::NAN,
        min: f64::NAN,
        p5: f64::NAN,
        p25: f64::NAN,
        p50: f64::NAN,
        p75: f64::NAN,
        p95: f64::NAN,
        max: f64::NAN,
        whisker_low: f64::NAN,
        whisker_high: f64::NAN,
    }
}

/// Reads places `floor(h)` and `floor(h) + 1` alone; `values` is not empty.
fn interpolated(values: &[f64], q: f64) -> f64 {
    let h = (values.len() - 1) as f64 * q;
    let below = h as usize;
    let share = h - below as f64;
    let low = values[below];
    if share == 0.0 {
        return low;
    }
    low + share * (values[below + 1] - low)
}
