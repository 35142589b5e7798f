//! Dictionaries of motion primitives.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::finger::{Finger, PerFinger};
use crate::names::named;
use crate::protocol::Protocol;
use crate::residual::Residual;
use crate::segments::{Configuration, SEGMENT_COORDINATES, SegmentLayout};
use crate::units::{Millimetres, Number, Numbers, Unit, millimetres_or_infinite};

named! {
    /// How a dictionary was learned.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum DictionaryKind {
        /// Non-negative matrix factorisation: primitives and activations are non-negative.
        Nmf = "nmf",
        /// Principal components: orthonormal primitives, activations of any sign.
        Pca = "pca",
    }
}

named! {
    /// Why learning stopped.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum StopReason {
        /// The objective changed less than the tolerance.
        Converged = "converged",
        /// The wanted error was reached.
        TargetReached = "target_reached",
        /// The iteration limit was reached first.
        IterationLimit = "iteration_limit",
        /// The error of left-out takes fell by less than the tolerance.
        NoLongerBetterOnLeftOutTakes = "no_longer_better_on_left_out_takes",
        /// The factorisation is exact, not iterative.
        ClosedForm = "closed_form",
    }
}

/// How learning went.
#[derive(Clone, Debug, PartialEq)]
pub struct Learning {
    /// Training segments (columns).
    pub segments: usize,
    /// Root mean square of the reconstruction error over all numbers, metres.
    pub rms_m: f64,
    /// Frobenius norm of the error over that of the shifted data.
    pub relative_error: f64,
    /// Iterations (sweeps) done.
    pub iterations: usize,
    /// Why it stopped.
    pub stop_reason: StopReason,
    /// Objective (half the squared Frobenius norm of the error, m²) after each sweep, first the start.
    pub objective_history_m2: Vec<f64>,
    /// Seed of the random start.
    pub seed: u64,
    /// Every start that was made and how it ended, in the order made; empty where there was one
    /// only. The dictionary is that of the smallest objective.
    pub restarts: Vec<Restart>,
}

/// How learning from one of several random starts ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Restart {
    /// Seed of the start.
    pub seed: u64,
    /// Root mean square of the reconstruction error, metres.
    pub rms_m: f64,
    /// Objective at the end, m².
    pub objective_m2: f64,
    /// Mean cosine between its primitives and those of the start that was kept, each matched with one
    /// other so that the sum is largest: 1 where learning found the same primitives again.
    pub matched_cosine: f64,
}

/// An error on segments that were left out of learning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldOut {
    /// Root mean square, metres.
    pub rms_m: f64,
    /// Its standard error over takes (over intervals of a single take), metres; `None` where only
    /// one of them was left out.
    pub standard_error_m: Option<f64>,
}

/// Errors of a dictionary of one rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankPoint {
    /// Number of primitives.
    pub rank: usize,
    /// Root mean square of the reconstruction error of the training segments, metres.
    pub training_rms_m: f64,
    /// Share of the training segments' variance that is explained: one less the squared error over
    /// the squared deviation of the segments from their mean segment. Negative where the mean
    /// segment alone does better.
    pub explained_variance: f64,
    /// Reconstruction error of segments left out of learning, all of their rows known. It falls
    /// with every primitive.
    pub reconstructed: HeldOut,
    /// Error on the middle part of segments left out of learning, from the rest of their rows. It
    /// rises again where primitives follow what does not repeat.
    pub predicted: HeldOut,
}

/// Bounds on the velocity of each coordinate, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VelocityBounds {
    /// Lower bounds, finger then axis.
    pub min_m_s: Configuration,
    /// Upper bounds, finger then axis.
    pub max_m_s: Configuration,
}

/// A convex hull by its corners and by the half-spaces `normal * x <= offset` whose intersection
/// it is: one for each triangle of its surface, in the order of the triangles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Hull {
    /// Corners, metres.
    pub vertices_m: Vec<[f64; 3]>,
    /// Triangles as indices of corners, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Outward unit normal of each half-space.
    pub normals: Vec<[f64; 3]>,
    /// Offset of each half-space, metres.
    pub offsets_m: Vec<f64>,
}

/// What the training takes showed, as constraints for new motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Demonstrated {
    /// Hull of each fingertip's positions over the training takes, hand frame.
    pub hulls: PerFinger<Hull>,
    /// Extremes of each coordinate's velocity between neighbouring samples of the training takes,
    /// without any factor.
    pub velocity: VelocityBounds,
}

/// Motion primitives with what is needed to use and to judge them.
///
/// A segment `v` (15 N numbers, with the object 21 N, metres) is
/// `offset + primitives * activations`.
#[derive(Clone, Debug, PartialEq)]
pub struct Dictionary {
    /// How it was learned.
    pub kind: DictionaryKind,
    /// Shape of the segments.
    pub layout: SegmentLayout,
    /// Offset of each row, metres (as many as the layout has); for NMF the same at every sample.
    pub offset_m: DVector<f64>,
    /// Primitives as unit-length columns (rows x rank), without unit.
    pub primitives: DMatrix<f64>,
    /// Mean of the training activations, metres.
    pub activation_mean_m: DVector<f64>,
    /// Covariance of the training activations, shrunk so that it can be inverted, m².
    pub activation_covariance_m2: DMatrix<f64>,
    /// Weight of the shrinkage towards a scaled identity, 0 (none) to 1.
    pub covariance_shrinkage: f64,
    /// How learning went.
    pub learning: Learning,
    /// What the training takes showed.
    pub demonstrated: Demonstrated,
    /// Deviations from the smooth curve, where they were learned as well.
    pub residual: Option<Residual>,
    /// Deviations learned under [`Protocol::HeldOut`]: from unfiltered motion, with the boundary conditions of
    /// that protocol. `None` where they were not learned.
    pub residual_held_out: Option<Residual>,
    /// How methods compare on left-out training takes, where that was asked for.
    pub choice: Option<MethodChoice>,
}

/// Why parts do not make a dictionary.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum DictionaryError {
    /// A part of another size.
    #[error("dictionary: {what} is {found}, expected {expected}")]
    Shape {
        /// Which size.
        what: &'static str,
        /// The size it should have.
        expected: usize,
        /// The size it has.
        found: usize,
    },
    /// A number is NaN or infinite.
    #[error("dictionary: {what} holds a number that is not finite")]
    NotFinite {
        /// Which part.
        what: &'static str,
    },
    /// A negative number where the kind allows none.
    #[error("dictionary: an NMF primitive has a negative entry")]
    Negative,
}

impl Dictionary {
    /// Learned deviations for plans under a protocol: those of the published one where none were learned under it.
    pub fn residual(&self, protocol: Protocol) -> Option<&Residual> {
        match protocol {
            Protocol::Published => self.residual.as_ref(),
            Protocol::HeldOut => self.residual_held_out.as_ref().or(self.residual.as_ref()),
        }
    }

    /// Number of primitives.
    pub fn rank(&self) -> usize {
        self.primitives.ncols()
    }

    /// Checks sizes and numbers; for dictionaries that come from outside.
    ///
    /// # Errors
    ///
    /// [`DictionaryError`] for the first part that does not fit.
    pub fn validate(&self) -> Result<(), DictionaryError> {
        let (rows, rank) = (self.layout.rows(), self.rank());
        let (mean_m, covariance) = (&self.activation_mean_m, &self.activation_covariance_m2);
        let (high, wide) = covariance.shape();
        for (what, expected, found) in [
            ("rows of the primitives", rows, self.primitives.nrows()),
            ("length of the offset", rows, self.offset_m.len()),
            ("length of the activation mean", rank, mean_m.len()),
            ("rows of the activation covariance", rank, high),
            ("columns of the activation covariance", rank, wide),
        ] {
            if expected != found {
                return Err(DictionaryError::Shape {
                    what,
                    expected,
                    found,
                });
            }
        }
        let velocity = &self.demonstrated.velocity;
        for (what, numbers) in [
            ("the primitives", self.primitives.as_slice()),
            ("the offset", self.offset_m.as_slice()),
            ("the activation mean", mean_m.as_slice()),
            ("the activation covariance", covariance.as_slice()),
            ("the velocity bounds", &velocity.min_m_s),
            ("the velocity bounds", &velocity.max_m_s),
        ] {
            if !numbers.iter().all(|v| v.is_finite()) {
                return Err(DictionaryError::NotFinite { what });
            }
        }
        if self.kind == DictionaryKind::Nmf && self.primitives.iter().any(|&v| v < 0.0) {
            return Err(DictionaryError::Negative);
        }
        Ok(())
    }
}

/// How methods compare on left-out training takes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodChoice {
    /// The protocol under which methods were compared.
    #[serde(default)]
    pub protocol: Protocol,
    /// The method chosen.
    pub method: String,
    /// Every method that was compared.
    pub candidates: Vec<MethodCandidate>,
    /// By how much the best learned method is better than the best that learns nothing, metres;
    /// `None` where only one kind was compared. A learned method is chosen if this is above its
    /// standard error.
    #[serde(rename = "gain_mm", with = "Millimetres")]
    pub gain_m: Option<f64>,
    /// Standard error of that difference over segments, metres.
    #[serde(rename = "gain_standard_error_mm", with = "Millimetres")]
    pub gain_standard_error_m: Option<f64>,
    /// Groups of takes left out in turn.
    pub folds: usize,
    /// Segments planned.
    pub segments: usize,
}

/// One method on left-out training takes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodCandidate {
    /// Name.
    pub name: String,
    /// Mean error over segments, fingers and instants, metres; infinite where a plan failed.
    #[serde(rename = "mean_error_mm", with = "millimetres_or_infinite")]
    pub mean_error_m: f64,
}

/// Velocity bounds of one finger in a document, each axis.
#[derive(Serialize, Deserialize)]
pub(crate) struct FingerBounds {
    min: [Number; 3],
    max: [Number; 3],
}

impl Numbers for VelocityBounds {
    type Written = PerFinger<FingerBounds>;

    fn write(&self, unit: fn(f64) -> f64) -> Self::Written {
        let axes = |bounds: &[f64; SEGMENT_COORDINATES], finger: Finger| {
            std::array::from_fn(|axis| bounds[3 * finger.index() + axis].write(unit))
        };
        PerFinger::from_fn(|finger| FingerBounds {
            min: axes(&self.min_m_s, finger),
            max: axes(&self.max_m_s, finger),
        })
    }

    fn read(written: Self::Written, unit: fn(f64) -> f64) -> Self {
        let mut bounds = VelocityBounds {
            min_m_s: [0.0; SEGMENT_COORDINATES],
            max_m_s: [0.0; SEGMENT_COORDINATES],
        };
        for (finger, FingerBounds { min, max }) in written.into_array().into_iter().enumerate() {
            for (axis, (min, max)) in min.into_iter().zip(max).enumerate() {
                bounds.min_m_s[3 * finger + axis] = f64::read(min, unit);
                bounds.max_m_s[3 * finger + axis] = f64::read(max, unit);
            }
        }
        bounds
    }
}
