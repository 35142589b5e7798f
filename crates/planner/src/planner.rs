//! Certified trajectories from a dictionary and targets.

use std::sync::{Arc, OnceLock, PoisonError, RwLock};
use std::time::{Duration, Instant};

use inhand_model::{
    Corridor, Dictionary, EndConditions, Finger, Hull, ObjectEnds, PerFinger, Plan, Pose, Residual,
    SEGMENT_COORDINATES, SegmentLayout,
};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::MM_PER_M;
use crate::error::PlanError;
use crate::method::{Backend, Method};
use crate::model::MotionModel;
use crate::outcome::plan_from;
use crate::problem::{Deviations, Problem};
use crate::rows::{Differences, Families, Family, Held, Reach, Separation};
use crate::settings::PlannerSettings;
use crate::solve::Task;
use crate::target::Target;
use crate::target_values::{TargetValues, sample_at};

/// Number of patterns of targets that are kept prepared, besides the usual one.
const KEPT: usize = 32;

/// A dictionary ready to plan with one method: everything that does not depend on the target's
/// values is computed once, for the usual target when it is made and for others when they first
/// come.
#[derive(Clone, Debug)]
pub struct Planner {
    method: Option<Method>,
    backend: Backend,
    model: MotionModel,
    deviations: Option<Deviations>,
    families: Vec<Arc<dyn Family>>,
    hulls: Option<Arc<PerFinger<Hull>>>,
    usual: Arc<Prepared>,
    /// The same problems for every clone: none depends on the backend.
    others: Arc<RwLock<Vec<Arc<Prepared>>>>,
}

/// Parts of a planner that depend on the pattern of targets, not on their values.
#[derive(Debug)]
struct Prepared {
    problem: Problem,
    corridor: OnceLock<Corridor>,
}

impl Planner {
    /// Prepares a dictionary for planning. Cost: inversions of rank x rank matrices.
    ///
    /// # Errors
    ///
    /// [`PlanError`] for a dictionary that does not validate, has no primitives, no two samples or
    /// a covariance that is not positive definite, and for settings out of range.
    pub fn new(
        dictionary: &Dictionary,
        method: Method,
        settings: &PlannerSettings,
    ) -> Result<Self, PlanError> {
        settings.validate()?;
        let model = MotionModel::of_dictionary(dictionary, method, settings.ridge)?;
        let hulls = settings.hulls.clone().or_else(|| {
            let hulls = &dictionary.demonstrated.hulls;
            let known = hulls.iter().all(|(_, hull)| !hull.normals.is_empty());
            known.then(|| Arc::new(hulls.clone()))
        });
        Self::with_model(model, Some(method), settings, hulls)
    }

    /// Prepares motion as a smooth curve with a learned deviation for planning.
    ///
    /// Unknowns are the end conditions and the activations of the deviation. What a target gives of
    /// the end conditions decides what is expected of the deviation; end conditions that it does
    /// not give are taken at their most likely values there.
    ///
    /// # Errors
    ///
    /// [`PlanError`] for parts that do not fit together, hold numbers that are not finite, a
    /// covariance that is not positive definite, and for settings out of range.
    pub fn residual(residual: &Residual, settings: &PlannerSettings) -> Result<Self, PlanError> {
        settings.validate()?;
        let model = MotionModel::of_residual(residual)?;
        Self::with_model(model, None, settings, settings.hulls.clone())
    }

    fn with_model(
        model: MotionModel,
        method: Option<Method>,
        settings: &PlannerSettings,
        hulls: Option<Arc<PerFinger<Hull>>>,
    ) -> Result<Self, PlanError> {
        let layout = model.layout;
        let constraints = &settings.constraints;
        let mut families: Vec<Arc<dyn Family>> = Vec::new();
        if let Some(bounds) = &constraints.velocity {
            let (min, max) = (&bounds.min_m_s, &bounds.max_m_s);
            families.push(Arc::new(Differences::new(1, min, max, layout)));
        }
        if let Some(bounds) = &constraints.acceleration {
            let (min, max) = (&bounds.min_m_s2, &bounds.max_m_s2);
            families.push(Arc::new(Differences::new(2, min, max, layout)));
        }
        if let Some(margin_m) = constraints.reachability_margin_m {
            let hulls = (hulls.as_ref()).ok_or_else(|| PlanError::no_hull(Finger::Thumb))?;
            families.push(Arc::new(Reach::new(hulls, margin_m, layout)?));
        }
        if let Some(least_m) = constraints.separation_m {
            let expected_mm = model.motion_mm(&model.mean_mm(None, &[]));
            families.push(Arc::new(Separation::new(least_m, layout, expected_mm)));
        }
        let deviations = Deviations::new(settings, method);
        let usual = TargetValues::new(&usual_target(method), layout)?;
        Ok(Self {
            method,
            backend: Backend::default(),
            families,
            hulls,
            usual: Arc::new(Prepared::new(&model, &usual, deviations)?),
            others: Arc::default(),
            deviations,
            model,
        })
    }

    /// The same planner with another solver.
    #[must_use]
    pub fn with_backend(mut self, backend: Backend) -> Self {
        self.backend = backend;
        self
    }

    /// The same planner with hard targets: what they give is reached exactly.
    ///
    /// # Errors
    ///
    /// [`PlanError`] where rounding leaves no problem to solve.
    pub fn exact(mut self) -> Result<Self, PlanError> {
        if self.deviations.take().is_some() {
            let usual = TargetValues::new(&usual_target(self.method), self.model.layout)?;
            self.usual = Arc::new(Prepared::new(&self.model, &usual, None)?);
            self.others = Arc::default();
        }
        Ok(self)
    }

    /// Whether targets are hard.
    pub const fn is_exact(&self) -> bool {
        self.deviations.is_none()
    }

    /// Problem of a dictionary that is solved; `None` for a smooth curve with a deviation.
    pub const fn method(&self) -> Option<Method> {
        self.method
    }

    /// Shape of the planned trajectories.
    pub const fn layout(&self) -> SegmentLayout {
        self.model.layout
    }

    /// Number of unknowns: primitives, and end conditions where they are unknowns too.
    pub fn unknowns(&self) -> usize {
        self.model.unknowns()
    }

    /// Plans the motion to a target.
    ///
    /// Rows of the constraints are activated only where they are violated; the plan's certificate
    /// covers all of them. A problem without a solution gives [`PlanStatus::Infeasible`](inhand_model::PlanStatus::Infeasible) with an
    /// infinite objective and says by how much its constraints would have to be relaxed; its
    /// certificate then belongs to the last point tried.
    ///
    /// # Errors
    ///
    /// [`PlanError`] for a target that gives nothing, contradicts itself, has a number that is not
    /// finite or too large to be in metres, a waypoint outside the segment, or an object where
    /// segments carry none.
    pub fn plan(&self, target: &Target) -> Result<Plan, PlanError> {
        self.plan_near(target, None)
    }

    /// [`Planner::plan`] with what is expected of the unknowns (mm; as the demonstrations have it if
    /// `None`).
    pub(crate) fn plan_near(
        &self,
        target: &Target,
        expected_mm: Option<DVector<f64>>,
    ) -> Result<Plan, PlanError> {
        let values = TargetValues::new(target, self.model.layout)?;
        let prepared = self.prepared(&values)?;
        let problem = &prepared.problem;
        let instance = problem.instance(&self.model, &values, expected_mm);
        let held = target.holding.as_ref().map(Held::new);
        let mut families: Vec<&dyn Family> = self.families.iter().map(|f| &**f).collect();
        families.extend(held.iter().map(|held| held as &dyn Family));
        let task = Task {
            model: &self.model,
            problem,
            instance: &instance,
            families: Families {
                all: families,
                from: sample_at(target.constrained_from_s, self.model.layout)?,
            },
        };
        let outcome = task.solve(self.backend);
        plan_from(&task, &outcome, target, self.hulls.as_deref())
    }

    /// Prediction region (95 %) of motion around a plan to this target. Depends on which parts of a segment the
    /// target gives, not on their values; constraints narrow it no further.
    ///
    /// # Errors
    ///
    /// As for [`Planner::plan`]; [`PlanError::Setting`] for [`Method::Paper`].
    pub fn corridor(&self, target: &Target) -> Result<Corridor, PlanError> {
        if self.method == Some(Method::Paper) {
            return Err(PlanError::Setting(
                "the method paper has no prediction region: its ridge makes the solution unique and says \
                 nothing about how demonstrations vary"
                    .to_owned(),
            ));
        }
        let values = TargetValues::new(target, self.model.layout)?;
        let prepared = self.prepared(&values)?;
        let made = || corridor(&self.model, &prepared.problem.inverse);
        Ok(prepared.corridor.get_or_init(made).clone())
    }

    /// The problem for targets that give these parts, made if there is none yet.
    fn prepared(&self, values: &TargetValues) -> Result<Arc<Prepared>, PlanError> {
        let fits = |prepared: &&Arc<Prepared>| prepared.problem.fits(values);
        // A thread that panicked left the list whole: it is only ever pushed to.
        let known = || self.others.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(prepared) = std::iter::once(&self.usual).find(fits) {
            return Ok(Arc::clone(prepared));
        }
        if let Some(prepared) = known().iter().find(fits) {
            return Ok(Arc::clone(prepared));
        }
        let prepared = Arc::new(Prepared::new(&self.model, values, self.deviations)?);
        let mut others = self.others.write().unwrap_or_else(PoisonError::into_inner);
        if others.len() == KEPT {
            others.remove(0);
        }
        others.push(Arc::clone(&prepared));
        Ok(prepared)
    }
}

impl Prepared {
    fn new(
        model: &MotionModel,
        values: &TargetValues,
        deviations: Option<Deviations>,
    ) -> Result<Self, PlanError> {
        Ok(Self {
            problem: Problem::new(model, values, deviations)?,
            corridor: OnceLock::new(),
        })
    }
}

/// The target that is usual for a method: what it is given when methods are compared.
fn usual_target(method: Option<Method>) -> Target {
    let pose = Pose::identity();
    let ends = EndConditions {
        first_m: [0.0; SEGMENT_COORDINATES],
        last_m: [0.0; SEGMENT_COORDINATES],
        first_velocity_m_s: [0.0; SEGMENT_COORDINATES],
        last_velocity_m_s: [0.0; SEGMENT_COORDINATES],
        object: Some(ObjectEnds {
            first: pose,
            last: pose,
        }),
    };
    match method {
        Some(method) => method.target(&ends),
        None => Target::from(ends),
    }
}

/// Plans to each target, on all threads of the current rayon pool; results in order, each with the
/// time its plan took on its thread. The results do not depend on the number of threads.
pub fn plan_all(planner: &Planner, targets: &[Target]) -> Vec<(Result<Plan, PlanError>, Duration)> {
    targets
        .par_iter()
        .map(|target| {
            let start = Instant::now();
            let plan = planner.plan(target);
            (plan, start.elapsed())
        })
        .collect()
}

/// `W_t C W_tᵀ + unexplained` for each fingertip and sample, with the covariance `C` of the unknowns
/// given the target. Cost: a product of (15 N x n) and (n x n).
fn corridor(model: &MotionModel, covariance: &DMatrix<f64>) -> Corridor {
    let layout = model.layout;
    let basis = model.basis.to_dense(layout.finger_rows());
    let spread = &basis * covariance;
    let squared = MM_PER_M * MM_PER_M;
    let covariance_m2 = (0..layout.samples)
        .map(|t| {
            PerFinger::from_fn(|finger| {
                let at = SegmentLayout::row(t, finger, 0);
                let mut block = spread.rows(at, 3) * basis.rows(at, 3).transpose();
                for axis in 0..3 {
                    block[(axis, axis)] += model.unexplained_mm2;
                }
                [0, 1, 2]
                    .map(|i| [0, 1, 2].map(|j| 0.5 * (block[(i, j)] + block[(j, i)]) / squared))
            })
        })
        .collect();
    Corridor::new(covariance_m2)
}
