//! The hand in the world, held in front of the body, slowly moving; and the object in the hand frame: strokes
//! about and along the hand's axes, and a slow sway.

use inhand_model::{Hand, Object, Pose, Position, World};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::curves::{Wander, minimum_jerk};
use crate::random::Random;

/// Deviation of the object from its home in the hand: translation along x, y, z in metres, then
/// rotation vector in radians, both in hand axes.
pub(crate) type Posture = [f64; 6];

/// Sway of a held object: standard deviation along an axis (m) and about one (rad), and its
/// frequencies (Hz).
const SWAY_M: f64 = 0.4e-3;
const SWAY_RAD: f64 = 0.6 * std::f64::consts::PI / 180.0;
const SWAY_BAND_HZ: (f64, f64) = (0.06, 0.45);

/// A minimum-jerk change of posture; before it the posture is that of the stroke before.
#[derive(Clone, Copy, Debug)]
struct Stroke {
    start_s: f64,
    duration_s: f64,
    from: Posture,
    to: Posture,
}

/// The object's pose in the hand at any time.
#[derive(Clone, Debug)]
pub(crate) struct ObjectMotion {
    home: Position<Hand>,
    rest: Posture,
    sway: [Wander; 6],
    /// In order of time, none overlapping the next.
    strokes: Vec<Stroke>,
}

impl ObjectMotion {
    /// An object resting at `home` with its axes parallel to the hand's, but for its sway.
    pub(crate) fn new(home: Position<Hand>, random: &mut Random) -> Self {
        let sway = std::array::from_fn(|axis| {
            let deviation = if axis < 3 { SWAY_M } else { SWAY_RAD };
            Wander::new(random, deviation, SWAY_BAND_HZ)
        });
        Self {
            home,
            rest: [0.0; 6],
            sway,
            strokes: Vec::new(),
        }
    }

    /// Adds a stroke after all others and returns when it ends.
    pub(crate) fn stroke(&mut self, start_s: f64, duration_s: f64, to: Posture) -> f64 {
        let from = self.last_posture();
        debug_assert!(
            self.strokes
                .last()
                .is_none_or(|s| s.start_s + s.duration_s <= start_s)
        );
        self.strokes.push(Stroke {
            start_s,
            duration_s,
            from,
            to,
        });
        start_s + duration_s
    }

    /// Posture after every stroke so far, without sway.
    pub(crate) fn last_posture(&self) -> Posture {
        self.strokes.last().map_or(self.rest, |stroke| stroke.to)
    }

    pub(crate) fn hand_from_object(&self, time_s: f64) -> Pose<Hand, Object> {
        let begun = self.strokes.partition_point(|s| s.start_s <= time_s);
        let strokes = self.strokes[..begun].last();
        let posture = strokes.map_or(self.rest, |stroke| {
            let progress = minimum_jerk((time_s - stroke.start_s) / stroke.duration_s);
            std::array::from_fn(|i| stroke.from[i] + (stroke.to[i] - stroke.from[i]) * progress)
        });
        let [x, y, z, rx, ry, rz] =
            std::array::from_fn(|axis| posture[axis] + self.sway[axis].at(time_s));
        Pose::new(Isometry3::from_parts(
            Translation3::from(self.home.coords_m() + Vector3::new(x, y, z)),
            UnitQuaternion::from_scaled_axis(Vector3::new(rx, ry, rz)),
        ))
    }
}

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
