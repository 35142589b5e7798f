//! Intervals from the statistics of draws.

use std::f64::consts::{PI, SQRT_2};
use std::ops::Range;

use crate::bootstrap::{Draws, Estimate, Interval, Resampling};
use crate::quantiles::quantile;

/// Estimates of `width` statistics. `statistics` gets how many times each cluster is taken and writes
/// `width` numbers, NaN or infinite where one is not defined. `occupied` says which clusters have rows, those of
/// samples that are drawn apart from one another after each other, `samples` how many clusters each has.
pub(crate) fn estimate(
    occupied: &[bool],
    samples: &[usize],
    width: usize,
    resampling: &Resampling,
    mut statistics: impl FnMut(&[u32], &mut [f64]),
) -> Vec<Option<Estimate>> {
    let mut found = vec![f64::NAN; width];
    let mut times = vec![1; occupied.len()];
    statistics(&times, &mut found);
    let values = found.clone();

    // Leaving out a cluster without rows changes nothing and is no part of the jackknife.
    let mut left_out = vec![Vec::new(); width];
    let mut drawn = vec![Vec::with_capacity(resampling.draws); width];
    let mut start = 0;
    let ranges: Vec<Range<usize>> = (samples.iter())
        .map(|size| {
            start += size;
            start - size..start
        })
        .collect();
    let several =
        |range: &Range<usize>| occupied[range.clone()].iter().filter(|&&o| o).count() >= 2;
    if ranges.iter().all(several) {
        for cluster in (0..occupied.len()).filter(|&cluster| occupied[cluster]) {
            times[cluster] = 0;
            statistics(&times, &mut found);
            times[cluster] = 1;
            push(&mut left_out, &found);
        }
        for draw in 0..resampling.draws {
            for (sample, range) in ranges.iter().enumerate() {
                let draws = Draws {
                    clusters: range.len(),
                    seed: resampling.seed.wrapping_add(sample as u64),
                };
                draws.times(draw as u64, &mut times[range.clone()]);
            }
            statistics(&times, &mut found);
            push(&mut drawn, &found);
        }
    }
    (values.iter().zip(drawn).zip(&left_out))
        .map(|((&value, drawn), left_out)| {
            value
                .is_finite()
                .then(|| summary(value, drawn, left_out, resampling))
        })
        .collect()
}

fn push(columns: &mut [Vec<f64>], found: &[f64]) {
    for (column, &found) in columns.iter_mut().zip(found) {
        column.push(found);
    }
}

fn summary(value: f64, mut drawn: Vec<f64>, left_out: &[f64], resampling: &Resampling) -> Estimate {
    let draws = drawn.len();
    drawn.retain(|value| value.is_finite());
    drawn.sort_unstable_by(f64::total_cmp);
    let tail = (1.0 - resampling.confidence) / 2.0;
    Estimate {
        value,
        standard_error: standard_deviation(&drawn),
        percentile: between(&drawn, tail, 1.0 - tail),
        bca: bca_shares(value, &drawn, left_out, tail)
            .and_then(|[low, high]| between(&drawn, low, high)),
        undefined_draws: draws - drawn.len(),
    }
}

fn between(sorted: &[f64], low: f64, high: f64) -> Option<Interval> {
    Some(Interval {
        low: quantile(sorted, low)?,
        high: quantile(sorted, high)?,
    })
}

fn standard_deviation(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((squares / (n - 1.0)).sqrt())
}

/// The shares of the draws between which the BCa interval lies (Efron 1987):
/// `Phi(z0 + (z0 + z) / (1 - a (z0 + z)))` for the normal quantiles `z` of both tails. Bias `z0` is the
/// normal quantile of the share of draws below the value, half of those equal to it counted; the
/// acceleration `a` comes from the values with one cluster left out.
fn bca_shares(value: f64, sorted: &[f64], left_out: &[f64], tail: f64) -> Option<[f64; 2]> {
    let n = sorted.len() as f64;
    let below = sorted.partition_point(|drawn| *drawn < value) as f64;
    let up_to = sorted.partition_point(|drawn| *drawn <= value) as f64;
    let bias = normal_quantile((below + up_to) / (2.0 * n))?;

    let mean = left_out.iter().sum::<f64>() / left_out.len() as f64;
    let power = |exponent| -> f64 {
        (left_out.iter())
            .map(|value| (mean - value).powi(exponent))
            .sum()
    };
    let acceleration = power(3) / (6.0 * power(2).powf(1.5));
    let share = |z: f64| {
        let moved = bias + z;
        normal_share(bias + moved / (1.0 - acceleration * moved))
    };
    let z = normal_quantile(tail)?;
    let shares = [share(z), share(-z)];
    // No change whichever cluster is left out makes the acceleration 0 / 0. An acceleration so strong
    // that the map folds over puts the ends the wrong way round.
    (shares[0] <= shares[1]).then_some(shares)
}

/// Share of the standard normal distribution below `z`.
fn normal_share(z: f64) -> f64 {
    libm::erfc(-z / SQRT_2) / 2.0
}

/// Where [`normal_share`] is `share`; `None` at 0 and 1 and outside.
fn normal_quantile(share: f64) -> Option<f64> {
    if !(share > 0.0 && share < 1.0) {
        return None;
    }
    // Below a half, where small shares have all their digits; 1 - share is exact above.
    let lower = share.min(1.0 - share);
    // Abramowitz and Stegun 26.2.23 is off by less than 4.5e-4.
    let t = (-2.0 * lower.ln()).sqrt();
    let mut z = (2.515_517 + t * (0.802_853 + t * 0.010_328))
        / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)))
        - t;
    // Each of Halley's steps triples the digits that are right.
    for _ in 0..3 {
        let error = (normal_share(z) - lower) * (2.0 * PI).sqrt() * (z * z / 2.0).exp();
        z -= error / (1.0 + z * error / 2.0);
    }
    Some(if share > 0.5 { -z } else { z })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `scipy.stats.norm.ppf` (1.17).
    #[test]
    fn normal_quantiles_agree_with_scipy() {
        for (share, expected) in [
            (0.5, 0.0),
            (0.975, 1.959_963_984_540_054),
            (0.05, -1.644_853_626_951_472_9),
            (0.0005, -3.290_526_731_491_897_6),
            (1e-12, -7.034_483_825_301_131),
        ] {
            let found = normal_quantile(share).expect("a share between 0 and 1");
            assert!((found - expected).abs() < 1e-13, "{share}: {found}");
            assert!((normal_share(found) / share - 1.0).abs() < 1e-13);
        }
        for share in [0.0, 1.0, -0.1, f64::NAN] {
            assert_eq!(normal_quantile(share), None);
        }
    }
}
