//! Markers on fingertips.

use std::collections::BTreeSet;

use inhand_model::{Finger, Marker, MarkerKind, PerFinger, Recording, Setting};

use super::error::{RoleError, contents, listed};
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
    let take = &recording.name;
    let mut chosen: PerFinger<Option<String>> = PerFinger::default();
    for (finger, name) in settings.fingers.iter() {
        if let Some(name) = name {
            let marker = named_marker(recording, name, &full_name(finger))?;
            if let Some((first, _)) = chosen.iter().find(|(_, c)| c.as_ref() == Some(&marker)) {
                return Err(RoleError(format!(
                    "the marker \"{marker}\" is set for both {first} and {finger} in take \"{take}\""
                )));
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
                return Err(RoleError(format!(
                    "cannot tell which marker is the {}: take \"{take}\" has {}\n  say it with   \
                     {} {finger}=\"MARKER\"   or in inhand.toml under [fingers]; markers of the \
                     same name have to be renamed in the capture software",
                    full_name(finger),
                    described(&candidates),
                    Setting::Fingers
                )));
            }
        }
    }
    if let Some(first) = missing.first() {
        let names: Vec<String> = missing.iter().copied().map(full_name).collect();
        return Err(RoleError(format!(
            "cannot tell which marker is the {} in take \"{take}\"\n  {}\n  say it with   {} \
             {first}=\"MARKER\"   or in inhand.toml under [fingers]",
            names.join(", the "),
            contents(recording),
            Setting::Fingers
        )));
    }
    Ok(chosen.map(Option::unwrap_or_default))
}

/// Labelled markers called like the finger; those that a body's fit places only where there are
/// none.
fn candidates(recording: &Recording, finger: Finger) -> Vec<&Marker> {
    let is_meant = |marker: &&Marker| words::fingertip(&marker.name) == Some(finger);
    let of_kind = |kind: MarkerKind| {
        let markers = recording
            .markers
            .iter()
            .filter(|marker| marker.kind == kind);
        markers.filter(is_meant).collect::<Vec<_>>()
    };
    match of_kind(MarkerKind::Labelled) {
        labelled if labelled.is_empty() => of_kind(MarkerKind::RigidBodyMarker),
        labelled => labelled,
    }
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
    let lower = name.to_lowercase();
    let alike = recording.markers.iter().map(|marker| marker.name.as_str());
    let alike: BTreeSet<&str> = alike
        .filter(|other| other.to_lowercase() == lower)
        .collect();
    match (alike.first(), alike.len()) {
        (Some(only), 1) => Ok((*only).to_owned()),
        _ => Err(RoleError(format!(
            "take \"{}\" has no marker \"{name}\", which is set for the {role}\n  {}",
            recording.name,
            contents(recording)
        ))),
    }
}

fn full_name(finger: Finger) -> String {
    match finger {
        Finger::Thumb => "thumb".to_owned(),
        finger => format!("{finger} finger"),
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
