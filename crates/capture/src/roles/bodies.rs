//! Sources of the poses of hand and object.

use inhand_model::{BodyKind, BodySource, MarkerKind, PerFinger, Recording, Setting, TrackedBody};

use super::error::{RoleError, contents, listed};
use super::fingers::named_marker;
use super::{BodyChoice, RoleSettings, words};

/// Markers that a pose needs.
const CLUSTER_MARKERS: usize = 3;

/// The hand: as the user says, else the only thing called hand.
pub(super) fn hand(
    recording: &Recording,
    settings: &RoleSettings,
    fingers: &PerFinger<String>,
) -> Result<BodySource, RoleError> {
    if let Some(choice) = &settings.hand {
        return chosen(recording, choice, "hand", fingers);
    }
    let hand = named_by_role(recording, "hand", Setting::Hand, fingers, words::is_hand)?;
    hand.ok_or_else(|| {
        RoleError(format!(
            "cannot tell what the hand is: take \"{}\" has no rigid body and no three markers \
             called hand\n  {}\n  say it with   {hand} \"BODY\"   or   {hand} \
             \"MARKER,MARKER,MARKER\"   or in inhand.toml",
            recording.name,
            contents(recording),
            hand = Setting::Hand
        ))
    })
}

/// The object: as the user says, else the only thing plainly called one, else none.
pub(super) fn object(
    recording: &Recording,
    settings: &RoleSettings,
    fingers: &PerFinger<String>,
    hand: &BodySource,
) -> Result<Option<BodySource>, RoleError> {
    let object = match (&settings.object, settings.no_object) {
        (Some(_), true) => {
            let message = "an object is set and at the same time that there is none: leave one of \
                           both out";
            return Err(RoleError(message.to_owned()));
        }
        (None, true) => None,
        (Some(choice), false) => Some(chosen(recording, choice, "object", fingers)?),
        (None, false) => {
            let is_object = words::is_object;
            named_by_role(recording, "object", Setting::Object, fingers, is_object)?
        }
    };
    let shared = match (hand, &object) {
        (BodySource::RigidBody(a), Some(BodySource::RigidBody(b))) if a == b => Some(a),
        (BodySource::Markers(a), Some(BodySource::Markers(b))) => a.iter().find(|m| b.contains(m)),
        _ => None,
    };
    match shared {
        Some(name) => Err(RoleError(format!(
            "\"{name}\" is set as part of both hand and object in take \"{}\"",
            recording.name
        ))),
        None => Ok(object),
    }
}

pub(super) fn chosen(
    recording: &Recording,
    choice: &BodyChoice,
    role: &'static str,
    fingers: &PerFinger<String>,
) -> Result<BodySource, RoleError> {
    match choice {
        BodyChoice::Markers(names) => {
            let mut markers = Vec::with_capacity(names.len());
            for name in names {
                let marker = named_marker(recording, name, role)?;
                if !markers.contains(&marker) {
                    markers.push(marker);
                }
            }
            if markers.len() < CLUSTER_MARKERS {
                return Err(RoleError(format!(
                    "the {role} is set to {} different markers: expected three or more, as a pose \
                     needs",
                    markers.len()
                )));
            }
            Ok(BodySource::Markers(markers))
        }
        BodyChoice::Named(name) => {
            if recording.body(name).is_some() {
                return Ok(BodySource::RigidBody(name.clone()));
            }
            let lower = name.to_lowercase();
            let same = |other: &str| other.to_lowercase() == lower;
            let mut alike = recording.bodies.iter().filter(|body| same(&body.name));
            if let (Some(body), None) = (alike.next(), alike.next()) {
                return Ok(BodySource::RigidBody(body.name.clone()));
            }
            let clusters = clusters(recording, fingers, same).into_iter();
            let markers: Vec<_> = clusters.flat_map(|(_, markers)| markers).collect();
            if markers.len() >= CLUSTER_MARKERS {
                return Ok(BodySource::Markers(markers));
            }
            Err(RoleError(format!(
                "take \"{}\" has no rigid body \"{name}\", which is set for the {role}, and no \
                 three markers whose names start with it\n  {}",
                recording.name,
                contents(recording)
            )))
        }
    }
}

/// The only rigid body of such a name, else the only bone, else the only cluster; none where there
/// is none.
fn named_by_role(
    recording: &Recording,
    role: &'static str,
    option: Setting,
    fingers: &PerFinger<String>,
    is_meant: fn(&str) -> bool,
) -> Result<Option<BodySource>, RoleError> {
    let ambiguous = |candidates: Vec<String>| {
        Err(RoleError(format!(
            "cannot tell which is the {role}: take \"{}\" has {}\n  say it with   {option} \
             \"NAME\"   or in inhand.toml",
            recording.name,
            listed(candidates.iter().map(String::as_str))
        )))
    };
    for kind in [BodyKind::RigidBody, BodyKind::Bone] {
        let candidates = recording.bodies.iter();
        let candidates = candidates.filter(|body| body.kind == kind && is_meant(&body.name));
        let candidates: Vec<_> = candidates.collect();
        match candidates[..] {
            [] => {}
            [body] => return Ok(Some(BodySource::RigidBody(body.name.clone()))),
            _ => {
                let described =
                    |body: &&TrackedBody| format!("the body \"{}\" (ID {})", body.name, body.id);
                return ambiguous(candidates.iter().map(described).collect());
            }
        }
    }
    let mut clusters = clusters(recording, fingers, is_meant);
    clusters.retain(|(_, markers)| markers.len() >= CLUSTER_MARKERS);
    if clusters.len() > 1 {
        let described = |(shared, markers): &(String, Vec<String>)| {
            format!("the markers {shared} ({})", markers.join(", "))
        };
        return ambiguous(clusters.iter().map(described).collect());
    }
    Ok(clusters
        .pop()
        .map(|(_, markers)| BodySource::Markers(markers)))
}

/// Markers by the part of the name that they share, in the order of the take, each name once.
/// Labelled markers only, where any cluster has them; never those of a finger.
fn clusters(
    recording: &Recording,
    fingers: &PerFinger<String>,
    is_meant: impl Fn(&str) -> bool,
) -> Vec<(String, Vec<String>)> {
    for kind in [MarkerKind::Labelled, MarkerKind::RigidBodyMarker] {
        let mut clusters: Vec<(String, Vec<String>)> = Vec::new();
        for marker in recording.markers.iter().filter(|m| m.kind == kind) {
            let shared = words::cluster(&marker.name);
            let of_finger = words::speaks_of_a_finger(&marker.name)
                || fingers.as_array().contains(&marker.name);
            if shared.is_empty() || of_finger || !is_meant(shared) {
                continue;
            }
            match clusters.iter_mut().find(|(known, _)| known == shared) {
                Some((_, markers)) if markers.contains(&marker.name) => {}
                Some((_, markers)) => markers.push(marker.name.clone()),
                None => clusters.push((shared.to_owned(), vec![marker.name.clone()])),
            }
        }
        if !clusters.is_empty() {
            return clusters;
        }
    }
    Vec::new()
}
