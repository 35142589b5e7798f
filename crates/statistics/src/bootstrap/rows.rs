//! Rows in clusters, sorted once.

use inhand_model::Measure;
use rayon::prelude::*;

use crate::error::BootstrapError;

/// Rows are counted in blocks of at least this many: shorter ones would not make the walk through a
/// block much faster than the search for it.
const BLOCK_ROWS: usize = 64;

/// Rows in clusters, sorted together, with what is needed to find quantiles of any number of copies of
/// each cluster without copying a row.
///
/// Beside each sorted row stands its cluster, and beside every block of rows how many rows of each
/// cluster come before it. The row at place `k` of the multiset in which cluster `c` occurs `times[c]`
/// times is then found by halving over the blocks, where the count before a block is the product of
/// `times` with the block's counts, and by a walk through one block. Blocks have four times as many rows as
/// there are clusters (64 at least): the walk takes about as long as the halving, and the counts need an
/// eighth of the memory of the rows.
#[derive(Clone, Debug)]
pub struct ClusteredRows {
    sorted: Vec<f64>,
    /// Of each sorted row.
    cluster: Vec<u32>,
    block_rows: usize,
    /// (blocks x clusters) rows of each cluster before each block.
    before: Vec<u32>,
    /// Of each cluster.
    sizes: Vec<usize>,
    sums: Vec<f64>,
    sums_of_squares: Vec<f64>,
}

/// Refuses more rows or clusters than are counted with 32 bits.
fn check_count(found: usize) -> Result<(), BootstrapError> {
    let limit = u32::MAX as usize;
    if found > limit {
        return Err(BootstrapError::Rows(format!(
            "{found} rows or clusters: expected at most {limit}, bootstrap over larger parts"
        )));
    }
    Ok(())
}

/// Rows ascend; equal ones stand in the order of their clusters.
fn order(a: &(f64, u32), b: &(f64, u32)) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

impl ClusteredRows {
    /// Sorts the rows of all clusters. A cluster may have no rows; it is drawn as any other.
    ///
    /// # Errors
    ///
    /// [`BootstrapError::Rows`] for a row that is no number, and for more than 2^32 - 1 rows.
    pub fn new(clusters: &[impl AsRef<[f64]>]) -> Result<Self, BootstrapError> {
        for (cluster, rows) in clusters.iter().enumerate() {
            if let Some(row) = rows.as_ref().iter().position(|value| !value.is_finite()) {
                let found = rows.as_ref()[row];
                return Err(BootstrapError::Rows(format!(
                    "row {row} of cluster {cluster} is {found}: expected a finite number, \
                     leave missing rows out and count them"
                )));
            }
        }
        let n: usize = clusters.iter().map(|rows| rows.as_ref().len()).sum();
        check_count(n.max(clusters.len()))?;
        let mut rows: Vec<(f64, u32)> = (clusters.iter().zip(0..))
            .flat_map(|(rows, cluster)| rows.as_ref().iter().map(move |&value| (value, cluster)))
            .collect();
        rows.par_sort_unstable_by(order);
        let (sorted, cluster): (Vec<f64>, Vec<u32>) = rows.into_iter().unzip();
        let sums = |of: fn(f64) -> f64| -> Vec<f64> {
            (clusters.iter())
                .map(|rows| rows.as_ref().iter().map(|&value| of(value)).sum())
                .collect()
        };
        let (sums, sums_of_squares) = (sums(|value| value), sums(|value| value * value));
        Ok(Self::counted(sorted, cluster, sums, sums_of_squares))
    }

    /// The rows of several samples of the same clusters together: those of all fingers from those of each.
    /// They are sorted already, so this takes one pass.
    ///
    /// # Errors
    ///
    /// [`BootstrapError::Unpaired`] for different numbers of clusters, [`BootstrapError::Rows`] for more than
    /// 2^32 - 1 rows.
    pub fn merged(parts: &[&Self]) -> Result<Self, BootstrapError> {
        let clusters = parts.first().map_or(0, |part| part.sizes.len());
        if let Some(other) = parts.iter().find(|part| part.sizes.len() != clusters) {
            return Err(BootstrapError::Unpaired {
                first: clusters,
                second: other.sizes.len(),
            });
        }
        let n: usize = parts.iter().map(|part| part.sorted.len()).sum();
        check_count(n)?;
        let (mut sorted, mut cluster) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut heads = vec![0; parts.len()];
        let row = |part: usize, head: usize| {
            let rows: &Self = parts[part];
            Some((*rows.sorted.get(head)?, rows.cluster[head]))
        };
        // Parts are few: the smallest head is looked for among all of them.
        while let Some((part, (value, of))) = (heads.iter().enumerate())
            .filter_map(|(part, &head)| Some((part, row(part, head)?)))
            .min_by(|a, b| order(&a.1, &b.1))
        {
            heads[part] += 1;
            sorted.push(value);
            cluster.push(of);
        }
        let added = |of: fn(&Self) -> &Vec<f64>| -> Vec<f64> {
            (0..clusters)
                .map(|c| parts.iter().map(|part| of(part)[c]).sum())
                .collect()
        };
        let (sums, squares) = (
            added(|part| &part.sums),
            added(|part| &part.sums_of_squares),
        );
        Ok(Self::counted(sorted, cluster, sums, squares))
    }

    /// The same rows without those of the clusters that are not to be kept; they stay as clusters without rows, so that
    /// draws are the same.
    #[must_use]
    pub fn only(&self, keep: &[bool]) -> Self {
        let kept = |cluster: usize| keep.get(cluster).copied().unwrap_or(false);
        let rows = self.sorted.iter().zip(&self.cluster);
        let (sorted, cluster) = rows
            .filter(|(_, cluster)| kept(**cluster as usize))
            .map(|(&value, &cluster)| (value, cluster))
            .unzip();
        let of_kept = |sums: &[f64]| -> Vec<f64> {
            let sums = sums.iter().enumerate();
            sums.map(|(c, &sum)| if kept(c) { sum } else { 0.0 })
                .collect()
        };
        let (sums, squares) = (of_kept(&self.sums), of_kept(&self.sums_of_squares));
        Self::counted(sorted, cluster, sums, squares)
    }

    /// Counts the rows of each cluster before each block; there are as many clusters as sums.
    fn counted(
        sorted: Vec<f64>,
        cluster: Vec<u32>,
        sums: Vec<f64>,
        sums_of_squares: Vec<f64>,
    ) -> Self {
        let clusters = sums.len();
        let block_rows = (4 * clusters).max(BLOCK_ROWS);
        let mut before = Vec::with_capacity(sorted.len().div_ceil(block_rows) * clusters);
        let mut seen = vec![0_u32; clusters];
        for block in cluster.chunks(block_rows) {
            before.extend_from_slice(&seen);
            for &cluster in block {
                seen[cluster as usize] += 1;
            }
        }
        Self {
            sorted,
            cluster,
            block_rows,
            before,
            sizes: seen.into_iter().map(|size| size as usize).collect(),
            sums,
            sums_of_squares,
        }
    }

    /// Rows of each cluster.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// The rows of each cluster, ascending.
    pub fn by_cluster(&self) -> Vec<Vec<f64>> {
        let mut clusters: Vec<Vec<f64>> = (self.sizes.iter())
            .map(|&size| Vec::with_capacity(size))
            .collect();
        for (&value, &cluster) in self.sorted.iter().zip(&self.cluster) {
            clusters[cluster as usize].push(value);
        }
        clusters
    }

    /// All rows, ascending.
    pub fn sorted(&self) -> &[f64] {
        &self.sorted
    }

    /// Each measure of the rows themselves; NaN without rows.
    pub fn measures(&self, measures: &[Measure]) -> Vec<f64> {
        let mut found = vec![f64::NAN; measures.len()];
        self.measure(&vec![1; self.sizes.len()], measures, &mut found);
        found
    }

    /// Each measure of the rows with cluster `c` taken `times[c]` times; NaN without rows.
    pub(crate) fn measure(&self, times: &[u32], measures: &[Measure], found: &mut [f64]) {
        let n: u64 = (times.iter().zip(&self.sizes))
            .map(|(&times, &size)| u64::from(times) * size as u64)
            .sum();
        let weighted = |sums: &[f64]| -> f64 {
            (times.iter().zip(sums))
                .map(|(&times, sum)| f64::from(times) * sum)
                .sum()
        };
        for (measure, found) in measures.iter().zip(found) {
            *found = match *measure {
                _ if n == 0 => f64::NAN,
                Measure::Mean => weighted(&self.sums) / n as f64,
                Measure::Rmse => (weighted(&self.sums_of_squares) / n as f64).sqrt(),
                Measure::P50 => self.quantile(times, n, 0.5),
                Measure::P75 => self.quantile(times, n, 0.75),
                Measure::P95 => self.quantile(times, n, 0.95),
            };
        }
    }

    /// Type 7 among `n` rows, by the very operations of [`quantile`](crate::quantiles::quantile).
    fn quantile(&self, times: &[u32], n: u64, q: f64) -> f64 {
        let h = (n - 1) as f64 * q;
        let below = h as u64;
        let share = h - below as f64;
        let (mut row, through) = self.find(times, below);
        let low = self.sorted[row];
        if share == 0.0 {
            return low;
        }
        // A share is left, so `below` is not the last place; the row at the next one is another copy
        // of this row or the next that occurs.
        if below + 1 >= through {
            row += 1;
            while times[self.cluster[row] as usize] == 0 {
                row += 1;
            }
        }
        low + share * (self.sorted[row] - low)
    }

    /// The sorted row at place `k`, and how many rows there are up to it and with it, copies
    /// counted. There are more than `k` rows.
    fn find(&self, times: &[u32], k: u64) -> (usize, u64) {
        let clusters = times.len();
        let count_before = |block: usize| -> u64 {
            (self.before[block * clusters..][..clusters]
                .iter()
                .zip(times))
            .map(|(&rows, &times)| u64::from(rows) * u64::from(times))
            .sum()
        };
        // The last block that starts at place k or before; none comes before the first.
        let (mut low, mut high) = (0, self.sorted.len().div_ceil(self.block_rows));
        let mut through = 0;
        while high - low > 1 {
            let middle = low.midpoint(high);
            let before = count_before(middle);
            if before <= k {
                (low, through) = (middle, before);
            } else {
                high = middle;
            }
        }
        let mut row = low * self.block_rows;
        loop {
            through += u64::from(times[self.cluster[row] as usize]);
            if through > k {
                return (row, through);
            }
            row += 1;
        }
    }
}
