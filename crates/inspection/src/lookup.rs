//! The markers and bodies that roles name, and the hand's pose.

use inhand_model::{
    Body, BodySource, Finger, Hand, MarkerKind, PerFinger, PointTrack, Pose, PoseTrack, Position,
    Recording, Roles, Track, World,
};
use inhand_motion::{GapFill, fill_poses, fit_templates, fitted_bodies};

use crate::detect::flips::{breaks, without_flips};
use crate::error::CleaningError;

/// Longest time over which the hand's pose is guessed where it is missing, seconds: what is found
/// and filled in the hand's frame rests on it. A tenth of a second of a hand's motion is near a line.
const HAND_GAP_S: f64 = 0.1;

/// Index of the marker of that name, labelled ones first, as [`Recording::marker`] finds it.
pub(crate) fn marker_index(recording: &Recording, name: &str) -> Option<usize> {
    let named = || (recording.markers.iter().enumerate()).filter(|(_, m)| m.name == name);
    named()
        .find(|(_, m)| m.kind == MarkerKind::Labelled)
        .or_else(|| named().next())
        .map(|(index, _)| index)
}

/// Index of the marker of each fingertip.
pub(crate) fn tips(
    recording: &Recording,
    roles: &Roles,
) -> Result<PerFinger<usize>, CleaningError> {
    PerFinger::try_from_fn(|finger| {
        let name = &roles.fingers[finger];
        marker_index(recording, name).ok_or_else(|| CleaningError::NotInTake {
            take: recording.name.clone(),
            role: finger.name().to_owned(),
            kind: "marker",
            name: name.clone(),
        })
    })
}

/// The finger whose marker it is.
pub(crate) fn finger_of(tips: &PerFinger<usize>, marker: usize) -> Option<Finger> {
    Finger::ALL.into_iter().find(|&f| tips[f] == marker)
}

/// Whether a body that jumps to a wrong pose is taken as it is or as it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flips {
    /// As recorded: for steps that write what they compute, and were not asked to undo flips.
    Kept,
    /// Turned back, or missing: for looking at fingertips in the hand.
    SetAside,
}

/// The hand's pose at every sample; short gaps are filled by a line.
pub(crate) fn hand_poses(
    recording: &Recording,
    roles: &Roles,
    flips: Flips,
) -> Result<PoseTrack<World, Hand>, CleaningError> {
    let mut track = body_poses(recording, roles, &roles.hand, "hand", flips)?;
    let max_gap = (HAND_GAP_S * recording.clock.rate_hz()).round() as usize;
    fill_poses(&mut track, max_gap, GapFill::Linear);
    Ok(track)
}

/// Where the recorded hand jumps, from the sample before to the sample after: its frame carries nothing
/// across.
pub(crate) fn hand_breaks(recording: &Recording, roles: &Roles) -> Vec<std::ops::Range<usize>> {
    match &roles.hand {
        BodySource::RigidBody(name) => (recording.body(name))
            .map_or_else(Vec::new, |body| breaks(body, recording.clock.rate_hz())),
        BodySource::Markers(_) => Vec::new(),
    }
}

fn body_poses(
    recording: &Recording,
    roles: &Roles,
    source: &BodySource,
    role: &str,
    flips: Flips,
) -> Result<PoseTrack<World, Hand>, CleaningError> {
    let in_role = |pose: Pose<World, Body>| Pose::new(pose.isometry());
    let missing = |kind, name: &str| CleaningError::NotInTake {
        take: recording.name.clone(),
        role: role.to_owned(),
        kind,
        name: name.to_owned(),
    };
    match source {
        BodySource::RigidBody(name) => {
            let body = recording
                .body(name)
                .ok_or_else(|| missing("rigid body", name))?;
            Ok(match flips {
                Flips::Kept => body.track.map(in_role),
                Flips::SetAside => without_flips(body, recording.clock.rate_hz()).map(in_role),
            })
        }
        BodySource::Markers(names) => {
            // The hand alone: an object that no template fits must not stand in the way.
            let hand = Roles {
                object: None,
                ..roles.clone()
            };
            let templates = fit_templates([(recording, &hand)])?;
            let bodies = fitted_bodies(recording, &hand, &templates)?;
            let body =
                (bodies.first()).ok_or_else(|| missing("marker cluster", &names.join(", ")))?;
            Ok(body.track.map(in_role))
        }
    }
}

/// A marker in the hand's frame; missing where either is.
pub(crate) fn in_hand(
    world_from_hand: &PoseTrack<World, Hand>,
    marker: &PointTrack<World>,
) -> PointTrack<Hand> {
    let mut track = Track::with_capacity(marker.len());
    for k in 0..marker.len() {
        let both = world_from_hand.get(k).zip(marker.get(k));
        let status = world_from_hand.status(k).and(marker.status(k));
        track.push(
            both.map(|(pose, at): (_, Position<World>)| pose.inverse() * at),
            status,
        );
    }
    track
}
