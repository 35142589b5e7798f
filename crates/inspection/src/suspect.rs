//! Suspect samples: what detectors find, and their repair.

use std::fmt;
use std::ops::Range;

use inhand_model::{
    Change, ChangeKind, Finger, Frame, Marker, PointTrack, Recording, Roles, Status,
};
use inhand_motion::{MotionError, fingertip_markers};
use nalgebra::Isometry3;

/// Samples that look wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspect {
    /// What looks wrong about them.
    pub kind: SuspectKind,
    /// The samples.
    pub samples: Range<usize>,
    /// How sure the detector is, 1 or more: how many times its threshold the samples reach. For a swap
    /// 0 or more: the natural logarithm of how much more likely the take is with the labels exchanged
    /// back; 10 is near certain.
    pub score: f64,
}

/// What looks wrong, and with what.
#[derive(Clone, Debug, PartialEq)]
pub enum SuspectKind {
    /// A body whose pose jumps to a wrong solution of its fit.
    Flip {
        /// Index of the body in the recording.
        body: usize,
        /// Name of the body.
        name: String,
        /// By how much its orientation jumps, radians.
        turn_rad: f64,
        /// What to do about it.
        repair: FlipRepair,
    },
    /// Fingertip labels that have changed places. The suggested repair is to exchange them back.
    Swap {
        /// The fingers, two or a longer cycle: the label of each carries the samples of the next, the last
        /// label those of the first.
        fingers: Vec<Finger>,
    },
    /// A marker that is off its path for a few samples and comes back to it. The suggested repair is to
    /// remove the samples.
    Spike {
        /// Index of the marker in the recording.
        marker: usize,
        /// Name of the marker.
        name: String,
        /// How far at most, metres, from the path through the samples beside them.
        off_m: f64,
    },
    /// A piece of an unlabelled marker that goes on where a fingertip is lost. The suggested repair is to
    /// give the fingertip the samples.
    Unlabelled {
        /// Index of the unlabelled marker in the recording.
        marker: usize,
        /// Name of that marker.
        name: String,
        /// The finger that it is.
        finger: Finger,
    },
}

/// What to do about a body in a wrong pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlipRepair {
    /// It comes back by the way it went, so that its true pose is known: the recorded pose times the
    /// inverse of this transform from the body recorded to the true body.
    TurnBack(Isometry3<f64>),
    /// It does not come back by that way: the samples are better removed.
    Remove,
}

impl SuspectKind {
    /// Identifier of its check results: `flips`, `swaps`, `spikes` or `unlabelled-stretches`.
    pub const fn id(&self) -> &'static str {
        match self {
            SuspectKind::Flip { .. } => "flips",
            SuspectKind::Swap { .. } => "swaps",
            SuspectKind::Spike { .. } => "spikes",
            SuspectKind::Unlabelled { .. } => "unlabelled-stretches",
        }
    }

    /// The marker, body or finger; for a swap all of them, such as `index and middle`.
    pub fn entity(&self) -> String {
        match self {
            SuspectKind::Flip { name, .. } | SuspectKind::Spike { name, .. } => name.clone(),
            SuspectKind::Swap { fingers } => {
                let names: Vec<_> = fingers.iter().map(|finger| finger.name()).collect();
                names.join(" and ")
            }
            SuspectKind::Unlabelled { finger, .. } => finger.name().to_owned(),
        }
    }
}

impl fmt::Display for Suspect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let entity = self.kind.entity();
        match &self.kind {
            SuspectKind::Flip {
                turn_rad, repair, ..
            } => {
                let back = match repair {
                    FlipRepair::TurnBack(_) => "and back",
                    FlipRepair::Remove => "and does not come back that way",
                };
                write!(
                    f,
                    "{entity} jumps by {:.0} degrees {back}",
                    turn_rad.to_degrees()
                )
            }
            SuspectKind::Swap { .. } => write!(f, "{entity} look swapped"),
            SuspectKind::Spike { off_m, .. } => {
                let samples = self.samples.len();
                let plural = if samples == 1 { "" } else { "s" };
                let off_mm = off_m * 1e3;
                write!(
                    f,
                    "{entity} is {off_mm:.1} mm off its path for {samples} sample{plural}"
                )
            }
            SuspectKind::Unlabelled { name, .. } => {
                write!(f, "{name} goes on where {entity} is lost")
            }
        }
    }
}

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
