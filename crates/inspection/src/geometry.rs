//! Usual position of each finger in the hand's frame.

use inhand_model::{Finger, Hand, PerFinger, PointTrack, Position};
use nalgebra::Vector3;

use crate::statistics::median_and_deviation;

/// Time after which a finger's place says something new, seconds: strokes and regrasps take about one.
pub(crate) const INDEPENDENT_S: f64 = 0.5;
/// Least spread of a finger along an axis, metres: one that hardly moves in a take may still move.
const LEAST_SPREAD_M: f64 = 0.004;
/// Degrees of freedom: fingers go to unusual places more often than a normal distribution lets them.
const FREEDOM: f64 = 5.0;

/// Where in the hand's frame each finger usually is: a t distribution along each axis, of median and
/// median deviation.
#[derive(Clone, Debug)]
pub(crate) struct Geometry {
    places: PerFinger<Usual>,
}

#[derive(Clone, Debug)]
struct Usual {
    middle_m: Vector3<f64>,
    /// One over the usual deviation along each axis, 1/m.
    per_deviation: Vector3<f64>,
    /// Logarithm of the product of the usual deviations.
    log_spread: f64,
}

impl Geometry {
    pub(crate) fn new(tracks: &PerFinger<&PointTrack<Hand>>) -> Self {
        Self {
            places: PerFinger::from_fn(|finger| {
                let axis = |axis: usize| {
                    let places = tracks[finger].values();
                    median_and_deviation(places.map(|at| at.coords_m()[axis]))
                };
                let axes = [axis(0), axis(1), axis(2)];
                let spread = axes.map(|(_, spread)| spread.max(LEAST_SPREAD_M));
                Usual {
                    middle_m: axes.map(|(middle, _)| middle).into(),
                    per_deviation: spread.map(f64::recip).into(),
                    log_spread: spread.iter().map(|spread| spread.ln()).sum(),
                }
            }),
        }
    }

    /// How far a place is from a finger's usual one, in its usual deviations.
    pub(crate) fn deviations(&self, finger: Finger, at: Position<Hand>) -> f64 {
        self.places[finger].square(at).sqrt()
    }

    /// Minus the logarithm of the density at each of some places but for a constant, summed up, nats.
    pub(crate) fn cost(&self, finger: Finger, places: impl Iterator<Item = Position<Hand>>) -> f64 {
        /// A factor more cannot leave the range of numbers.
        const LARGE: f64 = 1e100;
        let usual = &self.places[finger];
        // The logarithm of a product instead of the sum of logarithms.
        let (mut count, mut product, mut logarithms) = (0.0, 1.0_f64, 0.0);
        for at in places {
            count += 1.0;
            product *= 1.0 + usual.square(at) / FREEDOM;
            if product > LARGE {
                logarithms += product.ln();
                product = 1.0;
            }
        }
        0.5 * (FREEDOM + 3.0) * (logarithms + product.ln()) + count * usual.log_spread
    }
}

impl Usual {
    /// Squared distance of a place from the usual one, in usual deviations.
    fn square(&self, at: Position<Hand>) -> f64 {
        (at.coords_m() - self.middle_m)
            .component_mul(&self.per_deviation)
            .norm_squared()
    }
}
