//! Deviation predictor: kernel regression on demonstrations, given the boundary conditions.

mod kernel;

use serde::{Deserialize, Serialize};
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use self::kernel::kernels;
use crate::finger::Finger;
use crate::segments::{FINGER_ENDS, SEGMENT_COORDINATES, SegmentLayout, ends_len};

/// Sums of a product that are kept side by side.
const SUMS: usize = 4;
/// Features come in threes.
const AXES: usize = 3;
/// Features of one finger: how far the last position lies from where the mean of both end
/// velocities would lead, displacement, both velocities, first position.
const FINGER_FEATURES: usize = 15;
/// Of these, the ones that stay the same when the finger's motion is moved elsewhere.
const MOTION_FEATURES: usize = 12;
/// Features of the object: displacement, rotation, first position.
const OBJECT_FEATURES: usize = 9;
/// Of these, the ones that are about its motion.
const OBJECT_MOTION_FEATURES: usize = 6;
/// Standard deviation (metres, or m/s) below which a feature never changes: a nanometre is rounding.
const SMALLEST_DEVIATION: f64 = 1e-9;

/// Weights of the three parts of an [`DeviationPredictor`], without unit; all zero gives the smooth curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PredictorWeights {
    /// Of the shared profile.
    #[serde(rename = "profile_weight")]
    pub profile: f64,
    /// Of demonstrations in which the whole hand did something similar.
    #[serde(rename = "hand_weight")]
    pub hand: f64,
    /// Of demonstrations in which the finger did something similar.
    #[serde(rename = "finger_weight")]
    pub finger: f64,
}

/// What is expected of a deviation's activations `z` (r numbers, metres), given end conditions `x`
/// (d numbers): a weighted sum of three predictions,
///
/// ```text
/// mean(x) = w_p L x + w_h k_hand(x) + w_f k_finger(x)
/// ```
///
/// * `L x`: a profile over time that all coordinates share, linear in a coordinate's displacement
///   and end velocities; it has few numbers to learn and holds for any object;
/// * `k_hand(x)`: kernel regression (E. A. Nadaraya, "On estimating regression", Theory of
///   Probability and Its Applications 9, 1964; G. S. Watson, Sankhya A 26, 1964) of what the profile
///   leaves, with a Gaussian kernel over the standardised features of all fingers and the object;
/// * `k_finger(x)`: the same for each finger by itself, over its displacement and velocities (and
///   the object's), wherever in the hand they happen: it carries from one object to another.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviationPredictor {
    layout: SegmentLayout,
    blocks: Vec<usize>,
    /// `L` (r x d).
    profile: DMatrix<f64>,
    /// Mean of each feature over the demonstrations.
    feature_mean: DVector<f64>,
    /// One over each feature's standard deviation; zero where it never changes.
    feature_scale: DVector<f64>,
    /// End conditions of the demonstrations (d x n), metres and m/s.
    ends: DMatrix<f64>,
    /// Their standardised features (n x features), so that one feature of all demonstrations lies
    /// together.
    features: DMatrix<f64>,
    /// What the profile leaves of each demonstration's activations (r x n), metres.
    answers: DMatrix<f64>,
    /// The same (n x r), so that one activation of all demonstrations lies together: it is read from
    /// end to end for every expectation.
    by_activation: DMatrix<f64>,
    bandwidths: Bandwidths,
    weights: PredictorWeights,
}

/// Widths of the Gaussian kernels, in standard deviations of the features.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bandwidths {
    /// Over the features of the whole hand.
    #[serde(rename = "hand_bandwidth")]
    pub hand: f64,
    /// Over the features of one finger.
    #[serde(rename = "finger_bandwidth")]
    pub finger: f64,
}

/// Squared distances of end conditions to each demonstration, in standardised features.
#[derive(Clone, Debug)]
pub struct Distances {
    hand: Vec<f64>,
    fingers: [Vec<f64>; Finger::COUNT],
}

impl DeviationPredictor {
    /// From demonstrations: their end conditions (d x n) and what the profile `L` (r x d) leaves of
    /// their activations (r x n, metres). `blocks` are the numbers of activations of each finger,
    /// then of the object where the layout has it; they sum to r. All weights are zero.
    ///
    /// # Panics
    ///
    /// If the sizes do not fit together.
    pub fn new(
        layout: SegmentLayout,
        blocks: Vec<usize>,
        profile: DMatrix<f64>,
        ends: DMatrix<f64>,
        answers: DMatrix<f64>,
    ) -> Self {
        let rank: usize = blocks.iter().sum();
        assert_eq!(blocks.len(), Finger::COUNT + usize::from(layout.object));
        assert_eq!(profile.shape(), (rank, ends_len(layout)));
        assert_eq!(ends.nrows(), ends_len(layout));
        assert_eq!(answers.shape(), (rank, ends.ncols()));
        let mut features = DMatrix::zeros(features_len(layout), ends.ncols());
        for (mut column, x) in features.column_iter_mut().zip(ends.column_iter()) {
            column.copy_from(&raw_features(layout, x.as_slice()));
        }
        let feature_mean = features.column_mean();
        // In two passes: nalgebra's `column_variance` subtracts squares, which leaves rounding where
        // a place never changes.
        let feature_scale = DVector::from_fn(features.nrows(), |i, _| {
            let row = features.row(i);
            let squares: f64 = row.iter().map(|v| (v - feature_mean[i]).powi(2)).sum();
            let deviation = (squares / ends.ncols() as f64).sqrt();
            if deviation > SMALLEST_DEVIATION && deviation.is_finite() {
                deviation.recip()
            } else {
                0.0
            }
        });
        for mut column in features.column_iter_mut() {
            column -= &feature_mean;
            column.component_mul_assign(&feature_scale);
        }
        Self {
            layout,
            blocks,
            profile,
            feature_mean,
            feature_scale,
            ends,
            features: features.transpose(),
            by_activation: answers.transpose(),
            answers,
            bandwidths: Bandwidths {
                hand: 2.0,
                finger: 0.5,
            },
            weights: PredictorWeights::default(),
        }
    }

    /// The same with these widths and weights.
    #[must_use]
    pub fn weighted(mut self, bandwidths: Bandwidths, weights: PredictorWeights) -> Self {
        (self.bandwidths, self.weights) = (bandwidths, weights);
        self
    }

    /// Number of demonstrations.
    pub fn demonstrations(&self) -> usize {
        self.ends.ncols()
    }

    /// End conditions of the demonstrations (d x n), metres and m/s.
    pub const fn ends(&self) -> &DMatrix<f64> {
        &self.ends
    }

    /// What the profile leaves of the demonstrations' activations (r x n), metres.
    pub const fn answers_m(&self) -> &DMatrix<f64> {
        &self.answers
    }

    /// Numbers of activations of each finger, then of the object where there is one.
    pub fn blocks(&self) -> &[usize] {
        &self.blocks
    }

    /// `L` (r x d).
    pub const fn profile(&self) -> &DMatrix<f64> {
        &self.profile
    }

    /// Widths of the kernels.
    pub const fn bandwidths(&self) -> Bandwidths {
        self.bandwidths
    }

    /// Weights of the three parts.
    pub const fn weights(&self) -> PredictorWeights {
        self.weights
    }

    /// `mean(x)`, metres (r).
    ///
    /// # Panics
    ///
    /// If `ends` has another length than the layout gives.
    pub fn expected_m(&self, ends: &DVector<f64>) -> DVector<f64> {
        let weights = self.weights;
        let mut expected = &self.profile * ends * weights.profile;
        if self.demonstrations() > 0 && (weights.hand != 0.0 || weights.finger != 0.0) {
            let shares = self.shares(self.distances(ends), self.bandwidths, weights);
            self.add_answers(&mut expected, &shares);
        }
        expected
    }

    /// The parts by themselves, each with weight one (r x 3: profile, hand, finger), metres.
    pub fn parts_m(
        &self,
        ends: &DVector<f64>,
        distances: &Distances,
        widths: Bandwidths,
    ) -> DMatrix<f64> {
        let [hand, finger] = self.kernel_parts_m(std::slice::from_ref(distances), widths);
        let mut parts = DMatrix::zeros(self.answers.nrows(), 3);
        parts.set_column(0, &(&self.profile * ends));
        parts.set_column(1, &hand.column(0));
        parts.set_column(2, &finger.column(0));
        parts
    }

    /// The predictions of hand and finger for several end conditions, each with weight one (r x conditions),
    /// metres: products of the answers with the kernels of all conditions together.
    pub fn kernel_parts_m(&self, distances: &[Distances], widths: Bandwidths) -> [DMatrix<f64>; 2] {
        let mut shares = DMatrix::zeros(self.demonstrations(), distances.len());
        fill_shares(&mut shares, distances, |d| &d.hand, widths.hand);
        let hand = &self.answers * &shares;
        // The object is no finger: what the whole hand does tells most of it.
        let mut finger = hand.clone();
        let mut start = 0;
        for (i, &size) in self.blocks[..Finger::COUNT].iter().enumerate() {
            fill_shares(&mut shares, distances, |d| &d.fingers[i], widths.finger);
            let product = self.answers.rows(start, size) * &shares;
            finger.rows_mut(start, size).copy_from(&product);
            start += size;
        }
        [hand, finger]
    }

    /// Squared distances to each demonstration.
    ///
    /// # Panics
    ///
    /// If `ends` has another length than the layout gives.
    pub fn distances(&self, ends: &DVector<f64>) -> Distances {
        let mut query = raw_features(self.layout, ends.as_slice());
        query -= &self.feature_mean;
        query.component_mul_assign(&self.feature_scale);
        let count = self.demonstrations();
        let mut fingers: [Vec<f64>; Finger::COUNT] = std::array::from_fn(|_| vec![0.0; count]);
        let mut hand = vec![0.0; count];
        let mut own = vec![0.0; count];
        if self.layout.object {
            let motion = SEGMENT_FEATURES..SEGMENT_FEATURES + OBJECT_MOTION_FEATURES;
            self.add_squares(&mut own, &query, motion);
            for sum in fingers.iter_mut().chain([&mut hand]) {
                add(sum, &own);
            }
            let place = SEGMENT_FEATURES + OBJECT_MOTION_FEATURES..features_len(self.layout);
            self.add_squares(&mut hand, &query, place);
        }
        for (i, sum) in fingers.iter_mut().enumerate() {
            let first = i * FINGER_FEATURES;
            own.fill(0.0);
            self.add_squares(&mut own, &query, first..first + MOTION_FEATURES);
            add(sum, &own);
            add(&mut hand, &own);
            let place = first + MOTION_FEATURES..first + FINGER_FEATURES;
            self.add_squares(&mut hand, &query, place);
        }
        Distances { hand, fingers }
    }

    /// Adds the squared differences of some features of all demonstrations to a query's. Features
    /// come in threes (one for each axis), so that the sum is loaded and stored a third as often.
    fn add_squares(&self, sums: &mut [f64], query: &DVector<f64>, features: Range<usize>) {
        let count = self.demonstrations();
        if count == 0 {
            return;
        }
        let columns = &self.features.as_slice()[features.start * count..features.end * count];
        let (threes, _) = query.as_slice()[features].as_chunks::<AXES>();
        for (&[x, y, z], columns) in threes.iter().zip(columns.chunks_exact(AXES * count)) {
            let (xs, rest) = columns.split_at(count);
            let (ys, zs) = rest.split_at(count);
            for (((sum, vx), vy), vz) in sums.iter_mut().zip(xs).zip(ys).zip(zs) {
                let (dx, dy, dz) = (vx - x, vy - y, vz - z);
                *sum += dx * dx + dy * dy + dz * dz;
            }
        }
    }

    /// How much of each demonstration's answer is expected, by block: its kernels over their sum,
    /// hand's and finger's with their weights.
    fn shares(
        &self,
        distances: Distances,
        widths: Bandwidths,
        weights: PredictorWeights,
    ) -> Vec<Vec<f64>> {
        let Distances { mut hand, fingers } = distances;
        let hand_total = kernels(&mut hand, widths.hand);
        let share = |weight: f64, total: f64| if total > 0.0 { weight / total } else { 0.0 };
        let by_hand = share(weights.hand, hand_total);
        let mut shares = Vec::with_capacity(self.blocks.len());
        for mut finger in fingers {
            let by_finger = match weights.finger {
                0.0 => 0.0,
                weight => share(weight, kernels(&mut finger, widths.finger)),
            };
            for (finger, hand) in finger.iter_mut().zip(&hand) {
                *finger = by_finger * *finger + by_hand * hand;
            }
            shares.push(finger);
        }
        if self.layout.object {
            // The object is no finger: what the whole hand does tells most of it.
            let both = by_hand + share(weights.finger, hand_total);
            hand.iter_mut().for_each(|hand| *hand *= both);
            shares.push(hand);
        }
        shares
    }

    /// Adds the answers, each block of a demonstration by its share.
    fn add_answers(&self, expected: &mut DVector<f64>, shares: &[Vec<f64>]) {
        let count = self.demonstrations();
        if count == 0 {
            return;
        }
        let mut start = 0;
        for (&size, shares) in self.blocks.iter().zip(shares) {
            let block = start..start + size;
            start += size;
            let answers = &self.by_activation.as_slice()[block.start * count..block.end * count];
            let expected = &mut expected.as_mut_slice()[block];
            let (fours, rest) = expected.as_chunks_mut::<4>();
            let (at_fours, at_rest) = answers.split_at(4 * fours.len() * count);
            for (expected, answers) in fours.iter_mut().zip(at_fours.chunks_exact(4 * count)) {
                let mut columns = answers.chunks_exact(count);
                let dots = dots([(); 4].map(|()| columns.next().unwrap_or_default()), shares);
                for (expected, dot) in expected.iter_mut().zip(dots) {
                    *expected += dot;
                }
            }
            for (expected, answers) in rest.iter_mut().zip(at_rest.chunks_exact(count)) {
                let [dot] = dots([answers], shares);
                *expected += dot;
            }
        }
    }
}

const SEGMENT_FEATURES: usize = Finger::COUNT * FINGER_FEATURES;

const fn features_len(layout: SegmentLayout) -> usize {
    SEGMENT_FEATURES + if layout.object { OBJECT_FEATURES } else { 0 }
}

/// Products of columns with one vector of the same length, which is loaded once for all of them; in
/// several sums side by side, so that none waits for the one before.
fn dots<const C: usize>(columns: [&[f64]; C], by: &[f64]) -> [f64; C] {
    let split = by.len() - by.len() % SUMS;
    let mut sums = [[0.0; SUMS]; C];
    let (by, by_rest) = by.split_at(split);
    let rests = columns.map(|column| &column[split..]);
    let columns = columns.map(|column| column[..split].as_chunks::<SUMS>().0);
    for (i, by) in by.as_chunks::<SUMS>().0.iter().enumerate() {
        for (sums, column) in sums.iter_mut().zip(&columns) {
            for ((sum, value), by) in sums.iter_mut().zip(&column[i]).zip(by) {
                *sum += value * by;
            }
        }
    }
    for (sums, rest) in sums.iter_mut().zip(rests) {
        for ((sum, value), by) in sums.iter_mut().zip(rest).zip(by_rest) {
            *sum += value * by;
        }
    }
    sums.map(|sums| sums.iter().sum())
}

/// Kernels of some distances of each query over their sum, a column each.
fn fill_shares(
    shares: &mut DMatrix<f64>,
    queries: &[Distances],
    distances: impl Fn(&Distances) -> &[f64],
    width: f64,
) {
    for (mut column, query) in shares.column_iter_mut().zip(queries) {
        let column = column.as_mut_slice();
        column.copy_from_slice(distances(query));
        let total = kernels(column, width);
        if total > 0.0 {
            column.iter_mut().for_each(|kernel| *kernel /= total);
        }
    }
}

fn add(sums: &mut [f64], values: &[f64]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += value;
    }
}

/// Features of end conditions, finger by finger, then the object's; metres and m/s.
fn raw_features(layout: SegmentLayout, ends: &[f64]) -> DVector<f64> {
    assert_eq!(
        ends.len(),
        ends_len(layout),
        "end conditions of another layout"
    );
    let duration_s = layout.duration_s();
    let mut features = DVector::zeros(features_len(layout));
    let mut put = 0;
    let mut push = |value: f64| {
        features[put] = value;
        put += 1;
    };
    let part = |part: usize, coordinate: usize| ends[part * SEGMENT_COORDINATES + coordinate];
    for finger in Finger::ALL {
        let coordinates = finger.index() * 3..finger.index() * 3 + 3;
        let displacement = |c| part(1, c) - part(0, c);
        for c in coordinates.clone() {
            push(displacement(c) - 0.5 * duration_s * (part(2, c) + part(3, c)));
        }
        for c in coordinates.clone() {
            push(displacement(c));
        }
        for velocity in [2, 3] {
            for c in coordinates.clone() {
                push(part(velocity, c));
            }
        }
        for c in coordinates {
            push(part(0, c));
        }
    }
    if layout.object {
        let object = &ends[FINGER_ENDS..];
        for axis in 0..3 {
            push(object[3 + axis] - object[axis]);
        }
        for axis in 0..3 {
            push(object[6 + axis]);
        }
        for &position in &object[..3] {
            push(position);
        }
    }
    features
}

#[cfg(test)]
mod tests;
