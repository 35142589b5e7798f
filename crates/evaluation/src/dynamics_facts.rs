//! Facts of contacts over time.

use std::collections::BTreeMap;
use std::ops::Range;

use inhand_model::{
    ContactRow, ContactRows, Finger, FingerContactFacts, FingerSet, GaitFacts, PerFinger,
    PhaseFacts, SegmentContacts, StateFacts, StateRow, Statistics, TakeContacts, Transition,
};
use inhand_statistics::quantiles::statistics;

/// Facts of the contacts of a take.
pub(crate) fn take_contacts(take: &str, rate_hz: f64, rows: &ContactRows) -> TakeContacts {
    let span_s =
        |samples: &Range<usize>| [samples.start, samples.end].map(|sample| sample as f64 / rate_hz);
    TakeContacts {
        take: take.to_owned(),
        rate_hz,
        duration_s: rows.samples as f64 / rate_hz,
        by_finger: fingers(std::slice::from_ref(rows), rate_hz),
        contacts_s: (rows.contacts.each_ref())
            .map(|contacts| contacts.iter().map(|row| span_s(&row.samples)).collect()),
        unknown_s: (rows.unknown.each_ref())
            .map(|stretches| stretches.iter().map(span_s).collect()),
        states: states(&rows.states, rate_hz),
        transitions: transitions(&rows.states),
        phases: (rows.phases.iter())
            .map(|phase| PhaseFacts {
                kind: phase.kind,
                span_s: span_s(&phase.samples),
                holding: phase.holding,
            })
            .collect(),
        gaits: (rows.gaits.iter())
            .map(|gait| GaitFacts {
                finger: gait.finger,
                span_s: span_s(&gait.samples),
                holding: gait.holding,
                step_m: gait.step_m,
            })
            .collect(),
    }
}

/// Facts of the contacts inside all segments.
pub(crate) fn segment_contacts(segments: &[ContactRows], rate_hz: f64) -> SegmentContacts {
    let is_known = |rows: &&ContactRows| Finger::ALL.iter().any(|&finger| rows.known(finger) > 0);
    let mut by_fingers = [0; Finger::COUNT + 1];
    for state in segments.iter().flat_map(|rows| &rows.states) {
        by_fingers[state.fingers.len()] += state.samples.len();
    }
    SegmentContacts {
        segments: segments.iter().filter(is_known).count(),
        by_finger: fingers(segments, rate_hz),
        by_fingers,
    }
}

/// Facts of each finger over intervals of time.
fn fingers(stretches: &[ContactRows], rate_hz: f64) -> PerFinger<FingerContactFacts> {
    PerFinger::from_fn(|finger| {
        let contacts = || stretches.iter().flat_map(|rows| &rows.contacts[finger]);
        let known: usize = stretches.iter().map(|rows| rows.known(finger)).sum();
        let touching: usize = contacts().map(|row| row.samples.len()).sum();
        let is_complete = |row: &&ContactRow| row.made && row.broken;
        let whole = || contacts().filter(is_complete);
        let slipped = || contacts().filter(|row| row.slip_m.is_finite());
        let filled =
            |rows: &mut dyn Iterator<Item = &ContactRow>| rows.filter(|r| r.filled).count();
        FingerContactFacts {
            known_s: known as f64 / rate_hz,
            duty: touching as f64 / known as f64,
            makes: contacts().filter(|row| row.made).count(),
            breaks: contacts().filter(|row| row.broken).count(),
            duration_s: statistics(
                whole()
                    .map(|row| row.samples.len() as f64 / rate_hz)
                    .collect(),
                filled(&mut whole()),
                0,
            ),
            censored: contacts().filter(|row| !is_complete(row)).count(),
            slip_m: statistics(
                slipped().map(|row| row.slip_m).collect(),
                filled(&mut slipped()),
                contacts().count() - slipped().count(),
            ),
        }
    })
}

/// Contact states, most frequent first.
fn states(runs: &[StateRow], rate_hz: f64) -> Vec<StateFacts> {
    let all: usize = runs.iter().map(|run| run.samples.len()).sum();
    let mut by_state: BTreeMap<FingerSet, Vec<&StateRow>> = BTreeMap::new();
    for run in runs {
        by_state.entry(run.fingers).or_default().push(run);
    }
    let mut states: Vec<StateFacts> = (by_state.into_iter())
        .map(|(fingers, runs)| {
            let samples = runs.iter().map(|run| run.samples.len()).sum();
            StateFacts {
                fingers,
                samples,
                share: samples as f64 / all as f64,
                runs: runs.len(),
                duration_s: durations(&runs, rate_hz),
            }
        })
        .collect();
    states.sort_by_key(|state| (std::cmp::Reverse(state.samples), state.fingers));
    states
}

fn durations(runs: &[&StateRow], rate_hz: f64) -> Statistics {
    let whole = runs.iter().filter(|run| run.complete);
    let durations_s = whole
        .map(|run| run.samples.len() as f64 / rate_hz)
        .collect();
    statistics(durations_s, 0, 0)
}

/// Transitions from one sample to the next, most frequent first.
fn transitions(runs: &[StateRow]) -> Vec<Transition> {
    let mut counts: BTreeMap<(FingerSet, FingerSet), usize> = BTreeMap::new();
    for pair in runs.windows(2) {
        // Samples at which not all is known may lie between.
        if pair[0].samples.end == pair[1].samples.start {
            *counts
                .entry((pair[0].fingers, pair[1].fingers))
                .or_default() += 1;
        }
    }
    let mut transitions: Vec<Transition> = (counts.into_iter())
        .map(|((from, to), count)| Transition { from, to, count })
        .collect();
    transitions.sort_by_key(|t| (std::cmp::Reverse(t.count), t.from, t.to));
    transitions
}
