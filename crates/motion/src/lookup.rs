//! Finding what a role names.

use inhand_model::{Marker, Recording, TrackedBody};

use crate::error::MotionError;

/// The marker that `role` names.
pub(crate) fn marker<'a>(
    take: &'a Recording,
    role: &str,
    name: &str,
) -> Result<&'a Marker, MotionError> {
    take.marker(name).ok_or_else(|| {
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
