//! Quadratic program shared by all targets with the same pattern.
//!
//! In millimetres, for unknowns `h` (n):
//!
//! ```text
//! f(h) = 1/2 sum_i w_i (a_i h - y_i)² + 1/2 (h - mu)ᵀ Λ (h - mu)    subject to    E h = e
//! ```
//!
//! with what soft targets observe as the rows `a_i` of `A` (m x n), their values less the
//! base motion as `y` (m), weights `w = 1 / sigma²`, the prior's mean `mu` and precision `Λ`, and
//! what hard targets observe as the rows of `E`. Only `y`, `e` and `mu` depend on the target's
//! values; the inverse of the second derivative, within `E h = 0`, does not.

use inhand_model::ROTATION_LEVER_M;
use nalgebra::{DMatrix, DVector};

use crate::MM_PER_M;
use crate::completion::Completion;
use crate::equality::Equalities;
use crate::error::PlanError;
use crate::method::Method;
use crate::model::MotionModel;
use crate::precision::{Precision, inverse};
use crate::settings::{Ends, PlannerSettings};
use crate::target_values::{TargetPart, TargetValues};

/// How much more sharply than a soft target the present state is meant. With a hundredth of 0.1 mm,
/// against demonstrations that vary by millimetres, plans start within some nanometres of it.
const FACT: f64 = 1e-2;

/// Standard deviations of what soft targets give, mm and mm/s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deviations {
    position_mm: f64,
    velocity_mm_s: f64,
    object_mm: f64,
    /// Of a rotation times its lever.
    rotation_mm: f64,
}

impl Deviations {
    /// `None` where targets are hard.
    pub(crate) fn new(settings: &PlannerSettings, method: Option<Method>) -> Option<Self> {
        let Ends::Soft { sigma_m } = settings.ends else {
            return None;
        };
        // As printed, the paper's target errors count in mm².
        let scale = match method {
            Some(Method::Paper) => 1.0 / sigma_m,
            _ => MM_PER_M,
        };
        Some(Self {
            position_mm: sigma_m * scale,
            velocity_mm_s: settings.velocity_sigma_m_s * scale,
            object_mm: settings.object_sigma_m * scale,
            rotation_mm: settings.object_sigma_rad * ROTATION_LEVER_M * scale,
        })
    }

    fn sigma(&self, part: TargetPart, now: Option<usize>) -> f64 {
        match part {
            TargetPart::Position { sample, .. } if Some(sample) == now => FACT * self.position_mm,
            TargetPart::Step { sample, .. } if Some(sample) == now => FACT * self.velocity_mm_s,
            TargetPart::Position { .. } => self.position_mm,
            TargetPart::Velocity { .. } | TargetPart::Step { .. } => self.velocity_mm_s,
            TargetPart::ObjectPosition { .. } => self.object_mm,
            TargetPart::ObjectRotation { .. } => self.rotation_mm,
        }
    }
}

/// The part of a problem that does not depend on the target's values.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    /// What targets give.
    pub(crate) pattern: Vec<TargetPart>,
    /// The sample of which positions and velocities are facts.
    now: Option<usize>,
    completion: Option<Completion>,
    /// What is observed where all unknowns are zero (three for each part of the pattern).
    base: Vec<f64>,
    /// `A` (m x n); without rows where targets are hard.
    pub(crate) design: DMatrix<f64>,
    /// `w` (m).
    pub(crate) weights: DVector<f64>,
    /// `Λ`, 1/mm².
    pub(crate) precision: Precision,
    /// `E`, where targets are hard.
    pub(crate) equalities: Option<Equalities>,
    /// `C`, inverse of the second derivative within `E h = 0` (n x n), mm²: the covariance of the
    /// unknowns, given the target.
    pub(crate) inverse: DMatrix<f64>,
}

/// The part that does.
#[derive(Clone, Debug)]
pub(crate) struct Instance {
    /// `y` (m), or `e` where targets are hard.
    pub(crate) values: DVector<f64>,
    /// `mu`, mm.
    pub(crate) mean: DVector<f64>,
    /// Gradient of `f` at zero, to which residuals are relative.
    pub(crate) gradient_at_zero: DVector<f64>,
}

impl Problem {
    /// Cost: some n³ + m n² multiplications.
    pub(crate) fn new(
        model: &MotionModel,
        target: &TargetValues,
        deviations: Option<Deviations>,
    ) -> Result<Self, PlanError> {
        let n = model.unknowns();
        let pattern = &target.pattern;
        // Row by row, which are the columns of the transpose.
        let mut rows = DMatrix::zeros(n, 3 * pattern.len());
        let mut base = Vec::with_capacity(rows.ncols());
        for (k, &part) in pattern.iter().enumerate() {
            for axis in 0..3 {
                let mut column = rows.column_mut(3 * k + axis);
                base.push(model.observe(part, axis, column.as_mut_slice()));
            }
        }
        let observed = rows.transpose();
        let (design, weights, equalities) = match deviations {
            Some(deviations) => {
                let weights = DVector::from_iterator(
                    observed.nrows(),
                    (pattern.iter())
                        .flat_map(|&part| [deviations.sigma(part, target.now).powi(-2); 3]),
                );
                (observed, weights, None)
            }
            None => (
                DMatrix::zeros(0, n),
                DVector::zeros(0),
                Some(Equalities::new(observed)),
            ),
        };

        let mut hessian = {
            let mut weighted = design.clone();
            for (mut row, weight) in weighted.row_iter_mut().zip(weights.iter()) {
                row *= *weight;
            }
            design.tr_mul(&weighted)
        };
        model.precision.add_to(&mut hessian);
        // Cannot fail but by rounding: a positive definite precision plus a Gram matrix.
        let inverse = match &equalities {
            None => inverse(hessian),
            Some(equalities) => equalities.inverse_within(&hessian),
        };
        let inverse = inverse.ok_or_else(|| {
            PlanError::Model(format!(
                "the problem of {n} unknowns cannot be factorised: \
                 allow targets a larger standard deviation, or make them hard"
            ))
        })?;
        Ok(Self {
            pattern: pattern.clone(),
            now: target.now,
            completion: model.completion(pattern),
            base,
            design,
            weights,
            precision: model.precision.clone(),
            equalities,
            inverse,
        })
    }

    /// Whether the target gives the parts that this problem is for.
    pub(crate) fn fits(&self, target: &TargetValues) -> bool {
        self.pattern == target.pattern && self.now == target.now
    }

    /// The problem of hard targets and its instance with only these equations; `None` where rounding leaves none.
    pub(crate) fn with_equations(
        &self,
        instance: &Instance,
        equations: &[usize],
    ) -> Option<(Self, Instance)> {
        let rows = self.equalities.as_ref()?.rows.select_rows(equations);
        let mut hessian = DMatrix::zeros(rows.ncols(), rows.ncols());
        self.precision.add_to(&mut hessian);
        let equalities = (!equations.is_empty()).then(|| Equalities::new(rows));
        let inverse = match &equalities {
            None => inverse(hessian)?,
            Some(equalities) => equalities.inverse_within(&hessian)?,
        };
        let problem = Self {
            equalities,
            inverse,
            ..self.clone()
        };
        let instance = Instance {
            values: instance.values.select_rows(equations),
            ..instance.clone()
        };
        Some((problem, instance))
    }

    /// The problem for a target that gives the same parts, with what is expected of the unknowns
    /// (mm; as the demonstrations have it if `None`).
    pub(crate) fn instance(
        &self,
        model: &MotionModel,
        target: &TargetValues,
        expected: Option<DVector<f64>>,
    ) -> Instance {
        let mean =
            expected.unwrap_or_else(|| model.mean_mm(self.completion.as_ref(), &target.values));
        let values = DVector::from_iterator(
            self.base.len(),
            (target.values.iter().zip(&self.base)).map(|(value, base)| value - base),
        );
        let mut gradient_at_zero = -self.precision.times(&mean);
        if self.equalities.is_none() {
            gradient_at_zero -= self.design.tr_mul(&values.component_mul(&self.weights));
        }
        Instance {
            values,
            mean,
            gradient_at_zero,
        }
    }

    /// The minimum without inequalities.
    pub(crate) fn unconstrained(&self, instance: &Instance) -> DVector<f64> {
        let mut point = instance.mean.clone();
        if let Some(equalities) = &self.equalities {
            equalities.restore(&mut point, &instance.values);
        }
        let (_, gradient) = self.evaluate(instance, &point);
        point.gemv(-1.0, &self.inverse, &gradient, 1.0);
        point
    }

    /// `f(h)` and its gradient.
    pub(crate) fn evaluate(
        &self,
        instance: &Instance,
        unknowns: &DVector<f64>,
    ) -> (f64, DVector<f64>) {
        let away = unknowns - &instance.mean;
        let drawn = self.precision.times(&away);
        let value = 0.5 * away.dot(&drawn);
        if self.equalities.is_some() {
            return (value, drawn);
        }
        let misses = &self.design * unknowns - &instance.values;
        let weighted = misses.component_mul(&self.weights);
        (
            value + 0.5 * misses.dot(&weighted),
            drawn + self.design.tr_mul(&weighted),
        )
    }
}
