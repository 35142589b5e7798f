//! Errors of assigning roles to the markers and bodies of a take.

use inhand_model::{Finger, MarkerKind, Recording, Setting};
use thiserror::Error;

/// Names listed before the rest is only counted.
const LISTED: usize = 40;

/// Why the roles of a take stay open.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RoleError {
    /// No marker is called like these fingers.
    #[error(
        "cannot tell which marker is the {}\n  take \"{take}\" has the markers: {markers}\n  say \
         it with   {} {}=\"MARKER\"   or in inhand.toml under [fingers]",
        finger_names(.fingers), Setting::Fingers, .fingers.first().map_or("thumb", |finger| finger.name())
    )]
    NoFingertip {
        /// The take.
        take: String,
        /// The fingers without marker.
        fingers: Vec<Finger>,
        /// The markers it has.
        markers: String,
    },
    /// More than one marker is called like a finger.
    #[error(
        "cannot tell which marker is the {finger}{}: take \"{take}\" has {candidates}\n  say it \
         with   {} {finger}=\"MARKER\"   or in inhand.toml under [fingers]; markers of the \
         same name have to be renamed in the capture software",
        if *.finger == Finger::Thumb { "" } else { " finger" }, Setting::Fingers
    )]
    AmbiguousFingertip {
        /// The take.
        take: String,
        /// The finger.
        finger: Finger,
        /// The markers that could be meant.
        candidates: String,
    },
    /// One marker was given to two fingers.
    #[error("the marker \"{marker}\" is set for both {first} and {second} in take \"{take}\"")]
    SharedFingertip {
        /// The take.
        take: String,
        /// The marker.
        marker: String,
        /// A finger.
        first: Finger,
        /// Another one.
        second: Finger,
    },
    /// The user names a marker that the take does not have.
    #[error(
        "take \"{take}\" has no marker \"{name}\", which is set for the {role}\n  it has the \
         markers: {markers}"
    )]
    NoSuchMarker {
        /// The take.
        take: String,
        /// The role it was named for.
        role: String,
        /// The name.
        name: String,
        /// The markers it has.
        markers: String,
    },
    /// The user names a body that the take does not have, nor markers that start with the name.
    #[error(
        "take \"{take}\" has no rigid body \"{name}\", which is set for the {role}, and no three \
         markers whose names start with it\n  it has the bodies: {bodies}\n  and the markers: \
         {markers}"
    )]
    NoSuchBody {
        /// The take.
        take: String,
        /// `hand` or `object`.
        role: &'static str,
        /// The name.
        name: String,
        /// The bodies it has.
        bodies: String,
        /// The markers it has.
        markers: String,
    },
    /// A cluster with too few markers.
    #[error(
        "the {role} is set to {found} different markers: expected three or more, as a pose needs"
    )]
    SmallCluster {
        /// `hand` or `object`.
        role: &'static str,
        /// Different markers named.
        found: usize,
    },
    /// Nothing in the take is called hand.
    #[error(
        "cannot tell what the hand is: take \"{take}\" has no rigid body and no three markers \
         called hand\n  it has the bodies: {bodies}\n  and the markers: {markers}\n  say it with   \
         {hand} \"BODY\"   or   {hand} \"MARKER,MARKER,MARKER\"   or in inhand.toml",
        hand = Setting::Hand
    )]
    NoHand {
        /// The take.
        take: String,
        /// The bodies it has.
        bodies: String,
        /// The markers it has.
        markers: String,
    },
    /// More than one thing is called like the role.
    #[error(
        "cannot tell which is the {role}: take \"{take}\" has {candidates}\n  say it with   \
         {option} \"NAME\"   or in inhand.toml"
    )]
    AmbiguousBody {
        /// The take.
        take: String,
        /// `hand` or `object`.
        role: &'static str,
        /// The bodies or clusters that could be meant.
        candidates: String,
        /// The setting that decides.
        option: Setting,
    },
    /// Hand and object are the same body, or share markers.
    #[error("\"{name}\" is set as part of both hand and object in take \"{take}\"")]
    SharedBody {
        /// The take.
        take: String,
        /// The body or marker.
        name: String,
    },
    /// An object is named and denied at once.
    #[error("an object is set and at the same time that there is none: leave one of both out")]
    ObjectDenied,
}

fn finger_names(fingers: &[Finger]) -> String {
    let names: Vec<String> = fingers
        .iter()
        .map(|&finger| match finger {
            Finger::Thumb => "thumb".to_owned(),
            finger => format!("{finger} finger"),
        })
        .collect();
    names.join(", the ")
}

/// Names of the take's markers, each once, those without label last.
pub(super) fn marker_names(recording: &Recording) -> String {
    let (unlabelled, named): (Vec<_>, Vec<_>) = recording
        .markers
        .iter()
        .partition(|marker| marker.kind == MarkerKind::Unlabelled);
    listed(
        named
            .into_iter()
            .chain(unlabelled)
            .map(|marker| marker.name.as_str()),
    )
}

/// Names of the take's bodies.
pub(super) fn body_names(recording: &Recording) -> String {
    listed(recording.bodies.iter().map(|body| body.name.as_str()))
}

/// Different names in their order, as a list that stays readable.
pub(super) fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut seen = std::collections::BTreeSet::new();
    let names: Vec<&str> = names.filter(|name| seen.insert(*name)).collect();
    if names.is_empty() {
        return "none".to_owned();
    }
    let mut list = names[..names.len().min(LISTED)].join(", ");
    if names.len() > LISTED {
        list.push_str(&format!(" and {} more", names.len() - LISTED));
    }
    list
}
