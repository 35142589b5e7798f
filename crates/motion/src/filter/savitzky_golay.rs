//! The Savitzky-Golay filter.

use crate::error::MotionError;

/// The polynomial of least squares of degree `order` through `window` samples, evaluated at the
/// middle one: Savitzky and Golay, *Smoothing and differentiation of data by simplified least
/// squares procedures*, Anal. Chem. 36(8), 1964.
///
/// Edge rule: the first and the last half window are evaluated on the polynomial through the first
/// and the last `window` samples (SciPy's `savgol_filter`, mode `interp`). An interval shorter than
/// the window is fitted as a whole, with at most as many coefficients as it has samples.
#[derive(Clone, Debug, PartialEq)]
pub struct SavitzkyGolay {
    order: usize,
    basis: Basis,
    /// Weight of each sample of the window in the value at its middle.
    middle: Vec<f64>,
}

impl SavitzkyGolay {
    /// The sliding polynomial of least squares, ready to use.
    ///
    /// # Errors
    ///
    /// [`MotionError::Setting`] for an even window and for an order that the window does not allow.
    pub fn new(window: usize, order: usize) -> Result<Self, MotionError> {
        let odd = !window.is_multiple_of(2);
        MotionError::unless(odd, "filter.window", window, "an odd number of samples")?;
        let expected = format!("a degree below the window of {window} samples");
        MotionError::unless(order < window, "filter.order", order, &expected)?;
        let basis = Basis::new(window, order);
        let middle = (0..window).map(|k| basis.product(window / 2, k)).collect();
        Ok(Self {
            order,
            basis,
            middle,
        })
    }

    /// Filters an interval of numbers.
    pub fn apply(&self, interval: &[f64]) -> Vec<f64> {
        let (window, len) = (self.middle.len(), interval.len());
        if len == 0 {
            return Vec::new();
        }
        if len < window {
            let basis = Basis::new(len, self.order.min(len - 1));
            return basis.fitted(interval);
        }
        let half = window / 2;
        let mut smooth = self.basis.fitted(&interval[..window]);
        smooth.truncate(half);
        smooth.extend(interval.windows(window).map(|samples| {
            (samples.iter().zip(&self.middle))
                .map(|(sample, weight)| sample * weight)
                .sum::<f64>()
        }));
        let last = self.basis.fitted(&interval[len - window..]);
        smooth.extend_from_slice(&last[window - half..]);
        smooth
    }
}

/// Orthonormal polynomials on evenly spaced samples (Gram polynomials), one list of values each.
#[derive(Clone, Debug, PartialEq)]
struct Basis {
    polynomials: Vec<Vec<f64>>,
}

impl Basis {
    /// Polynomials of degree 0 to `order` (below `len`): each is the one before times the abscissa,
    /// made orthogonal to all before it. Twice is enough to lose nothing to rounding, where powers of
    /// the abscissa would be nearly dependent from degree ten on.
    fn new(len: usize, order: usize) -> Self {
        let abscissa = |k: usize| {
            if len == 1 {
                0.0
            } else {
                2.0 * k as f64 / (len - 1) as f64 - 1.0
            }
        };
        let mut polynomials = vec![vec![1.0 / (len as f64).sqrt(); len]];
        for degree in 1..=order {
            let before: &Vec<f64> = &polynomials[degree - 1];
            let mut next: Vec<f64> = (0..len).map(|k| abscissa(k) * before[k]).collect();
            for _ in 0..2 {
                for polynomial in &polynomials {
                    let share = dot(polynomial, &next);
                    for (next, value) in next.iter_mut().zip(polynomial) {
                        *next -= share * value;
                    }
                }
            }
            let norm = dot(&next, &next).sqrt();
            next.iter_mut().for_each(|value| *value /= norm);
            polynomials.push(next);
        }
        Self { polynomials }
    }

    /// Weight of sample `j` in the fitted value at sample `k`; symmetric.
    fn product(&self, k: usize, j: usize) -> f64 {
        self.polynomials.iter().map(|p| p[k] * p[j]).sum()
    }

    /// The fitted values at all samples.
    fn fitted(&self, samples: &[f64]) -> Vec<f64> {
        let mut fitted = vec![0.0; samples.len()];
        for polynomial in &self.polynomials {
            let share = dot(polynomial, samples);
            for (fitted, value) in fitted.iter_mut().zip(polynomial) {
                *fitted += share * value;
            }
        }
        fitted
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn has_the_published_weights() {
        // Savitzky and Golay's table: quadratic/cubic, five and seven points.
        for (window, order, weights, divisor) in [
            (5, 2, vec![-3.0, 12.0, 17.0, 12.0, -3.0], 35.0),
            (5, 3, vec![-3.0, 12.0, 17.0, 12.0, -3.0], 35.0),
            (7, 2, vec![-2.0, 3.0, 6.0, 7.0, 6.0, 3.0, -2.0], 21.0),
        ] {
            let filter = SavitzkyGolay::new(window, order).unwrap();
            for (found, expected) in filter.middle.iter().zip(weights) {
                assert!((found - expected / divisor).abs() < 1e-15);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Edges and intervals shorter than the window included.
        #[test]
        fn leaves_polynomials_alone(
            c in prop::array::uniform4(-1.0..1.0), len in 4_usize..80, half in 2_usize..20,
        ) {
            let polynomial: Vec<f64> = (0..len)
                .map(|k| k as f64 / len as f64)
                .map(|t| c[0] + t * (c[1] + t * (c[2] + t * c[3])))
                .collect();
            let smooth = SavitzkyGolay::new(2 * half + 1, 3).unwrap().apply(&polynomial);
            for (found, expected) in smooth.iter().zip(&polynomial) {
                prop_assert!((found - expected).abs() < 1e-12);
            }
            prop_assert_eq!(smooth.len(), len);
        }
    }

    #[test]
    fn high_orders_stay_exact() {
        // As many coefficients as samples: every signal is its own fit.
        let signal: Vec<f64> = (0..41).map(|k| f64::from(k * k % 13)).collect();
        let smooth = SavitzkyGolay::new(41, 40).unwrap().apply(&signal);
        for (found, expected) in smooth.iter().zip(&signal) {
            assert!((found - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn refuses_what_has_no_middle_or_too_few_samples() {
        assert!(SavitzkyGolay::new(10, 2).is_err());
        assert!(SavitzkyGolay::new(0, 0).is_err());
        assert!(SavitzkyGolay::new(5, 5).is_err());
        let single = SavitzkyGolay::new(1, 0).unwrap();
        assert_eq!(single.apply(&[2.0, 5.0]), [2.0, 5.0]);
        assert!(single.apply(&[]).is_empty());
    }
}
