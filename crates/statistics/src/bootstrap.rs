//! Bootstrap intervals of statistics over clusters of rows.
//!
//! Errors of neighbouring instants are not independent: a bootstrap over instants would give
//! intervals that are far too narrow. What is independent are segments (within one session) or
//! sessions (across several). So rows are grouped in *clusters*; a draw takes as many clusters as
//! there are, with replacement, and the statistic is computed on all rows of the drawn clusters,
//! a cluster drawn twice counting twice (Davison and Hinkley, *Bootstrap Methods and their
//! Application*, 1997, section 3.8: clusters resampled, rows in them kept).
//!
//! The interval is the percentile interval: from quantile `(1 - confidence) / 2` to
//! `(1 + confidence) / 2` (type 7) of the statistic over the draws. There is none of fewer than
//! [`Estimate::FEWEST_CLUSTERS`] clusters with rows, nor where no draw differs from another: an
//! interval of no width would pass for certainty.
//!
//! Which clusters a draw takes depends on seed, number of the draw and number of clusters alone
//! ([`draw_clusters`]), so that two methods on the same clusters are drawn together and no order of
//! work changes a result. The rows of a draw are never put together: [`ClusteredRows`] sorts them
//! once and finds the very numbers.
//!
//! ```
//! use inhand_model::{Bootstrap, Cluster, Measure};
//! use inhand_statistics::bootstrap::{ClusteredRows, intervals};
//!
//! // Errors (metres) in five segments of two instants each.
//! let rows = ClusteredRows::new(&[
//!     [0.001, 0.002], [0.004, 0.002], [0.001, 0.003], [0.002, 0.005], [0.002, 0.001],
//! ])?;
//! let bootstrap = Bootstrap { cluster: Cluster::Segment, draws: 2000, seed: 7, confidence: 0.95 };
//! let median = intervals(&rows, &[Measure::P50], &bootstrap)?[0].unwrap();
//! assert_eq!(median.value, 0.002);
//! let [low, high] = median.interval.unwrap();
//! assert!(low >= 0.001 && low < 0.002 && high <= 0.0045);
//! # Ok::<(), inhand_statistics::BootstrapError>(())
//! ```

mod rows;

use inhand_model::{Bootstrap, Estimate, Measure};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

pub use self::rows::ClusteredRows;
use crate::error::BootstrapError;
use crate::quantiles::quantile;

/// Difference of a statistic between two samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// First less second; negative where the first is smaller. Unit of the rows.
    pub absolute: Estimate,
    /// The difference over the size of the second, no unit: -0.2 is less than the second by 20 % of it, of
    /// whichever sign it is. `None` where the second is 0.
    pub relative: Option<Estimate>,
}

/// Estimates of several statistics of the same rows, in the order asked for, from the same draws.
///
/// A statistic of no rows is `None`. The quantiles are bit for bit those of the rows of each draw
/// sorted together; means and root mean squares add up per cluster and agree to rounding.
///
/// Cost: each draw takes O(clusters log(rows / clusters)) a statistic, whatever the number of rows.
///
/// # Errors
///
/// [`BootstrapError`] for a confidence or number of draws that makes no sense.
pub fn intervals(
    rows: &ClusteredRows,
    measures: &[Measure],
    bootstrap: &Bootstrap,
) -> Result<Vec<Option<Estimate>>, BootstrapError> {
    let clusters = [rows.sizes().len()];
    let measure = |times: &[u32], found: &mut [f64]| rows.measure(times, measures, found);
    estimates(&[rows], &clusters, measures.len(), bootstrap, measure)
}

/// Differences of statistics of `first` from those of `second`.
///
/// Where both are of the same clusters (`paired`), the same are drawn from both. What varies from cluster
/// to cluster in both alike (hard segments are hard for every method) cancels: the interval of the
/// difference is narrower than the two intervals apart would suggest. Clusters may have different numbers
/// of rows in both, and none in one of them. Otherwise clusters of both are drawn apart, those of the
/// second with the seed after the first's.
///
/// `None` for a statistic of no rows. Numbers of rows and clusters are those of the first.
///
/// # Errors
///
/// [`BootstrapError::Unpaired`] for pairs of different numbers of clusters; others as for [`intervals`].
pub fn differences(
    first: &ClusteredRows,
    second: &ClusteredRows,
    paired: bool,
    measures: &[Measure],
    bootstrap: &Bootstrap,
) -> Result<Vec<Option<Difference>>, BootstrapError> {
    let clusters = [first.sizes().len(), second.sizes().len()];
    if paired && clusters[0] != clusters[1] {
        let [first, second] = clusters;
        return Err(BootstrapError::Unpaired { first, second });
    }
    let (drawn, start) = if paired {
        (&clusters[..1], 0)
    } else {
        (&clusters[..], clusters[0])
    };
    let mut of_second = vec![f64::NAN; measures.len()];
    let difference = |times: &[u32], found: &mut [f64]| {
        let (absolute, relative) = found.split_at_mut(measures.len());
        first.measure(&times[..clusters[0]], measures, absolute);
        second.measure(&times[start..], measures, &mut of_second);
        for ((absolute, relative), &second) in absolute.iter_mut().zip(relative).zip(&of_second) {
            *absolute -= second;
            *relative = *absolute / second.abs();
        }
    };
    let width = 2 * measures.len();
    let found = estimates(&[first, second], drawn, width, bootstrap, difference)?;
    let (absolute, relative) = found.split_at(measures.len());
    Ok((absolute.iter().zip(relative))
        .map(|(&absolute, &relative)| absolute.map(|absolute| Difference { absolute, relative }))
        .collect())
}

/// Writes how many times draw number `draw` takes each cluster; it takes as many clusters as there are.
///
/// Anyone can repeat the draws: their numbers are those of ChaCha with 8 rounds, a 64-bit
/// counter and a 64-bit stream number (Bernstein's layout), with the seed's eight bytes and 24 zeros
/// (little-endian) as key and `draw` as stream. Each 64-bit word `x` (two 32-bit words, the lower first)
/// takes cluster `floor(x * clusters / 2^64)`. (A cluster's probability is off by less than
/// 2^-32 of itself.)
///
/// ```
/// use inhand_statistics::bootstrap::draw_clusters;
///
/// let mut times = vec![0; 5];
/// draw_clusters(1, 0, &mut times);
/// assert_eq!(times.iter().sum::<u32>(), 5);
/// ```
pub fn draw_clusters(seed: u64, draw: u64, times: &mut [u32]) {
    times.fill(0);
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    let mut random = ChaCha8Rng::from_seed(key);
    random.set_stream(draw);
    for _ in 0..times.len() {
        let place = (u128::from(random.next_u64()) * times.len() as u128) >> 64;
        times[place as usize] += 1;
    }
}

/// Estimates of `width` statistics. `statistics` gets how many times each cluster is taken and writes
/// `width` numbers, NaN or infinite where one is not defined. `clusters` are the numbers of those that are
/// drawn together, one part after the other.
fn estimates(
    samples: &[&ClusteredRows],
    clusters: &[usize],
    width: usize,
    bootstrap: &Bootstrap,
    mut statistics: impl FnMut(&[u32], &mut [f64]),
) -> Result<Vec<Option<Estimate>>, BootstrapError> {
    let &Bootstrap {
        draws,
        seed,
        confidence,
        ..
    } = bootstrap;
    if !(confidence > 0.0 && confidence < 1.0) {
        return Err(BootstrapError::Confidence { found: confidence });
    }
    if draws == 0 {
        return Err(BootstrapError::NoDraws);
    }
    let mut times = vec![1; clusters.iter().sum()];
    let mut found = vec![f64::NAN; width];
    statistics(&times, &mut found);
    let values = found.clone();

    let mut drawn = vec![Vec::new(); width];
    let occupied = |rows: &&ClusteredRows| rows.sizes().iter().filter(|&&size| size > 0).count();
    let counted = samples.first().map_or(0, occupied);
    // A sample with rows in one cluster only repeats them in every draw that is defined.
    let spread = samples.iter().all(|rows| occupied(rows) >= 2);
    let draws = if spread && counted >= Estimate::FEWEST_CLUSTERS {
        draws as u64
    } else {
        0
    };
    for draw in 0..draws {
        let mut rest = times.as_mut_slice();
        for (&size, part) in clusters.iter().zip(0..) {
            let (own, others) = rest.split_at_mut(size);
            draw_clusters(seed.wrapping_add(part), draw, own);
            rest = others;
        }
        statistics(&times, &mut found);
        for (drawn, &found) in drawn.iter_mut().zip(&found) {
            drawn.push(found);
        }
    }
    let tail = (1.0 - confidence) / 2.0;
    let estimate = |value, mut drawn: Vec<f64>| {
        drawn.retain(|value| value.is_finite());
        drawn.sort_unstable_by(f64::total_cmp);
        let ends = quantile(&drawn, tail).zip(quantile(&drawn, 1.0 - tail));
        let interval = ends.filter(|(low, high)| low < high);
        Estimate {
            value,
            n: samples.first().map_or(0, |rows| rows.sorted().len()),
            clusters: counted,
            standard_error: interval.and_then(|_| standard_deviation(&drawn)),
            interval: interval.map(|(low, high)| [low, high]),
        }
    };
    Ok((values.into_iter().zip(drawn))
        .map(|(value, drawn)| value.is_finite().then(|| estimate(value, drawn)))
        .collect())
}

/// Standard deviation with divisor n - 1; `None` of a single value.
fn standard_deviation(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    if values.len() < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((squares / (n - 1.0)).sqrt())
}
