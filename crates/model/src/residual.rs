//! Motion as a smooth curve with a learned deviation from it.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use crate::deviation_predictor::DeviationPredictor;
use crate::names::named;
use crate::segments::{EndConditions, FINGER_ENDS, SEGMENT_COORDINATES, SegmentLayout, ends_len};
use crate::units::{Millimetres, Unit};

/// Motion as the smooth curve through its end conditions plus a learned deviation:
///
/// ```text
/// v = S x + B z,    z ~ N(mean(x), Σ),    x ~ N(m, C)
/// ```
///
/// `x` are the end conditions ([`EndConditions::to_vector`], d numbers), `S x` is the smooth curve
/// ([`SmoothCurve::basis`]), and the columns of `B` are primitives of the deviation. What is expected of
/// the deviation depends on the end conditions, by regression over the demonstrations, so that
/// with little to learn from the expectation is near zero and the motion near the smooth curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Shape of the segments.
    pub layout: SegmentLayout,
    /// The smooth curve.
    pub curve: SmoothCurve,
    /// `m`: mean of the training end conditions (d), metres and m/s.
    pub ends_mean: DVector<f64>,
    /// `C`: their covariance, shrunk so that it can be inverted (d x d).
    pub ends_covariance: DMatrix<f64>,
    /// `B`: orthonormal primitives of the deviation as columns (rows x r), without unit.
    pub primitives: DMatrix<f64>,
    /// `mean(x)`.
    pub expectation: DeviationPredictor,
    /// `Σ`: covariance of the activations around what was expected of them on takes left out of
    /// the regression, shrunk (r x r), m².
    pub covariance_m2: DMatrix<f64>,
    /// Mean square of what the primitives cannot express, per fingertip coordinate, m².
    pub unexplained_m2: f64,
    /// How wide a prediction region has to be to hold a share of the demonstrations, measured on takes left
    /// out.
    pub calibration: Vec<Calibration>,
    /// How the weights of the expectation were chosen.
    pub validation: Validation,
}

named! {
    /// A curve that boundary conditions alone determine.
    #[derive(Default, PartialOrd, Ord, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum SmoothCurve {
        /// Cubic Hermite interpolation of positions and velocities.
        #[default]
        Hermite = "hermite",
        /// Minimum jerk from rest to rest.
        MinimumJerk = "minimum_jerk",
        /// Straight line at constant velocity.
        Line = "line",
    }
}

/// Cross-validation on the training takes: each group of takes in turn is left out and predicted
/// from the others. With one take, stretches of it are left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Validation {
    /// Groups that were left out in turn.
    pub folds: usize,
    /// Segments predicted (none overlaps another).
    pub segments: usize,
    /// Mean error of the smooth curve over fingers and instants, metres.
    #[serde(rename = "smooth_error_mm", with = "Millimetres")]
    pub smooth_error_m: f64,
    /// Mean error with the expected deviation, metres.
    #[serde(rename = "error_mm", with = "Millimetres")]
    pub error_m: f64,
    /// Standard error of the difference of the two over segments, metres.
    #[serde(rename = "standard_error_mm", with = "Millimetres")]
    pub standard_error_m: f64,
}

/// Width of a prediction region: at each instant the recorded fingertip lies within `mahalanobis` standard
/// deviations of the planned one (as the three-dimensional covariance measures it) at a share
/// `share` of all instants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Share of instants inside, 0 to 1.
    pub share: f64,
    /// Mahalanobis distance, without unit.
    pub mahalanobis: f64,
}

impl Residual {
    /// `mean(x)`: the expected activations for end conditions (d numbers), metres (r).
    ///
    /// # Panics
    ///
    /// If `ends` has another length than the layout gives ([`ends_len`]).
    pub fn expected_m(&self, ends: &DVector<f64>) -> DVector<f64> {
        self.expectation.expected_m(ends)
    }
}

impl EndConditions {
    /// The end conditions as numbers: first configuration, last configuration (metres), first
    /// velocity, last velocity (m/s), and where the layout has the object, its first position, its
    /// last position and, times [`ROTATION_LEVER_M`](crate::ROTATION_LEVER_M), its rotation vector
    /// (metres). `None` where the layout has the object and the end conditions have not.
    pub fn to_vector(&self, layout: SegmentLayout) -> Option<DVector<f64>> {
        let mut numbers = Vec::with_capacity(ends_len(layout));
        for part in [
            &self.first_m,
            &self.last_m,
            &self.first_velocity_m_s,
            &self.last_velocity_m_s,
        ] {
            numbers.extend_from_slice(part);
        }
        if layout.object {
            let [first, last] = self.object?.coordinates_m();
            numbers.extend_from_slice(&first[..3]);
            numbers.extend_from_slice(&last);
        }
        Some(DVector::from_vec(numbers))
    }
}

impl SmoothCurve {
    /// Weights of first position, last position, first velocity and last velocity at the share `s` of a segment's
    /// duration.
    fn weights(self, s: f64, duration_s: f64) -> [f64; 4] {
        let (s2, s3) = (s * s, s * s * s);
        let between = |share: f64| [1.0 - share, share, 0.0, 0.0];
        match self {
            Self::Hermite => [
                2.0 * s3 - 3.0 * s2 + 1.0,
                3.0 * s2 - 2.0 * s3,
                (s3 - 2.0 * s2 + s) * duration_s,
                (s3 - s2) * duration_s,
            ],
            Self::MinimumJerk => between(s3 * (10.0 - 15.0 * s + 6.0 * s2)),
            Self::Line => between(s),
        }
    }

    /// `S` (rows x d): the curve as a linear function of the end conditions. The object moves and turns evenly.
    ///
    /// # Panics
    ///
    /// If segments have fewer than two samples.
    pub fn basis(self, layout: SegmentLayout) -> DMatrix<f64> {
        let mut basis = DMatrix::zeros(layout.rows(), ends_len(layout));
        let duration_s = layout.duration_s();
        assert!(
            layout.samples >= 2,
            "a curve needs a first and a last sample"
        );
        for t in 0..layout.samples {
            let s = t as f64 / (layout.samples - 1) as f64;
            let weights = self.weights(s, duration_s);
            for c in 0..SEGMENT_COORDINATES {
                for (part, weight) in weights.into_iter().enumerate() {
                    basis[(t * SEGMENT_COORDINATES + c, part * SEGMENT_COORDINATES + c)] = weight;
                }
            }
            if layout.object {
                for axis in 0..3 {
                    let place = layout.object_row(t, axis);
                    basis[(place, FINGER_ENDS + axis)] = 1.0 - s;
                    basis[(place, FINGER_ENDS + 3 + axis)] = s;
                    basis[(layout.object_row(t, 3 + axis), FINGER_ENDS + 6 + axis)] = s;
                }
            }
        }
        basis
    }
}

#[cfg(test)]
mod tests;
