//! Cubic splines through points at any times: where a chain of segments passes between knots.

/// A cubic spline: twice continuously differentiable but where slopes are given. The last point is
/// natural (no second derivative) where no slope is given there, and so is the first, unless time
/// begins before it: then it comes from rest. It rests before its first point and goes straight on
/// after its last.
#[derive(Clone, Debug)]
pub(crate) struct Spline {
    times: Vec<f64>,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Spline {
    /// Through points `(time, value, slope if given)` in rising order of time, at least one, in time
    /// from 0 on.
    pub(crate) fn through(points: &[(f64, f64, Option<f64>)]) -> Self {
        let times: Vec<f64> = points.iter().map(|p| p.0).collect();
        let values: Vec<f64> = points.iter().map(|p| p.1).collect();
        let count = points.len();
        let width = |i: usize| times[i + 1] - times[i];
        let rise = |i: usize| (values[i + 1] - values[i]) / width(i);
        // `below * slope[i - 1] + diagonal * slope[i] + above * slope[i + 1] = right`, solved by
        // elimination from the first to the last and back. Rows are diagonally dominant, so that
        // no pivot is near zero.
        let mut solved: Vec<(f64, f64)> = Vec::with_capacity(count);
        for (i, &(time, _, slope)) in points.iter().enumerate() {
            let comes_from_rest = i == 0 && (time > 0.0 || count == 1);
            let slope = slope.or(comes_from_rest.then_some(0.0));
            let (mut below, mut diagonal, mut above, mut right) = (0.0, 1.0, 0.0, 0.0);
            if let Some(slope) = slope {
                right = slope;
            } else {
                // Second derivatives agree: of the piece before (if any) and the piece after.
                diagonal = 0.0;
                if i > 0 {
                    below = 1.0 / width(i - 1);
                    diagonal += 2.0 * below;
                    right += 3.0 * rise(i - 1) * below;
                }
                if i + 1 < count {
                    above = 1.0 / width(i);
                    diagonal += 2.0 * above;
                    right += 3.0 * rise(i) * above;
                }
            }
            let (before, factor) = solved.last().copied().unwrap_or((0.0, 0.0));
            let pivot = diagonal - below * factor;
            solved.push(((right - below * before) / pivot, above / pivot));
        }
        let mut slopes = vec![0.0; count];
        let mut next = 0.0;
        for (slope, (value, factor)) in slopes.iter_mut().zip(solved).rev() {
            *slope = value - factor * next;
            next = *slope;
        }
        Self {
            times,
            values,
            slopes,
        }
    }

    /// Time of the last point.
    pub(crate) fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    pub(crate) fn position(&self, time: f64) -> f64 {
        self.at(time).0
    }

    pub(crate) fn velocity(&self, time: f64) -> f64 {
        self.at(time).1
    }

    /// Value and slope.
    fn at(&self, time: f64) -> (f64, f64) {
        let last = self.times.len() - 1;
        if time < self.times[0] {
            return (self.values[0], 0.0);
        }
        if time >= self.times[last] {
            let slope = self.slopes[last];
            return (self.values[last] + slope * (time - self.times[last]), slope);
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
        let spline = Spline::through(&points);
        for i in 0..=140 {
            let t = f64::from(i) / 100.0;
            assert!((spline.position(t) - cubic(t)).abs() < 1e-13);
            assert!((spline.velocity(t) - slope(t)).abs() < 1e-12);
        }
    }

    #[test]
    fn ends_without_a_slope_are_natural_and_go_straight_on() {
        let spline = Spline::through(&[(0.0, 0.0, None), (1.0, 1.0, None), (2.0, 0.0, None)]);
        // By symmetry flat in the middle; natural ends of the textbook example have slope 1.5.
        assert!((spline.velocity(0.0) - 1.5).abs() < 1e-14);
        assert!(spline.velocity(1.0).abs() < 1e-14);
        assert!((spline.position(3.0) + 1.5).abs() < 1e-13);
        assert_eq!(spline.end(), 2.0);
    }

    #[test]
    fn before_its_first_point_it_rests() {
        let still = Spline::through(&[(0.0, 2.0, None)]);
        assert_eq!((still.position(3.0), still.velocity(3.0)), (2.0, 0.0));
        let late = Spline::through(&[(1.0, 2.0, None), (2.0, 3.0, None)]);
        assert_eq!((late.position(0.5), late.velocity(0.5)), (2.0, 0.0));
        assert_eq!((late.position(1.0), late.velocity(1.0)), (2.0, 0.0));
        // From rest to a natural end: slope 1.5 there.
        assert!((late.velocity(2.0) - 1.5).abs() < 1e-14);
    }

    #[test]
    fn slopes_given_in_the_middle_part_it_in_two() {
        let points = [(0.0, 0.0, None), (1.0, 1.0, Some(-2.0)), (3.0, 0.5, None)];
        let whole = Spline::through(&points);
        let left = Spline::through(&points[..2]);
        assert_eq!(whole.velocity(1.0), -2.0);
        for t in [0.0, 0.2, 0.9] {
            assert_eq!(whole.position(t), left.position(t));
        }
    }

    #[test]
    fn a_hundred_thousand_points_take_no_matrix() {
        let points: Vec<_> = (0..100_000)
            .map(|i| (f64::from(i) * 0.01, (f64::from(i) * 1e-3).sin(), None))
            .collect();
        let spline = Spline::through(&points);
        let t = 512.345;
        assert!((spline.position(t) - (0.1 * t).sin()).abs() < 1e-12);
        assert!((spline.velocity(t) - 0.1 * (0.1 * t).cos()).abs() < 1e-9);
    }
}
