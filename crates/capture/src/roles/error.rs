//! Errors of assigning roles to the markers and bodies of a take.

use std::collections::BTreeSet;

use inhand_model::{Marker, MarkerKind, Recording};
use thiserror::Error;

/// Unlabelled markers listed before the rest is only counted: a take may have thousands.
const UNLABELLED: usize = 40;

/// Reasons why the roles of a take stay open: what is undetermined, what the take has, and how to set it.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct RoleError(pub(super) String);

/// The bodies and markers of a take, each once, markers without label last.
pub(super) fn contents(recording: &Recording) -> String {
    let is_unlabelled = |marker: &&Marker| marker.kind == MarkerKind::Unlabelled;
    let (unlabelled, labelled): (Vec<_>, Vec<_>) =
        recording.markers.iter().partition(is_unlabelled);
    let more = unlabelled.len().saturating_sub(UNLABELLED);
    let markers = labelled
        .into_iter()
        .chain(unlabelled.into_iter().take(UNLABELLED));
    let more = match more {
        0 => String::new(),
        more => format!(" and {more} more without label"),
    };
    format!(
        "it has the bodies: {}\n  and the markers: {}{more}",
        listed(recording.bodies.iter().map(|body| body.name.as_str())),
        listed(markers.map(|marker| marker.name.as_str())),
    )
}

/// Different names in their order.
pub(super) fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut seen = BTreeSet::new();
    let names: Vec<&str> = names.filter(|name| seen.insert(*name)).collect();
    match names.is_empty() {
        true => "none".to_owned(),
        false => names.join(", "),
    }
}
