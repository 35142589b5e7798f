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

use std::ops::Range;

use inhand_model::{
    BodySource, Change, ChangeKind, Finger, PerFinger, PointTrack, Pose, Position, Recording,
    Roles, World,
};
use inhand_motion::{fit_templates, fitted_bodies};
use nalgebra::Vector3;

use crate::error::CleaningError;
use crate::lookup::{Flips, hand_poses, tips};

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
/// told as a change of its own ([`ChangeKind::Removed`]).
///
/// # Errors
///
/// [`CleaningError::Setting`] for numbers that are not finite, [`CleaningError::NotInTake`],
/// [`CleaningError::Hand`].
pub fn to_pads(
    recording: &mut Recording,
    roles: &Roles,
    offsets: &PerFinger<Option<PadOffset>>,
) -> Result<Vec<Change>, CleaningError> {
    for offset in offsets.as_array().iter().flatten() {
        offset.check()?;
    }
    let tips = tips(recording, roles)?;
    let hand = hand_poses(recording, roles, Flips::Kept)?;
    let wants_object = |offset: &PadOffset| matches!(offset, PadOffset::TowardsObject { .. });
    let centres = if offsets.as_array().iter().flatten().any(wants_object) {
        object_centres(recording, roles)?
    } else {
        PointTrack::missing(recording.len())
    };
    let mut changes = Vec::new();
    for finger in Finger::ALL {
        let Some(offset) = offsets[finger] else {
            continue;
        };
        let marker = &mut recording.markers[tips[finger]];
        let mut lost: Vec<Range<usize>> = Vec::new();
        for k in 0..marker.track.len() {
            let Some(at) = marker.track.get(k) else {
                continue;
            };
            let frame = hand.get(k);
            let (moved, frame_status) = match offset {
                PadOffset::InHand { offset_m } => {
                    let turned = frame.map(|f| f.isometry().rotation * Vector3::from(offset_m));
                    (turned, hand.status(k))
                }
                PadOffset::AlongFinger { from_m, beyond_m } => {
                    let from = frame.map(|f| (f * Position::from(from_m)).coords_m());
                    (
                        from.and_then(|from| along(from, at.coords_m(), beyond_m)),
                        hand.status(k),
                    )
                }
                PadOffset::TowardsObject { distance_m } => {
                    let centre = centres.get(k).map(Position::coords_m);
                    let towards = centre.and_then(|c| along(at.coords_m(), c, distance_m));
                    (towards, centres.status(k))
                }
            };
            let status = marker.track.status(k).and(frame_status);
            let pad = moved.map(|moved| Position::from_coords(at.coords_m() + moved));
            if pad.is_none() {
                match lost.last_mut() {
                    Some(last) if last.end == k => last.end = k + 1,
                    _ => lost.push(k..k + 1),
                }
                if let Some(quality) = &mut marker.quality {
                    quality[k] = f64::NAN;
                }
            }
            marker.track.set(k, pad, status);
        }
        changes.push(Change {
            kind: ChangeKind::Moved,
            entity: marker.name.clone(),
            samples: 0..marker.track.len(),
            message: format!("moved to the pad of the {finger}: {}", offset.in_words()),
        });
        changes.extend(lost.into_iter().map(|samples| Change {
            kind: ChangeKind::Removed,
            entity: marker.name.clone(),
            message: format!(
                "no {} is known there to place the pad of the {finger} by: taken away",
                offset.frame_in_words()
            ),
            samples,
        }));
    }
    Ok(changes)
}

/// A vector of that length from one point towards another; `None` where they coincide.
fn along(from: Vector3<f64>, to: Vector3<f64>, length_m: f64) -> Option<Vector3<f64>> {
    Some((to - from).try_normalize(1e-9)? * length_m)
}

fn object_centres(
    recording: &Recording,
    roles: &Roles,
) -> Result<PointTrack<World>, CleaningError> {
    let not_there = |name: &str| CleaningError::NotInTake {
        take: recording.name.clone(),
        role: "object".to_owned(),
        kind: "rigid body",
        name: name.to_owned(),
    };
    let source = roles.object.as_ref().ok_or_else(|| not_there("object"))?;
    let fitted;
    let body = match source {
        BodySource::RigidBody(name) => recording.body(name).ok_or_else(|| not_there(name))?,
        BodySource::Markers(names) => {
            let templates = fit_templates([(recording, roles)])?;
            fitted = fitted_bodies(recording, roles, &templates)?;
            // Hand and object are named after their roles; the object comes last.
            fitted.last().ok_or_else(|| not_there(&names.join(", ")))?
        }
    };
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
        Err(CleaningError::Setting {
            setting: "pad offset",
            found: format!("{numbers:?} m"),
            expected: "lengths of a finger at most, metres",
        })
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
