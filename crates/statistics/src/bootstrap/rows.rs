//! Rows in clusters, sorted once.

use inhand_model::Measure;

use super::draws::{Drawn, Draws};
use crate::error::BootstrapError;
use crate::sort::sort_by_number;

/// Rows are counted in blocks of at least this many: shorter ones would not make the walk through a
/// block much faster than the search for it.
const BLOCK_ROWS: usize = 64;

/// Rows of a block at most, however many clusters there are.
const MOST_BLOCK_ROWS: usize = 1 << 14;

/// Draws whose sums are added up side by side: one alone would wait for each addition.
const SIDE_BY_SIDE: usize = 8;

/// Guesses from where rows are expected; after them the search halves.
const GUESSES: usize = 6;

/// Rows in clusters, sorted together, with what is needed to find quantiles of any number of copies of
/// each cluster without copying a row.
///
/// Beside each sorted row stands its cluster, and beside every block of rows how many rows of each
/// cluster come before it. The row at place `k` of the multiset in which cluster `c` occurs `times[c]`
/// times is then found over the blocks, where the count before a block is the product of
/// `times` with the block's counts, and by a walk through one block. Draws are about as dense as the rows
/// themselves, so that each count tells how many blocks further the place is: two or three counts are enough. Blocks
/// have as many rows as there are clusters (64 at least), so that the counts need a sixth of the memory of the rows:
/// within a span of blocks they are of 16 bits, and processors multiply eight of those at once.
#[derive(Clone, Debug)]
pub struct ClusteredRows {
    sorted: Vec<f64>,
    /// Of each sorted row.
    cluster: Vec<u32>,
    block_rows: usize,
    /// Blocks whose rows can be counted with 16 bits.
    span_blocks: usize,
    /// (spans x clusters) rows of each cluster before each span.
    before_span: Vec<u32>,
    /// (blocks x clusters) rows of each cluster before each block in its span.
    before_block: Vec<i16>,
    /// Of each cluster.
    sizes: Vec<usize>,
    /// Of each cluster: rows, their sum, the sum of their squares.
    totals: Vec<[f64; 3]>,
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
        sort_by_number(&mut rows, |row| row.0);
        let (sorted, cluster): (Vec<f64>, Vec<u32>) = rows.into_iter().unzip();
        let totals = clusters.iter().map(|rows| {
            let rows = rows.as_ref();
            let squares = rows.iter().map(|value| value * value);
            [rows.len() as f64, rows.iter().sum(), squares.sum()]
        });
        Ok(Self::counted(sorted, cluster, totals.collect()))
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
        let (mut sorted, mut cluster) = (vec![0.0; n], vec![0; n]);
        // Rows below a number in the middle and the others are merged at once.
        let middle = parts.iter().max_by_key(|part| part.sorted.len());
        let middle = middle.map_or(0.0, |part| {
            let middle = part.sorted.get(part.sorted.len() / 2);
            middle.copied().unwrap_or_default()
        });
        let (low, high): (Vec<_>, Vec<_>) = (parts.iter())
            .map(|part| {
                let at = part.sorted.partition_point(|value| *value < middle);
                let ((low, high), of) = (part.sorted.split_at(at), part.cluster.split_at(at));
                ((low, of.0), (high, of.1))
            })
            .unzip();
        let lower = low.iter().map(|(rows, _)| rows.len()).sum();
        let ((to_low, to_high), of) = (sorted.split_at_mut(lower), cluster.split_at_mut(lower));
        rayon::join(|| merge(&low, to_low, of.0), || merge(&high, to_high, of.1));
        let added = |c: usize| [0, 1, 2].map(|k| parts.iter().map(|part| part.totals[c][k]).sum());
        let totals = (0..clusters).map(added).collect();
        Ok(Self::counted(sorted, cluster, totals))
    }

    /// Counts the rows of each cluster before each block; there are as many clusters as totals.
    fn counted(sorted: Vec<f64>, cluster: Vec<u32>, totals: Vec<[f64; 3]>) -> Self {
        let clusters = totals.len();
        let block_rows = clusters.clamp(BLOCK_ROWS, MOST_BLOCK_ROWS);
        let span_blocks = i16::MAX as usize / block_rows;
        let blocks = sorted.len().div_ceil(block_rows);
        let mut before_block = Vec::with_capacity(blocks * clusters);
        let mut before_span = Vec::with_capacity(blocks.div_ceil(span_blocks) * clusters);
        let (mut seen, mut in_span) = (vec![0_u32; clusters], vec![0_i16; clusters]);
        for span in cluster.chunks(block_rows * span_blocks) {
            before_span.extend_from_slice(&seen);
            in_span.fill(0);
            for block in span.chunks(block_rows) {
                before_block.extend_from_slice(&in_span);
                for &cluster in block {
                    in_span[cluster as usize] += 1;
                }
            }
            for (seen, &in_span) in seen.iter_mut().zip(&in_span) {
                *seen += in_span as u32;
            }
        }
        Self {
            sorted,
            cluster,
            block_rows,
            span_blocks,
            before_span,
            before_block,
            sizes: seen.into_iter().map(|size| size as usize).collect(),
            totals,
        }
    }

    /// Rows of each cluster.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// The rows of each cluster, ascending.
    pub fn by_cluster(&self) -> Vec<Vec<f64>> {
        self.by_group(&(0..self.sizes.len()).collect::<Vec<_>>())
    }

    /// The rows of groups of clusters, ascending; `group` is that of each cluster.
    pub fn by_group(&self, group: &[usize]) -> Vec<Vec<f64>> {
        let mut sizes = vec![0; group.iter().max().map_or(0, |last| last + 1)];
        for (&group, size) in group.iter().zip(&self.sizes) {
            sizes[group] += size;
        }
        let mut groups: Vec<Vec<f64>> = sizes.into_iter().map(Vec::with_capacity).collect();
        for (&value, &cluster) in self.sorted.iter().zip(&self.cluster) {
            groups[group[cluster as usize]].push(value);
        }
        groups
    }

    /// All rows, ascending.
    pub fn sorted(&self) -> &[f64] {
        &self.sorted
    }

    /// Each measure of the rows themselves, and of those of every draw; NaN without rows.
    ///
    /// Of fewer than two clusters with rows no draw is looked at: it would repeat them.
    ///
    /// # Errors
    ///
    /// [`BootstrapError::Unpaired`] for draws of another number of clusters.
    pub fn drawn(&self, draws: &Draws, measures: &[Measure]) -> Result<Drawn, BootstrapError> {
        draws.check_clusters(self.sizes.len())?;
        let kept = (self.sizes.iter().zip(draws.whole())).filter(|(_, times)| **times > 0);
        let (n, clusters) = (kept.filter(|(size, _)| **size > 0))
            .fold((0, 0), |(n, clusters), (size, _)| (n + size, clusters + 1));
        let mut values = vec![f64::NAN; measures.len()];
        self.measure([draws.whole()], measures, |measure, [value]| {
            values[measure] = value;
        });
        let mut drawn = vec![Vec::new(); measures.len()];
        if clusters > 1 {
            let all: Vec<&[i16]> = draws.each().collect();
            let (together, rest) = all.as_chunks::<SIDE_BY_SIDE>();
            for times in together {
                self.measure(*times, measures, |measure, found| {
                    drawn[measure].extend(found);
                });
            }
            for times in rest {
                self.measure([times], measures, |measure, found| {
                    drawn[measure].extend(found);
                });
            }
        }
        Ok(Drawn::new(n, clusters, (values, drawn), draws))
    }

    /// Each measure of the rows with cluster `c` taken `times[c]` times; NaN without rows.
    fn measure<const N: usize>(
        &self,
        times: [&[i16]; N],
        measures: &[Measure],
        mut found: impl FnMut(usize, [f64; N]),
    ) {
        let [n, sums, squares] = self.weighted(times);
        for (place, measure) in measures.iter().enumerate() {
            found(
                place,
                std::array::from_fn(|k| match *measure {
                    _ if n[k] == 0.0 => f64::NAN,
                    Measure::Mean => sums[k] / n[k],
                    Measure::Rmse => (squares[k] / n[k]).sqrt(),
                    Measure::P50 => self.quantile(times[k], n[k], 0.5),
                    Measure::P75 => self.quantile(times[k], n[k], 0.75),
                    Measure::P95 => self.quantile(times[k], n[k], 0.95),
                }),
            );
        }
    }

    /// The totals of each draw, a cluster after the other.
    fn weighted<const N: usize>(&self, times: [&[i16]; N]) -> [[f64; N]; 3] {
        let mut found = [[0.0; N]; 3];
        for (cluster, totals) in self.totals.iter().enumerate() {
            let times: [f64; N] = std::array::from_fn(|k| times[k][cluster].into());
            for (found, total) in found.iter_mut().zip(totals) {
                for (found, times) in found.iter_mut().zip(times) {
                    *found += times * total;
                }
            }
        }
        found
    }

    /// Type 7 among `n` rows, by the very operations of [`quantile`](crate::quantiles::quantile).
    fn quantile(&self, times: &[i16], n: f64, q: f64) -> f64 {
        let h = (n - 1.0) * q;
        let below = h as u64;
        let share = h - below as f64;
        let expected = (self.sorted.len() as f64 * q) as usize / self.block_rows;
        let (mut row, through) = self.find(times, below, expected);
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
    /// counted. There are more than `k` rows. The search begins at the block where it is `expected`.
    fn find(&self, times: &[i16], k: u64, expected: usize) -> (usize, u64) {
        // The last block that starts at place k or before; none comes before the first.
        let (mut low, mut high) = (0, self.sorted.len().div_ceil(self.block_rows));
        let (mut through, mut guess) = (0, expected);
        let mut span = (0, 0);
        for step in 0.. {
            if high - low <= 1 {
                break;
            }
            let block = guess.clamp(low + 1, high - 1);
            let before = self.count_before(times, block, &mut span);
            if before <= k {
                (low, through) = (block, before);
            } else {
                high = block;
            }
            let blocks_on = (k as i64 - before as i64).div_euclid(self.block_rows as i64);
            guess = match step < GUESSES {
                true => block.saturating_add_signed(blocks_on as isize),
                false => low.midpoint(high),
            };
        }
        let start = low * self.block_rows;
        for (row, &cluster) in (start..).zip(&self.cluster[start..]) {
            through += times[cluster as usize] as u64;
            if through > k {
                return (row, through);
            }
        }
        unreachable!("{k} is below the number of rows")
    }

    /// Rows before a block, copies counted. `span` is one with the rows before it, and becomes that of the block.
    fn count_before(&self, times: &[i16], block: usize, span: &mut (usize, u64)) -> u64 {
        let clusters = times.len();
        let of_block = block / self.span_blocks;
        if of_block != span.0 {
            let before = &self.before_span[of_block * clusters..][..clusters];
            let before = before.iter().zip(times);
            let before = before.map(|(&rows, &times)| u64::from(rows) * times as u64);
            *span = (of_block, before.sum());
        }
        let before = &self.before_block[block * clusters..][..clusters];
        let before = before.iter().zip(times);
        // A span has 2^15 rows at most, and none is taken as often: the sum is below 2^30.
        let before = before.map(|(&rows, &times)| i32::from(rows) * i32::from(times));
        span.1 + before.sum::<i32>() as u64
    }
}

/// Merges ascending rows and what stands beside them. The lists are few, so that the smallest head is looked for among
/// all of them.
fn merge(lists: &[(&[f64], &[u32])], sorted: &mut [f64], cluster: &mut [u32]) {
    // Rows are finite, so that no head of a list that is left comes after that of one at its end.
    let head = |list: usize, place: usize| lists[list].0.get(place).copied();
    let head = |list, place| head(list, place).unwrap_or(f64::INFINITY);
    let mut places = vec![0; lists.len()];
    let mut heads: Vec<f64> = (0..lists.len()).map(|list| head(list, 0)).collect();
    for (to, of) in sorted.iter_mut().zip(cluster) {
        let mut list = 0;
        for other in 1..heads.len() {
            if heads[other] < heads[list] {
                list = other;
            }
        }
        (*to, *of) = (heads[list], lists[list].1[places[list]]);
        places[list] += 1;
        heads[list] = head(list, places[list]);
    }
}
