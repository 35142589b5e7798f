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
    places: PerFinger<(Vector3<f64>, Vector3<f64>)>,
}

impl Geometry {
    pub(crate) fn new(tracks: &PerFinger<&PointTrack<Hand>>) -> Self {
        Self {
            places: PerFinger::from_fn(|finger| {
                let axis = |axis: usize| {
                    let places = tracks[finger].values().iter();
                    median_and_deviation(places.map(|at| at.coords_m()[axis]))
                };
                let axes = [axis(0), axis(1), axis(2)];
                (
                    Vector3::from(axes.map(|(middle, _)| middle)),
                    Vector3::from(axes.map(|(_, spread)| spread.max(LEAST_SPREAD_M))),
                )
            }),
        }
    }

    /// How far a place is from a finger's usual one, in its usual deviations.
    pub(crate) fn deviations(&self, finger: Finger, at: Position<Hand>) -> f64 {
        let (middle, spread) = &self.places[finger];
        (at.coords_m() - middle).component_div(spread).norm()
    }

    /// Minus the logarithm of the density there but for a constant, nats.
    pub(crate) fn cost(&self, finger: Finger, at: Position<Hand>) -> f64 {
        let (_, spread) = &self.places[finger];
        let square = self.deviations(finger, at).powi(2);
        0.5 * (FREEDOM + 3.0) * (square / FREEDOM).ln_1p() + spread.map(f64::ln).sum()
    }
}
