//! Sources of the poses of hand and object.

use inhand_model::{BodyKind, BodySource, MarkerKind, PerFinger, Recording, Setting};

use super::error::{RoleError, body_names, listed, marker_names};
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
    found(recording, "hand", Setting::Hand, fingers, words::is_hand)?.ok_or_else(|| {
        RoleError::NoHand {
            take: recording.name.clone(),
            bodies: body_names(recording),
            markers: marker_names(recording),
        }
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
        (Some(_), true) => return Err(RoleError::ObjectDenied),
        (None, true) => None,
        (Some(choice), false) => Some(chosen(recording, choice, "object", fingers)?),
        (None, false) => found(
            recording,
            "object",
            Setting::Object,
            fingers,
            words::is_object,
        )?,
    };
    let shared = match (hand, &object) {
        (BodySource::RigidBody(a), Some(BodySource::RigidBody(b))) if a == b => Some(a),
        (BodySource::Markers(a), Some(BodySource::Markers(b))) => a.iter().find(|m| b.contains(m)),
        _ => None,
    };
    match shared {
        Some(name) => Err(RoleError::SharedBody {
            take: recording.name.clone(),
            name: name.clone(),
        }),
        None => Ok(object),
    }
}

fn chosen(
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
                return Err(RoleError::SmallCluster {
                    role,
                    found: markers.len(),
                });
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
            let markers = clusters(recording, fingers, same)
                .into_iter()
                .flat_map(|(_, markers)| markers)
                .collect::<Vec<_>>();
            if markers.len() >= CLUSTER_MARKERS {
                return Ok(BodySource::Markers(markers));
            }
            Err(RoleError::NoSuchBody {
                take: recording.name.clone(),
                role,
                name: name.clone(),
                bodies: body_names(recording),
                markers: marker_names(recording),
            })
        }
    }
}

/// The only rigid body of such a name, else the only bone, else the only cluster; none where there
/// is none.
fn found(
    recording: &Recording,
    role: &'static str,
    option: Setting,
    fingers: &PerFinger<String>,
    is_meant: fn(&str) -> bool,
) -> Result<Option<BodySource>, RoleError> {
    let ambiguous = |candidates: Vec<String>| {
        Err(RoleError::AmbiguousBody {
            take: recording.name.clone(),
            role,
            candidates: listed(candidates.iter().map(String::as_str)),
            option,
        })
    };
    for kind in [BodyKind::RigidBody, BodyKind::Bone] {
        let candidates: Vec<_> = recording
            .bodies
            .iter()
            .filter(|body| body.kind == kind && is_meant(&body.name))
            .collect();
        match candidates[..] {
            [] => {}
            [body] => return Ok(Some(BodySource::RigidBody(body.name.clone()))),
            _ => {
                return ambiguous(
                    candidates
                        .iter()
                        .map(|body| format!("the body \"{}\" (ID {})", body.name, body.id))
                        .collect(),
                );
            }
        }
    }
    let mut clusters = clusters(recording, fingers, is_meant);
    clusters.retain(|(_, markers)| markers.len() >= CLUSTER_MARKERS);
    if clusters.len() > 1 {
        return ambiguous(
            clusters
                .iter()
                .map(|(shared, markers)| format!("the markers {shared} ({})", markers.join(", ")))
                .collect(),
        );
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
