//! Undoing what was found. Each function changes a recording as findings suggest and says what it
//! did.

use std::ops::Range;

use inhand_model::{Change, ChangeKind, Frame, PointTrack, Recording, Roles, Status};

use crate::detect::flips::undo;
use crate::detect::{Flip, FlipRepair, Spike, Swap, Unlabelled};
use crate::error::CleaningError;
use crate::lookup::tips;

/// Turns flipped bodies back, or takes their poses away where the way back is not known. Markers of a
/// rigid body that the recording places by its pose ([`inhand_model::MarkerKind::RigidBodyMarker`]) stay as they
/// are.
pub fn flips(recording: &mut Recording, flips: &[Flip]) -> Vec<Change> {
    let mut changes = Vec::new();
    for flip in flips {
        let body = &mut recording.bodies[flip.body];
        undo(&mut body.track, flip);
        let (kind, done) = match &flip.repair {
            FlipRepair::TurnBack(_) => (ChangeKind::TurnedBack, "turned back"),
            FlipRepair::Remove => (ChangeKind::Removed, "taken away"),
        };
        // The error was that of the wrong solution.
        if let Some(error_m) = &mut body.marker_error_m {
            error_m[flip.samples.clone()].fill(f64::NAN);
        }
        changes.push(Change {
            kind,
            entity: flip.name.clone(),
            samples: flip.samples.clone(),
            message: format!("{flip}: {done}"),
        });
    }
    changes
}

/// Gives exchanged labels back to their fingers.
///
/// # Errors
///
/// [`CleaningError::NotInTake`].
pub fn swaps(
    recording: &mut Recording,
    roles: &Roles,
    swaps: &[Swap],
) -> Result<Vec<Change>, CleaningError> {
    let tips = tips(recording, roles)?;
    let mut changes = Vec::new();
    for swap in swaps {
        for k in swap.samples.clone() {
            let seen: Vec<_> = (swap.fingers.iter())
                .map(|&label| {
                    let marker = &recording.markers[tips[label]];
                    let quality = marker.quality.as_ref().map_or(f64::NAN, |q| q[k]);
                    (marker.track.get(k), marker.track.status(k), quality)
                })
                .collect();
            for (i, (value, status, quality)) in seen.into_iter().enumerate() {
                // Label i carries the samples of the next finger of the cycle.
                let finger = swap.fingers[(i + 1) % swap.fingers.len()];
                let marker = &mut recording.markers[tips[finger]];
                marker.track.set(k, value, status);
                if let Some(qualities) = &mut marker.quality {
                    qualities[k] = quality;
                }
            }
        }
        let names: Vec<_> = (swap.fingers.iter())
            .map(|&finger| recording.markers[tips[finger]].name.as_str())
            .collect();
        changes.push(Change {
            kind: ChangeKind::Swapped,
            entity: names.join(", "),
            samples: swap.samples.clone(),
            message: format!("{swap}: exchanged back"),
        });
    }
    Ok(changes)
}

/// Takes spikes away: their samples are missing then.
pub fn spikes(recording: &mut Recording, spikes: &[Spike]) -> Vec<Change> {
    let mut changes = Vec::new();
    for spike in spikes {
        let marker = &mut recording.markers[spike.marker];
        for k in spike.samples.clone() {
            marker.track.set(k, None, Status::Missing);
            if let Some(quality) = &mut marker.quality {
                quality[k] = f64::NAN;
            }
        }
        changes.push(Change {
            kind: ChangeKind::Removed,
            entity: marker.name.clone(),
            samples: spike.samples.clone(),
            message: format!("{spike}: taken away"),
        });
    }
    changes
}

/// Gives the samples of unlabelled markers to the fingertips that they are; the unlabelled markers lose
/// them. Their status stays: they were measured.
///
/// # Errors
///
/// [`CleaningError::NotInTake`].
pub fn stitch(
    recording: &mut Recording,
    roles: &Roles,
    pieces: &[Unlabelled],
) -> Result<Vec<Change>, CleaningError> {
    let tips = tips(recording, roles)?;
    let mut changes = Vec::new();
    for piece in pieces {
        let source = &mut recording.markers[piece.marker];
        let (track, quality) = (source.track.clone(), source.quality.clone());
        for k in piece.samples.clone() {
            source.track.set(k, None, Status::Missing);
            if let Some(own) = &mut source.quality {
                own[k] = f64::NAN;
            }
        }
        let target = &mut recording.markers[tips[piece.finger]];
        take_over(&mut target.track, &track, &piece.samples);
        if let Some(own) = &mut target.quality {
            for k in piece.samples.clone() {
                own[k] = quality.as_ref().map_or(f64::NAN, |quality| quality[k]);
            }
        }
        changes.push(Change {
            kind: ChangeKind::Stitched,
            entity: target.name.clone(),
            samples: piece.samples.clone(),
            message: format!("{piece}: its samples are the fingertip's now"),
        });
    }
    Ok(changes)
}

/// Puts the present samples of one track into the same places of another.
pub(crate) fn take_over<F: Frame>(
    to: &mut PointTrack<F>,
    from: &PointTrack<F>,
    samples: &Range<usize>,
) {
    for k in samples.clone() {
        if let Some(value) = from.get(k) {
            to.set(k, Some(value), from.status(k));
        }
    }
}
