//! Detectors of suspect samples. Nothing here changes a recording.
//!
//! Each kind is looked for with what is found before it out of the way: flips first, since a flipped
//! hand moves all fingers in its frame; then swaps; spikes in what swaps leave; then what unlabelled
//! markers could be, beside fingertips that are known.

pub(crate) mod flips;
mod spikes;
mod swaps;
mod unlabelled;

use std::borrow::Cow;

use inhand_model::{Finger, Recording, Roles};
use inhand_motion::{MotionError, fingertip_markers};

use crate::lookup::finger_of;
use crate::suspect::{Suspect, SuspectKind, repair};

pub use flips::flips;
pub use spikes::spikes;
pub use swaps::swaps;
pub use unlabelled::unlabelled;

/// Everything that looks wrong: flips, swaps, spikes, lost fingertips among unlabelled markers, those of
/// each kind in order of time. Without roles, what needs none: flips and spikes.
///
/// # Errors
///
/// [`MotionError`] for roles that are not in the recording.
pub fn all(recording: &Recording, roles: Option<&Roles>) -> Result<Vec<Suspect>, MotionError> {
    let flips = flips(recording);
    let found = match roles {
        Some(roles) => fingertips(recording, roles)?.concat(),
        None => spikes(recording),
    };
    Ok([flips, found].concat())
}

/// Swaps, spikes in what they leave, and lost fingertips in what both leave.
///
/// Spikes inside swapped ranges are named by the marker that holds them in the recording.
pub(crate) fn fingertips(
    recording: &Recording,
    roles: &Roles,
) -> Result<[Vec<Suspect>; 3], MotionError> {
    // A long take without suspects is not copied.
    let mut state = Cow::Borrowed(recording);
    let swaps = swaps(&state, roles)?;
    if !swaps.is_empty() {
        repair(state.to_mut(), roles, &swaps)?;
    }
    let mut spikes = spikes(&state);
    if !spikes.is_empty() {
        repair(state.to_mut(), roles, &spikes)?;
    }
    let unlabelled = unlabelled::unlabelled_of_clean_tips(&state, roles)?;
    let tips = fingertip_markers(recording, roles)?;
    for spike in &mut spikes {
        if let SuspectKind::Spike { marker, name, .. } = &mut spike.kind
            && let Some(finger) = finger_of(&tips, *marker)
        {
            *marker = tips[label_of(finger, spike.samples.start, &swaps)];
            name.clone_from(&recording.markers[*marker].name);
        }
    }
    spikes::sort(&mut spikes);
    Ok([swaps, spikes, unlabelled])
}

/// The label that carries a finger's samples at sample `k`.
fn label_of(finger: Finger, k: usize, swaps: &[Suspect]) -> Finger {
    for swap in swaps.iter().filter(|swap| swap.samples.contains(&k)) {
        if let SuspectKind::Swap { fingers } = &swap.kind
            && let Some(at) = fingers.iter().position(|&f| f == finger)
        {
            // The label before the finger in the cycle carries it.
            return fingers[(at + fingers.len() - 1) % fingers.len()];
        }
    }
    finger
}
