//! Velocity bounds as rows of the problem: two for each coordinate and pair of neighbouring
//! samples, almost none of them ever active.

use nalgebra::{DMatrix, DVector};

use inhand_model::{SEGMENT_COORDINATES, SegmentLayout, VelocityBounds};

use crate::objective::MM_PER_M;

/// How far over its bound a velocity may be, relative to the bound, before its row is added.
/// A thousandth of what is promised (1e-6); rounding is a thousand times smaller still.
const TOLERANCE: f64 = 1e-9;

/// Which of the two bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Side {
    Lower,
    Upper,
}

/// One velocity bound, as the row `normal · h >= bound`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct VelocityRow {
    /// From this sample to the next.
    pub(crate) step: usize,
    /// Finger and axis, 0 to 14.
    pub(crate) coordinate: usize,
    /// Which of the two bounds.
    pub(crate) side: Side,
}

/// Bounds on how far each coordinate moves from one sample to the next, mm.
#[derive(Clone, Debug)]
pub(crate) struct VelocityLimits {
    lower_mm: [f64; SEGMENT_COORDINATES],
    upper_mm: [f64; SEGMENT_COORDINATES],
    steps: usize,
    rate_hz: f64,
}

impl VelocityLimits {
    pub(crate) fn new(bounds: &VelocityBounds, layout: SegmentLayout) -> Self {
        let per_step = |v: f64| v * MM_PER_M / layout.rate_hz;
        Self {
            lower_mm: bounds.min_m_s.map(per_step),
            upper_mm: bounds.max_m_s.map(per_step),
            steps: layout.samples - 1,
            rate_hz: layout.rate_hz,
        }
    }

    /// The row's factors of the activations: `±(W_{t+1} - W_t)`.
    pub(crate) fn normal(&self, primitives: &DMatrix<f64>, row: VelocityRow) -> DVector<f64> {
        let at = row.step * SEGMENT_COORDINATES + row.coordinate;
        let sign = row.sign();
        DVector::from_iterator(
            primitives.ncols(),
            primitives
                .column_iter()
                .map(|w| sign * (w[at + SEGMENT_COORDINATES] - w[at])),
        )
    }

    /// The row's right-hand side, mm: the bound less what the base motion does already.
    pub(crate) fn bound_mm(&self, base_mm: &[f64], row: VelocityRow) -> f64 {
        row.sign() * (self.limit_mm(row) - row.step_mm(base_mm))
    }

    /// How far a motion stays inside the bound, mm; negative outside.
    pub(crate) fn slack_mm(&self, motion_mm: &[f64], row: VelocityRow) -> f64 {
        row.sign() * (row.step_mm(motion_mm) - self.limit_mm(row))
    }

    /// Largest violation over all rows, relative to the bound (or to 1 mm/s where that is larger).
    pub(crate) fn worst_violation(&self, motion_mm: &[f64]) -> f64 {
        let scale = |limit_mm: f64| (limit_mm.abs() * self.rate_hz).max(1.0) / self.rate_hz;
        let lower_scale = self.lower_mm.map(scale);
        let upper_scale = self.upper_mm.map(scale);
        let mut worst = [0.0_f64; SEGMENT_COORDINATES];
        for (now, next) in samples(motion_mm).zip(samples(motion_mm).skip(1)) {
            for c in 0..SEGMENT_COORDINATES {
                let step_mm = next[c] - now[c];
                let below = (self.lower_mm[c] - step_mm) / lower_scale[c];
                let above = (step_mm - self.upper_mm[c]) / upper_scale[c];
                worst[c] = worst[c].max(below).max(above);
            }
        }
        worst.into_iter().fold(0.0, f64::max)
    }

    /// The violated rows, in order of coordinate, side and time; of each coordinate and side only
    /// the worst one if `peaks_only`. Neighbouring rows are nearly the same, so enforcing the peak
    /// usually mends most of them.
    pub(crate) fn violated(&self, motion_mm: &[f64], peaks_only: bool) -> Vec<VelocityRow> {
        if self.worst_violation(motion_mm) <= TOLERANCE {
            return Vec::new();
        }
        let mut found = Vec::new();
        for coordinate in 0..SEGMENT_COORDINATES {
            for side in [Side::Lower, Side::Upper] {
                let mut peak: Option<(VelocityRow, f64)> = None;
                for step in 0..self.steps {
                    let row = VelocityRow {
                        step,
                        coordinate,
                        side,
                    };
                    let slack_mm = self.slack_mm(motion_mm, row);
                    if slack_mm >= -self.allowed_mm(row) {
                        continue;
                    }
                    if !peaks_only {
                        found.push(row);
                    } else if peak.is_none_or(|(_, least_mm)| slack_mm < least_mm) {
                        peak = Some((row, slack_mm));
                    }
                }
                found.extend(peak.map(|(row, _)| row));
            }
        }
        found
    }

    /// How far a row may be violated, mm.
    pub(crate) fn allowed_mm(&self, row: VelocityRow) -> f64 {
        TOLERANCE * self.limit_mm(row).abs().max(1.0 / self.rate_hz)
    }

    fn limit_mm(&self, row: VelocityRow) -> f64 {
        match row.side {
            Side::Lower => self.lower_mm[row.coordinate],
            Side::Upper => self.upper_mm[row.coordinate],
        }
    }
}

impl VelocityRow {
    fn sign(self) -> f64 {
        match self.side {
            Side::Lower => 1.0,
            Side::Upper => -1.0,
        }
    }

    fn step_mm(self, motion_mm: &[f64]) -> f64 {
        let at = self.step * SEGMENT_COORDINATES + self.coordinate;
        motion_mm[at + SEGMENT_COORDINATES] - motion_mm[at]
    }
}

fn samples(motion_mm: &[f64]) -> impl Iterator<Item = &[f64; SEGMENT_COORDINATES]> {
    motion_mm.as_chunks::<SEGMENT_COORDINATES>().0.iter()
}
