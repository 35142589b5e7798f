//! Bootstrap intervals of statistics over clusters of rows.
//!
//! Errors of neighbouring instants are not independent: a bootstrap over instants would give
//! intervals that are far too narrow. What is independent are segments (within one session) or
//! sessions (across several). So rows are grouped in *clusters*; a draw takes as many clusters as
//! there are, with replacement, and the statistic is computed on all rows of the drawn clusters,
//! a cluster drawn twice counting twice (Davison and Hinkley, *Bootstrap Methods and their
//! Application*, 1997, section 3.8: clusters resampled, rows in them kept).
//!
//! Which clusters a draw takes depends on seed, number of the draw and number of clusters alone
//! ([`Draws`]), so that two methods on the same clusters are drawn together and no order of work
//! changes a result.
//!
//! Means, root mean squares and quantiles ([`Measure`]) do not need the rows of a draw put together:
//! [`ClusteredRows`] sorts them once and finds the very numbers ([`intervals`]). Any other statistic
//! goes through [`intervals_of`], which copies the rows of every draw.
//!
//! ```
//! use inhand_statistics::bootstrap::{ClusteredRows, Measure, Resampling, intervals};
//!
//! // Errors (metres) in four segments of two instants each.
//! let rows = ClusteredRows::new(&[[0.001, 0.002], [0.004, 0.002], [0.001, 0.003], [0.002, 0.005]])?;
//! let resampling = Resampling { draws: 2000, seed: 7, confidence: 0.95 };
//! let median = intervals(&rows, &[Measure::Quantile(0.5)], &resampling)?[0].unwrap();
//! assert_eq!(median.value, 0.002);
//! let interval = median.percentile.unwrap();
//! assert!(interval.low >= 0.001 && interval.low < 0.002 && interval.high <= 0.0045);
//! # Ok::<(), inhand_statistics::BootstrapError>(())
//! ```

mod draws;
mod interval;
mod rows;

pub use draws::Draws;
pub use rows::ClusteredRows;

use crate::error::BootstrapError;
use interval::estimate;

/// How draws are made and how wide intervals are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resampling {
    /// How many draws. The ends of a 95 % interval rest on a fortieth of them each: 2000 are usual.
    pub draws: usize,
    /// Seed of the draws. Two results that are to be compared have the same.
    pub seed: u64,
    /// Share of the distribution inside an interval, such as 0.95.
    pub confidence: f64,
}

/// A statistic of rows that is found without putting the rows of a draw together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// Arithmetic mean.
    Mean,
    /// Root of the mean square.
    Rmse,
    /// Quantile of type 7 at a share from 0 to 1 ([`quantile`](crate::quantiles::quantile)).
    Quantile(f64),
}

/// Two ends, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A statistic with what the draws say of it; all in the unit of the statistic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The statistic of the rows themselves.
    pub value: f64,
    /// Standard deviation of the statistic over the draws (divisor draws - 1); `None` where there is
    /// no [`percentile`](Self::percentile) interval, and for a single draw.
    pub standard_error: Option<f64>,
    /// From quantile `(1 - confidence) / 2` to `(1 + confidence) / 2` of the statistic over the
    /// draws (type 7). `None` with fewer than two clusters that have rows: drawing one cluster again
    /// and again tells nothing, and an interval of no width would pass for certainty.
    pub percentile: Option<Interval>,
    /// The same, corrected for bias and for a spread that changes with the value (BCa; Efron,
    /// *Better bootstrap confidence intervals*, J. Am. Stat. Assoc. 82(397), 1987, with the
    /// acceleration from leaving out one cluster at a time). Better than
    /// [`percentile`](Self::percentile) for means; for quantiles of few clusters its acceleration is
    /// rough, since a quantile jumps when a cluster is left out. `None` where it is not defined: the
    /// value outside all draws, or no change whichever cluster is left out.
    pub bca: Option<Interval>,
    /// Draws left out because the statistic was not defined on them (no rows, or a relative
    /// difference to zero).
    pub undefined_draws: usize,
}

/// How a statistic differs between two samples on the same clusters, drawn together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// First less second; negative where the first is smaller. Unit of the rows.
    pub absolute: Estimate,
    /// The difference over the size of the second, no unit: -0.2 is less than the second by 20 % of it, of
    /// whichever sign it is. `None` where the second is 0.
    pub relative: Option<Estimate>,
}

/// Intervals of several statistics of the same rows, in the order asked for, from the same draws.
///
/// A statistic of no rows is `None`. The quantiles are bit for bit those of the rows of each draw
/// sorted together; means and root mean squares add up per cluster and agree to rounding.
///
/// Cost: each draw takes O(clusters log(rows / clusters)) a statistic, whatever the number of rows.
///
/// # Errors
///
/// [`BootstrapError`] for a confidence, number of draws or quantile that makes no sense.
pub fn intervals(
    rows: &ClusteredRows,
    measures: &[Measure],
    resampling: &Resampling,
) -> Result<Vec<Option<Estimate>>, BootstrapError> {
    check(measures, resampling)?;
    Ok(estimate(
        &(rows.sizes().iter().map(|&size| size > 0)).collect::<Vec<_>>(),
        &[rows.sizes().len()],
        measures.len(),
        resampling,
        |times, found| rows.measure(times, measures, found),
    ))
}

/// How statistics of `first` differ from those of `second`, with the same clusters drawn from both.
///
/// What varies from cluster to cluster in both alike (hard segments are hard for every method) cancels:
/// the interval of the difference is narrower than the two intervals apart would suggest. Clusters may
/// have different numbers of rows in both, and none in one of them. `None` for a statistic of no rows.
///
/// # Errors
///
/// [`BootstrapError::Unpaired`] for different numbers of clusters; others as for [`intervals`].
pub fn differences(
    first: &ClusteredRows,
    second: &ClusteredRows,
    measures: &[Measure],
    resampling: &Resampling,
) -> Result<Vec<Option<Difference>>, BootstrapError> {
    check(measures, resampling)?;
    if first.sizes().len() != second.sizes().len() {
        return Err(BootstrapError::Unpaired {
            first: first.sizes().len(),
            second: second.sizes().len(),
        });
    }
    let lone = |rows: &ClusteredRows| rows.sizes().iter().filter(|&&size| size > 0).count() < 2;
    // Where one sample has rows in one cluster only, every draw that is defined repeats them: no interval.
    let comparable = !(lone(first) || lone(second));
    let occupied: Vec<bool> = (first.sizes().iter().zip(second.sizes()))
        .map(|(&first, &second)| comparable && (first > 0 || second > 0))
        .collect();
    let found = difference(measures, |times, measures, of_first, of_second| {
        first.measure(times, measures, of_first);
        second.measure(times, measures, of_second);
    });
    let samples = [occupied.len()];
    let n = measures.len();
    Ok(paired_up(&estimate(
        &occupied,
        &samples,
        2 * n,
        resampling,
        found,
    )))
}

/// How statistics of `first` differ from those of `second`, which have nothing to do with each other: clusters of
/// both are drawn apart, those of the second with the seed after the first's. The intervals are wider than those
/// of [`differences`], and the only ones there are where the clusters are not the same.
///
/// # Errors
///
/// As for [`intervals`].
pub fn unpaired_differences(
    first: &ClusteredRows,
    second: &ClusteredRows,
    measures: &[Measure],
    resampling: &Resampling,
) -> Result<Vec<Option<Difference>>, BootstrapError> {
    check(measures, resampling)?;
    let samples = [first.sizes().len(), second.sizes().len()];
    let sizes = first.sizes().iter().chain(second.sizes());
    let occupied: Vec<bool> = sizes.map(|&size| size > 0).collect();
    let found = difference(measures, |times, measures, of_first, of_second| {
        let (times, of_others) = times.split_at(samples[0]);
        first.measure(times, measures, of_first);
        second.measure(of_others, measures, of_second);
    });
    let n = measures.len();
    Ok(paired_up(&estimate(
        &occupied,
        &samples,
        2 * n,
        resampling,
        found,
    )))
}

/// Writes the differences of both samples' measures, then the relative ones.
fn difference(
    measures: &[Measure],
    both: impl Fn(&[u32], &[Measure], &mut [f64], &mut [f64]),
) -> impl FnMut(&[u32], &mut [f64]) {
    let mut of_second = vec![f64::NAN; measures.len()];
    move |times, found| {
        let (absolute, relative) = found.split_at_mut(measures.len());
        both(times, measures, absolute, &mut of_second);
        for ((absolute, relative), &second) in absolute.iter_mut().zip(relative).zip(&of_second) {
            *absolute -= second;
            *relative = *absolute / second.abs();
        }
    }
}

/// Differences and then relative ones, each with its own.
fn paired_up(estimates: &[Option<Estimate>]) -> Vec<Option<Difference>> {
    let (absolute, relative) = estimates.split_at(estimates.len() / 2);
    (absolute.iter().zip(relative))
        .map(|(&absolute, &relative)| absolute.map(|absolute| Difference { absolute, relative }))
        .collect()
}

/// Intervals of any statistics: `statistics` gets the rows of all drawn clusters (those of a cluster
/// drawn twice twice, clusters in their order) and returns as many numbers as it returns for
/// `clusters` themselves; NaN or an infinity where one is not defined.
///
/// It is called draws + clusters + 1 times on about as many rows as there are.
///
/// # Errors
///
/// As for [`ClusteredRows::new`] and [`intervals`].
pub fn intervals_of<const N: usize>(
    clusters: &[impl AsRef<[f64]>],
    resampling: &Resampling,
    mut statistics: impl FnMut(&[f64]) -> [f64; N],
) -> Result<Vec<Option<Estimate>>, BootstrapError> {
    check(&[], resampling)?;
    rows::check(clusters)?;
    let mut pooled = Vec::new();
    let occupied: Vec<bool> = (clusters.iter())
        .map(|rows| !rows.as_ref().is_empty())
        .collect();
    let samples = [occupied.len()];
    Ok(estimate(
        &occupied,
        &samples,
        N,
        resampling,
        |times, found| {
            pooled.clear();
            for (rows, &times) in clusters.iter().zip(times) {
                for _ in 0..times {
                    pooled.extend_from_slice(rows.as_ref());
                }
            }
            found.copy_from_slice(&statistics(&pooled));
        },
    ))
}

fn check(measures: &[Measure], resampling: &Resampling) -> Result<(), BootstrapError> {
    let confidence = resampling.confidence;
    if !(confidence > 0.0 && confidence < 1.0) {
        return Err(BootstrapError::Confidence { found: confidence });
    }
    if resampling.draws == 0 {
        return Err(BootstrapError::NoDraws);
    }
    for measure in measures {
        if let Measure::Quantile(q) = *measure
            && !(0.0..=1.0).contains(&q)
        {
            return Err(BootstrapError::Quantile { found: q });
        }
    }
    Ok(())
}
