//! Errors of dictionaries of different ranks on takes left out of learning.

mod fit;

use std::collections::BTreeMap;
use std::ops::Range;

use inhand_model::{
    Demonstrated, Dictionary, DictionaryKind, HeldOut, RankPoint, SegmentLayout, Segments,
};

use crate::data::{check_any_rank, place};
use crate::error::{LearnError, check_setting};
use crate::nmf::learn_nmf;
use crate::pca::learn_pca;
use crate::residual::{Fold, folds};
use crate::settings::NmfSettings;
use fit::{fitted, squared_errors_m2};

/// Share of a left-out segment that is hidden and predicted, in its middle.
const HIDDEN_SHARE: f64 = 0.3;
/// Time over which the errors of a dictionary are alike, seconds: what it misses of smooth motion is
/// smooth. Without this every sample would count as evidence of its own and the prior would hardly
/// count: on a hand session of 595 segments PCA of rank 100 then predicts with 0.76 mm, with it
/// 0.52 mm; ten times as long is better still for PCA but worse for NMF.
const ALIKE_S: f64 = 0.1;
/// Fewest samples of a segment: some before, some in and some after the hidden part.
const LEAST_SAMPLES: usize = 3;

/// Kind of dictionary that is learned at each rank.
#[derive(Clone, Copy, Debug)]
pub enum RankMethod<'a> {
    /// Non-negative matrix factorisation with these settings; their rank is not used.
    Nmf(&'a NmfSettings),
    /// Principal components.
    Pca,
}

/// Groups in which segments are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RankGroups {
    /// By take.
    Takes,
    /// By intervals of the only take.
    Intervals,
}

/// Errors of dictionaries of different ranks.
#[derive(Clone, Debug, PartialEq)]
pub struct RankCurve {
    /// Kind of dictionary.
    pub kind: DictionaryKind,
    /// One for each rank that could be learned, smallest first; at least one.
    pub points: Vec<RankPoint>,
    /// Ranks asked for that some group's other segments do not support, smallest first.
    pub too_large: Vec<usize>,
    /// Largest rank that the segments outside of each group support.
    pub largest: usize,
    /// Training segments.
    pub segments: usize,
    /// Segments that were left out in turn and judged; none overlaps another.
    pub left_out: usize,
    /// Groups in which they were left out.
    pub by: RankGroups,
    /// Takes, or intervals of the only one.
    pub groups: usize,
    /// Samples of each left-out segment that were hidden and predicted.
    pub hidden: Range<usize>,
    /// Samples per second.
    pub rate_hz: f64,
}

/// The rank to learn with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankSuggestion {
    /// Smallest rank whose prediction error is not above `limit_m`.
    pub rank: usize,
    /// Its prediction error, metres.
    pub predicted_m: f64,
    /// Rank of the smallest prediction error.
    pub best_rank: usize,
    /// The smallest prediction error, metres.
    pub best_m: f64,
    /// The smallest prediction error and its standard error, metres; the smallest error alone where
    /// that has none.
    pub limit_m: f64,
    /// Whether the error is smallest at the largest rank tried, so that a larger one may be better.
    pub still_falling: bool,
}

/// Learns dictionaries of the given ranks and judges each on segments left out of learning.
///
/// Segments are left out by take ([`folds`]; a single take by intervals), never by segment: overlapping
/// or neighbouring segments are nearly the same. For each group the dictionary is learned from the
/// others, and the group's segments are
///
/// * reconstructed: activations by least squares on all rows (non-negative for NMF), the error over
///   all rows. More primitives always come nearer, so it only falls;
/// * predicted: the middle 0.3 of the segment hidden for all fingers (and the object), activations
///   from the visible rows, the error over the hidden ones. Hiding rows of left-out columns is the
///   holdout of Gabriel ("Le biplot", 2002) and Owen and Perry ("Bi-cross-validation of the SVD and
///   the nonnegative matrix factorization", Annals of Applied Statistics 2009), whose error has a
///   minimum.
///
/// Visible rows alone do not settle activations of primitives that act in the hidden part: plain least
/// squares then peaks where the rank nears the number of independent visible numbers, whatever the
/// data. So the fit expects activations as the training ones are (their mean and covariance, as
/// planners do), against rows that are off by the training error, errors over 0.1 s counted as one.
///
/// `progress` is called with each point as it is ready, smallest rank first.
///
/// Cost: for each rank, learning once more than there are groups (at most 8), and two least squares for
/// each of at most 600 left-out segments. PCA is learned once for all ranks.
///
/// # Errors
///
/// [`LearnError`] as for learning; [`LearnError::Data`] for too few segments to leave any out and where
/// all ranks are too large, [`LearnError::Setting`] for rank 0, no rank at all or segments of less than
/// three samples.
pub fn rank_curve(
    segments: &Segments,
    method: RankMethod<'_>,
    ranks: &[usize],
    progress: &mut dyn FnMut(&RankPoint),
) -> Result<RankCurve, LearnError> {
    let layout = segments.layout();
    let mut ranks = ranks.to_vec();
    ranks.sort_unstable();
    ranks.dedup();
    check(layout, &ranks)?;
    let folds = whole(folds(segments.origins(), layout.samples), segments);
    if folds.is_empty() {
        return Err(LearnError::Data(format!(
            "{} training segments are too few to leave any out and judge ranks by them: name one rank, \
             or give more takes",
            segments.len()
        )));
    }
    let learner = Learner::new(segments, method, &folds, ranks[ranks.len() - 1])?;
    let largest = learner.largest();
    let too_large = ranks.split_off(ranks.partition_point(|&rank| rank <= largest));
    if ranks.is_empty() {
        return Err(LearnError::Data(format!(
            "rank {} and above are too large: without the takes left out in turn, {} training segments \
             support ranks up to {largest}; lower the ranks or the stride",
            too_large[0],
            segments.len()
        )));
    }

    let judge = Judge::new(segments, &folds);
    let (spread_m2, numbers) = squared_deviation_m2(segments);
    let mut points = Vec::with_capacity(ranks.len());
    let mut groups = 0;
    for rank in ranks {
        let training_rms_m = learner.learned(None, rank)?.learning.rms_m;
        let squares_m2 = training_rms_m.powi(2) * numbers as f64;
        let (reconstructed, predicted) = judge.errors(&learner, rank)?;
        groups = predicted.groups.len();
        let point = RankPoint {
            rank,
            training_rms_m,
            explained_variance: 1.0 - squares_m2 / spread_m2,
            reconstructed: reconstructed.summary(),
            predicted: predicted.summary(),
        };
        progress(&point);
        points.push(point);
    }
    Ok(RankCurve {
        kind: match method {
            RankMethod::Nmf(_) => DictionaryKind::Nmf,
            RankMethod::Pca => DictionaryKind::Pca,
        },
        points,
        too_large,
        largest,
        segments: segments.len(),
        left_out: folds.iter().map(|fold| fold.left_out.len()).sum(),
        by: judge.by,
        groups,
        hidden: judge.hidden_samples,
        rate_hz: layout.rate_hz,
    })
}

impl RankCurve {
    /// The smallest rank whose prediction error is within one standard error of the smallest: what
    /// more primitives gain beyond that is less than what another choice of takes would change
    /// (Breiman and others, Classification and Regression Trees, 1984, section 3.4.3). `None` for a
    /// curve without points.
    pub fn suggestion(&self) -> Option<RankSuggestion> {
        let error = |point: &&RankPoint| point.predicted.rms_m;
        let best = (self.points.iter()).min_by(|a, b| error(a).total_cmp(&error(b)))?;
        let best_m = best.predicted.rms_m;
        let limit_m = best_m + best.predicted.standard_error_m.unwrap_or(0.0);
        let chosen = self.points.iter().find(|point| error(point) <= limit_m)?;
        Some(RankSuggestion {
            rank: chosen.rank,
            predicted_m: chosen.predicted.rms_m,
            best_rank: best.rank,
            best_m,
            limit_m,
            still_falling: self.points.len() > 1 && self.points.last() == Some(best),
        })
    }
}

/// Checks what does not depend on the segments' numbers.
fn check(layout: SegmentLayout, ranks: &[usize]) -> Result<(), LearnError> {
    let (samples, expected) = (layout.samples, "at least 3, as the middle ones are hidden");
    let enough = samples >= LEAST_SAMPLES;
    check_setting(enough, "samples of a segment", expected, samples as f64)?;
    check_setting(!ranks.is_empty(), "number of ranks", "at least 1", 0.0)?;
    check_any_rank(ranks[0])
}

/// Folds whose left-out segments have all their numbers; others cannot judge.
fn whole(mut folds: Vec<Fold>, segments: &Segments) -> Vec<Fold> {
    for fold in &mut folds {
        fold.left_out
            .retain(|&segment| segments.is_complete(segment));
    }
    folds.retain(|fold| !fold.left_out.is_empty());
    folds
}

/// Squared deviation of the segments from their mean segment, m², and over how many numbers: those
/// that are there.
fn squared_deviation_m2(segments: &Segments) -> (f64, usize) {
    let (mut squares_m2, mut numbers) = (0.0, 0);
    for row in segments.columns_m().row_iter() {
        let present = || row.iter().filter(|v| v.is_finite());
        let count = present().count();
        let mean_m = present().sum::<f64>() / count.max(1) as f64;
        squares_m2 += present().map(|v| (v - mean_m).powi(2)).sum::<f64>();
        numbers += count;
    }
    (squares_m2, numbers)
}

/// Left-out segments and which of their rows are hidden.
struct Judge<'a> {
    segments: &'a Segments,
    folds: &'a [Fold],
    by: RankGroups,
    hidden_samples: Range<usize>,
    hidden: Vec<usize>,
    visible: Vec<usize>,
    all: Vec<usize>,
    /// Neighbouring samples whose errors are alike.
    alike: f64,
}

impl<'a> Judge<'a> {
    fn new(segments: &'a Segments, folds: &'a [Fold]) -> Self {
        let layout = segments.layout();
        let hidden_samples = middle(layout.samples);
        let (hidden, visible) =
            (0..layout.rows()).partition(|&row| hidden_samples.contains(&place(layout, row).0));
        let origins = segments.origins();
        let one_take = (origins.windows(2)).all(|pair| pair[0].take == pair[1].take);
        Self {
            segments,
            folds,
            by: if one_take {
                RankGroups::Intervals
            } else {
                RankGroups::Takes
            },
            hidden_samples,
            hidden,
            visible,
            all: (0..layout.rows()).collect(),
            alike: (ALIKE_S * layout.rate_hz).max(1.0),
        }
    }

    /// Which take or interval a left-out segment belongs to.
    fn group(&self, fold: usize, segment: usize) -> usize {
        match self.by {
            RankGroups::Takes => self.segments.origins()[segment].take,
            RankGroups::Intervals => fold,
        }
    }

    /// Errors of reconstruction and of prediction.
    fn errors(&self, learner: &Learner<'_>, rank: usize) -> Result<(Errors, Errors), LearnError> {
        let (mut reconstructed, mut predicted) = (Errors::default(), Errors::default());
        for (number, fold) in self.folds.iter().enumerate() {
            let dictionary = learner.learned(Some(number), rank)?;
            let columns_m = self.segments.columns_m().select_columns(&fold.left_out);
            for (errors, known, judged, alike) in [
                (&mut reconstructed, &self.all, &self.all, None),
                (
                    &mut predicted,
                    &self.visible,
                    &self.hidden,
                    Some(self.alike),
                ),
            ] {
                let activations_m = fitted(&dictionary, &columns_m, known, alike)?;
                let squares_m2 = squared_errors_m2(&dictionary, &activations_m, &columns_m, judged);
                for (&segment, squares_m2) in fold.left_out.iter().zip(squares_m2) {
                    errors.add(self.group(number, segment), squares_m2, judged.len());
                }
            }
        }
        Ok((reconstructed, predicted))
    }
}

/// The samples in the middle of a segment that are hidden.
fn middle(samples: usize) -> Range<usize> {
    let count = ((HIDDEN_SHARE * samples as f64).round() as usize).max(1);
    let first = (samples - count) / 2;
    first..first + count
}

/// Learns from all segments or from those outside of a fold. What the takes demonstrate is left empty:
/// learning passes it on without a look.
struct Learner<'a> {
    segments: &'a Segments,
    method: RankMethod<'a>,
    folds: &'a [Fold],
    /// Principal components of everything, then of what is outside of each fold, as many as are
    /// wanted; none for NMF.
    components: Vec<Dictionary>,
}

impl<'a> Learner<'a> {
    fn new(
        segments: &'a Segments,
        method: RankMethod<'a>,
        folds: &'a [Fold],
        most: usize,
    ) -> Result<Self, LearnError> {
        let components = match method {
            RankMethod::Nmf(_) => Vec::new(),
            RankMethod::Pca => std::iter::once(components(segments, most))
                .chain((folds.iter()).map(|fold| components(&segments.select(&fold.known), most)))
                .collect::<Result<_, _>>()?,
        };
        Ok(Self {
            segments,
            method,
            folds,
            components,
        })
    }

    /// Largest rank that can be learned outside of every fold.
    fn largest(&self) -> usize {
        let rows = self.segments.layout().rows();
        let known = self.folds.iter().map(|fold| fold.known.len().min(rows));
        match self.method {
            RankMethod::Nmf(_) => known.min(),
            RankMethod::Pca => self.components.iter().map(Dictionary::rank).min(),
        }
        .unwrap_or(0)
    }

    /// A dictionary learned outside of a fold, or from everything.
    fn learned(&self, fold: Option<usize>, rank: usize) -> Result<Dictionary, LearnError> {
        match self.method {
            RankMethod::Pca => Ok(leading(&self.components[fold.map_or(0, |i| i + 1)], rank)),
            RankMethod::Nmf(settings) => {
                let settings = NmfSettings {
                    rank,
                    ..settings.clone()
                };
                match fold {
                    None => learn_nmf(self.segments, Demonstrated::default(), &settings),
                    Some(fold) => {
                        let known = self.segments.select(&self.folds[fold].known);
                        learn_nmf(&known, Demonstrated::default(), &settings)
                    }
                }
            }
        }
    }
}

/// The first components, `most` of them or as many as the segments have.
fn components(segments: &Segments, most: usize) -> Result<Dictionary, LearnError> {
    match learn_pca(segments, Demonstrated::default(), most) {
        // The largest rank for this many segments may still be above what their numbers have.
        Err(LearnError::RankTooLarge { largest, .. }) if largest > 0 => {
            components(segments, largest)
        }
        learned => learned,
    }
}

/// The dictionary of the first `rank` components of a larger one. Components are orthonormal and
/// their activations uncorrelated, so the squared error grows by those of the ones dropped.
fn leading(dictionary: &Dictionary, rank: usize) -> Dictionary {
    let covariance_m2 = &dictionary.activation_covariance_m2;
    let dropped_m2: f64 = (rank..dictionary.rank())
        .map(|j| covariance_m2[(j, j)])
        .sum();
    let mut leading = Dictionary {
        primitives: dictionary.primitives.columns(0, rank).into_owned(),
        activation_mean_m: dictionary.activation_mean_m.rows(0, rank).into_owned(),
        activation_covariance_m2: covariance_m2.view((0, 0), (rank, rank)).into_owned(),
        ..dictionary.clone()
    };
    let rows = dictionary.layout.rows() as f64;
    leading.learning.rms_m = (dictionary.learning.rms_m.powi(2) + dropped_m2 / rows).sqrt();
    leading
}

/// Squared errors by group, a take or an interval of the only one: their sum, m², and over how many numbers.
#[derive(Clone, Debug, Default)]
struct Errors {
    groups: BTreeMap<usize, (f64, usize)>,
}

impl Errors {
    /// Adds a segment: the sum of its squared errors, over how many numbers, and its group.
    fn add(&mut self, group: usize, squares_m2: f64, numbers: usize) {
        let sum = self.groups.entry(group).or_default();
        sum.0 += squares_m2;
        sum.1 += numbers;
    }

    /// Root mean square over all numbers, with its standard error over groups.
    ///
    /// The mean square is a ratio of sums over K groups, so its variance is
    /// `K / (K - 1) sum_k w_k² (m_k - m)²`, with the groups' mean squares `m_k` and shares of the
    /// numbers `w_k` (Cochran, Sampling Techniques, 1977, section 6.3; for groups of one size the
    /// usual variance of a mean). The root's standard error is half of that over the root.
    fn summary(&self) -> HeldOut {
        let groups = || self.groups.values();
        let numbers = groups().map(|sum| sum.1).sum::<usize>().max(1) as f64;
        let mean_m2 = groups().map(|sum| sum.0).sum::<f64>() / numbers;
        let spread_m4: f64 = groups()
            .map(|&(squares_m2, n)| ((squares_m2 - n as f64 * mean_m2) / numbers).powi(2))
            .sum();
        let count = self.groups.len();
        let rms_m = mean_m2.sqrt();
        let standard_error_m = (count > 1).then(|| {
            let error_m2 = (spread_m4 * count as f64 / (count - 1) as f64).sqrt();
            if rms_m > 0.0 {
                0.5 * error_m2 / rms_m
            } else {
                0.0
            }
        });
        HeldOut {
            rms_m,
            standard_error_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_hidden() {
        for (samples, hidden) in [
            (100, 35..65),
            (10, 3..6),
            (3, 1..2),
            (4, 1..2),
            (120, 42..78),
        ] {
            assert_eq!(middle(samples), hidden, "{samples}");
        }
    }

    #[test]
    fn rows_of_fingers_and_object_belong_to_samples() {
        let layout = SegmentLayout {
            samples: 4,
            rate_hz: 10.0,
            object: true,
        };
        for (row, expected) in [(0, 0), (14, 0), (15, 1), (59, 3), (60, 0), (66, 1), (83, 3)] {
            assert_eq!(place(layout, row).0, expected, "{row}");
        }
    }

    #[test]
    fn groups_of_one_size_have_the_standard_error_of_a_mean() {
        let mut errors = Errors::default();
        for (group, square) in [(0, 1.0), (1, 4.0), (2, 7.0), (0, 1.0), (1, 4.0), (2, 7.0)] {
            errors.add(group, 5.0 * square, 5);
        }
        let summary = errors.summary();
        assert!((summary.rms_m - 2.0).abs() < 1e-12);
        // Mean squares 1, 4, 7: standard deviation 3, of their mean 3 / sqrt(3), of its root a
        // quarter of that.
        let expected = 3.0_f64.sqrt() / 4.0;
        assert!((summary.standard_error_m.unwrap() - expected).abs() < 1e-12);
        assert_eq!(errors.groups.len(), 3);
    }

    #[test]
    fn one_group_has_no_standard_error() {
        let mut errors = Errors::default();
        errors.add(3, 8.0, 2);
        let summary = errors.summary();
        assert_eq!((summary.rms_m, summary.standard_error_m), (2.0, None));
    }
}
