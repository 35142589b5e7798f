//! Finding what a role names.

use inhand_model::{PerFinger, PointTrack, Recording, Roles, TrackedBody, World};

use crate::error::MotionError;

/// Index of the marker of each fingertip.
///
/// # Errors
///
/// [`MotionError::NotInTake`].
pub fn fingertip_markers(take: &Recording, roles: &Roles) -> Result<PerFinger<usize>, MotionError> {
    PerFinger::try_from_fn(|finger| marker_index(take, finger.name(), &roles.fingers[finger]))
}

/// The track of the marker that `role` names.
pub(crate) fn marker_track<'a>(
    take: &'a Recording,
    role: &str,
    name: &str,
) -> Result<&'a PointTrack<World>, MotionError> {
    Ok(&take.markers[marker_index(take, role, name)?].track)
}

fn marker_index(take: &Recording, role: &str, name: &str) -> Result<usize, MotionError> {
    take.marker_index(name).ok_or_else(|| {
        let names = take.markers.iter().map(|marker| marker.name.clone());
        not_in_take(take, role, "marker", name, names.collect())
    })
}

/// The rigid body that `role` names.
pub(crate) fn body<'a>(
    take: &'a Recording,
    role: &str,
    name: &str,
) -> Result<&'a TrackedBody, MotionError> {
    take.body(name).ok_or_else(|| {
        let names = take.bodies.iter().map(|body| body.name.clone());
        not_in_take(take, role, "rigid body", name, names.collect())
    })
}

fn not_in_take(
    take: &Recording,
    role: &str,
    kind: &'static str,
    name: &str,
    available: Vec<String>,
) -> MotionError {
    MotionError::NotInTake {
        take: take.name.clone(),
        role: role.to_owned(),
        kind,
        name: name.to_owned(),
        available,
    }
}
