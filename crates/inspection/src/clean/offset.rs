//! Offsets from markers to the pads of the fingers.
//!
//! A marker sits on the nail or the end of a finger, contact is made by the pad. Where the pad is from
//! the marker depends on how the last joint is turned, and that cannot be known from one marker on it
//! and a body on the back of the hand. What can be stated is an offset with fixed axes of the hand: right
//! where the last joints keep their direction in the hand, as in a grasp that stays much the same.

use inhand_model::{Change, ChangeKind, Finger, PerFinger, Position, Recording, Roles, runs};
use inhand_motion::{MotionError, fingertip_markers};
use nalgebra::Vector3;

use crate::lookup::{Flips, hand_poses};

/// Longer than any finger.
const FARTHEST_M: f64 = 0.2;

/// Moves the markers of fingers to their pads, by vectors with the axes of the hand's frame (metres) and
/// with the poses as they are recorded. Where the hand is missing the pad is not known: the sample is
/// missing then, and the range is listed as a change of its own ([`ChangeKind::Removed`]).
///
/// # Errors
///
/// [`MotionError`] for offsets that are not finite or longer than a finger, and for roles that
/// are not in the take.
pub fn to_pads(
    recording: &mut Recording,
    roles: &Roles,
    offsets_m: &PerFinger<Option<[f64; 3]>>,
) -> Result<Vec<Change>, MotionError> {
    for offset_m in offsets_m.as_array().iter().flatten() {
        // A range contains no NaN.
        if !offset_m
            .iter()
            .all(|n| (-FARTHEST_M..=FARTHEST_M).contains(n))
        {
            let (found, expected) = (
                format!("{offset_m:?} m"),
                "lengths of a finger at most, metres",
            );
            return Err(MotionError::setting("pad offset", found, expected));
        }
    }
    let tips = fingertip_markers(recording, roles)?;
    let hand = hand_poses(recording, roles, Flips::Kept)?;
    let mut changes = Vec::new();
    for finger in Finger::ALL {
        let Some(offset_m) = offsets_m[finger] else {
            continue;
        };
        let marker = &mut recording.markers[tips[finger]];
        let mut change = |kind, samples, message| {
            let entity = marker.name.clone();
            changes.push(Change {
                kind,
                entity,
                samples,
                message,
            });
        };
        let [x, y, z] = offset_m.map(|metres| 1e3 * metres);
        let moved = format!(
            "moved to the pad of the {finger}: by ({x:.1}, {y:.1}, {z:.1}) mm in the hand's axes"
        );
        change(ChangeKind::Moved, 0..marker.track.len(), moved);
        let lost = |k: usize| marker.track.get(k).is_some() && hand.get(k).is_none();
        for samples in runs(0..marker.track.len(), lost) {
            let why = format!(
                "no pose of the hand is known there to place the pad of the {finger} by: removed"
            );
            change(ChangeKind::Removed, samples, why);
        }
        for k in 0..marker.track.len() {
            let Some(at) = marker.track.get(k) else {
                continue;
            };
            let turned = hand
                .get(k)
                .map(|hand| hand.isometry().rotation * Vector3::from(offset_m));
            let pad = turned.map(|turned| Position::from_coords(at.coords_m() + turned));
            if let Some(quality) = marker.quality.as_mut().filter(|_| pad.is_none()) {
                quality[k] = f64::NAN;
            }
            marker
                .track
                .set(k, pad, marker.track.status(k).and(hand.status(k)));
        }
    }
    Ok(changes)
}
