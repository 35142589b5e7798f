//! Bounds on velocity and acceleration: first and second differences of each coordinate.

use inhand_model::{Configuration, ConstraintFamily, SEGMENT_COORDINATES, SegmentLayout};

use super::{Family, Key, Row, TOLERANCE, Worst};
use crate::MM_PER_M;

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
    pub(crate) fn new(
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

    const fn limit_mm(&self, series: usize) -> f64 {
        match side(series) {
            (coordinate, true) => self.upper_mm[coordinate],
            (coordinate, false) => self.lower_mm[coordinate],
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

/// Coordinate of a series, and whether its bound is the upper one.
const fn side(series: usize) -> (usize, bool) {
    (series / 2, series % 2 == 1)
}

impl Family for Differences {
    fn family(&self) -> ConstraintFamily {
        if self.order == 1 {
            ConstraintFamily::Velocity
        } else {
            ConstraintFamily::Acceleration
        }
    }

    fn size(&self) -> (usize, usize) {
        (2 * SEGMENT_COORDINATES, self.places)
    }

    fn is_difference(&self) -> bool {
        true
    }

    fn rate(&self) -> f64 {
        self.rate
    }

    /// The bound, or 1 mm/s (mm/s²) where that is larger.
    fn scale_mm(&self, series: usize) -> f64 {
        self.limit_mm(series).abs().max(1.0 / self.rate)
    }

    fn allowed_mm(&self, series: usize) -> f64 {
        (TOLERANCE * self.scale_mm(series)).max(ROUNDING_MM)
    }

    fn excess(&self, motion_mm: &[f64], series: usize, place: usize) -> f64 {
        let (coordinate, upper) = side(series);
        let at = |k: usize| motion_mm[(place + k) * SEGMENT_COORDINATES + coordinate];
        let difference = if self.order == 1 {
            at(1) - at(0)
        } else {
            at(2) - 2.0 * at(1) + at(0)
        };
        if upper {
            difference - self.upper_mm[coordinate]
        } else {
            self.lower_mm[coordinate] - difference
        }
    }

    fn row(&self, _motion_mm: &[f64], series: usize, place: usize) -> Row {
        let (coordinate, upper) = side(series);
        let sign = if upper { -1.0 } else { 1.0 };
        let at = |sample: usize| sample * SEGMENT_COORDINATES + coordinate;
        let factors: &[f64] = if self.order == 1 {
            &[-1.0, 1.0]
        } else {
            &[1.0, -2.0, 1.0]
        };
        let terms = (factors.iter().enumerate()).map(|(k, factor)| (at(place + k), sign * factor));
        Row {
            family: self.family(),
            key: Key::Difference {
                order: self.order,
                sample: place,
                coordinate,
                upper,
            },
            terms: terms.collect(),
            bound: sign * self.limit_mm(series),
            allowed: self.allowed_mm(series),
            yielding: MM_PER_M / self.rate,
        }
    }

    /// All coordinates of a place at once, which takes a fraction of the time of one after the other.
    fn worst(&self, motion_mm: &[f64]) -> Worst {
        let scale = |limit_mm: f64| 1.0 / limit_mm.abs().max(1.0 / self.rate);
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
}
