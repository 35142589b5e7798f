//! Quantiles and summaries of a distribution.

use inhand_model::Statistics;

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

/// Summarises values (any order, any unit; cost O(n), no full sort).
///
/// `n_filled` and `n_left_out` are passed on. `n` counts the values; without any, and where one of
/// them is NaN or infinite, every other field is NaN, so that a summary of nothing cannot pass for
/// a number.
///
/// Quantiles are of type 7 ([`quantile`]); whiskers are values that occur.
pub fn statistics(mut values: Vec<f64>, n_filled: usize, n_left_out: usize) -> Statistics {
    let n = values.len();
    if n == 0 || !values.iter().all(|value| value.is_finite()) {
        return undefined(n, n_filled, n_left_out);
    }
    // In the order given, whatever selection makes of it.
    let sums = sums(&values);
    place(&mut values, 0, &places_used(n));
    placed_statistics(&values, sums, n_filled, n_left_out)
}

/// The same of values that ascend already, which nobody checks: no copy, one pass.
///
/// Sums are taken in that order, so that the mean may differ from that of [`statistics`] by rounding.
pub fn sorted_statistics(sorted: &[f64], n_filled: usize, n_left_out: usize) -> Statistics {
    let n = sorted.len();
    let ends = [sorted.first(), sorted.last()];
    if n == 0 || !ends.iter().flatten().all(|end| end.is_finite()) {
        return undefined(n, n_filled, n_left_out);
    }
    placed_statistics(sorted, sums(sorted), n_filled, n_left_out)
}

/// Sum of the values, and of their squares.
fn sums(values: &[f64]) -> (f64, f64) {
    (values.iter()).fold((0.0, 0.0), |(sum, squares), value| {
        (sum + value, squares + value * value)
    })
}

/// Statistics of finite values, one at least, that stand where they would stand if sorted at the places that
/// quantiles read.
fn placed_statistics(
    values: &[f64],
    (sum, sum_of_squares): (f64, f64),
    n_filled: usize,
    n_left_out: usize,
) -> Statistics {
    let n = values.len();
    let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
    for &value in values {
        min = min.min(value);
        max = max.max(value);
    }
    let [p5, p25, p50, p75, p95] = SHARES.map(|share| interpolated(values, share));
    let reach = WHISKER_RANGES * (p75 - p25);
    let (mut whisker_low, mut whisker_high) = (max, min);
    for &value in values {
        if value >= p25 - reach {
            whisker_low = whisker_low.min(value);
        }
        if value <= p75 + reach {
            whisker_high = whisker_high.max(value);
        }
    }
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
        whisker_low,
        whisker_high,
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

/// Ascending places that [`interpolated`] reads for [`SHARES`].
fn places_used(n: usize) -> Vec<usize> {
    let mut places: Vec<usize> = SHARES
        .iter()
        .map(|share| ((n - 1) as f64 * share) as usize)
        .flat_map(|below| [below, (below + 1).min(n - 1)])
        .collect();
    places.sort_unstable();
    places.dedup();
    places
}

/// Puts the values that belong at the ascending `places` there, as a full sort would: selects at the
/// middle place, then goes on in the two parts. `start` is the place of `values[0]`.
fn place(values: &mut [f64], start: usize, places: &[usize]) {
    if places.is_empty() {
        return;
    }
    let (before, rest) = places.split_at(places.len() / 2);
    let (&at, after) = rest.split_first().expect("the latter half is not empty");
    let (low, _, high) = values.select_nth_unstable_by(at - start, f64::total_cmp);
    place(low, start, before);
    place(high, at + 1, after);
}
