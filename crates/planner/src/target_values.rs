//! Pattern and values of a target: which parts of a segment it gives (on which everything prepared
//! depends), and their numbers.

use inhand_model::{
    Finger, Hand, Object, Pose, Position, SEGMENT_COORDINATES, SegmentLayout, object_coordinates_m,
};

use crate::MM_PER_M;
use crate::error::{PlanError, check_size};
use crate::target::{Holding, Target, Tips};

/// Farther from the hand than any fingertip, metres. Catches targets in millimetres.
pub(crate) const FARTHEST_M: f64 = 10.0;
/// Faster than any fingertip, m/s. Catches velocities in mm/s.
pub(crate) const FASTEST_M_S: f64 = 100.0;
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
pub(crate) enum TargetPart {
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

impl TargetPart {
    /// Where its three numbers start in a vector of end conditions, if they are among them.
    pub(crate) fn end_condition(self, layout: SegmentLayout) -> Option<usize> {
        let fingers = 4 * SEGMENT_COORDINATES;
        match self {
            TargetPart::Position { sample: 0, finger } => Some(SegmentLayout::row(0, finger, 0)),
            TargetPart::Position { sample, finger } if sample + 1 == layout.samples => {
                Some(SEGMENT_COORDINATES + SegmentLayout::row(0, finger, 0))
            }
            TargetPart::Velocity { end, finger } => {
                let part = end.velocity_part();
                Some(part * SEGMENT_COORDINATES + SegmentLayout::row(0, finger, 0))
            }
            TargetPart::ObjectPosition { end: End::First } => Some(fingers),
            TargetPart::ObjectPosition { end: End::Last } => Some(fingers + 3),
            TargetPart::ObjectRotation { end: End::Last } => Some(fingers + 6),
            TargetPart::Position { .. }
            | TargetPart::Step { .. }
            | TargetPart::ObjectRotation { end: End::First } => None,
        }
    }
}

/// Pattern and values of a target, in the order of [`TargetPart`].
#[derive(Clone, Debug)]
pub(crate) struct TargetValues {
    pub(crate) pattern: Vec<TargetPart>,
    /// Three for each, mm or mm/s.
    pub(crate) values: Vec<f64>,
    /// The sample of which positions and velocities are facts, not wishes.
    pub(crate) now: Option<usize>,
}

/// A part of a segment, its value (m, m/s), and which part of the target gives it.
type Entry = (TargetPart, [f64; 3], &'static str);

impl TargetValues {
    /// Checks a target and lists what it gives of segments of this layout.
    pub(crate) fn new(target: &Target, layout: SegmentLayout) -> Result<Self, PlanError> {
        let mut entries = entries(target, layout)?;
        entries.sort_by_key(|(part, ..)| *part);
        if let Some(holding) = &target.holding {
            check_holding(holding, layout)?;
        }
        let now = target.now_s.map(|time_s| sample_at(time_s, layout));
        let (mut pattern, mut values) = (Vec::new(), Vec::new());
        let mut before: Option<Entry> = None;
        for entry in entries {
            if let Some(before) = before.filter(|before| before.0 == entry.0) {
                check_same(before, entry, layout)?;
                continue;
            }
            before = Some(entry);
            pattern.push(entry.0);
            values.extend(entry.1.map(|v| v * MM_PER_M));
        }
        if pattern.is_empty() {
            return Err(PlanError::Target(
                "the target gives nothing to reach: give at least one position, velocity or pose"
                    .to_owned(),
            ));
        }
        Ok(Self {
            pattern,
            values,
            now: now.transpose()?,
        })
    }
}

fn entries(target: &Target, layout: SegmentLayout) -> Result<Vec<Entry>, PlanError> {
    let last = layout.samples - 1;
    let mut entries: Vec<Entry> = Vec::new();
    let mut add = |what, limit, tips: &Tips, part: &dyn Fn(Finger) -> TargetPart| {
        check_tips(what, tips, limit)?;
        entries.extend(given(tips).map(|(finger, tip)| (part(finger), tip, what)));
        Ok::<(), PlanError>(())
    };
    let at = |sample| move |finger| TargetPart::Position { sample, finger };
    add("first configuration", FARTHEST_M, &target.first_m, &at(0))?;
    add("last configuration", FARTHEST_M, &target.last_m, &at(last))?;
    for waypoint in &target.waypoints {
        let sample = sample_at(waypoint.time_s, layout)?;
        add("waypoint", FARTHEST_M, &waypoint.tips, &at(sample))?;
    }
    for step in &target.steps {
        let sample = sample_at(step.time_s, layout)?.min(last - 1);
        let part = |finger| TargetPart::Step { sample, finger };
        add("velocity on the way", FASTEST_M_S, &step.tips, &part)?;
    }
    for (what, end, tips) in [
        ("first velocity", End::First, &target.first_velocity_m_s),
        ("last velocity", End::Last, &target.last_velocity_m_s),
    ] {
        let part = |finger| TargetPart::Velocity { end, finger };
        add(what, FASTEST_M_S, tips, &part)?;
    }
    entries.extend(object(target, layout)?);
    Ok(entries)
}

/// Refuses two positions or two velocities of one finger at one sample.
fn check_same(one: Entry, other: Entry, layout: SegmentLayout) -> Result<(), PlanError> {
    let ((part, a, one), (_, b, other)) = (one, other);
    if (0..3).all(|axis| (a[axis] - b[axis]).abs() <= SAME_M) {
        return Ok(());
    }
    let time_s = |sample: usize| sample as f64 / layout.rate_hz;
    match part {
        TargetPart::Position { sample, finger } => Err(PlanError::Target(format!(
            "target: {one} and {other} want {finger} at {a:?} and at {b:?} m \
             at the same sample {sample} ({} s): expected one position",
            time_s(sample)
        ))),
        TargetPart::Step { sample, finger } => Err(PlanError::Target(format!(
            "target: {finger} is wanted to move at {a:?} and at {b:?} m/s \
             from the same sample {sample} ({} s) on: expected one velocity",
            time_s(sample)
        ))),
        _ => Ok(()),
    }
}

/// The fingers of which something is given, and what.
fn given(tips: &Tips) -> impl Iterator<Item = (Finger, [f64; 3])> {
    (tips.0.iter()).filter_map(|(finger, tip)| Some((finger, (*tip)?)))
}

/// The sample nearest to a time.
pub(crate) fn sample_at(time_s: f64, layout: SegmentLayout) -> Result<usize, PlanError> {
    let duration_s = layout.duration_s();
    if !(time_s >= -ROUNDING_S && time_s <= duration_s + ROUNDING_S) {
        return Err(PlanError::Target(format!(
            "a waypoint lies at {time_s} s: expected a time from 0 to {duration_s} s"
        )));
    }
    Ok(((time_s * layout.rate_hz).round().max(0.0) as usize).min(layout.samples - 1))
}

/// Given poses of the object.
fn object(target: &Target, layout: SegmentLayout) -> Result<Vec<Entry>, PlanError> {
    let first = match target.object_first {
        _ if !layout.object && target.object_needed => {
            return Err(PlanError::Target(
                "the target gives a pose of the object, which is not in these segments: \
                 learn from takes that track it, or leave the object out of the target"
                    .to_owned(),
            ));
        }
        None if layout.object && target.object_last.is_some() => {
            return Err(PlanError::Target(
                "the target gives the object's last pose and not its first: segments know how far \
                 it turns from the first, so give both"
                    .to_owned(),
            ));
        }
        Some(first) if layout.object => first,
        _ => return Ok(Vec::new()),
    };
    let mut list = Vec::new();
    for (what, end, pose) in [
        ("first pose of the object", End::First, Some(first)),
        ("last pose of the object", End::Last, target.object_last),
    ] {
        let Some(pose) = pose else { continue };
        check_pose(what, pose)?;
        let [x, y, z, a, b, c] = object_coordinates_m(first, pose);
        list.push((TargetPart::ObjectPosition { end }, [x, y, z], what));
        list.push((TargetPart::ObjectRotation { end }, [a, b, c], what));
    }
    Ok(list)
}

fn check_holding(holding: &Holding, layout: SegmentLayout) -> Result<(), PlanError> {
    check_size(
        "number of the object's poses that fingers hold on to",
        layout.samples,
        holding.hand_from_object.len(),
    )?;
    let tau_m = holding.tau_m;
    if !(SMALLEST_TAU_M..=FARTHEST_M).contains(&tau_m) {
        let expected = "metres, from a micrometre to 10";
        return Err(PlanError::setting(
            "tau_m of holding fingers",
            tau_m,
            expected,
        ));
    }
    for &pose in &holding.hand_from_object {
        check_pose("pose of the held object", pose)?;
    }
    let contacts = (holding.contacts).map(|contact| contact.map(Position::to_array));
    if contacts.iter().all(|(_, contact)| contact.is_none()) {
        return Err(PlanError::Target(
            "holding needs a contact point of at least one finger, and there is none".to_owned(),
        ));
    }
    check_tips("contact point", &Tips(contacts), FARTHEST_M)
}

fn check_pose(what: &str, pose: Pose<Hand, Object>) -> Result<(), PlanError> {
    let position = pose.origin().to_array();
    let mut numbers = position.into_iter().chain(pose.quaternion_xyzw());
    match numbers.find(|v| v.is_nan() || v.abs() > FARTHEST_M) {
        None => Ok(()),
        Some(value) => Err(PlanError::Target(format!(
            "target: {what} holds {value}: expected numbers of at most {FARTHEST_M} in size (metres)"
        ))),
    }
}

/// Refuses numbers that are none, and positions (metres) or velocities (m/s) that no hand reaches.
pub(crate) fn check_tips(what: &str, tips: &Tips, limit: f64) -> Result<(), PlanError> {
    for (finger, values) in given(tips) {
        if let Some(axis) = (values.iter()).position(|value| value.is_nan() || value.abs() > limit)
        {
            return Err(PlanError::Target(format!(
                "target: {what} of {finger}, axis {axis}, is {}: \
                 expected a number of at most {limit} in size (metres and seconds)",
                values[axis]
            )));
        }
    }
    Ok(())
}
