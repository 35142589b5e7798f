//! Cubic splines through points at any times: where a chain of segments passes between knots.

use nalgebra::{DMatrix, DVector};

/// A cubic spline: twice continuously differentiable but where slopes are given. Ends are natural
/// (no second derivative) where no slope is given there; outside, it goes straight on.
#[derive(Clone, Debug)]
pub(crate) struct Spline {
    times: Vec<f64>,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Spline {
    /// Through points `(time, value, slope if given)` in rising order of time, at least one. If the
    /// last one lies before `end` it comes to rest there unless its slope is given.
    pub(crate) fn through(points: &[(f64, f64, Option<f64>)], end: f64) -> Self {
        let count = points.len();
        let mut given: Vec<Option<f64>> = points.iter().map(|p| p.2).collect();
        let times: Vec<f64> = points.iter().map(|p| p.0).collect();
        let values: Vec<f64> = points.iter().map(|p| p.1).collect();
        if times[count - 1] < end || count == 1 {
            given[count - 1].get_or_insert(0.0);
        }
        let mut system = DMatrix::zeros(count, count);
        let mut right = DVector::zeros(count);
        let width = |i: usize| times[i + 1] - times[i];
        let rise = |i: usize| (values[i + 1] - values[i]) / width(i);
        for i in 0..count {
            if let Some(slope) = given[i] {
                system[(i, i)] = 1.0;
                right[i] = slope;
                continue;
            }
            // Second derivatives agree: of the piece before (if any) and the piece after.
            if i > 0 {
                system[(i, i)] += 2.0 / width(i - 1);
                system[(i, i - 1)] += 1.0 / width(i - 1);
                right[i] += 3.0 * rise(i - 1) / width(i - 1);
            }
            if i + 1 < count {
                system[(i, i)] += 2.0 / width(i);
                system[(i, i + 1)] += 1.0 / width(i);
                right[i] += 3.0 * rise(i) / width(i);
            }
        }
        // Diagonally dominant, so it has one solution.
        let slopes = system
            .lu()
            .solve(&right)
            .unwrap_or_else(|| DVector::zeros(count));
        Self {
            times,
            values,
            slopes: slopes.as_slice().to_vec(),
        }
    }

    pub(crate) fn position(&self, time: f64) -> f64 {
        self.at(time).0
    }

    pub(crate) fn velocity(&self, time: f64) -> f64 {
        self.at(time).1
    }

    fn at(&self, time: f64) -> (f64, f64) {
        let last = self.times.len() - 1;
        let beyond = |i: usize| {
            (
                self.values[i] + self.slopes[i] * (time - self.times[i]),
                self.slopes[i],
            )
        };
        if time <= self.times[0] {
            return beyond(0);
        }
        if time >= self.times[last] {
            return beyond(last);
        }
        let i = self.times.partition_point(|t| *t <= time) - 1;
        let width = self.times[i + 1] - self.times[i];
        let s = (time - self.times[i]) / width;
        let (s2, s3) = (s * s, s * s * s);
        let (a, b) = (self.values[i], self.values[i + 1]);
        let (va, vb) = (self.slopes[i] * width, self.slopes[i + 1] * width);
        let position = (2.0 * s3 - 3.0 * s2 + 1.0) * a
            + (s3 - 2.0 * s2 + s) * va
            + (3.0 * s2 - 2.0 * s3) * b
            + (s3 - s2) * vb;
        let slope = (6.0 * s2 - 6.0 * s) * (a - b)
            + (3.0 * s2 - 4.0 * s + 1.0) * va
            + (3.0 * s2 - 2.0 * s) * vb;
        (position, slope / width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_its_own_spline() {
        let cubic = |t: f64| 1.0 + t * (0.5 + t * (-2.0 + t));
        let slope = |t: f64| 0.5 + t * (-4.0 + 3.0 * t);
        let times = [0.0, 0.3, 1.0, 1.4];
        let points: Vec<_> = times
            .iter()
            .map(|&t| (t, cubic(t), [0.0, 1.4].contains(&t).then(|| slope(t))))
            .collect();
        let spline = Spline::through(&points, 1.4);
        for i in 0..=140 {
            let t = f64::from(i) / 100.0;
            assert!((spline.position(t) - cubic(t)).abs() < 1e-13);
            assert!((spline.velocity(t) - slope(t)).abs() < 1e-12);
        }
    }

    #[test]
    fn ends_without_a_slope_are_natural_and_go_straight_on() {
        let spline = Spline::through(&[(0.0, 0.0, None), (1.0, 1.0, None), (2.0, 0.0, None)], 2.0);
        // By symmetry flat in the middle; natural ends of the textbook example have slope 1.5.
        assert!((spline.velocity(0.0) - 1.5).abs() < 1e-14);
        assert!(spline.velocity(1.0).abs() < 1e-14);
        assert!((spline.position(3.0) + 1.5).abs() < 1e-13);
        // One point, and time left after it: at rest.
        let still = Spline::through(&[(0.0, 2.0, None)], 5.0);
        assert_eq!((still.position(3.0), still.velocity(3.0)), (2.0, 0.0));
    }
}
