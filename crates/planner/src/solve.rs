//! One problem to its optimum: rows activated as needed, answers refined and judged.
//!
//! Certificates use nothing of a solver but its answer: gradient, slacks and multipliers are put into the
//! optimality conditions over all rows, also those that were never handed to it.

use inhand_model::{Certificate, PerFamily};
use nalgebra::DVector;

use crate::active_set::{ActiveSet, Constraint, Ending};
use crate::interior_point;
use crate::method::Backend;
use crate::model::MotionModel;
use crate::problem::{Instance, Problem};
use crate::rows::{ActiveRow, Families, Row, Worst};

/// Worst certificate residual of a plan that counts as solved.
pub(crate) const SOLVED: f64 = 1e-6;
/// Refinement of the optimum stops here at the latest: each step gains some six digits.
const REFINEMENTS: usize = 3;
/// Refinement stops once the certificate is this good.
const REFINED: f64 = 1e-11;
/// A polished answer this good is taken even where Clarabel's own is better: it says exactly which
/// bounds hold with equality.
const POLISHED: f64 = 1e-9;
/// Rounds of adding violated rows; each adds at least one, two or three are usual.
const ROUNDS: usize = 300;
/// How often directions in which fingertips are kept apart are taken anew.
const TURNS: usize = 20;
/// New directions are kept if they lower the objective by more than this part of it.
const GAIN: f64 = 1e-10;

/// A problem with its target and constraints.
#[derive(Clone)]
pub(crate) struct Task<'a> {
    pub(crate) model: &'a MotionModel,
    pub(crate) problem: &'a Problem,
    pub(crate) instance: &'a Instance,
    pub(crate) families: Families<'a>,
}

/// An optimum with its multipliers where they are not zero, its motion and its proof.
pub(crate) struct Judged {
    pub(crate) unknowns: DVector<f64>,
    pub(crate) multipliers: Vec<(Constraint, f64)>,
    pub(crate) motion_mm: Vec<f64>,
    pub(crate) objective: f64,
    pub(crate) worst: PerFamily<Option<Worst>>,
    pub(crate) certificate: Certificate,
}

/// Result of a backend.
pub(crate) struct Outcome {
    pub(crate) judged: Judged,
    pub(crate) infeasible: bool,
    pub(crate) rows: Vec<ActiveRow>,
    pub(crate) rounds: usize,
    pub(crate) iterations: usize,
}

impl Task<'_> {
    /// The optimum under all rows.
    pub(crate) fn solve(&self, backend: Backend) -> Outcome {
        let mut outcome = self.converge(backend, Vec::new());
        // The optimum keeps its rows when their directions follow it, so it can only improve.
        for _ in 0..TURNS {
            if outcome.infeasible || outcome.judged.certificate.worst() > SOLVED {
                break;
            }
            let motion_mm = &outcome.judged.motion_mm;
            let mut rows = outcome.rows.clone();
            let mut turned = false;
            for active in &mut rows {
                let mut families = self.families.all.iter();
                if let Some(row) = families.find_map(|f| f.turned(&active.row, motion_mm)) {
                    turned = true;
                    *active = self.activated(row);
                }
            }
            if !turned {
                break;
            }
            let mut next = self.converge(backend, rows);
            next.rounds += outcome.rounds;
            next.iterations += outcome.iterations;
            let gain = outcome.judged.objective - next.judged.objective;
            let better = gain > GAIN * outcome.judged.objective.max(1.0);
            if next.infeasible || next.judged.certificate.worst() > SOLVED || !better {
                break;
            }
            outcome = next;
        }
        outcome
    }

    fn converge(&self, backend: Backend, rows: Vec<ActiveRow>) -> Outcome {
        let start = self.problem.unconstrained(self.instance);
        if !self.equations_hold(&start) {
            return Outcome {
                judged: self.judge(start, Vec::new(), &[]),
                infeasible: true,
                rows,
                rounds: 0,
                iterations: 0,
            };
        }
        match backend {
            Backend::ActiveSet => {
                let outcome = self.by_active_set(start, rows);
                if !outcome.infeasible && outcome.judged.certificate.worst() <= SOLVED {
                    return outcome;
                }
                // Rows that are nearly combinations of one another can look contradictory.
                let second = self.by_interior_point(outcome.rows.clone());
                let judged = |outcome: &Outcome| outcome.judged.certificate.worst();
                let solved = !second.infeasible && judged(&second) <= SOLVED;
                let better = !outcome.infeasible && judged(&second) < judged(&outcome);
                if solved || better || (second.infeasible && !outcome.infeasible) {
                    second
                } else {
                    outcome
                }
            }
            Backend::Clarabel => self.by_interior_point(rows),
        }
    }

    fn by_active_set(&self, start: DVector<f64>, mut rows: Vec<ActiveRow>) -> Outcome {
        let mut solver = self.active_set(start, &rows);
        let mut rounds = 0;
        loop {
            rounds += 1;
            let ending = solver.minimise();
            let motion_mm = self.model.motion_mm(&solver.point);
            let fresh = self.fresh(&motion_mm, &PerFamily::default(), &rows, true);
            if ending != Ending::Optimal || fresh.is_empty() || rounds == ROUNDS {
                return Outcome {
                    judged: self.refined(&mut solver, &rows),
                    infeasible: ending == Ending::Infeasible,
                    rows,
                    rounds,
                    iterations: solver.steps,
                };
            }
            for active in fresh {
                add(&mut solver, &active);
                rows.push(active);
            }
        }
    }

    fn by_interior_point(&self, mut rows: Vec<ActiveRow>) -> Outcome {
        let (mut rounds, mut iterations) = (0, 0);
        loop {
            rounds += 1;
            let found = interior_point::solve(self.problem, self.instance, self.model.signs, &rows);
            iterations += found.iterations;
            let judged = self.polished(&found, &rows);
            let fresh = self.fresh(&judged.motion_mm, &PerFamily::default(), &rows, false);
            if found.ending != Ending::Optimal || fresh.is_empty() || rounds == ROUNDS {
                return Outcome {
                    judged,
                    infeasible: found.ending == Ending::Infeasible,
                    rows,
                    rounds,
                    iterations,
                };
            }
            rows.extend(fresh);
        }
    }

    /// Rows that a motion violates and that are not active yet.
    pub(crate) fn fresh(
        &self,
        motion_mm: &[f64],
        slack: &PerFamily<f64>,
        rows: &[ActiveRow],
        peaks_only: bool,
    ) -> Vec<ActiveRow> {
        let violated = self.families.violated(motion_mm, slack, peaks_only);
        (violated.into_iter())
            .filter(|row| rows.iter().all(|active| active.row.key != row.key))
            .map(|row| self.activated(row))
            .collect()
    }

    /// Whether a point keeps the equations.
    pub(crate) fn equations_hold(&self, point: &DVector<f64>) -> bool {
        let equalities = self.problem.equalities.as_ref();
        equalities.is_none_or(|equalities| equalities.consistent(point, &self.instance.values))
    }

    /// Takes back what rounding did to the solver's point.
    pub(crate) fn correct(&self, solver: &mut ActiveSet<'_>) {
        if let Some(equalities) = &self.problem.equalities {
            equalities.restore(&mut solver.point, &self.instance.values);
        }
        let (_, gradient) = self.problem.evaluate(self.instance, &solver.point);
        solver.refine(gradient);
    }

    fn activated(&self, row: Row) -> ActiveRow {
        ActiveRow {
            normal: row.normal(self.model),
            bound: row.bound_on_unknowns(self.model),
            row,
        }
    }

    fn active_set(&self, start: DVector<f64>, rows: &[ActiveRow]) -> ActiveSet<'_> {
        let mut solver = ActiveSet::new(&self.problem.inverse, start, self.model.signs);
        for active in rows {
            add(&mut solver, active);
        }
        solver
    }

    /// The solver's present point, refined until its certificate is as good as it gets.
    fn refined(&self, solver: &mut ActiveSet<'_>, rows: &[ActiveRow]) -> Judged {
        solver.snap();
        let mut best = self.judged(solver, rows);
        for _ in 0..REFINEMENTS {
            if best.certificate.worst() <= REFINED {
                break;
            }
            self.correct(solver);
            solver.snap();
            let next = self.judged(solver, rows);
            if next.certificate.worst() >= best.certificate.worst() {
                break;
            }
            best = next;
        }
        best
    }

    /// Clarabel's answer, solved once more with the bounds it found active as equalities, where
    /// that is better.
    fn polished(&self, found: &interior_point::Solution, rows: &[ActiveRow]) -> Judged {
        let multipliers = found
            .inequalities
            .iter()
            .map(|&(c, multiplier, _)| (c, multiplier));
        let raw = self.judge(found.unknowns.clone(), multipliers.collect(), rows);
        if found.ending != Ending::Optimal {
            return raw;
        }
        let mut solver = self.active_set(found.unknowns.clone(), rows);
        solver.hold(
            found
                .inequalities
                .iter()
                .filter(|(_, multiplier, slack)| multiplier > slack)
                .map(|&(constraint, ..)| constraint),
        );
        self.correct(&mut solver);
        let polished = self.refined(&mut solver, rows);
        if polished.certificate.worst() <= raw.certificate.worst().max(POLISHED) {
            polished
        } else {
            raw
        }
    }

    /// The solver's present point with its proof.
    fn judged(&self, solver: &ActiveSet<'_>, rows: &[ActiveRow]) -> Judged {
        self.judge(solver.point.clone(), solver.working().collect(), rows)
    }

    /// An answer with the four residuals of the optimality conditions, from its motion (mm, all rows) and
    /// the gradient of the minimised function there.
    ///
    /// With `q` the gradient of the minimised function at zero: stationarity, dual and complementarity
    /// are relative to max(1, |q|). Multipliers of equations are those that leave least of the gradient.
    /// Primal is the largest of: violation of a sign (mm), miss of an equation (mm or mm/s, relative to
    /// max(1, its right side)), and violation of a row, relative to its bound as its family has it.
    /// For fingertips kept apart or near contact points that is the true distance, not its
    /// linearisation, while multipliers belong to linearised rows.
    fn judge(
        &self,
        unknowns: DVector<f64>,
        multipliers: Vec<(Constraint, f64)>,
        rows: &[ActiveRow],
    ) -> Judged {
        let motion_mm = self.model.motion_mm(&unknowns);
        let (objective, gradient) = self.problem.evaluate(self.instance, &unknowns);
        let worst = self.families.worst(&motion_mm);
        let scale = self.instance.gradient_at_zero.norm().max(1.0);
        let mut lagrangian = gradient;
        let (mut dual, mut complementarity) = (0.0_f64, 0.0_f64);
        let mut judge = |multiplier: f64, slack: f64| {
            dual = dual.max(-multiplier);
            complementarity = complementarity.max((multiplier * slack).abs());
        };
        // Signs first: the sum is the same in whatever order they and rows were activated.
        for &(constraint, multiplier) in &multipliers {
            if let Constraint::Sign(i) = constraint {
                lagrangian[i] -= multiplier;
                judge(multiplier, unknowns[i]);
            }
        }
        for &(constraint, multiplier) in &multipliers {
            if let Constraint::Row(j) = constraint {
                lagrangian.axpy(-multiplier, &rows[j].normal, 1.0);
                judge(multiplier, rows[j].row.slack(&motion_mm));
            }
        }
        let mut primal = 0.0_f64;
        if self.model.signs {
            primal = primal.max(-unknowns.min());
        }
        if let Some(equalities) = &self.problem.equalities {
            primal = primal.max(equalities.violation(&unknowns, &self.instance.values));
            lagrangian = equalities.remaining(&lagrangian);
        }
        for (_, worst) in worst.iter() {
            primal = primal.max(worst.map_or(0.0, |worst| worst.relative));
        }
        let certificate = Certificate {
            stationarity: lagrangian.norm() / scale,
            primal,
            dual: dual / scale,
            complementarity: complementarity / scale,
        };
        Judged {
            unknowns,
            multipliers,
            motion_mm,
            objective,
            worst,
            certificate,
        }
    }
}

fn add(solver: &mut ActiveSet<'_>, active: &ActiveRow) {
    solver.add_row(
        active.normal.clone(),
        active.bound,
        0.5 * active.row.allowed,
    );
}
