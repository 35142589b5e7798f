//! The Butterworth low-pass, run forwards and backwards.

use std::f64::consts::{PI, SQRT_2};

use crate::error::MotionError;

/// Beyond this order the sections' resonances amplify the ends of an interval more than they filter.
const MAX_ORDER: usize = 10;

/// Samples by which an interval is extended on either side, for each coefficient of the filter:
/// SciPy's default for `sosfiltfilt`.
const EXTENSION_PER_COEFFICIENT: usize = 3;

/// A Butterworth low-pass applied forwards and then backwards, so that nothing is delayed, whose
/// stated cut-off holds after both passes.
///
/// Two passes square the gain: a filter designed for the cut-off itself would have lost 6 dB there.
/// The power gain of one pass is `1 / (1 + (w / w_c)^(2n))` over the pre-warped frequency
/// `w = tan(pi f / rate)`; for it to be `1 / sqrt(2)` at the stated cut-off, each pass is designed
/// for `w_c = w / (sqrt(2) - 1)^(1 / 2n)` (Winter, *Biomechanics and motor control of human
/// movement*, section on digital filtering, has this factor as 0.802 for n = 2).
///
/// Edge rule: an interval is extended at both ends by its point reflection in its end sample, over
/// three samples a coefficient (as far as it has them), and each pass starts in the steady state of
/// its first value (SciPy's `sosfiltfilt`).
#[derive(Clone, Debug, PartialEq)]
pub struct Butterworth {
    order: usize,
    sections: Vec<Section>,
}

/// A section of second order in transposed direct form II; unity gain at zero frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

impl Butterworth {
    /// The Butterworth low-pass without delay, ready to use.
    ///
    /// # Errors
    ///
    /// [`MotionError::Setting`] for an order outside 1 to 10 and for a cut-off that is not between zero
    /// and half the rate.
    pub fn new(cutoff_hz: f64, order: usize, rate_hz: f64) -> Result<Self, MotionError> {
        let (in_range, expected) = (
            (1..=MAX_ORDER).contains(&order),
            format!("1 to {MAX_ORDER}"),
        );
        MotionError::unless(in_range, "filter.order", order, &expected)?;
        let in_range = cutoff_hz > 0.0 && cutoff_hz < 0.5 * rate_hz;
        let expected = format!("above 0 and below half the rate of {rate_hz} Hz");
        MotionError::unless(in_range, "filter.cutoff_hz", cutoff_hz, &expected)?;
        let w = (PI * cutoff_hz / rate_hz).tan() / (SQRT_2 - 1.0).powf(0.5 / order as f64);
        let mut sections: Vec<Section> = (0..order / 2)
            .map(|pair| {
                // Pair of poles of the prototype 1 / (s² + damping s + 1).
                let damping = 2.0 * (PI * (2 * pair + 1) as f64 / (2 * order) as f64).sin();
                let scale = 1.0 / (1.0 + damping * w + w * w);
                let b = w * w * scale;
                Section {
                    b: [b, 2.0 * b, b],
                    a: [
                        2.0 * (w * w - 1.0) * scale,
                        (1.0 - damping * w + w * w) * scale,
                    ],
                }
            })
            .collect();
        if order % 2 == 1 {
            let b = w / (1.0 + w);
            sections.push(Section {
                b: [b, b, 0.0],
                a: [(w - 1.0) / (w + 1.0), 0.0],
            });
        }
        Ok(Self { order, sections })
    }

    /// Filters an interval of numbers.
    pub fn apply(&self, interval: &[f64]) -> Vec<f64> {
        let len = interval.len();
        let (Some(&first), Some(&last)) = (interval.first(), interval.last()) else {
            return Vec::new();
        };
        let extension = (EXTENSION_PER_COEFFICIENT * (self.order + 1)).min(len - 1);
        let before = (1..=extension).rev().map(|k| 2.0 * first - interval[k]);
        let after = (1..=extension).map(|k| 2.0 * last - interval[len - 1 - k]);
        let mut extended: Vec<f64> = before
            .chain(interval.iter().copied())
            .chain(after)
            .collect();
        self.pass(&mut extended);
        extended.reverse();
        self.pass(&mut extended);
        extended.reverse();
        extended[extension..extension + len].to_vec()
    }

    /// One pass from the steady state of the first value.
    fn pass(&self, values: &mut [f64]) {
        let Some(&start) = values.first() else {
            return;
        };
        for &Section { b, a } in &self.sections {
            // With input and output both at `start` these states reproduce themselves. All sections
            // pass a constant unchanged, so each one starts from the same value.
            let mut later = (b[2] - a[1]) * start;
            let mut next = (b[1] - a[0]) * start + later;
            for value in &mut *values {
                let x = *value;
                let y = b[0] * x + next;
                next = b[1] * x - a[0] * y + later;
                later = b[2] * x - a[1] * y;
                *value = y;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gain over both passes, measured on a sine in the middle of a long interval.
    fn gain(filter: &Butterworth, frequency_hz: f64, rate_hz: f64) -> f64 {
        let sine: Vec<f64> = (0..4001)
            .map(|k| (2.0 * PI * frequency_hz * (f64::from(k) - 2000.0) / rate_hz).cos())
            .collect();
        // No delay: the crest stays where it was.
        filter.apply(&sine)[2000]
    }

    #[test]
    fn loses_three_decibels_at_the_cutoff_after_both_passes() {
        for rate_hz in [100.0, 360.0] {
            for order in 1..=MAX_ORDER {
                for cutoff_hz in [4.0, 10.0, 31.7] {
                    let filter = Butterworth::new(cutoff_hz, order, rate_hz).unwrap();
                    let at_cutoff = gain(&filter, cutoff_hz, rate_hz);
                    assert!(
                        (at_cutoff - 0.5_f64.sqrt()).abs() < 1e-9,
                        "order {order}, {cutoff_hz} Hz of {rate_hz} Hz: {at_cutoff}"
                    );
                    assert!(gain(&filter, 0.3 * cutoff_hz, rate_hz) > 0.87);
                    let above = (2.0 * cutoff_hz).min(0.49 * rate_hz);
                    assert!(gain(&filter, above, rate_hz) < 0.45);
                }
            }
        }
    }

    #[test]
    fn leaves_lines_alone() {
        // Point reflection continues a line, and the steady state of a constant is exact.
        let line: Vec<f64> = (0..200).map(|k| 3.0 + 0.5 * f64::from(k)).collect();
        let smooth = Butterworth::new(6.0, 2, 100.0).unwrap().apply(&line);
        for (found, expected) in smooth[40..160].iter().zip(&line[40..160]) {
            assert!((found - expected).abs() < 1e-6);
        }
        for (found, expected) in Butterworth::new(6.0, 5, 100.0)
            .unwrap()
            .apply(&[2.5; 30])
            .iter()
            .zip([2.5; 30])
        {
            assert!((found - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn short_intervals_stay_as_long() {
        let filter = Butterworth::new(6.0, 4, 100.0).unwrap();
        assert!(filter.apply(&[]).is_empty());
        assert!((filter.apply(&[2.0])[0] - 2.0).abs() < 1e-12);
        for len in 2..20 {
            let smooth = filter.apply(&vec![1.0; len]);
            assert_eq!(smooth.len(), len);
            assert!(smooth.iter().all(|v| (v - 1.0).abs() < 1e-12));
        }
    }

    #[test]
    fn refuses_what_cannot_be_designed() {
        for (cutoff_hz, order) in [
            (0.0, 2),
            (-1.0, 2),
            (50.0, 2),
            (f64::NAN, 2),
            (6.0, 0),
            (6.0, 11),
        ] {
            assert!(Butterworth::new(cutoff_hz, order, 100.0).is_err());
        }
    }
}
