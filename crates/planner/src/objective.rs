//! What is minimised: distance to the targets and to what the demonstrations suggest.
//!
//! In millimetres, for activations `h` (n):
//!
//! ```text
//! f(h) = 1/2 sum_i w_i (a_i h - y_i)² + 1/2 (h - mu)ᵀ Λ (h - mu)
//! ```
//!
//! with the observed rows `a_i` of the dictionary as the rows of `A` (m x n), what the target wants
//! of them less the base motion as `y` (m), weights `w = 1 / sigma²`, and the prior's mean `mu` and
//! precision `Λ`. Only `y` (and, for some methods, `mu`) depends on the target.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use inhand_model::{Dictionary, SEGMENT_COORDINATES};

use crate::error::PlanError;
use crate::method::{Method, PlannerSettings};
use crate::target::Target;

pub(crate) const MM_PER_M: f64 = 1e3;

/// A configuration that the target gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Observed {
    First,
    Last,
}

/// How strongly activations are drawn to their mean.
#[derive(Clone, Debug)]
pub(crate) enum Precision {
    /// The same for every activation, on its own.
    Ridge(f64),
    /// The inverse of a covariance.
    Full(DMatrix<f64>),
}

impl Precision {
    /// `Λ v`.
    pub(crate) fn times(&self, v: &DVector<f64>) -> DVector<f64> {
        match self {
            Precision::Ridge(ridge) => v * *ridge,
            Precision::Full(matrix) => matrix * v,
        }
    }
}

/// The target-independent part of `f`.
#[derive(Clone, Debug)]
pub(crate) struct Objective {
    observed: Vec<Observed>,
    samples: usize,
    /// `A` (m x n).
    pub(crate) design: DMatrix<f64>,
    /// `w` (m), 1/mm².
    pub(crate) weights: DVector<f64>,
    /// `Λ`, 1/mm².
    pub(crate) precision: Precision,
    /// `mu`, mm.
    pub(crate) mean_mm: DVector<f64>,
}

impl Objective {
    pub(crate) fn new(
        dictionary: &Dictionary,
        method: Method,
        settings: &PlannerSettings,
    ) -> Result<Self, PlanError> {
        let samples = dictionary.layout.samples;
        let rank = dictionary.rank();
        let (observed, sigma_mm, mean_mm, precision) = match method {
            // As printed, target errors count in mm² and activations are drawn to zero.
            Method::Paper => (
                vec![Observed::Last],
                1.0,
                DVector::zeros(rank),
                Precision::Ridge(settings.ridge),
            ),
            Method::Prior => (
                vec![Observed::First, Observed::Last],
                settings.sigma_m * MM_PER_M,
                &dictionary.activation_mean_m * MM_PER_M,
                Precision::Full(inverse_of_covariance(dictionary)?),
            ),
        };
        let mut design = DMatrix::zeros(observed.len() * SEGMENT_COORDINATES, rank);
        for (block, observed) in observed.iter().enumerate() {
            design
                .rows_mut(block * SEGMENT_COORDINATES, SEGMENT_COORDINATES)
                .copy_from(
                    &dictionary
                        .primitives
                        .rows(observed.row(samples), SEGMENT_COORDINATES),
                );
        }
        let weights = DVector::repeat(design.nrows(), sigma_mm.powi(-2));
        Ok(Self {
            observed,
            samples,
            design,
            weights,
            precision,
            mean_mm,
        })
    }

    /// `y` for a target: what it wants of the observed rows, less the base motion there.
    pub(crate) fn wanted_mm(
        &self,
        target: &Target,
        base_mm: &[f64],
    ) -> Result<DVector<f64>, PlanError> {
        let mut wanted = DVector::zeros(self.design.nrows());
        for (block, observed) in self.observed.iter().enumerate() {
            let (what, values) = match observed {
                Observed::First => ("first configuration", &target.ends().first_m),
                Observed::Last => ("last configuration", &target.ends().last_m),
            };
            Target::check_position(what, values)?;
            let base = &base_mm[observed.row(self.samples)..];
            for (coordinate, (value, base)) in values.iter().zip(base).enumerate() {
                wanted[block * SEGMENT_COORDINATES + coordinate] = value * MM_PER_M - base;
            }
        }
        Ok(wanted)
    }

    /// `P`, the second derivative of `f` (n x n), 1/mm².
    pub(crate) fn hessian(&self) -> DMatrix<f64> {
        let mut weighted = self.design.clone();
        for (mut row, weight) in weighted.row_iter_mut().zip(self.weights.iter()) {
            row *= *weight;
        }
        let mut hessian = self.design.tr_mul(&weighted);
        match &self.precision {
            Precision::Ridge(ridge) => {
                for i in 0..hessian.nrows() {
                    hessian[(i, i)] += ridge;
                }
            }
            Precision::Full(precision) => hessian += precision,
        }
        hessian
    }

    /// The gradient of `f` at zero activations (`q`), to which residuals are relative.
    pub(crate) fn gradient_at_zero(
        &self,
        wanted_mm: &DVector<f64>,
        mean_mm: &DVector<f64>,
    ) -> DVector<f64> {
        -self.precision.times(mean_mm) - self.design.tr_mul(&wanted_mm.component_mul(&self.weights))
    }

    /// `f(h)` and its gradient.
    pub(crate) fn evaluate(
        &self,
        wanted_mm: &DVector<f64>,
        mean_mm: &DVector<f64>,
        activations_mm: &DVector<f64>,
    ) -> (f64, DVector<f64>) {
        let misses = &self.design * activations_mm - wanted_mm;
        let weighted = misses.component_mul(&self.weights);
        let away = activations_mm - mean_mm;
        let drawn = self.precision.times(&away);
        let value = 0.5 * (misses.dot(&weighted) + away.dot(&drawn));
        (value, drawn + self.design.tr_mul(&weighted))
    }
}

impl Observed {
    /// First row of the configuration in a segment of `samples`.
    fn row(self, samples: usize) -> usize {
        match self {
            Observed::First => 0,
            Observed::Last => (samples - 1) * SEGMENT_COORDINATES,
        }
    }
}

/// Inverse of the activations' covariance, 1/mm².
fn inverse_of_covariance(dictionary: &Dictionary) -> Result<DMatrix<f64>, PlanError> {
    let covariance = &dictionary.activation_covariance_m2;
    inverse(covariance * (MM_PER_M * MM_PER_M)).ok_or_else(|| PlanError::Covariance {
        rank: dictionary.rank(),
        smallest_m2: covariance.clone().symmetric_eigenvalues().min(),
    })
}

/// Inverse of a symmetric positive definite matrix, exactly symmetric; `None` where it is not
/// positive definite.
pub(crate) fn inverse(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut inverse = Cholesky::<f64, Dyn>::new(matrix)?.inverse();
    for j in 0..inverse.ncols() {
        for i in 0..j {
            let mean = 0.5 * (inverse[(i, j)] + inverse[(j, i)]);
            (inverse[(i, j)], inverse[(j, i)]) = (mean, mean);
        }
    }
    inverse.iter().all(|v| v.is_finite()).then_some(inverse)
}
