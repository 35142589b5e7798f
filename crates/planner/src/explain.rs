//! Explains infeasibility: the smallest relaxation of the constraints that has a solution, by contradictions.
//!
//! With the bounds of some families moved outwards by `s`, rows read `n_j · h >= b_j - y_j s`. Where
//! the active set finds that they contradict each other, it says why (Farkas): with factors
//! `l_j >= 0` the rows add up to one in which nothing is free, and the bounds to `missing` more than
//! its value. That holds for every `h`, so `s` has to rise by `missing / sum l_j y_j` at least; where
//! the sum is nothing, no relaxation of these families is enough. Raising `s` by just that until
//! there is no contradiction is Newton's method on the largest of these bounds (convex and piecewise
//! linear in `s`): it rises to the least relaxation in finitely many steps, a few in practice.
//! Where the active set has no answer, Clarabel finds the least relaxation as one program.

use std::borrow::Cow;

use clarabel::solver::SolverStatus;
use inhand_model::{ConstraintFamily, PerFamily, Relaxation};
use nalgebra::DVector;

use crate::MM_PER_M;
use crate::active_set::{ActiveSet, Constraint, Ending};
use crate::interior_point::Program;
use crate::problem::{Instance, Problem};
use crate::rows::ActiveRow;
use crate::solve::Task;
use crate::target_values::TargetPart;

/// Rows are activated until none is violated by more than this, mm.
const TOLERANCE_MM: f64 = 1e-7;
/// Contradictions that are answered, and rounds of adding violated rows.
const ROUNDS: usize = 100;
/// How often a point is refined where rounding let rows go.
const REFINEMENTS: usize = 3;
/// Rows that could be met this many standard deviations away do not contradict each other: what is
/// left free in their sum is more than rounding.
const FARTHEST: f64 = 1e4;
/// Families take no part in a contradiction where the yield of their rows is less than this part of
/// what all rows would yield.
const NO_PART: f64 = 1e-9;

/// Weight of the distance from the expected unknowns (over their largest precision), which keeps
/// the others where they are; small enough not to cost any of the relaxation (a linear program
/// plus a small enough quadratic term has a solution of the linear program as its own).
const ANCHOR: f64 = 1e-8;

/// Least relaxation of each family of constraints alone with which the rest has a solution, and where
/// none alone is enough, of all of them together, each by the same number of its units. Families are those of the
/// task and hard targets; signs are never relaxed.
///
/// Solves `minimise s` with the bounds of a family moved outwards by `s`, rows activated as needed.
/// For fingertips kept apart that is the linearised problem.
pub(crate) fn relaxations(task: &Task<'_>, rows: &[ActiveRow]) -> Vec<Relaxation> {
    let mut families: Vec<_> = task
        .families
        .all
        .iter()
        .map(|family| family.family())
        .collect();
    if task.problem.equalities.is_some() {
        for target in [
            ConstraintFamily::Targets,
            ConstraintFamily::TargetVelocities,
        ] {
            if (task.problem.pattern.iter()).any(|&part| family_of(part) == target) {
                families.push(target);
            }
        }
    }
    families.sort();
    let alone: Vec<Relaxation> = (families.iter())
        .filter_map(|&family| {
            Some(Relaxation {
                family,
                by: least(task, rows, &[family])?,
                joint: false,
            })
        })
        .collect();
    if !alone.is_empty() {
        return alone;
    }
    let Some(by) = least(task, rows, &families) else {
        return Vec::new();
    };
    let together = |family| Relaxation {
        family,
        by,
        joint: true,
    };
    families.into_iter().map(together).collect()
}

/// The family of a hard target.
pub(crate) const fn family_of(part: TargetPart) -> ConstraintFamily {
    match part {
        TargetPart::Velocity { .. } | TargetPart::Step { .. } => ConstraintFamily::TargetVelocities,
        // A rotation counts by its way at the lever.
        TargetPart::Position { .. }
        | TargetPart::ObjectPosition { .. }
        | TargetPart::ObjectRotation { .. } => ConstraintFamily::Targets,
    }
}

/// A row that may be relaxed.
struct Yielding {
    normal: DVector<f64>,
    bound: f64,
    /// How far the bound moves for one unit of relaxation; zero where it does not.
    yielding: f64,
}

/// The least relaxation of these families, in their units; `None` where no relaxation is enough.
fn least(task: &Task<'_>, rows: &[ActiveRow], families: &[ConstraintFamily]) -> Option<f64> {
    let mut active = rows.to_vec();
    match by_contradictions(task, &mut active, families) {
        Found::Least(by) => Some(by),
        Found::Nothing => None,
        Found::Unclear => by_program(task, active, families),
    }
}

enum Found {
    Least(f64),
    /// No relaxation is enough.
    Nothing,
    /// The active set did not come to an end.
    Unclear,
}

fn by_contradictions(
    task: &Task<'_>,
    active: &mut Vec<ActiveRow>,
    families: &[ConstraintFamily],
) -> Found {
    let Some((problem, instance, mut rows)) = kept(task, families) else {
        return Found::Unclear;
    };
    let kept = Task {
        problem: &problem,
        instance: &instance,
        ..task.clone()
    };
    let start = problem.unconstrained(&instance);
    if !kept.equations_hold(&start) {
        return Found::Nothing;
    }
    let yielding = |active: &ActiveRow| Yielding {
        normal: active.normal.clone(),
        bound: active.bound,
        yielding: if families.contains(&active.row.family) {
            active.row.yielding
        } else {
            0.0
        },
    };
    rows.extend(active.iter().map(yielding));
    let mut by = 0.0;
    for _ in 0..ROUNDS {
        let mut solver = ActiveSet::new(&problem.inverse, start.clone(), task.model.signs);
        let add = |solver: &mut ActiveSet<'_>, row: &Yielding| {
            let bound = row.bound - row.yielding * by;
            solver.add_row(row.normal.clone(), bound, 0.5 * TOLERANCE_MM);
        };
        rows.iter().for_each(|row| add(&mut solver, row));
        for round in 0.. {
            match solver.minimise() {
                Ending::Stalled => return Found::Unclear,
                Ending::Infeasible => break,
                Ending::Optimal => {}
            }
            if !restored(&kept, &mut solver, &rows, by) {
                return Found::Unclear;
            }
            let fresh = fresh(task, active, families, &solver.point, by);
            if fresh.is_empty() {
                return Found::Least(by);
            }
            if round == ROUNDS {
                return Found::Unclear;
            }
            for row in fresh {
                rows.push(yielding(&row));
                add(&mut solver, &rows[rows.len() - 1]);
                active.push(row);
            }
        }
        match rise(&problem, &solver, &rows) {
            Ok(rise) => by += rise,
            Err(found) => return found,
        }
    }
    Found::Unclear
}

/// Rows that are violated and not active yet, with families relaxed by `by` of their units.
fn fresh(
    task: &Task<'_>,
    active: &[ActiveRow],
    families: &[ConstraintFamily],
    unknowns: &DVector<f64>,
    by: f64,
) -> Vec<ActiveRow> {
    let slack = PerFamily::from_fn(|family| {
        let unit_mm = (active.iter().find(|active| active.row.family == family))
            .map_or(MM_PER_M, |active| active.row.yielding);
        TOLERANCE_MM / unit_mm + if families.contains(&family) { by } else { 0.0 }
    });
    let motion_mm = task.model.motion_mm(unknowns);
    task.fresh(&motion_mm, &slack, active, true)
}

/// The problem with the equations that are not relaxed, and those that are, as pairs of rows.
fn kept<'a>(
    task: &Task<'a>,
    families: &[ConstraintFamily],
) -> Option<(Cow<'a, Problem>, Cow<'a, Instance>, Vec<Yielding>)> {
    let (problem, instance) = (task.problem, task.instance);
    let equations = problem
        .equalities
        .as_ref()
        .map_or(0, |all| all.rows.nrows());
    let (relaxed, kept): (Vec<usize>, Vec<usize>) =
        (0..equations).partition(|k| families.contains(&family_of(problem.pattern[k / 3])));
    let Some(all) = problem.equalities.as_ref().filter(|_| !relaxed.is_empty()) else {
        return Some((Cow::Borrowed(problem), Cow::Borrowed(instance), Vec::new()));
    };
    let pair = |&k: &usize| {
        [1.0, -1.0].map(|sign| Yielding {
            normal: all.rows.row(k).transpose() * sign,
            bound: instance.values[k] * sign,
            yielding: MM_PER_M,
        })
    };
    let rows = relaxed.iter().flat_map(pair).collect();
    let (problem, instance) = problem.with_equations(instance, &kept)?;
    Some((Cow::Owned(problem), Cow::Owned(instance), rows))
}

/// By how much families have to be relaxed further for a contradiction to go.
fn rise(problem: &Problem, solver: &ActiveSet<'_>, rows: &[Yielding]) -> Result<f64, Found> {
    let contradiction = (solver.contradiction.as_ref()).ok_or(Found::Unclear)?;
    let (mut yields, mut could_yield) = (0.0, 0.0);
    let mut sum = DVector::zeros(solver.point.len());
    for &(constraint, factor) in &contradiction.factors {
        match constraint {
            Constraint::Sign(i) => sum[i] += factor,
            Constraint::Row(j) => {
                sum.axpy(factor, &rows[j].normal, 1.0);
                yields += factor * rows[j].yielding;
                could_yield += factor * MM_PER_M * rows[j].normal.norm();
            }
        }
    }
    let spread = sum.dot(&(&problem.inverse * &sum)).max(0.0).sqrt();
    if contradiction.missing < FARTHEST * spread {
        return Err(Found::Unclear);
    }
    if yields <= NO_PART * could_yield {
        return Err(Found::Nothing);
    }
    Ok(contradiction.missing / yields)
}

/// Takes back what rounding did to the solver's point; whether all rows, signs and equations
/// then hold.
fn restored(kept: &Task<'_>, solver: &mut ActiveSet<'_>, rows: &[Yielding], by: f64) -> bool {
    let row_holds = |point: &DVector<f64>, row: &Yielding| {
        row.normal.dot(point) - row.bound + row.yielding * by >= -TOLERANCE_MM
    };
    for refinement in 0..=REFINEMENTS {
        solver.snap();
        let point = &solver.point;
        if kept.equations_hold(point)
            && (!kept.model.signs || point.min() >= -TOLERANCE_MM)
            && rows.iter().all(|row| row_holds(point, row))
        {
            return true;
        }
        if refinement < REFINEMENTS {
            kept.correct(solver);
        }
    }
    false
}

/// The same by Clarabel, rows activated as needed.
fn by_program(
    task: &Task<'_>,
    mut active: Vec<ActiveRow>,
    families: &[ConstraintFamily],
) -> Option<f64> {
    // One family's rows all yield alike, so that the relaxation can be had in mm of its rows.
    let own = active.iter().find(|active| families == [active.row.family]);
    let unit_mm = own.map_or(MM_PER_M, |active| active.row.yielding);
    for _ in 0..ROUNDS {
        let (unknowns, relaxation_mm) = elastic(task, &active, families, unit_mm)?;
        let by = relaxation_mm.max(0.0) / unit_mm;
        let fresh = fresh(task, &active, families, &unknowns, by);
        if fresh.is_empty() {
            return Some(by);
        }
        active.extend(fresh);
    }
    None
}

/// Unknowns and the least relaxation (mm of rows that move by `unit_mm` for one unit) under the
/// given rows.
fn elastic(
    task: &Task<'_>,
    rows: &[ActiveRow],
    families: &[ConstraintFamily],
    unit_mm: f64,
) -> Option<(DVector<f64>, f64)> {
    let n = task.model.unknowns();
    let precision = &task.problem.precision;
    // The small pull towards the expected unknowns.
    let upper = precision.upper(n);
    let diagonal = upper.iter().filter(|(i, j, _)| i == j).map(|entry| entry.2);
    let weight = ANCHOR / diagonal.fold(f64::MIN_POSITIVE, f64::max);
    let pull = precision.times(&task.instance.mean) * -weight;
    let anchor = (upper.into_iter()).map(|(i, j, v)| (i, j, weight * v));
    let mut linear: Vec<f64> = pull.data.into();
    linear.push(1.0);
    let mut program = Program::new(anchor.collect(), linear);

    let slack = |family, yielding: f64| families.contains(&family).then_some((n, -yielding));
    let mut relaxed = Vec::new();
    for (k, row) in (task.problem.equalities.iter()).flat_map(|e| e.rows.row_iter().enumerate()) {
        let right = task.instance.values[k];
        match slack(family_of(task.problem.pattern[k / 3]), MM_PER_M / unit_mm) {
            None => program.push(row.iter(), 1.0, None, right),
            slack => relaxed.push((row, right, slack)),
        }
    }
    let equations = program.right.len();
    for (row, right, slack) in relaxed {
        program.push(row.iter(), 1.0, slack, right);
        program.push(row.iter(), -1.0, slack, -right);
    }
    for active in rows {
        let slack = slack(active.row.family, active.row.yielding / unit_mm);
        program.push(active.normal.iter(), -1.0, slack, -active.bound);
    }
    program.push([], 1.0, Some((n, -1.0)), 0.0);
    for i in 0..if task.model.signs { n } else { 0 } {
        program.push([], 1.0, Some((i, -1.0)), 0.0);
    }
    let found = program.solve(equations)?;
    matches!(
        found.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved
    )
    .then(|| (DVector::from_column_slice(&found.x[..n]), found.x[n]))
}
