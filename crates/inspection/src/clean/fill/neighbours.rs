//! A fingertip from the other fingertips.
//!
//! Fingers that hold one thing move together. In the hand's frame, the positions of the other
//! fingertips explain much of a fingertip's way, and how they do is learned from the samples about the
//! gap: a ridge regression of its three coordinates on theirs. What the regression misses on either
//! side of the gap is spread over it in proportion, so that the filled way joins the measured one.

use std::ops::Range;

use inhand_model::{Hand, PerFinger, PointTrack, Pose, PoseTrack, Position, Recording, World};
use nalgebra::{DMatrix, DVector, Vector3};

use super::{Filled, inner_gaps, join, to_world};
use crate::lookup::in_hand;

/// Time on each side of a gap that is learned from, seconds: the grasp stays about as it is.
const ABOUT_S: f64 = 0.5;
/// Least samples to learn from; fewer, and the gap stays.
const LEAST_SAMPLES: usize = 20;
/// Weight of the ridge, as the square of a distance for each sample, metres²: motions of others that
/// are smaller than half a millimetre explain nothing.
const RIDGE_M2: f64 = 2.5e-7;

pub(super) fn from_neighbours(
    recording: &Recording,
    hand: &PoseTrack<World, Hand>,
    tips: &PerFinger<usize>,
    limit: usize,
) -> Vec<Filled> {
    let about = (ABOUT_S * recording.clock.rate_hz()).round() as usize;
    let hand_from_world = hand.map(Pose::inverse);
    let tracks: Vec<PointTrack<Hand>> = (tips.as_array().iter())
        .map(|&marker| in_hand(&hand_from_world, &recording.markers[marker].track))
        .collect();
    let mut filled = Vec::new();
    for (own, &marker) in tips.as_array().iter().enumerate() {
        for gap in inner_gaps(&recording.markers[marker].track, limit) {
            let values = (one_gap(&tracks, own, &gap, about))
                .and_then(|values| to_world(hand, &gap, values));
            filled.extend(values.map(|values| Filled {
                marker,
                gap,
                values,
            }));
        }
    }
    filled
}

fn one_gap(
    tracks: &[PointTrack<Hand>],
    own: usize,
    gap: &Range<usize>,
    about: usize,
) -> Option<Vec<Position<Hand>>> {
    let around = gap.start - 1..gap.end + 1;
    // Fingers that are seen all through the gap and beside it.
    let others: Vec<&PointTrack<Hand>> = (tracks.iter().enumerate())
        .filter(|(finger, track)| *finger != own && around.clone().all(|k| track.get(k).is_some()))
        .map(|(_, track)| track)
        .collect();
    if others.is_empty() {
        return None;
    }
    let inputs = |k: usize| -> Option<Vec<f64>> {
        let mut inputs = Vec::with_capacity(3 * others.len());
        for track in &others {
            inputs.extend(track.get(k)?.to_array());
        }
        Some(inputs)
    };
    let learned_from = gap.start.saturating_sub(about)..(gap.end + about).min(tracks[own].len());
    let samples: Vec<(Vec<f64>, Vector3<f64>)> = learned_from
        .filter_map(|k| Some((inputs(k)?, tracks[own].get(k)?.coords_m())))
        .collect();
    if samples.len() < LEAST_SAMPLES {
        return None;
    }
    let regression = Regression::new(&samples)?;
    let guess = |k: usize| inputs(k).map(|inputs| regression.at(&inputs));
    let guesses: Vec<Vector3<f64>> = gap.clone().map(guess).collect::<Option<_>>()?;
    let off = |k: usize| Some(tracks[own].get(k)?.coords_m() - guess(k)?);
    let (before, after) = (off(gap.start - 1)?, off(gap.end)?);
    Some(join(gap, before, after, |k| guesses[k - gap.start]))
}

/// A ridge regression of a position on numbers, about their means.
struct Regression {
    means: DVector<f64>,
    mean: Vector3<f64>,
    /// Three rows, a column for each input.
    weights: DMatrix<f64>,
}

impl Regression {
    fn new(samples: &[(Vec<f64>, Vector3<f64>)]) -> Option<Self> {
        let n = samples.len() as f64;
        let width = samples.first()?.0.len();
        let means = samples
            .iter()
            .fold(DVector::zeros(width), |sum, (inputs, _)| {
                sum + DVector::from_column_slice(inputs) / n
            });
        let mean = samples.iter().map(|(_, at)| at).sum::<Vector3<f64>>() / n;
        let mut squares = DMatrix::identity(width, width) * (RIDGE_M2 * n);
        let mut products = DMatrix::zeros(width, 3);
        for (inputs, at) in samples {
            let about = DVector::from_column_slice(inputs) - &means;
            squares += &about * about.transpose();
            products += &about * (at - mean).transpose();
        }
        let solved = squares.cholesky()?.solve(&products);
        Some(Self {
            means,
            mean,
            weights: solved.transpose(),
        })
    }

    fn at(&self, inputs: &[f64]) -> Vector3<f64> {
        let about = DVector::from_column_slice(inputs) - &self.means;
        let moved = &self.weights * about;
        self.mean + Vector3::new(moved[0], moved[1], moved[2])
    }
}
