//! Repair of suspect samples.

use std::ops::Range;

use inhand_model::{Change, ChangeKind, Frame, Marker, PointTrack, Recording, Roles, Status};
use inhand_motion::{MotionError, fingertip_markers};

use crate::suspect::{FlipRepair, Suspect, SuspectKind};

/// Repairs a recording as suspects suggest, one after the other, and lists what was done.
///
/// * Flipped bodies are turned back, or lose their poses where the way back is not known. Markers of a
///   rigid body that the recording places by its pose
///   ([`inhand_model::MarkerKind::RigidBodyMarker`]) stay as they are.
/// * Exchanged labels are given back to their fingers.
/// * Spikes are removed: their samples are missing then.
/// * Samples of unlabelled markers are given to the fingertips that they are; the unlabelled markers lose
///   them. Their status stays: they were measured.
///
/// # Errors
///
/// [`MotionError`] where a fingertip of the roles is not in the recording.
pub fn repair(
    recording: &mut Recording,
    roles: &Roles,
    suspects: &[Suspect],
) -> Result<Vec<Change>, MotionError> {
    let mut changes = Vec::with_capacity(suspects.len());
    for suspect in suspects {
        let (kind, entity, done) = undo(recording, roles, suspect)?;
        changes.push(Change {
            kind,
            entity,
            samples: suspect.samples.clone(),
            message: format!("{suspect}: {done}"),
        });
    }
    Ok(changes)
}

/// Does what a suspect suggests; the kind of change, what was changed, and what was done in words.
fn undo(
    recording: &mut Recording,
    roles: &Roles,
    suspect: &Suspect,
) -> Result<(ChangeKind, String, &'static str), MotionError> {
    let samples = &suspect.samples;
    Ok(match &suspect.kind {
        SuspectKind::Flip {
            body, name, repair, ..
        } => {
            let body = &mut recording.bodies[*body];
            repair.apply(&mut body.track, samples);
            // The error was that of the wrong solution.
            if let Some(error_m) = &mut body.marker_error_m {
                error_m[samples.clone()].fill(f64::NAN);
            }
            let (kind, done) = match repair {
                FlipRepair::TurnBack(_) => (ChangeKind::TurnedBack, "turned back"),
                FlipRepair::Remove => (ChangeKind::Removed, "removed"),
            };
            (kind, name.clone(), done)
        }
        SuspectKind::Swap { fingers } => {
            let tips = fingertip_markers(recording, roles)?;
            let labels: Vec<usize> = fingers.iter().map(|&finger| tips[finger]).collect();
            let markers = &mut recording.markers;
            for k in samples.clone() {
                // Each label carries the samples of the next finger of the cycle.
                let sample = |&label: &usize| {
                    let Marker { track, .. } = &markers[label];
                    (track.get(k), track.status(k), quality(&markers[label], k))
                };
                let mut carried: Vec<_> = labels.iter().map(sample).collect();
                carried.rotate_right(1);
                for (&label, (value, status, quality)) in labels.iter().zip(carried) {
                    markers[label].track.set(k, value, status);
                    set_quality(&mut markers[label], k, quality);
                }
            }
            let names: Vec<_> = labels
                .iter()
                .map(|&label| markers[label].name.as_str())
                .collect();
            (ChangeKind::Swapped, names.join(", "), "exchanged back")
        }
        SuspectKind::Spike { marker, .. } => {
            let marker = &mut recording.markers[*marker];
            remove(marker, samples);
            (ChangeKind::Removed, marker.name.clone(), "removed")
        }
        SuspectKind::Unlabelled { marker, finger, .. } => {
            let tip = fingertip_markers(recording, roles)?[*finger];
            let source = recording.markers[*marker].clone();
            remove(&mut recording.markers[*marker], samples);
            let target = &mut recording.markers[tip];
            take_over(&mut target.track, &source.track, samples);
            for k in samples.clone() {
                set_quality(target, k, quality(&source, k));
            }
            let done = "its samples are the fingertip's now";
            (ChangeKind::Stitched, target.name.clone(), done)
        }
    })
}

fn remove(marker: &mut Marker, samples: &Range<usize>) {
    for k in samples.clone() {
        marker.track.set(k, None, Status::Missing);
        set_quality(marker, k, f64::NAN);
    }
}

fn quality(marker: &Marker, k: usize) -> f64 {
    marker
        .quality
        .as_ref()
        .map_or(f64::NAN, |quality| quality[k])
}

fn set_quality(marker: &mut Marker, k: usize, value: f64) {
    if let Some(quality) = &mut marker.quality {
        quality[k] = value;
    }
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
