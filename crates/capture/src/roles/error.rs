//! Errors of assigning roles to the markers and bodies of a take.

use inhand_model::{MarkerKind, Recording};
use thiserror::Error;

/// Names listed before the rest is only counted.
const LISTED: usize = 40;

/// Reasons why the roles of a take stay open: what is undetermined, what the take has, and how to set it.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct RoleError(pub(super) String);

/// Names of the take's markers, each once, those without label last.
pub(super) fn marker_names(recording: &Recording) -> String {
    let mut markers: Vec<_> = recording.markers.iter().collect();
    markers.sort_by_key(|marker| marker.kind == MarkerKind::Unlabelled);
    listed(markers.iter().map(|marker| marker.name.as_str()))
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
