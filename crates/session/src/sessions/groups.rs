//! Sessions of the same participant, object and task together.

use std::collections::BTreeMap;

use inhand_evaluation::SortedErrors;
use inhand_model::{Finger, GroupSummary, HandAndFingers, PerFinger, Protocol, Statistics};
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

    /// Each group's errors of a method, whose clusters are the sessions.
    pub(super) fn summaries(
        &self,
        parts: &[Part],
        protocol: Protocol,
        method: &str,
        errors: &SortedErrors,
    ) -> Vec<GroupSummary> {
        let mut group = vec![0; parts.len()];
        for (place, sessions) in self.0.values().enumerate() {
            sessions.iter().for_each(|&session| group[session] = place);
        }
        let of = |finger: Option<Finger>| -> Vec<Statistics> {
            let pooled = errors.rows(finger).by_group(&group);
            (self.0.values().zip(&pooled))
                .map(|(sessions, pooled)| {
                    let members = sessions.iter().map(|&session| &parts[session]);
                    let (filled, left_out) = counts(members, protocol, method, finger);
                    sorted_statistics(pooled, filled, left_out)
                })
                .collect()
        };
        let all = of(None);
        let by_finger = PerFinger::from_fn(|finger| of(Some(finger)));
        (self.0.iter().enumerate())
            .map(
                |(place, ((participant, object, task), sessions))| GroupSummary {
                    participant: participant.clone(),
                    object: object.clone(),
                    task: task.clone(),
                    sessions: sessions.len(),
                    method: method.to_owned(),
                    error: HandAndFingers {
                        all: all[place],
                        by_finger: by_finger.each_ref().map(|of_groups| of_groups[place]),
                    },
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
