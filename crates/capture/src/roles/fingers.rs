//! Markers on fingertips.

use inhand_model::{Finger, Marker, MarkerKind, PerFinger, Recording};

use super::error::{RoleError, listed, marker_names};
use super::{RoleSettings, words};

/// The marker on each fingertip, by name: as the user says, else the only one called like the
/// finger.
///
/// # Errors
///
/// [`RoleError`] where a finger has no marker or more than one, where one marker is set for two
/// fingers, and where the user names a marker that is not there.
pub fn fingertips(
    recording: &Recording,
    settings: &RoleSettings,
) -> Result<PerFinger<String>, RoleError> {
    let mut chosen: PerFinger<Option<String>> = PerFinger::default();
    for (finger, name) in settings.fingers.iter() {
        if let Some(name) = name {
            let marker = named_marker(recording, name, &finger.to_string())?;
            if let Some((first, _)) = chosen.iter().find(|(_, c)| c.as_ref() == Some(&marker)) {
                return Err(RoleError::SharedFingertip {
                    take: recording.name.clone(),
                    marker,
                    first,
                    second: finger,
                });
            }
            chosen[finger] = Some(marker);
        }
    }

    let mut missing = Vec::new();
    for finger in Finger::ALL {
        if chosen[finger].is_some() {
            continue;
        }
        let mut candidates = candidates(recording, finger);
        // What the user gave to another finger is not free.
        candidates.retain(|marker| chosen.iter().all(|(_, c)| c.as_ref() != Some(&marker.name)));
        match candidates[..] {
            [] => missing.push(finger),
            [marker] => chosen[finger] = Some(marker.name.clone()),
            _ => {
                return Err(RoleError::AmbiguousFingertip {
                    take: recording.name.clone(),
                    finger,
                    candidates: described(&candidates),
                });
            }
        }
    }
    if !missing.is_empty() {
        return Err(RoleError::NoFingertip {
            take: recording.name.clone(),
            fingers: missing,
            markers: marker_names(recording),
        });
    }
    Ok(chosen.map(Option::unwrap_or_default))
}

/// Labelled markers called like the finger; those that a body's fit places only where there are
/// none.
fn candidates(recording: &Recording, finger: Finger) -> Vec<&Marker> {
    [MarkerKind::Labelled, MarkerKind::RigidBodyMarker]
        .into_iter()
        .map(|kind| {
            recording
                .markers
                .iter()
                .filter(|marker| {
                    marker.kind == kind && words::fingertip(&marker.name) == Some(finger)
                })
                .collect::<Vec<_>>()
        })
        .find(|candidates| !candidates.is_empty())
        .unwrap_or_default()
}

/// The marker that a user names: exactly so, or the only one that differs in case alone.
pub(super) fn named_marker(
    recording: &Recording,
    name: &str,
    role: &str,
) -> Result<String, RoleError> {
    if recording.marker(name).is_some() {
        return Ok(name.to_owned());
    }
    let mut alike: Vec<&str> = recording
        .markers
        .iter()
        .map(|marker| marker.name.as_str())
        .filter(|other| other.to_lowercase() == name.to_lowercase())
        .collect();
    alike.sort_unstable();
    alike.dedup();
    match alike[..] {
        [only] => Ok(only.to_owned()),
        _ => Err(RoleError::NoSuchMarker {
            take: recording.name.clone(),
            role: role.to_owned(),
            name: name.to_owned(),
            markers: marker_names(recording),
        }),
    }
}

fn described(candidates: &[&Marker]) -> String {
    let names: Vec<String> = candidates
        .iter()
        .map(|marker| match marker.id.as_str() {
            "" => format!("\"{}\"", marker.name),
            id => format!("\"{}\" (ID {id})", marker.name),
        })
        .collect();
    listed(names.iter().map(String::as_str))
}
