//! Smooth curves of time.

use std::f64::consts::TAU;

use crate::random::Random;

/// Progress from 0 to 1 of a movement with least jerk that starts and ends at rest, over its time
/// `s` from 0 to 1 (Flash and Hogan 1985); constant outside. Velocity and acceleration are
/// continuous; the velocity peaks at 15/8 of its mean.
pub(crate) fn minimum_jerk(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 + s * (6.0 * s - 15.0))
}

/// Rises from 0 at `s = 0` to 1 in the middle and falls to 0 at `s = 1`; velocity and acceleration
/// vanish at both ends.
pub(crate) fn bump(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    let x = 4.0 * s * (1.0 - s);
    x * x * x
}

/// A slow wander about zero: a sum of sines with random frequency and phase.
#[derive(Clone, Debug)]
pub(crate) struct Wander {
    /// Amplitude, angular frequency in rad/s, phase.
    waves: [(f64, f64, f64); Wander::WAVES],
}

impl Wander {
    const WAVES: usize = 3;

    /// A wander of that standard deviation over time, with frequencies in Hz within `band_hz`.
    pub(crate) fn new(random: &mut Random, deviation: f64, band_hz: (f64, f64)) -> Self {
        // The variance of a sine is half its squared amplitude.
        let amplitude = deviation * (2.0 / Self::WAVES as f64).sqrt();
        let waves = std::array::from_fn(|_| {
            let frequency = TAU * random.between(band_hz);
            (amplitude, frequency, TAU * random.unit())
        });
        Self { waves }
    }

    pub(crate) fn at(&self, time_s: f64) -> f64 {
        let wave = |&(amplitude, frequency, phase): &(f64, f64, f64)| {
            amplitude * (frequency * time_s + phase).sin()
        };
        self.waves.iter().map(wave).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Purpose;

    #[test]
    fn curves_start_and_end_at_rest() {
        assert_eq!((minimum_jerk(-1.0), minimum_jerk(2.0)), (0.0, 1.0));
        assert_eq!((minimum_jerk(0.5), bump(0.5)), (0.5, 1.0));
        assert_eq!((bump(-1.0), bump(2.0)), (0.0, 0.0));
        // Both behave like s³ near an end: 10 s³ and 64 s³.
        let s = 1e-4;
        assert!((minimum_jerk(s) / s.powi(3) - 10.0).abs() < 1e-2);
        assert!((1.0 - minimum_jerk(1.0 - s)).abs() < 11.0 * s.powi(3));
        assert!((bump(s) / s.powi(3) - 64.0).abs() < 1e-1);
        // Peak velocity of 15/8 in the middle.
        let h = 1e-6;
        let velocity = (minimum_jerk(0.5 + h) - minimum_jerk(0.5 - h)) / (2.0 * h);
        assert!((velocity - 1.875).abs() < 1e-6);
    }

    #[test]
    fn a_wander_has_its_deviation() {
        let mut random = Random::new(3, Purpose::Sway);
        let wander = Wander::new(&mut random, 2.0, (0.1, 0.5));
        let n = 100_000;
        let square: f64 = (0..n).map(|k| wander.at(f64::from(k) * 0.1).powi(2)).sum();
        assert!(((square / f64::from(n)).sqrt() - 2.0).abs() < 0.02);
    }
}
