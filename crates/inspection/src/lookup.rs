//! The hand's pose, and fingertips in its frame.

use std::ops::Range;

use inhand_model::{
    BodySource, Finger, Hand, PerFinger, PointTrack, PoseTrack, Recording, Roles, World,
};
use inhand_motion::{BodyRole, GapFill, MotionError, fill_poses, fit_templates, role_body};

use crate::detect::flips::{breaks, without_flips};

/// Longest time over which the hand's pose is guessed where it is missing, seconds: what is found
/// and filled in the hand's frame rests on it. A tenth of a second of a hand's motion is near a line.
const HAND_GAP_S: f64 = 0.1;

/// The finger whose marker it is.
pub(crate) fn finger_of(tips: &PerFinger<usize>, marker: usize) -> Option<Finger> {
    Finger::ALL.into_iter().find(|&f| tips[f] == marker)
}

/// Whether a marker is called after a body: `Body:...` or `Body_1`, but not `Body_Thumb`.
pub(crate) fn is_named_after(marker: &str, body: &str) -> bool {
    let Some(rest) = marker.strip_prefix(body) else {
        return false;
    };
    let number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    rest.starts_with(':') || rest.strip_prefix('_').is_some_and(number)
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
) -> Result<PoseTrack<World, Hand>, MotionError> {
    let rate_hz = recording.clock.rate_hz();
    // The hand alone: an object that no template fits must not stand in the way.
    let hand = Roles {
        object: None,
        ..roles.clone()
    };
    let templates = fit_templates([(recording, &hand)])?;
    let body = role_body(recording, BodyRole::Hand, &hand.hand, &templates)?;
    let mut track = match (&hand.hand, flips) {
        (BodySource::RigidBody(_), Flips::SetAside) => without_flips(&body, rate_hz).in_role(),
        _ => body.track.clone().in_role(),
    };
    let max_gap = (HAND_GAP_S * rate_hz).round() as usize;
    fill_poses(&mut track, max_gap, GapFill::Linear);
    Ok(track)
}

/// Where the recorded hand jumps, from the sample before to the sample after: its frame carries nothing
/// across.
pub(crate) fn hand_breaks(recording: &Recording, roles: &Roles) -> Vec<Range<usize>> {
    match &roles.hand {
        BodySource::RigidBody(name) => (recording.body(name))
            .map_or_else(Vec::new, |body| breaks(body, recording.clock.rate_hz())),
        BodySource::Markers(_) => Vec::new(),
    }
}

/// A marker in the hand's frame; missing where either is.
pub(crate) fn in_hand(
    hand_from_world: &PoseTrack<Hand, World>,
    marker: &PointTrack<World>,
) -> PointTrack<Hand> {
    inhand_motion::in_hand(hand_from_world, marker, |pose, at| pose * at)
}
