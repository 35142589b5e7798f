//! Five fingertips on the object: where each belongs, how one is lifted and set down elsewhere.

use inhand_model::{Finger, Hand, Object, PerFinger, Pose, Position, Shape};
use nalgebra::Vector3;

use crate::curves::{bump, minimum_jerk};
use crate::error::SimulationError;
use crate::random::Random;
use crate::surface::{Contact, Solid};

/// Distance between two fingertips that touch, metres: at least the width of a finger.
const CONTACT_SEPARATION_M: f64 = 0.014;
/// Distance to others on the way, metres; above the 10 mm that count as a collision, with room for
/// noise.
const PATH_SEPARATION_M: f64 = 0.012;
/// Least distance worth lifting a finger for, metres.
const MIN_MOVE_M: f64 = 0.006;
/// Spread of contacts about a finger's home, metres.
const SPREAD_M: f64 = 0.006;
/// How far a finger is lifted off the surface, metres.
const CLEARANCE_RANGE_M: (f64, f64) = (0.004, 0.008);
/// Steps by which a path is raised until it clears the object, metres, and how often.
const RAISE_STEP_M: f64 = 0.001;
const MAX_RAISES: usize = 25;
/// Places where a path is checked.
const PATH_CHECKS: usize = 32;
/// Draws of a new contact before a finger stays where it is, and of a first grasp.
const MAX_CONTACT_DRAWS: usize = 12;
const MAX_GRASP_DRAWS: usize = 500;

/// Where each finger comes from: angle about z from x towards y in degrees, and height as a share
/// of half the object's height. The thumb opposes ring and little finger, index and middle lie
/// beside each other on the far side.
const HOMES: PerFinger<(f64, f64)> = PerFinger::new([
    (216.0, -0.25),
    (126.0, -0.10),
    (87.0, 0.05),
    (38.0, -0.10),
    (-6.0, -0.30),
]);

/// A finger in the air, from contact to contact, in the object's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Swing {
    pub(crate) start_s: f64,
    pub(crate) duration_s: f64,
    from: Contact,
    to: Contact,
    /// Highest deviation from the chord, metres, outward.
    lift_m: Vector3<f64>,
}

impl Swing {
    pub(crate) fn end_s(&self) -> f64 {
        self.start_s + self.duration_s
    }

    /// Position on the way, `s` from 0 to 1: along the chord with minimum jerk, off it by a bump
    /// whose velocity and acceleration vanish at both ends too.
    fn at(&self, s: f64) -> Position<Object> {
        // The ends exactly: interpolation may miss them by a rounding.
        if s <= 0.0 {
            return self.from.point;
        }
        if s >= 1.0 {
            return self.to.point;
        }
        let (from, to) = (self.from.point.coords_m(), self.to.point.coords_m());
        Position::from_coords(from + (to - from) * minimum_jerk(s) + self.lift_m * bump(s))
    }
}

/// One finger over a take.
#[derive(Clone, Debug)]
pub(crate) struct FingerTimeline {
    first: Contact,
    /// In order of time, none overlapping the next.
    swings: Vec<Swing>,
}

impl FingerTimeline {
    fn swing_at(&self, time_s: f64) -> Option<&Swing> {
        let begun = self.swings.partition_point(|s| s.start_s <= time_s);
        self.swings[..begun].last()
    }

    pub(crate) fn position_at(&self, time_s: f64) -> Position<Object> {
        self.swing_at(time_s).map_or(self.first.point, |swing| {
            swing.at((time_s - swing.start_s) / swing.duration_s)
        })
    }

    /// Touching the object; at both ends of a swing the finger still or again does.
    pub(crate) fn in_contact_at(&self, time_s: f64) -> bool {
        self.swing_at(time_s).is_none_or(|swing| {
            let s = (time_s - swing.start_s) / swing.duration_s;
            s <= 0.0 || s >= 1.0
        })
    }

    /// The contact after every swing so far.
    fn last_contact(&self) -> Contact {
        self.swings.last().map_or(self.first, |swing| swing.to)
    }
}

/// Five fingertips on an object.
#[derive(Clone, Debug)]
pub(crate) struct Grasp {
    solid: Solid,
    homes: PerFinger<Position<Hand>>,
    pub(crate) fingers: PerFinger<FingerTimeline>,
}

impl Grasp {
    /// A first grasp of an object that lies as `hand_from_object` says, `home` being where its
    /// centre belongs.
    pub(crate) fn new(
        shape: Shape,
        home: Position<Hand>,
        hand_from_object: Pose<Hand, Object>,
        random: &mut Random,
    ) -> Result<Self, SimulationError> {
        let solid = Solid::new(shape)?;
        let homes = PerFinger::from_fn(|finger| {
            let (angle_deg, height) = HOMES[finger];
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            let z = height * solid.half_extent_m().z;
            let contact = solid.side_contact(Position::new(cos, sin, z));
            Position::from_coords(home.coords_m() + contact.point.coords_m())
        });
        let object_from_hand = hand_from_object.inverse();
        for _ in 0..MAX_GRASP_DRAWS {
            let contacts =
                PerFinger::from_fn(|f| draw_contact(&solid, object_from_hand, homes[f], random));
            let apart = Finger::ALL.iter().all(|&a| {
                (Finger::ALL.iter().filter(|&&b| b > a)).all(|&b| {
                    contacts[a].point.distance_m(contacts[b].point) >= CONTACT_SEPARATION_M
                })
            });
            if apart {
                let fingers = contacts.map(|first| FingerTimeline {
                    first,
                    swings: Vec::new(),
                });
                return Ok(Self {
                    solid,
                    homes,
                    fingers,
                });
            }
        }
        Err(SimulationError::Object(format!(
            "no grasp of {shape} with five fingertips {CONTACT_SEPARATION_M} m apart was found: \
             give a larger object"
        )))
    }

    /// How far a finger is from its home, metres.
    pub(crate) fn strain_m(&self, finger: Finger, hand_from_object: Pose<Hand, Object>) -> f64 {
        let tip = hand_from_object * self.fingers[finger].last_contact().point;
        tip.distance_m(self.homes[finger])
    }

    /// Lifts a finger and sets it down nearer to its home, or elsewhere about it; the object lies
    /// as `hand_from_object` says when it is set down. `None`, and nothing changed, where the
    /// draws found no place and way that keeps clear of the object and the other fingers.
    pub(crate) fn regrasp(
        &mut self,
        finger: Finger,
        start_s: f64,
        duration_s: f64,
        hand_from_object: Pose<Hand, Object>,
        random: &mut Random,
    ) -> Option<Swing> {
        let from = self.fingers[finger].last_contact();
        let object_from_hand = hand_from_object.inverse();
        for _ in 0..MAX_CONTACT_DRAWS {
            let to = draw_contact(&self.solid, object_from_hand, self.homes[finger], random);
            let clearance_m = random.between(CLEARANCE_RANGE_M);
            if to.point.distance_m(from.point) < MIN_MOVE_M {
                continue;
            }
            let swing = Swing {
                start_s,
                duration_s,
                from,
                to,
                lift_m: Vector3::zeros(),
            };
            let Some(swing) = raised(swing, clearance_m, &self.solid) else {
                continue;
            };
            if self.keeps_apart(finger, &swing) {
                self.fingers[finger].swings.push(swing);
                return Some(swing);
            }
        }
        None
    }

    /// Whether the swing keeps its distance from every other finger, resting or swinging, until
    /// all are down.
    fn keeps_apart(&self, finger: Finger, swing: &Swing) -> bool {
        let others = || self.fingers.iter().filter(|&(other, _)| other != finger);
        let all_down_s = (others().filter_map(|(_, f)| f.swings.last()))
            .map(Swing::end_s)
            .fold(swing.end_s(), f64::max);
        let way_is_free = (0..=PATH_CHECKS).all(|k| {
            let part = k as f64 / PATH_CHECKS as f64;
            let time_s = swing.start_s + part * (all_down_s - swing.start_s);
            let tip = swing.at((time_s - swing.start_s) / swing.duration_s);
            others().all(|(_, f)| tip.distance_m(f.position_at(time_s)) >= PATH_SEPARATION_M)
        });
        way_is_free
            && others().all(|(_, other)| {
                swing.to.point.distance_m(other.last_contact().point) >= CONTACT_SEPARATION_M
            })
    }
}

/// A contact about a finger's home.
fn draw_contact(
    solid: &Solid,
    object_from_hand: Pose<Object, Hand>,
    home: Position<Hand>,
    random: &mut Random,
) -> Contact {
    let target = Position::from_coords(home.coords_m() + random.normal3(SPREAD_M));
    solid.side_contact(object_from_hand * target)
}

/// The swing, raised until it stays out of the object all the way and clears it in the middle.
fn raised(swing: Swing, clearance_m: f64, solid: &Solid) -> Option<Swing> {
    // Contacts on opposite faces have no outward direction in common.
    let outward = (swing.from.normal + swing.to.normal).try_normalize(0.1)?;
    (0..MAX_RAISES)
        .map(|raise| Swing {
            lift_m: outward * (clearance_m + RAISE_STEP_M * raise as f64),
            ..swing
        })
        .find(|swing| {
            (1..PATH_CHECKS).all(|k| {
                let s = k as f64 / PATH_CHECKS as f64;
                let distance_m = solid.signed_distance_m(swing.at(s));
                // Half the bump: a path over an edge is lower above it than above a face.
                distance_m >= 0.5 * clearance_m * bump(s)
            })
        })
}
