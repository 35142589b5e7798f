//! Rows in clusters, sorted once.

use std::borrow::Cow;

use inhand_model::Measure;
use rayon::prelude::*;

use super::draws::{Drawn, Draws};
use super::sorted::SortedRows;
use crate::error::BootstrapError;

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
    rows: SortedRows,
    block_rows: usize,
    /// Blocks whose rows can be counted with 16 bits.
    span_blocks: usize,
    /// (spans x clusters) rows of each cluster before each span.
    before_span: Vec<u32>,
    /// (blocks x clusters) rows of each cluster before each block in its span.
    before_block: Vec<i16>,
    /// Of each cluster.
    sizes: Vec<usize>,
}

impl From<SortedRows> for ClusteredRows {
    /// Counts the rows of each cluster before each block.
    fn from(rows: SortedRows) -> Self {
        let clusters = rows.totals.len();
        let block_rows = clusters.clamp(BLOCK_ROWS, MOST_BLOCK_ROWS);
        let span_blocks = i16::MAX as usize / block_rows;
        let blocks = rows.values.len().div_ceil(block_rows);
        let mut before_block = Vec::with_capacity(blocks * clusters);
        let mut before_span = Vec::with_capacity(blocks.div_ceil(span_blocks) * clusters);
        let (mut seen, mut in_span) = (vec![0_u32; clusters], vec![0_i16; clusters]);
        for span in rows.cluster.chunks(block_rows * span_blocks) {
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
            rows,
            block_rows,
            span_blocks,
            before_span,
            before_block,
            sizes: seen.into_iter().map(|size| size as usize).collect(),
        }
    }
}

impl ClusteredRows {
    /// Sorts the rows of all clusters. A cluster may have no rows; it is drawn as any other.
    ///
    /// # Errors
    ///
    /// As [`SortedRows::new`].
    pub fn new(clusters: &[impl AsRef<[f64]>]) -> Result<Self, BootstrapError> {
        Ok(SortedRows::new(clusters)?.into())
    }

    /// The rows without the counts.
    pub fn into_rows(self) -> SortedRows {
        self.rows
    }

    /// Rows of each cluster.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// The rows of each cluster, ascending.
    pub fn by_cluster(&self) -> Vec<Vec<f64>> {
        let mut found: Vec<_> = self.sizes.iter().map(|&n| Vec::with_capacity(n)).collect();
        for (&value, &cluster) in self.rows.values.iter().zip(&self.rows.cluster) {
            found[cluster as usize].push(value);
        }
        found
    }

    /// The rows of some clusters together, ascending; without a copy where these are all of them.
    pub fn of_clusters(&self, clusters: &[usize]) -> Cow<'_, [f64]> {
        let mut kept = vec![false; self.sizes.len()];
        clusters.iter().for_each(|&cluster| kept[cluster] = true);
        if kept.iter().all(|&kept| kept) {
            return Cow::Borrowed(self.sorted());
        }
        let mut found =
            Vec::with_capacity(clusters.iter().map(|&cluster| self.sizes[cluster]).sum());
        let rows = self.rows.values.iter().zip(&self.rows.cluster);
        found.extend(rows.filter(|row| kept[*row.1 as usize]).map(|row| *row.0));
        found.into()
    }

    /// All rows, ascending.
    pub fn sorted(&self) -> &[f64] {
        &self.rows.values
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
        let values = self.measured([draws.whole()], measures);
        let values = values.into_iter().map(|[value]| value).collect();
        let mut drawn = vec![Vec::new(); measures.len()];
        if clusters > 1 {
            let all: Vec<&[i16]> = draws.each().collect();
            let (together, rest) = all.as_chunks::<SIDE_BY_SIDE>();
            let found: Vec<_> = together
                .par_iter()
                .map(|times| self.measured(*times, measures))
                .collect();
            for (measure, drawn) in drawn.iter_mut().enumerate() {
                drawn.extend(found.iter().flat_map(|found| found[measure]));
            }
            for times in rest {
                for (drawn, [found]) in drawn.iter_mut().zip(self.measured([times], measures)) {
                    drawn.push(found);
                }
            }
        }
        Ok(Drawn::new(n, clusters, (values, drawn), draws))
    }

    /// Each measure of the rows with cluster `c` taken `times[c]` times; NaN without rows.
    fn measured<const N: usize>(&self, times: [&[i16]; N], measures: &[Measure]) -> Vec<[f64; N]> {
        let [n, sums, squares] = self.weighted(times);
        let of_draw = |measure: Measure, k: usize| match measure {
            _ if n[k] == 0.0 => f64::NAN,
            Measure::Mean => sums[k] / n[k],
            Measure::Rmse => (squares[k] / n[k]).sqrt(),
            Measure::P50 => self.quantile(times[k], n[k], 0.5),
            Measure::P75 => self.quantile(times[k], n[k], 0.75),
            Measure::P95 => self.quantile(times[k], n[k], 0.95),
        };
        (measures.iter())
            .map(|&measure| std::array::from_fn(|k| of_draw(measure, k)))
            .collect()
    }

    /// The totals of each draw, a cluster after the other.
    fn weighted<const N: usize>(&self, times: [&[i16]; N]) -> [[f64; N]; 3] {
        let mut found = [[0.0; N]; 3];
        for (cluster, totals) in self.rows.totals.iter().enumerate() {
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
        let expected = (self.rows.values.len() as f64 * q) as usize / self.block_rows;
        let (mut row, through) = self.find(times, below, expected);
        let low = self.rows.values[row];
        if share == 0.0 {
            return low;
        }
        // A share is left, so `below` is not the last place; the row at the next one is another copy
        // of this row or the next that occurs.
        if below + 1 >= through {
            row += 1;
            while times[self.rows.cluster[row] as usize] == 0 {
                row += 1;
            }
        }
        low + share * (self.rows.values[row] - low)
    }

    /// The sorted row at place `k`, and how many rows there are up to it and with it, copies
    /// counted. There are more than `k` rows. The search begins at the block where it is `expected`.
    fn find(&self, times: &[i16], k: u64, expected: usize) -> (usize, u64) {
        // The last block that starts at place k or before; none comes before the first.
        let (mut low, mut high) = (0, self.rows.values.len().div_ceil(self.block_rows));
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
        for (row, &cluster) in (start..).zip(&self.rows.cluster[start..]) {
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
