//! A target as what it gives of a segment: which parts (the pattern, on which everything prepared
//! depends) and their values.

use inhand_model::{
    Finger, Hand, Object, Pose, SEGMENT_COORDINATES, SegmentLayout, object_coordinates_m,
};

use crate::error::PlanError;
use crate::model::MM_PER_M;
use crate::target::{Holding, Target, Tips};

/// Farther from the hand than any fingertip, metres. Catches targets in millimetres.
const FARTHEST_M: f64 = 10.0;
/// Faster than any fingertip, m/s. Catches velocities in mm/s.
const FASTEST_M_S: f64 = 100.0;
/// Two positions (velocities) of one finger at one sample are the same up to here, metres (m/s): a
/// nanometre (in a second).
const SAME_M: f64 = 1e-9;
/// How far outside a segment the time of a waypoint may be by rounding, seconds.
const ROUNDING_S: f64 = 1e-9;
/// Contact points are known no better than this, and a smaller ball cannot be told from a point.
const SMALLEST_TAU_M: f64 = 1e-6;

/// First or last sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum End {
    First,
    Last,
}

impl End {
    /// Which of the four configurations in a vector of end conditions its velocities are.
    pub(crate) const fn velocity_part(self) -> usize {
        match self {
            End::First => 2,
            End::Last => 3,
        }
    }
}

/// Three numbers of a segment that a target can give.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Given {
    /// A fingertip at a sample.
    Position { sample: usize, finger: Finger },
    /// A fingertip's velocity at an end.
    Velocity { end: End, finger: Finger },
    /// A fingertip's velocity from a sample to the next one.
    Step { sample: usize, finger: Finger },
    /// The object at an end.
    ObjectPosition { end: End },
    /// The object's rotation since the first sample (times the lever) at an end.
    ObjectRotation { end: End },
}

impl Given {
    /// Where its three numbers start in a vector of end conditions, if they are among them.
    pub(crate) fn end_condition(self, layout: SegmentLayout) -> Option<usize> {
        let fingers = 4 * SEGMENT_COORDINATES;
        match self {
            Given::Position { sample: 0, finger } => Some(SegmentLayout::row(0, finger, 0)),
            Given::Position { sample, finger } if sample + 1 == layout.samples => {
                Some(SEGMENT_COORDINATES + SegmentLayout::row(0, finger, 0))
            }
            Given::Velocity { end, finger } => {
                let part = end.velocity_part();
                Some(part * SEGMENT_COORDINATES + SegmentLayout::row(0, finger, 0))
            }
            Given::ObjectPosition { end: End::First } => Some(fingers),
            Given::ObjectPosition { end: End::Last } => Some(fingers + 3),
            Given::ObjectRotation { end: End::Last } => Some(fingers + 6),
            Given::Position { .. }
            | Given::Step { .. }
            | Given::ObjectRotation { end: End::First } => None,
        }
    }
}

/// What a target gives, in the order of [`Given`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Wanted {
    pub(crate) given: Vec<Given>,
    /// Three for each, mm or mm/s.
    pub(crate) values: Vec<f64>,
    /// The sample of which positions and velocities are facts, not wishes.
    pub(crate) now: Option<usize>,
}

/// Something given, its value (m, m/s), and which part of the target gives it.
type Part = (Given, [f64; 3], &'static str);

/// Checks a target and lists what it gives of segments of this layout.
pub(crate) fn wanted(target: &Target, layout: SegmentLayout) -> Result<Wanted, PlanError> {
    let last = layout.samples - 1;
    let mut list: Vec<Part> = Vec::new();
    let mut positions = |what, sample, tips: &Tips| -> Result<(), PlanError> {
        check_position(what, tips)?;
        list.extend(
            given_of(tips).map(|(finger, v)| (Given::Position { sample, finger }, v, what)),
        );
        Ok(())
    };
    positions("first configuration", 0, &target.first_m)?;
    positions("last configuration", last, &target.last_m)?;
    for waypoint in &target.waypoints {
        let sample = sample_at(waypoint.time_s, layout)?;
        positions("waypoint", sample, &waypoint.tips)?;
    }
    for step in &target.steps {
        let sample = sample_at(step.time_s, layout)?.min(last - 1);
        let what = "velocity on the way";
        check_velocity(what, &step.tips)?;
        list.extend(
            given_of(&step.tips).map(|(finger, v)| (Given::Step { sample, finger }, v, what)),
        );
    }
    for (what, end, tips) in [
        ("first velocity", End::First, &target.first_velocity_m_s),
        ("last velocity", End::Last, &target.last_velocity_m_s),
    ] {
        check_velocity(what, tips)?;
        list.extend(given_of(tips).map(|(finger, v)| (Given::Velocity { end, finger }, v, what)));
    }
    list.extend(object(target, layout)?);
    if let Some(holding) = &target.holding {
        check_holding(holding, layout)?;
    }

    list.sort_by_key(|(given, ..)| *given);
    let mut wanted = Wanted {
        now: target
            .now_s
            .map(|time_s| sample_at(time_s, layout))
            .transpose()?,
        ..Wanted::default()
    };
    let mut before: Option<Part> = None;
    for (given, value, what) in list {
        if let Some((same, other, other_what)) = before
            && same == given
        {
            let differs = (0..3).any(|axis| (value[axis] - other[axis]).abs() > SAME_M);
            match given {
                Given::Position { sample, finger } if differs => {
                    return Err(PlanError::Contradiction {
                        finger,
                        sample,
                        time_s: sample as f64 / layout.rate_hz,
                        one: other_what,
                        one_m: other,
                        other: what,
                        other_m: value,
                    });
                }
                Given::Step { sample, finger } if differs => {
                    return Err(PlanError::VelocityContradiction {
                        finger,
                        sample,
                        time_s: sample as f64 / layout.rate_hz,
                        one_m_s: other,
                        other_m_s: value,
                    });
                }
                _ => continue,
            }
        }
        before = Some((given, value, what));
        wanted.given.push(given);
        wanted.values.extend(value.map(|v| v * MM_PER_M));
    }
    if wanted.given.is_empty() {
        return Err(PlanError::NothingGiven);
    }
    Ok(wanted)
}

/// The fingers of which something is given, and what.
fn given_of(tips: &Tips) -> impl Iterator<Item = (Finger, [f64; 3])> {
    (tips.0.iter()).filter_map(|(finger, tip)| Some((finger, (*tip)?)))
}

/// The sample nearest to a time.
pub(crate) fn sample_at(time_s: f64, layout: SegmentLayout) -> Result<usize, PlanError> {
    let duration_s = layout.duration_s();
    if !(time_s >= -ROUNDING_S && time_s <= duration_s + ROUNDING_S) {
        return Err(PlanError::WaypointTime { time_s, duration_s });
    }
    Ok(((time_s * layout.rate_hz).round().max(0.0) as usize).min(layout.samples - 1))
}

/// What is given of the object.
fn object(target: &Target, layout: SegmentLayout) -> Result<Vec<Part>, PlanError> {
    if !layout.object {
        return match target.object_needed {
            true => Err(PlanError::NoObject),
            false => Ok(Vec::new()),
        };
    }
    let Some(first) = target.object_first else {
        return match target.object_last {
            Some(_) => Err(PlanError::ObjectStart),
            None => Ok(Vec::new()),
        };
    };
    let mut list = Vec::new();
    for (what, end, pose) in [
        ("first pose of the object", End::First, Some(first)),
        ("last pose of the object", End::Last, target.object_last),
    ] {
        let Some(pose) = pose else { continue };
        check_pose(what, pose)?;
        let [x, y, z, a, b, c] = object_coordinates_m(first, pose);
        list.push((Given::ObjectPosition { end }, [x, y, z], what));
        list.push((Given::ObjectRotation { end }, [a, b, c], what));
    }
    Ok(list)
}

fn check_holding(holding: &Holding, layout: SegmentLayout) -> Result<(), PlanError> {
    let poses = holding.hand_from_object.len();
    if poses != layout.samples {
        return Err(PlanError::Shape {
            what: "number of the object's poses that fingers hold on to",
            expected: layout.samples,
            found: poses,
        });
    }
    if !(holding.tau_m >= SMALLEST_TAU_M && holding.tau_m <= FARTHEST_M) {
        return Err(PlanError::Setting {
            name: "tau_m of holding fingers",
            value: holding.tau_m,
            expected: "metres, from a micrometre to 10",
        });
    }
    for &pose in &holding.hand_from_object {
        check_pose("pose of the held object", pose)?;
    }
    let mut any = false;
    for (finger, contact) in holding.contacts.iter() {
        if let Some(contact) = contact {
            any = true;
            check("contact point", finger, contact.to_array(), FARTHEST_M)?;
        }
    }
    if any {
        Ok(())
    } else {
        Err(PlanError::NobodyHolds)
    }
}

fn check_pose(what: &'static str, pose: Pose<Hand, Object>) -> Result<(), PlanError> {
    let position = pose.origin().to_array();
    let numbers = position.into_iter().chain(pose.quaternion_xyzw());
    match numbers
        .into_iter()
        .find(|v| v.is_nan() || v.abs() > FARTHEST_M)
    {
        None => Ok(()),
        Some(value) => Err(PlanError::ObjectTarget {
            what,
            value,
            limit: FARTHEST_M,
        }),
    }
}

/// Refuses numbers that are none, and positions (metres) that no hand reaches.
pub(crate) fn check_position(what: &'static str, tips: &Tips) -> Result<(), PlanError> {
    (tips.0.iter()).try_for_each(|(finger, tip)| match *tip {
        Some(tip) => check(what, finger, tip, FARTHEST_M),
        None => Ok(()),
    })
}

/// Refuses numbers that are none, and velocities (m/s) that no hand reaches.
pub(crate) fn check_velocity(what: &'static str, tips: &Tips) -> Result<(), PlanError> {
    (tips.0.iter()).try_for_each(|(finger, tip)| match *tip {
        Some(tip) => check(what, finger, tip, FASTEST_M_S),
        None => Ok(()),
    })
}

fn check(
    what: &'static str,
    finger: Finger,
    values: [f64; 3],
    limit: f64,
) -> Result<(), PlanError> {
    match (values.iter()).position(|value| value.is_nan() || value.abs() > limit) {
        None => Ok(()),
        Some(axis) => Err(PlanError::Target {
            what,
            finger,
            axis,
            value: values[axis],
            limit,
        }),
    }
}
