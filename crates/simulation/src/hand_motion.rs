//! The hand in the world: held in front of the body, slowly moving.

use inhand_model::{Hand, Pose, World};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::curves::Wander;
use crate::random::Random;

/// Where the hand is held, metres, y up: one metre above the floor.
const PLACE_M: Vector3<f64> = Vector3::new(0.11, 1.06, 0.07);
/// How it is held, as a rotation vector in radians: no axis of the hand along one of the world,
/// as when a hand is held up to the cameras.
const POSTURE_RAD: Vector3<f64> = Vector3::new(0.35, 0.50, -0.28);
/// Standard deviation along an axis, metres, and about one, radians, and the frequencies: speeds
/// of some centimetres and some degrees a second.
const PLACE_DEVIATION_M: f64 = 0.035;
const POSTURE_DEVIATION_RAD: f64 = 0.11;
const BAND_HZ: (f64, f64) = (0.02, 0.12);

/// The hand's pose in the world at any time.
#[derive(Clone, Debug)]
pub(crate) struct HandMotion {
    place: [Wander; 3],
    posture: [Wander; 3],
}

impl HandMotion {
    pub(crate) fn new(random: &mut Random) -> Self {
        let mut wanders =
            |deviation| std::array::from_fn(|_| Wander::new(random, deviation, BAND_HZ));
        Self {
            place: wanders(PLACE_DEVIATION_M),
            posture: wanders(POSTURE_DEVIATION_RAD),
        }
    }

    pub(crate) fn world_from_hand(&self, time_s: f64) -> Pose<World, Hand> {
        let at = |wanders: &[Wander; 3]| Vector3::from_fn(|axis, _| wanders[axis].at(time_s));
        let turned = UnitQuaternion::from_scaled_axis(POSTURE_RAD)
            * UnitQuaternion::from_scaled_axis(at(&self.posture));
        Pose::new(Isometry3::from_parts(
            Translation3::from(PLACE_M + at(&self.place)),
            turned,
        ))
    }
}
