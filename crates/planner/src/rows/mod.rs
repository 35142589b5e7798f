//! Constraints on the motion as rows that are taken up where they are violated.
//!
//! Each family knows all its rows implicitly: which of them a motion violates, and by how much at
//! most. A row is a combination of a few trajectory coordinates; its factors of the unknowns are
//! made when it is taken up.

mod differences;
mod holding;
mod reach;
mod separation;

pub(crate) use differences::Differences;
pub(crate) use holding::Held;
pub(crate) use reach::Reach;
pub(crate) use separation::Separation;

use std::borrow::Cow;

use inhand_model::{ConstraintFamily, Finger, PerFamily, SEGMENT_COORDINATES};
use nalgebra::DVector;

use crate::model::MotionModel;

/// How far over its bound a linear row may be, relative to the bound, before it is taken up. A
/// thousandth of what is promised (1e-6); rounding is a thousand times smaller still.
const TOLERANCE: f64 = 1e-9;

/// Which row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Key {
    /// A bound on the first or second difference from a sample on.
    Difference {
        order: usize,
        sample: usize,
        coordinate: usize,
        upper: bool,
    },
    /// A face of a hull.
    Face {
        sample: usize,
        finger: Finger,
        face: usize,
    },
    /// A pair of fingertips, kept apart in one direction.
    Apart { sample: usize, pair: usize },
    /// A tangent of the ball around a contact point, by the bits of its direction.
    Tangent {
        sample: usize,
        finger: Finger,
        direction: [u64; 3],
    },
}

impl Key {
    /// The first sample that the row is about.
    const fn sample(self) -> usize {
        match self {
            Key::Difference { sample, .. }
            | Key::Face { sample, .. }
            | Key::Apart { sample, .. }
            | Key::Tangent { sample, .. } => sample,
        }
    }
}

/// `sum of factor * coordinate >= bound`, mm, over at most six trajectory coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) family: ConstraintFamily,
    pub(crate) key: Key,
    terms: [(usize, f64); 6],
    used: usize,
    pub(crate) bound: f64,
    /// How far the row may be violated, mm.
    pub(crate) allowed: f64,
    /// How far the bound moves when its family is relaxed by one of its units, mm.
    pub(crate) yielding: f64,
}

impl Row {
    fn new(
        family: ConstraintFamily,
        key: Key,
        terms: impl IntoIterator<Item = (usize, f64)>,
        bound: f64,
        allowed: f64,
        yielding: f64,
    ) -> Self {
        let mut row = Self {
            family,
            key,
            terms: [(0, 0.0); 6],
            used: 0,
            bound,
            allowed,
            yielding,
        };
        for (place, term) in row.terms.iter_mut().zip(terms) {
            *place = term;
            row.used += 1;
        }
        row
    }

    fn terms(&self) -> &[(usize, f64)] {
        &self.terms[..self.used]
    }

    /// How far a motion stays inside the bound, mm; negative outside.
    pub(crate) fn slack(&self, motion_mm: &[f64]) -> f64 {
        self.along(motion_mm) - self.bound
    }

    /// The row's factors of the unknowns.
    pub(crate) fn normal(&self, model: &MotionModel) -> DVector<f64> {
        let mut normal = DVector::zeros(model.unknowns());
        for &(coordinate, factor) in self.terms() {
            model
                .basis
                .add_row(coordinate, factor, normal.as_mut_slice());
        }
        normal
    }

    /// The row's right-hand side for the unknowns: the bound less what the base motion does already.
    pub(crate) fn bound_on_unknowns(&self, model: &MotionModel) -> f64 {
        self.bound - self.along(&model.base_mm)
    }

    fn along(&self, motion_mm: &[f64]) -> f64 {
        (self.terms().iter())
            .map(|&(coordinate, factor)| factor * motion_mm[coordinate])
            .sum()
    }
}

/// The largest violation of a family.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Worst {
    /// Relative to the bound, as certificates have it.
    pub(crate) relative: f64,
    /// In the family's unit; negative with room to spare.
    pub(crate) by: f64,
}

/// The families that are switched on, for one target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Families<'a> {
    pub(crate) velocity: Option<&'a Differences>,
    pub(crate) acceleration: Option<&'a Differences>,
    pub(crate) reach: Option<&'a Reach>,
    pub(crate) separation: Option<&'a Separation>,
    pub(crate) held: Option<&'a Held>,
    /// Constraints hold from this sample on.
    pub(crate) from: usize,
}

impl Families<'_> {
    /// Rows that a motion violates by more than its family's slack (in its unit) and tolerance. Of
    /// neighbouring ones only the worst if `peaks_only`: they are nearly the same, so enforcing the
    /// peak usually mends most of them.
    pub(crate) fn violated(
        &self,
        motion_mm: &[f64],
        slack: &PerFamily<f64>,
        peaks_only: bool,
    ) -> Vec<Row> {
        let straight = &*self.constrained(motion_mm, true);
        let motion_mm = &*self.constrained(motion_mm, false);
        let mut rows = Vec::new();
        for family in [self.velocity, self.acceleration].into_iter().flatten() {
            family.violated(straight, slack[family.family()], peaks_only, &mut rows);
        }
        if let Some(reach) = self.reach {
            let slack = slack[ConstraintFamily::Reachability];
            reach.violated(motion_mm, slack, peaks_only, &mut rows);
        }
        if let Some(separation) = self.separation {
            let slack = slack[ConstraintFamily::Separation];
            separation.violated(motion_mm, slack, peaks_only, &mut rows);
        }
        if let Some(held) = self.held {
            let slack = slack[ConstraintFamily::Holding];
            held.violated(motion_mm, slack, peaks_only, &mut rows);
        }
        rows.retain(|row| row.key.sample() >= self.from);
        rows
    }

    /// The motion with what lies before constraints begin to hold replaced by something that is as
    /// good as what comes then: going straight on backwards for bounds on velocity and acceleration,
    /// at rest for all others.
    fn constrained<'m>(&self, motion_mm: &'m [f64], straight: bool) -> Cow<'m, [f64]> {
        if self.from == 0 {
            return Cow::Borrowed(motion_mm);
        }
        let mut motion = motion_mm.to_vec();
        for c in 0..SEGMENT_COORDINATES {
            let at = |sample: usize| sample * SEGMENT_COORDINATES + c;
            let there = motion_mm[at(self.from)];
            let next = motion_mm.get(at(self.from + 1)).copied().unwrap_or(there);
            let step = if straight { next - there } else { 0.0 };
            for sample in 0..self.from {
                motion[at(sample)] = there - step * (self.from - sample) as f64;
            }
        }
        Cow::Owned(motion)
    }

    /// Largest violation of each family that is on.
    pub(crate) fn worst(&self, motion_mm: &[f64]) -> PerFamily<Option<Worst>> {
        let straight = &*self.constrained(motion_mm, true);
        let motion_mm = &*self.constrained(motion_mm, false);
        let mut worst = PerFamily::default();
        for family in [self.velocity, self.acceleration].into_iter().flatten() {
            worst[family.family()] = Some(family.worst(straight));
        }
        worst[ConstraintFamily::Reachability] = self.reach.map(|reach| reach.worst(motion_mm));
        worst[ConstraintFamily::Separation] = self
            .separation
            .map(|separation| separation.worst(motion_mm));
        worst[ConstraintFamily::Holding] = self.held.map(|held| held.worst(motion_mm));
        worst
    }

    /// How many rows there are.
    pub(crate) fn rows(&self) -> usize {
        let differences = [self.velocity, self.acceleration].into_iter().flatten();
        differences.map(Differences::rows).sum::<usize>()
            + self.reach.map_or(0, Reach::rows)
            + self.separation.map_or(0, Separation::rows)
            + self.held.map_or(0, Held::rows)
    }

    /// Which families are on.
    pub(crate) fn on(&self) -> Vec<ConstraintFamily> {
        [
            (ConstraintFamily::Velocity, self.velocity.is_some()),
            (ConstraintFamily::Acceleration, self.acceleration.is_some()),
            (ConstraintFamily::Reachability, self.reach.is_some()),
            (ConstraintFamily::Separation, self.separation.is_some()),
            (ConstraintFamily::Holding, self.held.is_some()),
        ]
        .into_iter()
        .filter_map(|(family, on)| on.then_some(family))
        .collect()
    }
}

/// Collects the worst row of each stretch of violated samples, or all of them.
struct Peaks<'a> {
    rows: &'a mut Vec<Row>,
    peaks_only: bool,
    /// The worst of the present stretch, with its excess.
    peak: Option<(Row, f64)>,
}

impl<'a> Peaks<'a> {
    fn new(rows: &'a mut Vec<Row>, peaks_only: bool) -> Self {
        Self {
            rows,
            peaks_only,
            peak: None,
        }
    }

    /// The next sample is violated by `excess`.
    fn violated(&mut self, excess: f64, row: impl FnOnce() -> Row) {
        if !self.peaks_only {
            self.rows.push(row());
        } else if self.peak.as_ref().is_none_or(|(_, worst)| excess > *worst) {
            self.peak = Some((row(), excess));
        }
    }

    /// The next sample is kept, or there is none.
    fn kept(&mut self) {
        self.rows.extend(self.peak.take().map(|(row, _)| row));
    }
}
