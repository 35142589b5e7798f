//! One problem to its optimum: rows taken up as needed, answers refined and judged.

use inhand_model::{Certificate, PerFamily};
use nalgebra::DVector;

use crate::active_set::{self, ActiveSet, Constraint};
use crate::certificate::{Answer, certificate};
use crate::interior_point;
use crate::method::Backend;
use crate::model::MotionModel;
use crate::problem::{Instance, Problem};
use crate::rows::{Families, Row, Worst};

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
#[derive(Clone, Copy)]
pub(crate) struct Task<'a> {
    pub(crate) model: &'a MotionModel,
    pub(crate) problem: &'a Problem,
    pub(crate) instance: &'a Instance,
    pub(crate) families: Families<'a>,
}

/// A row that was taken up.
#[derive(Clone)]
pub(crate) struct Taken {
    pub(crate) row: Row,
    pub(crate) normal: DVector<f64>,
    pub(crate) bound: f64,
}

/// An optimum with its multipliers, before it is judged.
pub(crate) struct Candidate {
    pub(crate) unknowns: DVector<f64>,
    pub(crate) signs: Vec<(usize, f64)>,
    /// By place among the rows taken up.
    pub(crate) rows: Vec<(usize, f64)>,
}

/// A candidate with its motion and proof.
pub(crate) struct Judged {
    pub(crate) candidate: Candidate,
    pub(crate) motion_mm: Vec<f64>,
    pub(crate) objective: f64,
    pub(crate) worst: PerFamily<Option<Worst>>,
    pub(crate) certificate: Certificate,
}

/// What a backend reached.
pub(crate) struct Outcome {
    pub(crate) judged: Judged,
    pub(crate) infeasible: bool,
    pub(crate) rows: Vec<Taken>,
    pub(crate) rounds: usize,
    pub(crate) iterations: usize,
}

impl Task<'_> {
    /// The optimum under all rows.
    pub(crate) fn solve(&self, backend: Backend) -> Outcome {
        let mut outcome = self.converge(backend, Vec::new());
        let Some(separation) = self.families.separation else {
            return outcome;
        };
        // The optimum keeps its rows when their directions follow it, so it can only improve.
        for _ in 0..TURNS {
            if outcome.infeasible || outcome.judged.certificate.worst() > SOLVED {
                break;
            }
            let mut turned = false;
            let rows = (outcome.rows.iter())
                .map(
                    |taken| match separation.turned(&taken.row, &outcome.judged.motion_mm) {
                        Some(row) => {
                            turned = true;
                            self.taken(row)
                        }
                        None => taken.clone(),
                    },
                )
                .collect();
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

    fn converge(&self, backend: Backend, rows: Vec<Taken>) -> Outcome {
        let start = self.problem.unconstrained(self.instance);
        if let Some(equalities) = &self.problem.equalities
            && !equalities.consistent(&start, &self.instance.wanted)
        {
            return Outcome {
                judged: self.judge(at_rest(start), &[]),
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

    fn by_active_set(&self, start: DVector<f64>, mut rows: Vec<Taken>) -> Outcome {
        let mut solver = self.active_set(start, &rows);
        let mut rounds = 0;
        loop {
            rounds += 1;
            let ending = solver.minimise();
            let motion_mm = self.model.motion_mm(solver.point());
            let fresh = self.fresh(&motion_mm, &rows, true);
            if ending != active_set::Ending::Optimal || fresh.is_empty() || rounds == ROUNDS {
                return Outcome {
                    judged: self.refined(&mut solver, &rows),
                    infeasible: ending == active_set::Ending::Infeasible,
                    rows,
                    rounds,
                    iterations: solver.steps(),
                };
            }
            for taken in fresh {
                add(&mut solver, &taken);
                rows.push(taken);
            }
        }
    }

    fn by_interior_point(&self, mut rows: Vec<Taken>) -> Outcome {
        let (mut rounds, mut iterations) = (0, 0);
        loop {
            rounds += 1;
            let found = interior_point::solve(self.problem, self.instance, self.model.signs, &rows);
            iterations += found.iterations;
            let judged = self.polished(&found, &rows);
            let fresh = self.fresh(&judged.motion_mm, &rows, false);
            if found.ending != interior_point::Ending::Optimal
                || fresh.is_empty()
                || rounds == ROUNDS
            {
                return Outcome {
                    judged,
                    infeasible: found.ending == interior_point::Ending::Infeasible,
                    rows,
                    rounds,
                    iterations,
                };
            }
            rows.extend(fresh);
        }
    }

    /// Rows that a motion violates and that were not taken up yet.
    fn fresh(&self, motion_mm: &[f64], rows: &[Taken], peaks_only: bool) -> Vec<Taken> {
        let violated = self
            .families
            .violated(motion_mm, &PerFamily::default(), peaks_only);
        (violated.into_iter())
            .filter(|row| rows.iter().all(|taken| taken.row.key != row.key))
            .map(|row| self.taken(row))
            .collect()
    }

    pub(crate) fn taken(&self, row: Row) -> Taken {
        Taken {
            normal: row.normal(self.model),
            bound: row.bound_on_unknowns(self.model),
            row,
        }
    }

    fn active_set(&self, start: DVector<f64>, rows: &[Taken]) -> ActiveSet<'_> {
        let mut solver = ActiveSet::new(&self.problem.inverse, start, self.model.signs);
        for taken in rows {
            add(&mut solver, taken);
        }
        solver
    }

    /// The solver's present point, refined until its certificate is as good as it gets.
    fn refined(&self, solver: &mut ActiveSet<'_>, rows: &[Taken]) -> Judged {
        solver.snap();
        let mut best = self.judge(candidate(solver), rows);
        for _ in 0..REFINEMENTS {
            if best.certificate.worst() <= REFINED {
                break;
            }
            if let Some(equalities) = &self.problem.equalities {
                solver.correct(|point| equalities.restore(point, &self.instance.wanted));
            }
            let (_, gradient) = self.problem.evaluate(self.instance, solver.point());
            solver.refine(gradient);
            solver.snap();
            let next = self.judge(candidate(solver), rows);
            if next.certificate.worst() >= best.certificate.worst() {
                break;
            }
            best = next;
        }
        best
    }

    /// Clarabel's answer, solved once more with the bounds it found active as equalities, where
    /// that is better.
    fn polished(&self, found: &interior_point::Solution, rows: &[Taken]) -> Judged {
        let mut raw = at_rest(found.unknowns.clone());
        for &(constraint, multiplier, _) in &found.inequalities {
            match constraint {
                Constraint::Sign(i) => raw.signs.push((i, multiplier)),
                Constraint::Row(j) => raw.rows.push((j, multiplier)),
            }
        }
        let raw = self.judge(raw, rows);
        if found.ending != interior_point::Ending::Optimal {
            return raw;
        }
        let mut start = found.unknowns.clone();
        if let Some(equalities) = &self.problem.equalities {
            equalities.restore(&mut start, &self.instance.wanted);
        }
        let (_, gradient) = self.problem.evaluate(self.instance, &start);
        let mut solver = self.active_set(start, rows);
        solver.hold(
            found
                .inequalities
                .iter()
                .filter(|(_, multiplier, slack)| multiplier > slack)
                .map(|&(constraint, ..)| constraint),
        );
        solver.refine(gradient);
        let polished = self.refined(&mut solver, rows);
        if polished.certificate.worst() <= raw.certificate.worst().max(POLISHED) {
            polished
        } else {
            raw
        }
    }

    fn judge(&self, candidate: Candidate, rows: &[Taken]) -> Judged {
        let motion_mm = self.model.motion_mm(&candidate.unknowns);
        let (objective, gradient) = self.problem.evaluate(self.instance, &candidate.unknowns);
        let worst = self.families.worst(&motion_mm);
        let multipliers: Vec<(&Row, f64)> = (candidate.rows.iter())
            .map(|&(j, multiplier)| (&rows[j].row, multiplier))
            .collect();
        let certificate = certificate(
            self.model,
            self.problem,
            self.instance,
            &Answer {
                unknowns: &candidate.unknowns,
                motion_mm: &motion_mm,
                gradient: &gradient,
                signs: &candidate.signs,
                rows: &multipliers,
                worst: &worst,
            },
        );
        Judged {
            candidate,
            motion_mm,
            objective,
            worst,
            certificate,
        }
    }
}

fn add(solver: &mut ActiveSet<'_>, taken: &Taken) {
    solver.add_row(taken.normal.clone(), taken.bound, 0.5 * taken.row.allowed);
}

/// A point without any multiplier.
fn at_rest(unknowns: DVector<f64>) -> Candidate {
    Candidate {
        unknowns,
        signs: Vec::new(),
        rows: Vec::new(),
    }
}

fn candidate(solver: &ActiveSet<'_>) -> Candidate {
    let mut candidate = at_rest(solver.point().clone());
    for (constraint, multiplier) in solver.working() {
        match constraint {
            Constraint::Sign(i) => candidate.signs.push((i, multiplier)),
            Constraint::Row(j) => candidate.rows.push((j, multiplier)),
        }
    }
    candidate
}
