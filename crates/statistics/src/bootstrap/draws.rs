//! Draws of clusters, and statistics in each of them.

use inhand_model::{Bootstrap, Estimate};

use super::{Difference, draw_clusters};
use crate::error::BootstrapError;
use crate::quantiles::quantile;
use crate::sort::sort_by_number;

/// How many times each cluster is taken, in every draw of a bootstrap: drawn once for all samples of the same clusters.
#[derive(Clone, Debug)]
pub struct Draws {
    confidence: f64,
    /// Of each cluster: 1, or 0 where it is left out.
    whole: Vec<i16>,
    /// (draws x clusters)
    times: Vec<i16>,
}

impl Draws {
    /// Draws clusters as [`draw_clusters`] does.
    ///
    /// # Errors
    ///
    /// [`BootstrapError`] for a confidence or number of draws that makes no sense.
    pub fn new(bootstrap: &Bootstrap, clusters: usize) -> Result<Self, BootstrapError> {
        let confidence = bootstrap.confidence;
        if !(confidence > 0.0 && confidence < 1.0) {
            return Err(BootstrapError::Confidence { found: confidence });
        }
        if bootstrap.draws == 0 {
            return Err(BootstrapError::NoDraws);
        }
        let mut times = Vec::with_capacity(bootstrap.draws * clusters);
        let mut of_draw = vec![0; clusters];
        for draw in 0..bootstrap.draws as u64 {
            draw_clusters(bootstrap.seed, draw, &mut of_draw);
            // No cluster is drawn 2^15 times: the chance of it is below 10^-100 000.
            times.extend(
                of_draw
                    .iter()
                    .map(|&times| times.min(i16::MAX as u32) as i16),
            );
        }
        Ok(Self {
            confidence,
            whole: vec![1; clusters],
            times,
        })
    }

    /// Draws of a second sample of other clusters, independent of those of the first: with the seed after its seed.
    ///
    /// # Errors
    ///
    /// As for [`new`](Self::new).
    pub fn apart(bootstrap: &Bootstrap, clusters: usize) -> Result<Self, BootstrapError> {
        let seed = bootstrap.seed.wrapping_add(1);
        Self::new(&Bootstrap { seed, ..*bootstrap }, clusters)
    }

    /// The same draws without the clusters that are not to be kept.
    ///
    /// # Errors
    ///
    /// [`BootstrapError::Unpaired`] for another number of clusters.
    pub fn only(&self, keep: &[bool]) -> Result<Self, BootstrapError> {
        self.check_clusters(keep.len())?;
        let kept = |times: &[i16]| -> Vec<i16> {
            let times = times.iter().zip(keep.iter().cycle());
            times
                .map(|(&times, &keep)| times * i16::from(keep))
                .collect()
        };
        Ok(Self {
            confidence: self.confidence,
            whole: kept(&self.whole),
            times: kept(&self.times),
        })
    }

    pub(super) fn check_clusters(&self, found: usize) -> Result<(), BootstrapError> {
        match self.whole.len() {
            expected if expected == found => Ok(()),
            expected => Err(BootstrapError::Unpaired {
                first: expected,
                second: found,
            }),
        }
    }

    /// Each cluster that is kept, once.
    pub(super) fn whole(&self) -> &[i16] {
        &self.whole
    }

    /// How many times each cluster is taken, a draw after the other.
    pub(super) fn each(&self) -> impl Iterator<Item = &[i16]> {
        self.times.chunks(self.whole.len().max(1))
    }
}

/// Statistics of a sample: of its rows, and of those of every draw.
#[derive(Clone, Debug)]
pub struct Drawn {
    n: usize,
    clusters: usize,
    confidence: f64,
    values: Vec<f64>,
    /// A list a statistic; without draws where fewer than two clusters have rows.
    drawn: Vec<Vec<f64>>,
}

impl Drawn {
    /// Of `n` rows in so many clusters.
    pub(super) fn new(
        n: usize,
        clusters: usize,
        (values, drawn): (Vec<f64>, Vec<Vec<f64>>),
        draws: &Draws,
    ) -> Self {
        Self {
            n,
            clusters,
            confidence: draws.confidence,
            values,
            drawn,
        }
    }

    /// Statistics of the rows themselves, in the order asked for; NaN without rows.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Estimates in the order asked for. A statistic of no rows is `None`.
    pub fn estimates(&self) -> Vec<Option<Estimate>> {
        let estimates = self.values.iter().zip(&self.drawn);
        estimates
            .map(|(&value, drawn)| self.estimate(value, drawn.clone()))
            .collect()
    }

    /// Differences of these statistics from those of another sample, of which the same were asked for; `None` for a
    /// statistic of no rows. Numbers of rows and clusters are those of this sample.
    pub fn less(&self, other: &Self) -> Vec<Option<Difference>> {
        let of_measure = |k: usize| {
            let absolute = self.values[k] - other.values[k];
            // A sample without draws has no spread, and so no difference from it has one.
            let drawn = self.drawn[k].iter().zip(&other.drawn[k]);
            let (less, relative) = drawn
                .map(|(own, other)| (own - other, (own - other) / other.abs()))
                .unzip();
            Some(Difference {
                absolute: self.estimate(absolute, less)?,
                relative: self.estimate(absolute / other.values[k].abs(), relative),
            })
        };
        (0..self.values.len()).map(of_measure).collect()
    }

    fn estimate(&self, value: f64, mut drawn: Vec<f64>) -> Option<Estimate> {
        if self.clusters < Estimate::FEWEST_CLUSTERS {
            drawn.clear();
        }
        drawn.retain(|value| value.is_finite());
        sort_by_number(&mut drawn, |&value| value);
        let tail = (1.0 - self.confidence) / 2.0;
        let ends = quantile(&drawn, tail).zip(quantile(&drawn, 1.0 - tail));
        let interval = ends.filter(|(low, high)| low < high);
        value.is_finite().then(|| Estimate {
            value,
            n: self.n,
            clusters: self.clusters,
            standard_error: interval.and_then(|_| standard_deviation(&drawn)),
            interval: interval.map(|(low, high)| [low, high]),
        })
    }
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
