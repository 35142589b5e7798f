//! Rows of all clusters in ascending order, each with its cluster.

use crate::error::BootstrapError;
use crate::sort::sort_clusters;

/// Rows of all clusters in ascending order, each with its cluster: 12 bytes a row.
#[derive(Clone, Debug)]
pub struct SortedRows {
    pub(super) values: Vec<f64>,
    /// Of each row.
    pub(super) cluster: Vec<u32>,
    /// Of each cluster: rows, their sum, the sum of their squares.
    pub(super) totals: Vec<[f64; 3]>,
}

impl SortedRows {
    /// Sorts the rows of all clusters.
    ///
    /// # Errors
    ///
    /// [`BootstrapError::Rows`] for a row that is no number, and for more than 2^32 - 1 rows.
    pub fn new(clusters: &[impl AsRef<[f64]>]) -> Result<Self, BootstrapError> {
        let clusters: Vec<&[f64]> = clusters.iter().map(AsRef::as_ref).collect();
        for (cluster, rows) in clusters.iter().enumerate() {
            if let Some(row) = rows.iter().position(|value| !value.is_finite()) {
                let found = rows[row];
                return Err(BootstrapError::Rows(format!(
                    "row {row} of cluster {cluster} is {found}: expected a finite number, \
                     leave missing rows out and count them"
                )));
            }
        }
        let n: usize = clusters.iter().map(|rows| rows.len()).sum();
        check_count(n.max(clusters.len()))?;
        let (values, cluster) = sort_clusters(&clusters);
        let totals = clusters.iter().map(|rows| {
            let squares = rows.iter().map(|value| value * value);
            [rows.len() as f64, rows.iter().sum(), squares.sum()]
        });
        Ok(Self {
            values,
            cluster,
            totals: totals.collect(),
        })
    }

    /// The rows of several samples of the same clusters together: those of all fingers from those of each.
    /// They are sorted already, so this takes one pass.
    ///
    /// # Errors
    ///
    /// [`BootstrapError::Unpaired`] for different numbers of clusters, [`BootstrapError::Rows`] for more than
    /// 2^32 - 1 rows.
    pub fn merged(parts: &[Self]) -> Result<Self, BootstrapError> {
        let clusters = parts.first().map_or(0, |part| part.totals.len());
        if let Some(other) = parts.iter().find(|part| part.totals.len() != clusters) {
            return Err(BootstrapError::Unpaired {
                first: clusters,
                second: other.totals.len(),
            });
        }
        let n: usize = parts.iter().map(|part| part.values.len()).sum();
        check_count(n)?;
        let (mut values, mut cluster) = (vec![0.0; n], vec![0; n]);
        // Rows below a number in the middle and the others are merged at once.
        let middle = parts.iter().max_by_key(|part| part.values.len());
        let middle = middle.map_or(0.0, |part| {
            let middle = part.values.get(part.values.len() / 2);
            middle.copied().unwrap_or_default()
        });
        let (low, high): (Vec<_>, Vec<_>) = (parts.iter())
            .map(|part| {
                let at = part.values.partition_point(|value| *value < middle);
                let ((low, high), of) = (part.values.split_at(at), part.cluster.split_at(at));
                ((low, of.0), (high, of.1))
            })
            .unzip();
        let lower = low.iter().map(|(rows, _)| rows.len()).sum();
        let ((to_low, to_high), of) = (values.split_at_mut(lower), cluster.split_at_mut(lower));
        rayon::join(|| merge(&low, to_low, of.0), || merge(&high, to_high, of.1));
        let added = |c: usize| [0, 1, 2].map(|k| parts.iter().map(|part| part.totals[c][k]).sum());
        let totals = (0..clusters).map(added).collect();
        Ok(Self {
            values,
            cluster,
            totals,
        })
    }
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
