//! Seeded random numbers, one independent stream for each purpose.
//!
//! With streams of their own, gaps or another noise level leave the motion as it was.

use inhand_model::Finger;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Purpose of random numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    /// Strokes, pauses and regrasps.
    Choreography,
    /// Drift of the object between strokes.
    Sway,
    /// The hand in the world.
    HandMotion,
    /// Noise of the markers on the hand, and the signs of its quaternions.
    HandMarkers,
    /// The same for the object.
    ObjectMarkers,
    /// Noise of a fingertip marker.
    Fingertip(Finger),
    /// Gaps of a fingertip marker.
    Gaps(Finger),
    /// Faults of one kind, by its number.
    Faults(u64),
    /// The seed of a take of a session.
    Take(u64),
}

impl Purpose {
    /// Number of the stream; no two purposes share one.
    fn stream(self) -> u64 {
        match self {
            Purpose::Choreography => 0,
            Purpose::Sway => 1,
            Purpose::HandMotion => 2,
            Purpose::HandMarkers => 3,
            Purpose::ObjectMarkers => 4,
            Purpose::Fingertip(finger) => 0x10 + finger.index() as u64,
            Purpose::Gaps(finger) => 0x20 + finger.index() as u64,
            Purpose::Faults(kind) => 0x30 + kind,
            Purpose::Take(take) => 0x100 + take,
        }
    }
}

/// ChaCha with 8 rounds: portable, and fast enough that noise does not dominate.
pub(crate) struct Random {
    generator: ChaCha8Rng,
    /// The second of a pair of normal numbers.
    spare: Option<f64>,
}

impl Random {
    pub(crate) fn new(seed: u64, purpose: Purpose) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(purpose.stream());
        Self {
            generator,
            spare: None,
        }
    }

    pub(crate) fn integer(&mut self) -> u64 {
        self.generator.next_u64()
    }

    /// Uniform in 0 (included) to 1 (not), all 53 bits of the mantissa.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.integer() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    pub(crate) fn between(&mut self, (low, high): (f64, f64)) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// -1 or 1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.chance(0.5) { -1.0 } else { 1.0 }
    }

    /// Uniform in `0..n`; `n` is far below 2^53, so its bias does not show.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// Fisher and Yates.
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }

    /// Standard normal (Box and Muller 1958).
    pub(crate) fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        // 1 - unit() is in (0, 1], so the logarithm is finite.
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * self.unit()).sin_cos();
        self.spare = Some(radius * sin);
        radius * cos
    }

    /// Three independent normal numbers of that standard deviation.
    pub(crate) fn normal3(&mut self, deviation: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| deviation * self.normal())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mut random = Random::new(1, Purpose::Sway);
        let n = 200_000;
        let normals: Vec<f64> = (0..n).map(|_| random.normal()).collect();
        let moment = |p: i32| normals.iter().map(|x| x.powi(p)).sum::<f64>() / f64::from(n);
        // Five standard errors of each moment: sqrt(1, 2, 15, 96) / sqrt(n).
        let tolerance = |variance: f64| 5.0 * (variance / f64::from(n)).sqrt();
        assert!(moment(1).abs() < tolerance(1.0));
        assert!((moment(2) - 1.0).abs() < tolerance(2.0));
        assert!(moment(3).abs() < tolerance(15.0));
        assert!((moment(4) - 3.0).abs() < tolerance(96.0));
        let mut counts = [0; 6];
        (0..n).for_each(|_| counts[random.below(6)] += 1);
        assert!(counts.iter().all(|&c: &i32| (c - n / 6).abs() < 1000));
    }

    #[test]
    fn purposes_have_streams_of_their_own() {
        let mut purposes = vec![
            Purpose::Choreography,
            Purpose::Sway,
            Purpose::HandMotion,
            Purpose::HandMarkers,
            Purpose::ObjectMarkers,
            Purpose::Faults(0),
            Purpose::Faults(5),
            Purpose::Take(0),
            Purpose::Take(1),
        ];
        purposes.extend(Finger::ALL.map(Purpose::Fingertip));
        purposes.extend(Finger::ALL.map(Purpose::Gaps));
        let firsts: std::collections::BTreeSet<u64> =
            (purposes.iter().map(|&p| Random::new(1, p).integer())).collect();
        assert_eq!(firsts.len(), purposes.len());
    }
}
