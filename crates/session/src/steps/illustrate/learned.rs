//! Learned primitives as paths, and the variance they explain.

use inhand_dictionary::explained_variance;
use inhand_model::{
    Dictionary, DictionaryKind, ExplainedVariance, PerFinger, PrimitivePath, SegmentLayout,
    Segments,
};

use crate::error::{Located as _, SessionError};
use crate::steps::complete;

/// How many primitives are shown.
const SHOWN: usize = 6;

/// Ranks whose share of the variance is shown, beside that of the dictionary.
const RANKS: [usize; 11] = [1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000];

/// The primitives used most in training, most first.
///
/// The use of a primitive is the mean of its activations; components, whose activations have no mean, by
/// their variance. Primitives have unit length, so uses compare. Each is shown as large as it is used: its
/// column times the mean activation, of components times the standard deviation.
pub(super) fn primitives(dictionary: &Dictionary) -> Vec<PrimitivePath> {
    let variances = dictionary.activation_covariance_m2.diagonal();
    let (uses, sizes): (Vec<f64>, Vec<f64>) = match dictionary.kind {
        DictionaryKind::Nmf => (dictionary.activation_mean_m.iter())
            .map(|mean| (mean.abs(), *mean))
            .unzip(),
        DictionaryKind::Pca => (variances.iter())
            .map(|variance| (*variance, variance.max(0.0).sqrt()))
            .unzip(),
    };
    let all: f64 = uses.iter().sum();
    if all <= 0.0 || !all.is_finite() {
        return Vec::new(); // No segment uses any.
    }
    let mut order: Vec<usize> = (0..dictionary.rank()).collect();
    order.sort_by(|&a, &b| uses[b].total_cmp(&uses[a]).then(a.cmp(&b)));
    order.truncate(SHOWN);
    (order.into_iter())
        .map(|index| {
            let column = dictionary.primitives.column(index);
            let at = |t, finger| {
                let row = SegmentLayout::row(t, finger, 0);
                [0, 1, 2].map(|axis| sizes[index] * column[row + axis])
            };
            PrimitivePath {
                index,
                share: uses[index] / all,
                path_m: PerFinger::from_fn(|finger| {
                    (0..dictionary.layout.samples)
                        .map(|t| at(t, finger))
                        .collect()
                }),
            }
        })
        .collect()
}

/// Share of the variance of the training segments that dictionaries of each rank explain; `None` where all
/// segments miss something.
pub(super) fn explained(
    train: &Segments,
    dictionary: &Dictionary,
) -> Result<Option<ExplainedVariance>, SessionError> {
    let segments = complete(train.clone());
    if segments.is_empty() {
        return Ok(None);
    }
    let mut ranks = RANKS.to_vec();
    ranks.push(dictionary.rank());
    ranks.sort_unstable();
    ranks.dedup();
    let learned = (dictionary.rank(), dictionary.learning.rms_m);
    explained_variance(&segments, &ranks, learned)
        .map(Some)
        .during("learning")
}
