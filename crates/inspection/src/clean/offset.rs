//! From markers to the pads of the fingers.
//!
//! A marker sits on the nail or the end of a finger, contact is made by the pad. Where the pad is from
//! the marker depends on how the last joint is turned, and that cannot be known from one marker on it
//! and a body on the back of the hand. What can be stated:
//!
//! * an offset with fixed axes of the hand ([`PadOffset::InHand`]): right where the last joints keep
//!   their direction in the hand, as in a grasp that stays much the same;
//! * an offset along the line from a fixed point of the hand, such as the knuckle, to the marker
//!   ([`PadOffset::AlongFinger`]): the finger's direction as well as it can be told without joints; it
//!   moves the point towards or away from the end of the finger, not around it;
//! * an offset from the marker towards the centre of the object ([`PadOffset::TowardsObject`]): the pad
//!   is on the side of the finger that faces what it holds. Only where the object is tracked.

use inhand_model::{
    Change, ChangeKind, Finger, Hand, PerFinger, PointTrack, Pose, PoseTrack, Position, Recording,
    Roles, Status, World, runs,
};
use inhand_motion::{BodyRole, MotionError, fingertip_markers, fit_templates, role_body};
use nalgebra::Vector3;

use crate::error::CleaningError;
use crate::lookup::{Flips, hand_poses};

/// Where the pad of a finger is from its marker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PadOffset {
    /// By a vector with the axes of the hand's frame, metres.
    InHand {
        /// From marker to pad, metres in `hand`.
        offset_m: [f64; 3],
    },
    /// Along the line from a point of the hand through the marker.
    AlongFinger {
        /// The point, such as the finger's knuckle, metres in `hand`.
        from_m: [f64; 3],
        /// How far beyond the marker, metres; negative for nearer to the point.
        beyond_m: f64,
    },
    /// Towards the centre of the object.
    TowardsObject {
        /// How far, metres.
        distance_m: f64,
    },
}

/// Moves the markers of fingers to their pads, with the poses as they are recorded. Where the frame
/// that the offset needs is missing the pad is not known: the sample is missing then, and the range is
/// listed as a change of its own ([`ChangeKind::Removed`]).
///
/// # Errors
///
/// [`CleaningError::Motion`] for numbers that are not finite and for roles that are not in the take.
pub fn to_pads(
    recording: &mut Recording,
    roles: &Roles,
    offsets: &PerFinger<Option<PadOffset>>,
) -> Result<Vec<Change>, CleaningError> {
    let wanted: Vec<(Finger, PadOffset)> = offsets
        .iter()
        .filter_map(|(finger, &offset)| Some((finger, offset?)))
        .collect();
    for (_, offset) in &wanted {
        offset.check()?;
    }
    let tips = fingertip_markers(recording, roles)?;
    let wants_object =
        |(_, offset): &(Finger, PadOffset)| matches!(offset, PadOffset::TowardsObject { .. });
    let frames = Frames {
        hand: hand_poses(recording, roles, Flips::Kept)?,
        object_centre: if wanted.iter().any(wants_object) {
            object_centres(recording, roles)?
        } else {
            PointTrack::missing(recording.len())
        },
    };
    let mut changes = Vec::new();
    for (finger, offset) in wanted {
        let marker = &mut recording.markers[tips[finger]];
        let present = |k: usize| marker.track.get(k).is_some();
        let seen: Vec<usize> = (0..marker.track.len()).filter(|&k| present(k)).collect();
        for &k in &seen {
            let at = marker.track.values()[k];
            let (moved, frame_status) = frames.moved(&offset, k, at);
            let pad = moved.map(|moved| Position::from_coords(at.coords_m() + moved));
            if let Some(quality) = marker.quality.as_mut().filter(|_| pad.is_none()) {
                quality[k] = f64::NAN;
            }
            marker
                .track
                .set(k, pad, marker.track.status(k).and(frame_status));
        }
        let lost = |k: usize| seen.binary_search(&k).is_ok() && marker.track.get(k).is_none();
        let lost = runs(0..marker.track.len(), lost);
        changes.push(Change {
            kind: ChangeKind::Moved,
            entity: marker.name.clone(),
            samples: 0..marker.track.len(),
            message: format!("moved to the pad of the {finger}: {}", offset.in_words()),
        });
        let frame = offset.frame_in_words();
        changes.extend(lost.into_iter().map(|samples| Change {
            kind: ChangeKind::Removed,
            entity: marker.name.clone(),
            message: format!(
                "no {frame} is known there to place the pad of the {finger} by: removed"
            ),
            samples,
        }));
    }
    Ok(changes)
}

/// What pads are placed by.
struct Frames {
    hand: PoseTrack<World, Hand>,
    object_centre: PointTrack<World>,
}

impl Frames {
    /// From a marker to its pad at sample `k`, metres in the world, and what is known of the frame.
    fn moved(
        &self,
        offset: &PadOffset,
        k: usize,
        at: Position<World>,
    ) -> (Option<Vector3<f64>>, Status) {
        let at_m = at.coords_m();
        let hand = self.hand.get(k);
        match *offset {
            PadOffset::InHand { offset_m } => {
                let turned = hand.map(|hand| hand.isometry().rotation * Vector3::from(offset_m));
                (turned, self.hand.status(k))
            }
            PadOffset::AlongFinger { from_m, beyond_m } => {
                let from = hand.map(|hand| (hand * Position::from(from_m)).coords_m());
                (
                    from.and_then(|from| along(from, at_m, beyond_m)),
                    self.hand.status(k),
                )
            }
            PadOffset::TowardsObject { distance_m } => {
                let centre = self.object_centre.get(k).map(Position::coords_m);
                let towards = centre.and_then(|centre| along(at_m, centre, distance_m));
                (towards, self.object_centre.status(k))
            }
        }
    }
}

/// A vector of that length from one point towards another; `None` where they coincide.
fn along(from: Vector3<f64>, to: Vector3<f64>, length_m: f64) -> Option<Vector3<f64>> {
    Some((to - from).try_normalize(1e-9)? * length_m)
}

fn object_centres(
    recording: &Recording,
    roles: &Roles,
) -> Result<PointTrack<World>, CleaningError> {
    let no_object = || {
        let expected = "an offset in the hand, for the roles name no object";
        MotionError::setting("pad offset", "towards the object", expected)
    };
    let source = roles.object.as_ref().ok_or_else(no_object)?;
    let templates = fit_templates([(recording, roles)])?;
    let body = role_body(recording, BodyRole::Object, source, &templates)?;
    Ok(body.track.map(Pose::origin))
}

impl PadOffset {
    fn check(&self) -> Result<(), CleaningError> {
        /// Longer than any finger.
        const FARTHEST_M: f64 = 0.2;
        let (numbers, within) = match self {
            PadOffset::InHand { offset_m } => (offset_m.to_vec(), FARTHEST_M),
            PadOffset::AlongFinger { from_m, beyond_m } => {
                ([from_m.as_slice(), &[*beyond_m]].concat(), 2.0 * FARTHEST_M)
            }
            PadOffset::TowardsObject { distance_m } => (vec![*distance_m], FARTHEST_M),
        };
        // A range contains no NaN.
        if numbers.iter().all(|n| (-within..=within).contains(n)) {
            return Ok(());
        }
        let (found, expected) = (
            format!("{numbers:?} m"),
            "lengths of a finger at most, metres",
        );
        Err(MotionError::setting("pad offset", found, expected).into())
    }

    const fn frame_in_words(&self) -> &'static str {
        match self {
            PadOffset::InHand { .. } => "pose of the hand",
            PadOffset::AlongFinger { .. } => "direction of the finger in the hand",
            PadOffset::TowardsObject { .. } => "direction to the object",
        }
    }

    fn in_words(&self) -> String {
        match self {
            PadOffset::InHand {
                offset_m: [x, y, z],
            } => {
                format!(
                    "by ({:.1}, {:.1}, {:.1}) mm in the hand's axes",
                    x * 1e3,
                    y * 1e3,
                    z * 1e3
                )
            }
            PadOffset::AlongFinger { beyond_m, .. } => {
                format!("by {:.1} mm along the finger", beyond_m * 1e3)
            }
            PadOffset::TowardsObject { distance_m } => {
                format!("by {:.1} mm towards the object", distance_m * 1e3)
            }
        }
    }
}
