//! Dictionaries of many ranks, from all segments or without some.

use inhand_model::{Demonstrated, Dictionary, Segments};

use super::RankMethod;
use crate::error::LearnError;
use crate::nmf::learn_nmf;
use crate::pca::learn_pca;
use crate::residual::Fold;
use crate::settings::NmfSettings;

/// Learns from all segments or from those outside of a fold. What the takes demonstrate is left empty:
/// learning passes it on without a look.
pub(super) struct Learner<'a> {
    segments: &'a Segments,
    method: RankMethod<'a>,
    folds: &'a [Fold],
    /// Principal components of everything, then of what is outside of each fold, as many as are
    /// wanted; none for NMF.
    components: Vec<Dictionary>,
}

impl<'a> Learner<'a> {
    pub(super) fn new(
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
    pub(super) fn largest(&self) -> usize {
        let rows = self.segments.layout().rows();
        let known = self.folds.iter().map(|fold| fold.known.len().min(rows));
        match self.method {
            RankMethod::Nmf(_) => known.min(),
            RankMethod::Pca => self.components.iter().map(Dictionary::rank).min(),
        }
        .unwrap_or(0)
    }

    /// A dictionary learned outside of a fold, or from everything.
    pub(super) fn learned(
        &self,
        fold: Option<usize>,
        rank: usize,
    ) -> Result<Dictionary, LearnError> {
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
