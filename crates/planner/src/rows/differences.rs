//! Bounds on velocity and acceleration: first and second differences of each coordinate.

use inhand_model::{
    Configuration, ConstraintFamily, SEGMENT_COORDINATES, SegmentLayout, VelocityBounds,
};

use super::{Key, Row, TOLERANCE, Worst};
use crate::model::MM_PER_M;
use crate::settings::AccelerationBounds;

/// Less than this no difference of positions can be told from rounding, mm.
const ROUNDING_MM: f64 = 1e-12;

/// Bounds on the differences of each coordinate between neighbouring samples, of first order
/// (velocity) or second (acceleration), mm. Two rows for each coordinate and place.
#[derive(Clone, Debug)]
pub(crate) struct Differences {
    order: usize,
    lower_mm: Configuration,
    upper_mm: Configuration,
    places: usize,
    /// Differences per second (or its square): their factor to mm/s or mm/s².
    rate: f64,
}

impl Differences {
    pub(crate) fn velocity(bounds: &VelocityBounds, layout: SegmentLayout) -> Self {
        Self::new(1, &bounds.min_m_s, &bounds.max_m_s, layout)
    }

    pub(crate) fn acceleration(bounds: &AccelerationBounds, layout: SegmentLayout) -> Self {
        Self::new(2, &bounds.min_m_s2, &bounds.max_m_s2, layout)
    }

    fn new(
        order: usize,
        lower: &Configuration,
        upper: &Configuration,
        layout: SegmentLayout,
    ) -> Self {
        let rate = if order == 1 {
            layout.rate_hz
        } else {
            layout.rate_hz * layout.rate_hz
        };
        let difference = |v: f64| v * MM_PER_M / rate;
        Self {
            order,
            lower_mm: lower.map(difference),
            upper_mm: upper.map(difference),
            places: layout.samples.saturating_sub(order),
            rate,
        }
    }

    pub(crate) const fn family(&self) -> ConstraintFamily {
        if self.order == 1 {
            ConstraintFamily::Velocity
        } else {
            ConstraintFamily::Acceleration
        }
    }

    pub(crate) const fn rows(&self) -> usize {
        2 * SEGMENT_COORDINATES * self.places
    }

    /// Largest violation, relative to the bound or to 1 mm/s (mm/s²) where that is larger.
    pub(crate) fn worst(&self, motion_mm: &[f64]) -> Worst {
        let scale = |limit_mm: f64| 1.0 / self.scale_mm(limit_mm);
        let (lower_scale, upper_scale) = (self.lower_mm.map(scale), self.upper_mm.map(scale));
        let mut relative = [f64::NEG_INFINITY; SEGMENT_COORDINATES];
        let mut by_mm = [f64::NEG_INFINITY; SEGMENT_COORDINATES];
        for place in 0..self.places {
            let differences = self.differences(motion_mm, place);
            for c in 0..SEGMENT_COORDINATES {
                let below = self.lower_mm[c] - differences[c];
                let above = differences[c] - self.upper_mm[c];
                relative[c] = relative[c]
                    .max(below * lower_scale[c])
                    .max(above * upper_scale[c]);
                by_mm[c] = by_mm[c].max(below).max(above);
            }
        }
        let largest = |values: Configuration| values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        Worst {
            relative: largest(relative),
            by: largest(by_mm) * self.rate / MM_PER_M,
        }
    }

    /// Violated rows in order of coordinate, side and time; of each coordinate and side only the
    /// worst one if `peaks_only`.
    pub(crate) fn violated(
        &self,
        motion_mm: &[f64],
        slack: f64,
        peaks_only: bool,
        rows: &mut Vec<Row>,
    ) {
        let yields_mm = slack * MM_PER_M / self.rate;
        if slack == 0.0 && self.worst(motion_mm).relative <= TOLERANCE {
            return;
        }
        for coordinate in 0..SEGMENT_COORDINATES {
            for upper in [false, true] {
                let mut peak: Option<(usize, f64)> = None;
                for place in 0..self.places {
                    let difference = self.difference(motion_mm, place, coordinate);
                    let excess = if upper {
                        difference - self.upper_mm[coordinate]
                    } else {
                        self.lower_mm[coordinate] - difference
                    };
                    if excess <= yields_mm + self.allowed_mm(coordinate, upper) {
                        continue;
                    }
                    if !peaks_only {
                        rows.push(self.row(place, coordinate, upper));
                    } else if peak.is_none_or(|(_, worst)| excess > worst) {
                        peak = Some((place, excess));
                    }
                }
                rows.extend(peak.map(|(place, _)| self.row(place, coordinate, upper)));
            }
        }
    }

    fn row(&self, place: usize, coordinate: usize, upper: bool) -> Row {
        let sign = if upper { -1.0 } else { 1.0 };
        let at = |sample: usize| sample * SEGMENT_COORDINATES + coordinate;
        let factors: &[f64] = if self.order == 1 {
            &[-1.0, 1.0]
        } else {
            &[1.0, -2.0, 1.0]
        };
        let terms = (factors.iter().enumerate()).map(|(k, factor)| (at(place + k), sign * factor));
        Row::new(
            self.family(),
            Key::Difference {
                order: self.order,
                sample: place,
                coordinate,
                upper,
            },
            terms,
            sign * self.limit_mm(coordinate, upper),
            self.allowed_mm(coordinate, upper),
            MM_PER_M / self.rate,
        )
    }

    /// How far a row may be violated, mm.
    fn allowed_mm(&self, coordinate: usize, upper: bool) -> f64 {
        (TOLERANCE * self.scale_mm(self.limit_mm(coordinate, upper))).max(ROUNDING_MM)
    }

    /// What a violation of a bound is relative to, mm.
    fn scale_mm(&self, limit_mm: f64) -> f64 {
        limit_mm.abs().max(1.0 / self.rate)
    }

    const fn limit_mm(&self, coordinate: usize, upper: bool) -> f64 {
        if upper {
            self.upper_mm[coordinate]
        } else {
            self.lower_mm[coordinate]
        }
    }

    fn difference(&self, motion_mm: &[f64], place: usize, coordinate: usize) -> f64 {
        let at = |k: usize| motion_mm[(place + k) * SEGMENT_COORDINATES + coordinate];
        if self.order == 1 {
            at(1) - at(0)
        } else {
            at(2) - 2.0 * at(1) + at(0)
        }
    }

    fn differences(&self, motion_mm: &[f64], place: usize) -> Configuration {
        let samples = motion_mm.as_chunks::<SEGMENT_COORDINATES>().0;
        let (now, next) = (&samples[place], &samples[place + 1]);
        if self.order == 1 {
            std::array::from_fn(|c| next[c] - now[c])
        } else {
            let after = &samples[place + 2];
            std::array::from_fn(|c| after[c] - 2.0 * next[c] + now[c])
        }
    }
}
