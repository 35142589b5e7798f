//! Sessions of the same participant, object and task together.

use std::collections::BTreeMap;

use inhand_model::{Finger, GroupSummary, HandAndFingers, Protocol, Statistics};
use inhand_statistics::bootstrap::ClusteredRows;
use inhand_statistics::quantiles::sorted_statistics;

use super::part::Part;

/// Participant, object, task.
type Kind = (Option<String>, Option<String>, Option<String>);

/// Which sessions belong together.
pub(super) struct Groups(BTreeMap<Kind, Vec<usize>>);

impl Groups {
    pub(super) fn new(parts: &[Part]) -> Self {
        let mut groups: BTreeMap<Kind, Vec<usize>> = BTreeMap::new();
        for (place, part) in parts.iter().enumerate() {
            let session = &part.evaluation.session;
            let kind = (
                session.participant.clone(),
                session.object.clone(),
                session.task.clone(),
            );
            groups.entry(kind).or_default().push(place);
        }
        Self(groups)
    }

    /// Errors of each group with a method and a finger; the clusters of the rows are the sessions.
    pub(super) fn statistics(
        &self,
        parts: &[Part],
        protocol: Protocol,
        method: &str,
        (finger, rows): (Option<Finger>, &ClusteredRows),
    ) -> Vec<Statistics> {
        (self.0.values())
            .map(|sessions| {
                let members = sessions.iter().map(|&session| &parts[session]);
                let (filled, left_out) = counts(members, protocol, method, finger);
                sorted_statistics(&rows.of_clusters(sessions), filled, left_out)
            })
            .collect()
    }

    /// Summaries of all groups with a method, of which `error` gives that of a finger and a group.
    pub(super) fn summaries(
        &self,
        method: &str,
        error: impl Fn(Option<Finger>, usize) -> Statistics,
    ) -> Vec<GroupSummary> {
        (self.0.iter().enumerate())
            .map(
                |(place, ((participant, object, task), sessions))| GroupSummary {
                    participant: participant.clone(),
                    object: object.clone(),
                    task: task.clone(),
                    sessions: sessions.len(),
                    method: method.to_owned(),
                    error: HandAndFingers::from_fn(|finger| error(finger, place)),
                },
            )
            .collect()
    }
}

/// Filled and left-out instants of a method, added up.
pub(super) fn counts<'a>(
    parts: impl IntoIterator<Item = &'a Part>,
    protocol: Protocol,
    method: &str,
    finger: Option<Finger>,
) -> (usize, usize) {
    let mut counts = (0_usize, 0_usize);
    for part in parts {
        if let Some(found) = part.method(protocol, method) {
            let error = finger.map_or(&found.error.all, |finger| &found.error.by_finger[finger]);
            counts.0 = counts.0.saturating_add(error.n_filled);
            counts.1 = counts.1.saturating_add(error.n_left_out);
        }
    }
    counts
}
