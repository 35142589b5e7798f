//! The object: how it moves between two poses, in a plan, and which fingers hold it.

use inhand_contact::FingerOffsets;
use inhand_model::{
    Configuration, Finger, Hand, Object, ObjectEnds, PerFinger, Pose, Position, ROTATION_LEVER_M,
    SegmentLayout, Shape,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::MM_PER_M;
use crate::error::PlanError;

/// Fewer fingers than this do not hold an object (three contacts, arXiv 2308.15153).
const HOLDING_FINGERS: usize = 3;

/// Poses of an object that moves and turns evenly from one pose to another, the shorter way round:
/// one a sample, the first and the last as given.
///
/// ```
/// use inhand_model::{Hand, Object, ObjectEnds, Pose};
/// use inhand_planner::object_between;
/// use nalgebra::{Isometry3, Vector3};
///
/// // 20 mm along x and a quarter turn about z.
/// let turn = Vector3::z() * std::f64::consts::FRAC_PI_2;
/// let ends = ObjectEnds {
///     first: Pose::<Hand, Object>::identity(),
///     last: Pose::new(Isometry3::new(Vector3::x() * 0.02, turn)),
/// };
/// let half = object_between(&ends, 3)[1].isometry();
/// assert!((half.translation.x - 0.01).abs() < 1e-15);
/// assert!((half.rotation.scaled_axis() - turn / 2.0).norm() < 1e-15);
/// ```
pub fn object_between(ends: &ObjectEnds, samples: usize) -> Vec<Pose<Hand, Object>> {
    let (first, last) = (ends.first.isometry(), ends.last.isometry());
    let turn = (last.rotation * first.rotation.inverse()).scaled_axis();
    let way = last.translation.vector - first.translation.vector;
    let steps = samples.saturating_sub(1).max(1) as f64;
    (0..samples)
        .map(|t| {
            if t + 1 == samples && t > 0 {
                return ends.last;
            }
            let part = t as f64 / steps;
            Pose::new(Isometry3::from_parts(
                Translation3::from(first.translation.vector + way * part),
                UnitQuaternion::from_scaled_axis(turn * part) * first.rotation,
            ))
        })
        .collect()
}

/// The fingers that hold an object from start to goal, with their contact points: those whose pads
/// are within `tau_m` of its surface (outside or inside) at both, and have not slid farther over it
/// than a ball of radius `tau_m` is wide. A contact point is the middle between where the fingertip
/// is on the object at start and at goal, so that both are within the ball.
///
/// # Errors
///
/// [`PlanError::TooFewHold`] for fewer than three, with the distances of all fingers.
pub fn held_fingers(
    shape: &Shape,
    offsets: &FingerOffsets,
    tau_m: f64,
    first_m: &Configuration,
    last_m: &Configuration,
    object: &ObjectEnds,
) -> Result<PerFinger<Option<Position<Object>>>, PlanError> {
    let on_object = |configuration: &Configuration, pose: Pose<Hand, Object>, finger: Finger| {
        let at = SegmentLayout::row(0, finger, 0);
        let tip = Position::<Hand>::new(
            configuration[at],
            configuration[at + 1],
            configuration[at + 2],
        );
        pose.inverse() * tip
    };
    let mut distances = Vec::new();
    let contacts = PerFinger::from_fn(|finger| {
        let start = on_object(first_m, object.first, finger);
        let goal = on_object(last_m, object.last, finger);
        let [at_start, at_goal] =
            [start, goal].map(|tip| offsets.pad_distance_m(shape, finger, tip));
        let slid = start.distance_m(goal);
        distances.push(format!(
            "{finger} {at_start:.4} and {at_goal:.4} m, slid {slid:.4} m"
        ));
        let holds = at_start.abs() <= tau_m && at_goal.abs() <= tau_m && slid <= 2.0 * tau_m;
        holds.then(|| Position::from_coords((start.coords_m() + goal.coords_m()) / 2.0))
    });
    let held = contacts
        .iter()
        .filter(|(_, contact)| contact.is_some())
        .count();
    if held < HOLDING_FINGERS {
        return Err(PlanError::TooFewHold(format!(
            "{held} fingers hold the object at start and goal, {HOLDING_FINGERS} are needed: {} \
             (in contact within {tau_m} m)",
            distances.join(", ")
        )));
    }
    Ok(contacts)
}

/// The object's poses in a planned motion (mm), from how it was turned at first.
pub(crate) fn planned_poses(
    layout: SegmentLayout,
    motion_mm: &[f64],
    first: Pose<Hand, Object>,
) -> Vec<Pose<Hand, Object>> {
    (0..layout.samples)
        .map(|t| {
            let part = |from: usize| {
                Vector3::from_fn(|axis, _| motion_mm[layout.object_row(t, from + axis)] / MM_PER_M)
            };
            let turn = UnitQuaternion::from_scaled_axis(part(3) / ROTATION_LEVER_M);
            Pose::new(Isometry3::from_parts(
                Translation3::from(part(0)),
                turn * first.isometry().rotation,
            ))
        })
        .collect()
}
