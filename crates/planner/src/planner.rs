//! From a dictionary and targets to certified trajectories.

use std::time::{Duration, Instant};

use inhand_model::{
    ActiveBounds, Certificate, Dictionary, DictionaryKind, Plan, PlanStatus, SegmentLayout,
    Trajectory,
};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::active_set::{self, ActiveSet, Constraint};
use crate::certificate::{Answer, certificate};
use crate::error::PlanError;
use crate::interior_point;
use crate::method::{Backend, Method, PlannerSettings};
use crate::objective::{self, MM_PER_M, Objective};
use crate::target::Target;
use crate::velocity::{VelocityLimits, VelocityRow};

/// Worst certificate residual of a plan that counts as solved.
const SOLVED: f64 = 1e-6;
/// Worst certificate residual of a plan that counts as almost solved.
const ALMOST_SOLVED: f64 = 1e-4;
/// Refinement of the optimum stops here at the latest: each step gains some six digits.
const REFINEMENTS: usize = 3;
/// Refinement stops once the certificate is this good.
const REFINED: f64 = 1e-11;
/// A polished answer this good is taken even where Clarabel's own is better: it says exactly which
/// bounds hold with equality.
const POLISHED: f64 = 1e-9;
/// Rounds of adding violated velocity rows; each adds at least one, two or three are usual.
const ROUNDS: usize = 200;

/// A dictionary ready to plan with one method: everything that does not depend on the target is
/// computed once, when it is made.
#[derive(Clone, Debug)]
pub struct Planner {
    method: Method,
    backend: Backend,
    layout: SegmentLayout,
    /// NMF: activations must not be negative.
    signs: bool,
    primitives: DMatrix<f64>,
    /// The motion at zero activations, mm.
    base_mm: Vec<f64>,
    objective: Objective,
    limits: VelocityLimits,
    /// `C`, inverse of the objective's second derivative (n x n), mm².
    inverse: DMatrix<f64>,
    /// From what is wanted to the unconstrained minimum: `C Aᵀ diag(w)` (n x m).
    gain: DMatrix<f64>,
    /// The unconstrained minimum where nothing is wanted: `C Λ mu`, mm.
    origin_mm: DVector<f64>,
}

/// An optimum with its multipliers, before it is judged.
struct Candidate {
    activations_mm: DVector<f64>,
    signs: Vec<(usize, f64)>,
    velocity: Vec<(VelocityRow, f64)>,
}

/// A candidate with its motion and proof.
struct Judged {
    candidate: Candidate,
    motion_mm: Vec<f64>,
    objective: f64,
    certificate: Certificate,
}

/// What a backend reached.
struct Outcome {
    judged: Judged,
    infeasible: bool,
    velocity_rows: usize,
    rounds: usize,
    iterations: usize,
}

impl Planner {
    /// Prepares a dictionary for planning. Cost: two inversions of rank x rank matrices.
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
        let SegmentLayout {
            samples, rate_hz, ..
        } = dictionary.layout;
        if samples < 2 || !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(PlanError::Layout { samples, rate_hz });
        }
        dictionary.validate()?;
        if dictionary.rank() == 0 {
            return Err(PlanError::NoPrimitives);
        }
        let objective = Objective::new(dictionary, method, settings)?;
        // Cannot fail but by rounding: a positive definite precision plus a Gram matrix.
        let inverse =
            objective::inverse(objective.hessian()).ok_or_else(|| PlanError::Conditioning {
                rank: dictionary.rank(),
                sigma_m: settings.sigma_m,
            })?;
        let mut gain = &inverse * objective.design.transpose();
        for (mut column, weight) in gain.column_iter_mut().zip(objective.weights.iter()) {
            column *= *weight;
        }
        let origin_mm = &inverse * objective.precision.times(&objective.mean_mm);
        Ok(Self {
            method,
            backend: Backend::default(),
            layout: dictionary.layout,
            signs: dictionary.kind == DictionaryKind::Nmf,
            base_mm: dictionary.offset_m.iter().map(|v| v * MM_PER_M).collect(),
            limits: VelocityLimits::new(&settings.velocity_bounds, dictionary.layout),
            primitives: dictionary.primitives.clone(),
            objective,
            inverse,
            gain,
            origin_mm,
        })
    }

    /// The same planner with another solver.
    #[must_use]
    pub fn with_backend(mut self, backend: Backend) -> Self {
        self.backend = backend;
        self
    }

    /// Which problem is solved.
    pub const fn method(&self) -> Method {
        self.method
    }

    /// Who solves it.
    pub const fn backend(&self) -> Backend {
        self.backend
    }

    /// Shape of the planned trajectories.
    pub const fn layout(&self) -> SegmentLayout {
        self.layout
    }

    /// Number of primitives.
    pub fn rank(&self) -> usize {
        self.primitives.ncols()
    }

    /// Plans the motion to a target.
    ///
    /// Velocity rows are taken up only where they are violated; the plan's certificate covers all
    /// of them. A problem without a solution gives [`PlanStatus::Infeasible`] with an infinite
    /// objective; its certificate then belongs to the last point tried and shows by how much it
    /// violates the rows.
    ///
    /// # Errors
    ///
    /// [`PlanError::Target`] for a target with a number that is not finite or too large to be in
    /// metres, among those the method uses.
    pub fn plan(&self, target: &Target) -> Result<Plan, PlanError> {
        let wanted_mm = self.objective.wanted_mm(target, &self.base_mm)?;
        let outcome = match self.backend {
            Backend::ActiveSet => {
                let outcome = self.by_active_set(&wanted_mm);
                if outcome.infeasible || outcome.judged.certificate.worst() <= SOLVED {
                    outcome
                } else {
                    let second = self.by_interior_point(&wanted_mm);
                    let better =
                        second.judged.certificate.worst() < outcome.judged.certificate.worst();
                    if better || second.infeasible {
                        second
                    } else {
                        outcome
                    }
                }
            }
            Backend::Clarabel => self.by_interior_point(&wanted_mm),
        };
        self.plan_from(outcome)
    }

    fn by_active_set(&self, wanted_mm: &DVector<f64>) -> Outcome {
        let unconstrained = &self.origin_mm + &self.gain * wanted_mm;
        let mut solver = ActiveSet::new(&self.inverse, unconstrained, self.signs);
        let mut rows: Vec<VelocityRow> = Vec::new();
        let mut rounds = 0;
        loop {
            rounds += 1;
            let ending = solver.minimise();
            let motion_mm = self.motion_mm(solver.point());
            let mut fresh = self.limits.violated(&motion_mm, true);
            fresh.retain(|row| !rows.contains(row));
            if ending != active_set::Ending::Optimal || fresh.is_empty() || rounds == ROUNDS {
                return Outcome {
                    judged: self.refined(&mut solver, &rows, wanted_mm),
                    infeasible: ending == active_set::Ending::Infeasible,
                    velocity_rows: rows.len(),
                    rounds,
                    iterations: solver.steps(),
                };
            }
            for row in fresh {
                solver.add_row(
                    self.limits.normal(&self.primitives, row),
                    self.limits.bound_mm(&self.base_mm, row),
                    0.5 * self.limits.allowed_mm(row),
                );
                rows.push(row);
            }
        }
    }

    fn by_interior_point(&self, wanted_mm: &DVector<f64>) -> Outcome {
        let mut rows: Vec<VelocityRow> = Vec::new();
        let mut handed: Vec<(DVector<f64>, f64)> = Vec::new();
        let (mut rounds, mut iterations) = (0, 0);
        loop {
            rounds += 1;
            let found = interior_point::solve(
                &self.objective,
                wanted_mm,
                &self.objective.mean_mm,
                self.signs,
                &handed,
            );
            iterations += found.iterations;
            let judged = self.polished(&found, &rows, wanted_mm);
            let mut fresh = self.limits.violated(&judged.motion_mm, false);
            fresh.retain(|row| !rows.contains(row));
            if found.ending != interior_point::Ending::Optimal
                || fresh.is_empty()
                || rounds == ROUNDS
            {
                return Outcome {
                    judged,
                    infeasible: found.ending == interior_point::Ending::Infeasible,
                    velocity_rows: rows.len(),
                    rounds,
                    iterations,
                };
            }
            handed.extend(fresh.iter().map(|&row| {
                (
                    self.limits.normal(&self.primitives, row),
                    self.limits.bound_mm(&self.base_mm, row),
                )
            }));
            rows.extend(fresh);
        }
    }

    /// The solver's present point, refined until its certificate is as good as it gets.
    fn refined(
        &self,
        solver: &mut ActiveSet<'_>,
        rows: &[VelocityRow],
        wanted_mm: &DVector<f64>,
    ) -> Judged {
        solver.snap();
        let mut best = self.judge(candidate(solver, rows), wanted_mm);
        for _ in 0..REFINEMENTS {
            if best.certificate.worst() <= REFINED {
                break;
            }
            let (_, gradient) =
                self.objective
                    .evaluate(wanted_mm, &self.objective.mean_mm, solver.point());
            solver.refine(gradient);
            solver.snap();
            let next = self.judge(candidate(solver, rows), wanted_mm);
            if next.certificate.worst() >= best.certificate.worst() {
                break;
            }
            best = next;
        }
        best
    }

    /// Clarabel's answer, solved once more with the bounds it found active as equalities, where
    /// that is better.
    fn polished(
        &self,
        found: &interior_point::Solution,
        rows: &[VelocityRow],
        wanted_mm: &DVector<f64>,
    ) -> Judged {
        let mut raw = Candidate {
            activations_mm: found.activations_mm.clone(),
            signs: Vec::new(),
            velocity: Vec::new(),
        };
        for &(constraint, multiplier, _) in &found.inequalities {
            match constraint {
                Constraint::Sign(i) => raw.signs.push((i, multiplier)),
                Constraint::Row(j) => raw.velocity.push((rows[j], multiplier)),
            }
        }
        let raw = self.judge(raw, wanted_mm);
        if found.ending != interior_point::Ending::Optimal {
            return raw;
        }
        let mut solver = ActiveSet::new(&self.inverse, found.activations_mm.clone(), self.signs);
        for &row in rows {
            solver.add_row(
                self.limits.normal(&self.primitives, row),
                self.limits.bound_mm(&self.base_mm, row),
                0.5 * self.limits.allowed_mm(row),
            );
        }
        solver.hold(
            found
                .inequalities
                .iter()
                .filter(|(_, multiplier, slack)| multiplier > slack)
                .map(|&(constraint, ..)| constraint),
        );
        let (_, gradient) =
            self.objective
                .evaluate(wanted_mm, &self.objective.mean_mm, &found.activations_mm);
        solver.refine(gradient);
        let polished = self.refined(&mut solver, rows, wanted_mm);
        if polished.certificate.worst() <= raw.certificate.worst().max(POLISHED) {
            polished
        } else {
            raw
        }
    }

    fn judge(&self, candidate: Candidate, wanted_mm: &DVector<f64>) -> Judged {
        let motion_mm = self.motion_mm(&candidate.activations_mm);
        let mean_mm = &self.objective.mean_mm;
        let (objective, gradient) =
            self.objective
                .evaluate(wanted_mm, mean_mm, &candidate.activations_mm);
        let gradient_at_zero = self.objective.gradient_at_zero(wanted_mm, mean_mm);
        let certificate = certificate(
            &self.primitives,
            &self.limits,
            self.signs,
            &gradient,
            &gradient_at_zero,
            &Answer {
                activations_mm: &candidate.activations_mm,
                motion_mm: &motion_mm,
                signs: &candidate.signs,
                velocity: &candidate.velocity,
            },
        );
        Judged {
            candidate,
            motion_mm,
            objective,
            certificate,
        }
    }

    /// `base + W h`, mm. Columns whose activation is zero are skipped, the others taken four at a
    /// time, so that the sum is loaded and stored a quarter as often.
    fn motion_mm(&self, activations_mm: &DVector<f64>) -> Vec<f64> {
        let rows = self.primitives.nrows();
        let mut motion = self.base_mm.clone();
        let used: Vec<(f64, &[f64])> = activations_mm
            .iter()
            .zip(self.primitives.as_slice().chunks_exact(rows))
            .filter(|(h, _)| **h != 0.0)
            .map(|(h, column)| (*h, column))
            .collect();
        let (fours, rest) = used.as_chunks::<4>();
        for &[(a, wa), (b, wb), (c, wc), (d, wd)] in fours {
            for ((((sum, wa), wb), wc), wd) in motion.iter_mut().zip(wa).zip(wb).zip(wc).zip(wd) {
                *sum += (a * wa + b * wb) + (c * wc + d * wd);
            }
        }
        for &(a, wa) in rest {
            for (sum, wa) in motion.iter_mut().zip(wa) {
                *sum += a * wa;
            }
        }
        motion
    }

    fn plan_from(&self, outcome: Outcome) -> Result<Plan, PlanError> {
        let Judged {
            candidate,
            motion_mm,
            objective,
            certificate,
        } = outcome.judged;
        let status = match certificate.worst() {
            _ if outcome.infeasible => PlanStatus::Infeasible,
            worst if worst <= SOLVED => PlanStatus::Solved,
            worst if worst <= ALMOST_SOLVED => PlanStatus::AlmostSolved,
            _ => PlanStatus::Failed,
        };
        let usable = matches!(status, PlanStatus::Solved | PlanStatus::AlmostSolved);
        let trajectory = if usable {
            let values_m = motion_mm.iter().map(|v| v / MM_PER_M).collect();
            Some(Trajectory::new(self.layout, values_m)?)
        } else {
            None
        };
        Ok(Plan {
            status,
            trajectory,
            active: ActiveBounds {
                velocity: candidate.velocity.iter().filter(|(_, u)| *u > 0.0).count(),
                activation: if self.signs && usable {
                    candidate
                        .activations_mm
                        .iter()
                        .filter(|h| **h == 0.0)
                        .count()
                } else {
                    0
                },
            },
            activations_m: if usable {
                candidate.activations_mm / MM_PER_M
            } else {
                DVector::zeros(0)
            },
            objective: if outcome.infeasible {
                f64::INFINITY
            } else {
                objective
            },
            certificate,
            velocity_rows: outcome.velocity_rows,
            rounds: outcome.rounds,
            iterations: outcome.iterations,
        })
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

fn candidate(solver: &ActiveSet<'_>, rows: &[VelocityRow]) -> Candidate {
    let (mut signs, mut velocity) = (Vec::new(), Vec::new());
    for (constraint, multiplier) in solver.working() {
        match constraint {
            Constraint::Sign(i) => signs.push((i, multiplier)),
            Constraint::Row(j) => velocity.push((rows[j], multiplier)),
        }
    }
    Candidate {
        activations_mm: solver.point().clone(),
        signs,
        velocity,
    }
}
