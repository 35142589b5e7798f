//! Suspect samples of the detectors as check results.

use std::ops::Range;

use inhand_model::Clock;

use super::checkup::{CheckResult, Level};
use super::words::{count, times};

/// What a detector suspects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SuspicionKind {
    /// Single samples far from where the marker was and will be.
    Spike,
    /// Two markers that have changed names.
    Swap,
    /// A rigid body that was fitted the wrong way round.
    Flip,
    /// A marker that goes on without its name.
    Unlabelled,
}

impl SuspicionKind {
    /// Identifier of its results.
    pub const fn id(self) -> &'static str {
        match self {
            SuspicionKind::Spike => "spikes",
            SuspicionKind::Swap => "swaps",
            SuspicionKind::Flip => "flips",
            SuspicionKind::Unlabelled => "unlabelled-stretches",
        }
    }

    const fn words(self) -> [&'static str; 2] {
        match self {
            SuspicionKind::Spike => ["spike", "spikes"],
            SuspicionKind::Swap => ["suspected swap", "suspected swaps"],
            SuspicionKind::Flip => ["suspected flip", "suspected flips"],
            SuspicionKind::Unlabelled => {
                ["stretch without its label", "stretches without their label"]
            }
        }
    }
}

/// One suspicion.
#[derive(Clone, Debug, PartialEq)]
pub struct Suspicion {
    /// What is suspected.
    pub kind: SuspicionKind,
    /// Which marker or body; for a swap both, such as `index and middle`.
    pub entity: String,
    /// Where.
    pub samples: Range<usize>,
    /// How sure the detector is; larger is surer.
    pub score: f64,
    /// What the detector saw.
    pub message: String,
}

/// One result for each kind and entity, in the order of the first suspicion of each.
pub(crate) fn suspected(clock: &Clock, suspicions: &[Suspicion]) -> Vec<CheckResult> {
    let mut groups: Vec<Vec<&Suspicion>> = Vec::new();
    for suspicion in suspicions {
        let same = |group: &&mut Vec<&Suspicion>| {
            (group.first()).is_some_and(|first| {
                first.kind == suspicion.kind && first.entity == suspicion.entity
            })
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(suspicion),
            None => groups.push(vec![suspicion]),
        }
    }
    groups
        .iter()
        .filter_map(|group| result(clock, group))
        .collect()
}

fn result(clock: &Clock, group: &[&Suspicion]) -> Option<CheckResult> {
    let first = group.first()?;
    let mut ranges: Vec<_> = group.iter().map(|s| s.samples.clone()).collect();
    ranges.sort_by_key(|range| (range.start, range.end));
    let scores = group.iter().map(|s| s.score);
    let message = if group.len() == 1 && !first.message.is_empty() {
        format!(": {}", first.message)
    } else {
        String::new()
    };
    let found = format!(
        "{} ({}){message}",
        count(group.len(), first.kind.words()),
        times(clock, &ranges)
    );
    Some(
        CheckResult::new(first.kind.id(), Level::Warn, first.entity.clone())
            .at(clock, &ranges)
            .expected("none")
            .found(found)
            .advice("look at it in a viewer; `inhand clean` lists and repairs it")
            .number("count", group.len() as f64, clock_samples(&ranges))
            .number(
                "largest_score",
                scores.fold(f64::NEG_INFINITY, f64::max),
                group.len(),
            ),
    )
}

fn clock_samples(ranges: &[Range<usize>]) -> usize {
    ranges.iter().map(ExactSizeIterator::len).sum()
}
