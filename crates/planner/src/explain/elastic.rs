//! The least relaxation by contradictions.
//!
//! With the bounds of some families moved outwards by `s`, rows read `n_j · h >= b_j - y_j s`. Where
//! the active set finds that they contradict each other, it says why (Farkas): with factors
//! `l_j >= 0` the rows add up to one in which nothing is free, and the bounds to `missing` more than
//! its value. That holds for every `h`, so `s` has to rise by `missing / sum l_j y_j` at least; where
//! the sum is nothing, no relaxation of these families is enough. Raising `s` by just that until
//! there is no contradiction is Newton's method on the largest of these bounds (convex and piecewise
//! linear in `s`): it rises to the least relaxation in finitely many steps, a few in practice.

use std::borrow::Cow;

use inhand_model::{ConstraintFamily, PerFamily};
use nalgebra::{DMatrix, DVector};

use super::{family_of, program};
use crate::active_set::{ActiveSet, Constraint, Ending};
use crate::equality::Equalities;
use crate::model::MM_PER_M;
use crate::precision::{inverse, make_symmetric};
use crate::solve::{Taken, Task};

/// Rows are taken up until none is violated by more than this, mm.
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

/// A row that may give way.
struct Yielding {
    normal: DVector<f64>,
    bound: f64,
    /// How far the bound moves for one unit of relaxation; zero where it does not.
    yielding: f64,
}

/// The least relaxation of these families, in their units; `None` where no relaxation is enough.
pub(super) fn least(task: &Task<'_>, rows: &[Taken], families: &[ConstraintFamily]) -> Option<f64> {
    let mut taken = rows.to_vec();
    match by_contradictions(task, &mut taken, families) {
        Found::Least(by) => Some(by),
        Found::Nothing => None,
        Found::Unclear => by_program(task, taken, families),
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
    taken: &mut Vec<Taken>,
    families: &[ConstraintFamily],
) -> Found {
    let relaxed = |family| families.contains(&family);
    let Some(mut kept) = Kept::new(task, families) else {
        return Found::Unclear;
    };
    if !kept.consistent {
        return Found::Nothing;
    }
    let yielding = |taken: &Taken| Yielding {
        normal: taken.normal.clone(),
        bound: taken.bound,
        yielding: if relaxed(taken.row.family) {
            taken.row.yielding
        } else {
            0.0
        },
    };
    let mut rows = std::mem::take(&mut kept.given_way);
    rows.extend(taken.iter().map(yielding));
    let mut by = 0.0;
    for _ in 0..ROUNDS {
        let mut solver = ActiveSet::new(&kept.inverse, kept.start.clone(), task.model.signs);
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
            if !kept.restored(task, &mut solver, &rows, by) {
                return Found::Unclear;
            }
            let fresh = fresh(task, taken, families, solver.point(), by);
            if fresh.is_empty() {
                return Found::Least(by);
            }
            if round == ROUNDS {
                return Found::Unclear;
            }
            for row in fresh {
                rows.push(yielding(&row));
                add(&mut solver, &rows[rows.len() - 1]);
                taken.push(row);
            }
        }
        let Some(contradiction) = solver.contradiction() else {
            return Found::Unclear;
        };
        let (mut yields, mut could_yield) = (0.0, 0.0);
        let mut sum = DVector::zeros(task.model.unknowns());
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
        let spread = sum.dot(&(&*kept.inverse * &sum)).max(0.0).sqrt();
        if contradiction.missing < FARTHEST * spread {
            return Found::Unclear;
        }
        if yields <= NO_PART * could_yield {
            return Found::Nothing;
        }
        by += contradiction.missing / yields;
    }
    Found::Unclear
}

/// Rows that are violated and were not taken up yet, with families relaxed by `by` of their units.
fn fresh(
    task: &Task<'_>,
    taken: &[Taken],
    families: &[ConstraintFamily],
    unknowns: &DVector<f64>,
    by: f64,
) -> Vec<Taken> {
    let slack = PerFamily::from_fn(|family| {
        let unit_mm = (taken.iter().find(|taken| taken.row.family == family))
            .map_or(MM_PER_M, |taken| taken.row.yielding);
        TOLERANCE_MM / unit_mm + if families.contains(&family) { by } else { 0.0 }
    });
    let motion_mm = task.model.motion_mm(unknowns);
    (task.families.violated(&motion_mm, &slack, true).into_iter())
        .filter(|row| taken.iter().all(|taken| taken.row.key != row.key))
        .map(|row| task.taken(row))
        .collect()
}

/// The equations that are kept, and those that give way as pairs of rows.
struct Kept<'a> {
    /// Inverse of the second derivative within the kept equations.
    inverse: Cow<'a, DMatrix<f64>>,
    /// The minimum under them alone.
    start: DVector<f64>,
    consistent: bool,
    given_way: Vec<Yielding>,
    /// The kept equations with their right side.
    equations: Option<(Cow<'a, Equalities>, DVector<f64>)>,
}

impl<'a> Kept<'a> {
    fn new(task: &Task<'a>, families: &[ConstraintFamily]) -> Option<Self> {
        let problem = task.problem;
        let Some(all) = &problem.equalities else {
            return Some(Self {
                inverse: Cow::Borrowed(&problem.inverse),
                start: problem.unconstrained(task.instance),
                consistent: true,
                given_way: Vec::new(),
                equations: None,
            });
        };
        let wanted = &task.instance.wanted;
        let (given_way, kept): (Vec<usize>, Vec<usize>) = (0..all.rows.nrows())
            .partition(|k| families.contains(&family_of(problem.given[k / 3])));
        if given_way.is_empty() {
            let start = problem.unconstrained(task.instance);
            return Some(Self {
                inverse: Cow::Borrowed(&problem.inverse),
                consistent: all.consistent(&start, wanted),
                start,
                given_way: Vec::new(),
                equations: Some((Cow::Borrowed(all), wanted.clone())),
            });
        }
        let pair = |&k: &usize| {
            [1.0, -1.0].map(|sign| Yielding {
                normal: all.rows.row(k).transpose() * sign,
                bound: wanted[k] * sign,
                yielding: MM_PER_M,
            })
        };
        let given_way = given_way.iter().flat_map(pair).collect();
        let n = task.model.unknowns();
        let mut hessian = DMatrix::zeros(n, n);
        problem.precision.add_to(&mut hessian);
        let mean = &task.instance.mean;
        if kept.is_empty() {
            return Some(Self {
                inverse: Cow::Owned(inverse(hessian)?),
                start: mean.clone(),
                consistent: true,
                given_way,
                equations: None,
            });
        }
        let equalities = Equalities::new(all.rows.select_rows(&kept));
        let wanted = wanted.select_rows(&kept);
        let free = equalities.free();
        let within = inverse(free.tr_mul(&(&hessian * free)))?;
        let mut inverse = free * within * free.transpose();
        make_symmetric(&mut inverse);
        let mut start = mean.clone();
        equalities.restore(&mut start, &wanted);
        let drawn = problem.precision.times(&(&start - mean));
        start.gemv(-1.0, &inverse, &drawn, 1.0);
        Some(Self {
            inverse: Cow::Owned(inverse),
            consistent: equalities.consistent(&start, &wanted),
            start,
            given_way,
            equations: Some((Cow::Owned(equalities), wanted)),
        })
    }

    /// Takes back what rounding did to the solver's point; whether all rows, signs and equations
    /// then hold.
    fn restored(
        &self,
        task: &Task<'_>,
        solver: &mut ActiveSet<'_>,
        rows: &[Yielding],
        by: f64,
    ) -> bool {
        for refinement in 0..=REFINEMENTS {
            solver.snap();
            if self.holds(task, solver.point(), rows, by) {
                return true;
            }
            if refinement < REFINEMENTS {
                if let Some((equations, wanted)) = &self.equations {
                    solver.correct(|point| equations.restore(point, wanted));
                }
                let (_, gradient) = task.problem.evaluate(task.instance, solver.point());
                solver.refine(gradient);
            }
        }
        false
    }

    fn holds(&self, task: &Task<'_>, point: &DVector<f64>, rows: &[Yielding], by: f64) -> bool {
        let equations = self.equations.as_ref();
        equations.is_none_or(|(equations, wanted)| equations.consistent(point, wanted))
            && (!task.model.signs || point.min() >= -TOLERANCE_MM)
            && rows
                .iter()
                .all(|row| row.normal.dot(point) - row.bound + row.yielding * by >= -TOLERANCE_MM)
    }
}

/// The same by Clarabel, rows taken up as needed.
fn by_program(
    task: &Task<'_>,
    mut taken: Vec<Taken>,
    families: &[ConstraintFamily],
) -> Option<f64> {
    // One family's rows all yield alike, so that the relaxation can be had in mm of its rows.
    let own = taken.iter().find(|taken| families == [taken.row.family]);
    let unit_mm = own.map_or(MM_PER_M, |taken| taken.row.yielding);
    for _ in 0..ROUNDS {
        let (unknowns, relaxation_mm) = program::elastic(task, &taken, families, unit_mm)?;
        let by = relaxation_mm.max(0.0) / unit_mm;
        let fresh = fresh(task, &taken, families, &unknowns, by);
        if fresh.is_empty() {
            return Some(by);
        }
        taken.extend(fresh);
    }
    None
}
