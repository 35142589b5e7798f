//! Fingertips at a distance from one another, by linearisation.
//!
//! `|f_i - f_j| >= d` is not convex. With the direction `n` from j to i at some motion,
//! `n · (f_i - f_j) >= d` implies it, and is kept by that motion's neighbours on the same side.

use inhand_model::{ConstraintFamily, Finger, SegmentLayout};
use nalgebra::Vector3;

use super::holding::tip;
use super::{Family, Key, Row};
use crate::MM_PER_M;

/// Fingertips nearer than this have no direction from one to the other, mm.
const COINCIDE_MM: f64 = 1e-6;
/// A direction that turned by less than this (the sine of the angle) stays.
const TURNED: f64 = 1e-7;

/// A least distance between any two fingertips, mm.
#[derive(Clone, Debug)]
pub(crate) struct Separation {
    least_mm: f64,
    samples: usize,
    /// Directions where a motion has none: the motion that is expected without any target.
    expected_mm: Vec<f64>,
}

/// All pairs, the first finger before the second.
const PAIRS: [(Finger, Finger); 10] = {
    let mut pairs = [(Finger::Thumb, Finger::Thumb); 10];
    let (mut i, mut at) = (0, 0);
    while i < Finger::COUNT {
        let mut j = i + 1;
        while j < Finger::COUNT {
            pairs[at] = (Finger::ALL[i], Finger::ALL[j]);
            at += 1;
            j += 1;
        }
        i += 1;
    }
    pairs
};

impl Separation {
    pub(crate) fn new(least_m: f64, layout: SegmentLayout, expected_mm: Vec<f64>) -> Self {
        Self {
            least_mm: least_m * MM_PER_M,
            samples: layout.samples,
            expected_mm,
        }
    }

    /// From the second fingertip of a pair to the first. Where they coincide, that of the nearest
    /// sample at which they do not (the earlier of two), or of the expected motion, or x.
    fn direction(&self, motion_mm: &[f64], sample: usize, pair: usize) -> Vector3<f64> {
        let unit = |motion: &[f64], at: usize| between(motion, at, pair).try_normalize(COINCIDE_MM);
        let neighbours = (0..self.samples).flat_map(|away| {
            let before = sample.checked_sub(away);
            let after = Some(sample + away).filter(|&at| at < self.samples);
            [before, after].into_iter().flatten()
        });
        neighbours
            .filter_map(|at| unit(motion_mm, at))
            .next()
            .or_else(|| unit(&self.expected_mm, sample))
            .unwrap_or_else(Vector3::x)
    }
}

impl Family for Separation {
    fn family(&self) -> ConstraintFamily {
        ConstraintFamily::Separation
    }

    fn size(&self) -> (usize, usize) {
        (PAIRS.len(), self.samples)
    }

    /// The true distance counts, not its linearisation.
    fn excess(&self, motion_mm: &[f64], pair: usize, sample: usize) -> f64 {
        self.least_mm - between(motion_mm, sample, pair).norm()
    }

    fn scale_mm(&self, _pair: usize) -> f64 {
        self.least_mm.max(1.0)
    }

    fn turned(&self, row: &Row, motion_mm: &[f64]) -> Option<Row> {
        let Key::Apart { sample, pair } = row.key else {
            return None;
        };
        let old = Vector3::from_fn(|axis, _| row.terms[axis].1);
        let new = self.direction(motion_mm, sample, pair);
        let turned = old.cross(&new).norm() > TURNED || old.dot(&new) < 0.0;
        turned.then(|| self.row(motion_mm, pair, sample))
    }

    fn row(&self, motion_mm: &[f64], pair: usize, sample: usize) -> Row {
        let direction = self.direction(motion_mm, sample, pair);
        let (one, other) = PAIRS[pair];
        let [one, other] = [one, other].map(|finger| SegmentLayout::row(sample, finger, 0));
        let away = (0..3).map(|axis| (one + axis, direction[axis]));
        let back = (0..3).map(|axis| (other + axis, -direction[axis]));
        Row {
            family: ConstraintFamily::Separation,
            key: Key::Apart { sample, pair },
            terms: away.chain(back).collect(),
            bound: self.least_mm,
            allowed: self.allowed_mm(pair),
            yielding: MM_PER_M,
        }
    }
}

/// From the second fingertip of a pair to the first, mm.
fn between(motion_mm: &[f64], sample: usize, pair: usize) -> Vector3<f64> {
    let (one, other) = PAIRS[pair];
    tip(motion_mm, sample, one) - tip(motion_mm, sample, other)
}
