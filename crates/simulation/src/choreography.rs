//! Choreography: strokes out and back about and along every axis, pauses, regrasps.

use inhand_model::{Finger, Hand, Position, Shape};

use crate::error::SimulationError;
use crate::grasp::{Grasp, Swing};
use crate::motion::{ObjectMotion, Posture};
use crate::random::{Purpose, Random};
use crate::surface::Solid;

/// The centre of a 50 mm object in the hand frame, metres: in front of the palm, below the tips of
/// the bent fingers. Larger objects lie further out, by what their sides come nearer.
const HOME_M: [f64; 3] = [0.0, 0.097, 0.052];
const HOME_HALF_M: f64 = 0.025;

/// Pause between strokes, seconds.
const PAUSE_RANGE_S: (f64, f64) = (0.2, 0.9);
/// Rest at the far end of a stroke, seconds.
const HOLD_RANGE_S: (f64, f64) = (0.1, 0.6);
/// Duration of a stroke, seconds.
const STROKE_RANGE_S: (f64, f64) = (0.9, 1.7);
/// Length of a stroke along an axis, metres, and angle about one, radians.
const TRANSLATION_RANGE_M: (f64, f64) = (0.006, 0.012);
const ROTATION_RANGE_RAD: (f64, f64) = (0.24, 0.52);
/// Second stroke in the same direction after a regrasp, as a share of the first, and how often.
const SECOND_STROKE_RANGE: (f64, f64) = (0.3, 0.6);
const SECOND_STROKE_CHANCE: f64 = 0.35;
/// Where other axes come to lie after a stroke: standard deviation, metres and radians.
const COUPLING_M: f64 = 0.5e-3;
const COUPLING_RAD: f64 = 0.015;

/// Time in the air of a lifted finger, seconds.
const SWING_RANGE_S: (f64, f64) = (0.28, 0.5);
/// Start of the next swing after that of the one before, as a share of its duration: below 1 two
/// fingers are in the air for a while.
const SWING_STAGGER_RANGE: (f64, f64) = (0.6, 1.3);
/// A finger this far from home is strained and moved, metres.
const STRAIN_LIMIT_M: f64 = 0.011;
/// Most fingers moved in one pause.
const MAX_REGRASPS: usize = 3;
/// How often a finger is moved that need not be.
const IDLE_REGRASP_CHANCE: f64 = 0.6;

/// Motion of object and fingers over a take.
pub(crate) struct Choreography {
    pub(crate) object: ObjectMotion,
    pub(crate) grasp: Grasp,
    random: Random,
    /// Up to here everything is planned, nothing moves beyond it.
    now_s: f64,
}

/// Plans at least `duration_s` seconds.
pub(crate) fn choreograph(
    shape: Shape,
    duration_s: f64,
    seed: u64,
) -> Result<Choreography, SimulationError> {
    let half_extent_m = Solid::new(shape)?.half_extent_m();
    let [x, y, z] = HOME_M;
    let home = Position::<Hand>::new(
        x,
        y + half_extent_m.y - HOME_HALF_M,
        z + half_extent_m.z - HOME_HALF_M,
    );
    let object = ObjectMotion::new(home, &mut Random::new(seed, Purpose::Sway));
    let mut random = Random::new(seed, Purpose::Choreography);
    let grasp = Grasp::new(shape, home, object.hand_from_object(0.0), &mut random)?;
    let mut plan = Choreography {
        object,
        grasp,
        random,
        now_s: 0.0,
    };
    // Every axis has its turn, in an order of chance.
    let mut axes = [0, 1, 2, 3, 4, 5];
    while plan.now_s < duration_s {
        plan.random.shuffle(&mut axes);
        for axis in axes {
            plan.episode(axis);
        }
    }
    Ok(plan)
}

/// Metres along an axis, radians about one.
const fn stroke_range(axis: usize) -> (f64, f64) {
    if axis < 3 {
        TRANSLATION_RANGE_M
    } else {
        ROTATION_RANGE_RAD
    }
}

impl Choreography {
    /// A pause, a stroke along or about one axis, perhaps a second one after a regrasp, and back.
    fn episode(&mut self, axis: usize) {
        self.now_s += self.random.between(PAUSE_RANGE_S);
        self.regrasp_strained();
        if self.random.chance(IDLE_REGRASP_CHANCE) {
            let finger = Finger::ALL[self.random.below(Finger::COUNT)];
            self.regrasp(&[finger]);
            self.now_s += self.random.between(HOLD_RANGE_S);
        }
        let amplitude = self.random.sign() * self.random.between(stroke_range(axis));
        self.stroke(axis, amplitude);
        self.now_s += self.random.between(HOLD_RANGE_S);
        if axis >= 3 && self.random.chance(SECOND_STROKE_CHANCE) {
            self.regrasp_strained();
            self.now_s += self.random.between(HOLD_RANGE_S);
            let further = self.random.between(SECOND_STROKE_RANGE);
            self.stroke(axis, amplitude * (1.0 + further));
            self.now_s += self.random.between(HOLD_RANGE_S);
        }
        self.stroke(axis, 0.0);
    }

    /// A stroke that brings one axis to `target` and the others near home.
    fn stroke(&mut self, axis: usize, target: f64) {
        let mut to: Posture = std::array::from_fn(|other| {
            let deviation = if other < 3 { COUPLING_M } else { COUPLING_RAD };
            // Cut at two deviations, so that the posture is bounded.
            deviation * self.random.normal().clamp(-2.0, 2.0)
        });
        to[axis] += target;
        let object = &mut self.object;
        // The way back from two strokes takes its time too.
        let (_, longest) = stroke_range(axis);
        let stretch = ((to[axis] - object.last_posture()[axis]).abs() / longest).max(1.0);
        let duration_s = stretch * self.random.between(STROKE_RANGE_S);
        self.now_s = object.stroke(self.now_s, duration_s, to);
    }

    /// Moves the fingers that are too far from home, the worst first.
    fn regrasp_strained(&mut self) {
        let hand_from_object = self.object.hand_from_object(self.now_s);
        let grasp = &self.grasp;
        let mut strained: Vec<(f64, Finger)> = Finger::ALL
            .into_iter()
            .map(|finger| (grasp.strain_m(finger, hand_from_object), finger))
            .filter(|&(strain_m, _)| strain_m > STRAIN_LIMIT_M)
            .collect();
        strained.sort_by(|a, b| b.0.total_cmp(&a.0));
        let fingers: Vec<Finger> = (strained.into_iter().take(MAX_REGRASPS))
            .map(|(_, finger)| finger)
            .collect();
        self.regrasp(&fingers);
    }

    /// Moves fingers one after the other, two at most in the air at any time.
    fn regrasp(&mut self, fingers: &[Finger]) {
        let mut start_s = self.now_s;
        let mut before: Option<Swing> = None;
        for &finger in fingers {
            let duration_s = self.random.between(SWING_RANGE_S);
            let set_down = self.object.hand_from_object(start_s + duration_s);
            let Some(swing) =
                (self.grasp).regrasp(finger, start_s, duration_s, set_down, &mut self.random)
            else {
                continue;
            };
            self.now_s = self.now_s.max(swing.end_s());
            let stagger = self.random.between(SWING_STAGGER_RANGE) * swing.duration_s;
            // The swing before this one is down before the next one starts.
            let down_s = before.map_or(start_s, |before| before.end_s());
            start_s = (start_s + stagger).max(down_s);
            before = Some(swing);
        }
    }
}
