//! Suspect samples of the detectors as check results.

use std::ops::Range;

use inhand_model::Clock;

use super::checkup::{CheckResult, Level};
use super::words::{count, times};
use crate::suspect::{Suspect, SuspectKind};

/// One result for each kind and entity, in the order of the first suspect of each.
pub(crate) fn suspected(clock: &Clock, suspects: &[Suspect]) -> Vec<CheckResult> {
    let mut groups: Vec<((&'static str, String), Vec<&Suspect>)> = Vec::new();
    for suspect in suspects {
        let key = (suspect.kind.id(), suspect.kind.entity());
        match groups.iter_mut().find(|(other, _)| *other == key) {
            Some((_, group)) => group.push(suspect),
            None => groups.push((key, vec![suspect])),
        }
    }
    let results = groups
        .into_iter()
        .map(|((id, entity), group)| result(clock, id, entity, &group));
    results.collect()
}

fn result(clock: &Clock, id: &'static str, entity: String, group: &[&Suspect]) -> CheckResult {
    let mut ranges: Vec<_> = group.iter().map(|s| s.samples.clone()).collect();
    ranges.sort_by_key(|range| (range.start, range.end));
    let samples = ranges.iter().map(Range::len).sum();
    let scores = group.iter().map(|s| s.score);
    let found = format!(
        "{} ({})",
        count(group.len(), words(&group[0].kind)),
        times(clock, &ranges)
    );
    CheckResult::new(id, Level::Warn, entity)
        .at(clock, &ranges)
        .expected("none")
        .found(match group {
            [suspect] => format!("{found}: {suspect}"),
            _ => found,
        })
        .advice("look at it in a viewer; `inhand clean` lists and repairs it")
        .number("count", group.len() as f64, samples)
        .number(
            "largest_score",
            scores.fold(f64::NEG_INFINITY, f64::max),
            group.len(),
        )
}

const fn words(kind: &SuspectKind) -> [&'static str; 2] {
    match kind {
        SuspectKind::Spike { .. } => ["spike", "spikes"],
        SuspectKind::Swap { .. } => ["suspected swap", "suspected swaps"],
        SuspectKind::Flip { .. } => ["suspected flip", "suspected flips"],
        SuspectKind::Unlabelled { .. } => [
            "interval without its label",
            "intervals without their label",
        ],
    }
}
