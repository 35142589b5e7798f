//! Constraints on the motion as rows that are activated where they are violated.
//!
//! Each [`Family`] knows all its rows implicitly: which of them a motion violates, and by how much at
//! most. A row is a combination of a few trajectory coordinates; its factors of the unknowns are
//! made when it is activated.

mod differences;
mod holding;
mod reach;
mod separation;

pub(crate) use differences::Differences;
pub(crate) use holding::Held;
pub(crate) use reach::Reach;
pub(crate) use separation::Separation;

use std::borrow::Cow;
use std::fmt::Debug;

use inhand_model::{ConstraintFamily, Finger, PerFamily, SEGMENT_COORDINATES};
use nalgebra::DVector;

use crate::MM_PER_M;
use crate::model::MotionModel;

/// How far over its bound a linear row may be, relative to the bound, before it is activated. A
/// thousandth of what is promised (1e-6); rounding is a thousand times smaller still.
const TOLERANCE: f64 = 1e-9;

/// Identity of a row.
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

/// `sum of factor * coordinate >= bound`, mm, over a few trajectory coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) family: ConstraintFamily,
    pub(crate) key: Key,
    terms: Vec<(usize, f64)>,
    pub(crate) bound: f64,
    /// How far the row may be violated, mm.
    pub(crate) allowed: f64,
    /// How far the bound moves when its family is relaxed by one of its units, mm.
    pub(crate) yielding: f64,
}

impl Row {
    /// How far a motion stays inside the bound, mm; negative outside.
    pub(crate) fn slack(&self, motion_mm: &[f64]) -> f64 {
        self.along(motion_mm) - self.bound
    }

    /// The row's factors of the unknowns.
    pub(crate) fn normal(&self, model: &MotionModel) -> DVector<f64> {
        let mut normal = DVector::zeros(model.unknowns());
        for &(coordinate, factor) in &self.terms {
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
        (self.terms.iter())
            .map(|&(coordinate, factor)| factor * motion_mm[coordinate])
            .sum()
    }
}

/// A row that was activated.
#[derive(Clone)]
pub(crate) struct ActiveRow {
    pub(crate) row: Row,
    pub(crate) normal: DVector<f64>,
    pub(crate) bound: f64,
}

/// The largest violation of a family.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Worst {
    /// Relative to the bound, as certificates have it.
    pub(crate) relative: f64,
    /// In the family's unit; negative with room to spare.
    pub(crate) by: f64,
}

/// Constraints of one kind: rows by series (a finger, a pair of fingers, a bound) and sample.
pub(crate) trait Family: Debug + Send + Sync {
    fn family(&self) -> ConstraintFamily;

    /// Numbers of series and of samples in each.
    fn size(&self) -> (usize, usize);

    /// Number of rows.
    fn rows(&self) -> usize {
        let (series, samples) = self.size();
        series * samples
    }

    /// How far a motion is beyond the bound, mm; negative inside.
    fn excess(&self, motion_mm: &[f64], series: usize, sample: usize) -> f64;

    /// The row that the motion violates most there.
    fn row(&self, motion_mm: &[f64], series: usize, sample: usize) -> Row;

    /// What a violation in a series is relative to, mm.
    fn scale_mm(&self, series: usize) -> f64;

    /// How far beyond the bound a motion may be before a row is activated, mm.
    fn allowed_mm(&self, series: usize) -> f64 {
        TOLERANCE * self.scale_mm(series)
    }

    /// Whether rows bound differences of neighbouring samples, of which each is nearly the same as the next.
    fn is_difference(&self) -> bool {
        false
    }

    /// Differences of positions a second (or its square), for bounds on those; 1 otherwise.
    fn rate(&self) -> f64 {
        1.0
    }

    /// The row of the same series and sample with the direction of another motion, if that turned.
    fn turned(&self, _row: &Row, _motion_mm: &[f64]) -> Option<Row> {
        None
    }

    /// Largest violation.
    fn worst(&self, motion_mm: &[f64]) -> Worst {
        let (series, samples) = self.size();
        let (mut relative, mut by_mm) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        for series in 0..series {
            for sample in 0..samples {
                let excess = self.excess(motion_mm, series, sample);
                by_mm = by_mm.max(excess);
                relative = relative.max(excess / self.scale_mm(series));
            }
        }
        Worst {
            relative,
            by: by_mm * self.rate() / MM_PER_M,
        }
    }

    /// Rows that a motion violates by more than `slack` (in the family's unit) and its tolerance. Of
    /// neighbouring samples only the worst if `peaks_only`, of a bound on differences only the worst of all.
    fn violated(&self, motion_mm: &[f64], slack: f64, peaks_only: bool, rows: &mut Vec<Row>) {
        let is_difference = self.is_difference();
        if is_difference && slack == 0.0 && self.worst(motion_mm).relative <= TOLERANCE {
            return;
        }
        let slack_mm = slack * MM_PER_M / self.rate();
        let (series, samples) = self.size();
        for series in 0..series {
            let limit = slack_mm + self.allowed_mm(series);
            let mut peak: Option<(usize, f64)> = None;
            for sample in 0..samples {
                let excess = self.excess(motion_mm, series, sample);
                if excess > limit {
                    if !peaks_only {
                        rows.push(self.row(motion_mm, series, sample));
                    } else if peak.is_none_or(|(_, worst)| excess > worst) {
                        peak = Some((sample, excess));
                    }
                } else if !is_difference && let Some((sample, _)) = peak.take() {
                    rows.push(self.row(motion_mm, series, sample));
                }
            }
            rows.extend(peak.map(|(sample, _)| self.row(motion_mm, series, sample)));
        }
    }
}

/// The families that are switched on, for one target.
#[derive(Clone, Debug)]
pub(crate) struct Families<'a> {
    pub(crate) all: Vec<&'a dyn Family>,
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
        let mut rows = Vec::new();
        self.each(motion_mm, |family, motion_mm| {
            family.violated(motion_mm, slack[family.family()], peaks_only, &mut rows);
        });
        rows.retain(|row| row.key.sample() >= self.from);
        rows
    }

    /// Largest violation of each family that is on.
    pub(crate) fn worst(&self, motion_mm: &[f64]) -> PerFamily<Option<Worst>> {
        let mut worst = PerFamily::default();
        self.each(motion_mm, |family, motion_mm| {
            worst[family.family()] = Some(family.worst(motion_mm));
        });
        worst
    }

    /// Looks at each family's motion, in which what lies before constraints begin to hold is replaced by something
    /// that is as good as what comes then: going straight on backwards for bounds on velocity and acceleration,
    /// at rest for all others.
    fn each(&self, motion_mm: &[f64], mut look: impl FnMut(&dyn Family, &[f64])) {
        let [still, straight] = [false, true].map(|straight| self.constrained(motion_mm, straight));
        for family in &self.all {
            let is_difference = family.is_difference();
            look(*family, if is_difference { &straight } else { &still });
        }
    }

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
}
