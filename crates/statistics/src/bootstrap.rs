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
//! work changes a result. [`Draws`] has them for all samples of the same clusters. The rows of a draw are never put
//! together: [`ClusteredRows`] sorts them once and finds the very numbers ([`Drawn`]).
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

mod draws;
mod rows;
mod sorted;

use inhand_model::{Bootstrap, Estimate, Measure};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

pub use self::draws::{Drawn, Draws};
pub use self::rows::ClusteredRows;
pub use self::sorted::SortedRows;
use crate::error::BootstrapError;

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
    let draws = Draws::new(bootstrap, rows.sizes().len())?;
    Ok(rows.drawn(&draws, measures)?.estimates())
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
    let draws = Draws::new(bootstrap, first.sizes().len())?;
    let of_second = match paired {
        true => second.drawn(&draws, measures)?,
        false => second.drawn(&Draws::apart(bootstrap, second.sizes().len())?, measures)?,
    };
    Ok(first.drawn(&draws, measures)?.less(&of_second))
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
