//! Phases of manipulation and steps of fingers as events of a take.

use std::ops::Range;

use inhand_model::{Annotations, Clock, ContactRows, Event, FOUND, FingerSet};

/// Keys of the labels that found events have, in the order of tables.
const KEYS: [&str; 5] = ["phase", "gait", "holding", "step_mm", FOUND.0];

/// The annotations of a take with the phases and steps that its contacts show, in place of any that were found
/// before: `phase=in_grasp` or `gait=index`, the fingers that hold all the while as `holding=thumb+middle`,
/// how far a finger stepped over the object as `step_mm`, and `by=inhand`.
pub fn with_found(annotations: &Annotations, rows: &ContactRows, clock: Clock) -> Annotations {
    let mut events = annotations.given();
    events.extend(found(rows, clock));
    // Keys of people first, those of events found before last.
    let given = Annotations {
        events: annotations.given(),
        keys: (annotations.keys.iter())
            .filter(|key| !KEYS.contains(&key.as_str()))
            .cloned()
            .collect(),
        about: annotations.about.clone(),
    };
    let mut keys: Vec<String> = given.all_keys().into_iter().map(str::to_owned).collect();
    let is_new = |key: &&str| !keys.iter().any(|known| known == key);
    let new: Vec<String> = KEYS
        .iter()
        .copied()
        .filter(is_new)
        .map(str::to_owned)
        .collect();
    keys.extend(new);
    Annotations {
        events,
        keys,
        about: given.about,
    }
}

/// Phases, then steps, each in order.
fn found(rows: &ContactRows, clock: Clock) -> impl Iterator<Item = Event> {
    let event = move |samples: &Range<usize>, labels: Vec<(&str, String)>| {
        let (by, inhand) = FOUND;
        let labels = labels.into_iter().chain([(by, inhand.to_owned())]);
        Event {
            start_unix_nanos: clock.unix_nanos(samples.start),
            // Both ends are included.
            end_unix_nanos: clock.unix_nanos(samples.end.saturating_sub(1).max(samples.start)),
            labels: labels.map(|(key, value)| (key.to_owned(), value)).collect(),
        }
    };
    let holding = |fingers: FingerSet| ("holding", fingers.to_string());
    let phases = (rows.phases.iter()).map(move |phase| {
        let kind = ("phase", phase.kind.name().to_owned());
        event(&phase.samples, vec![kind, holding(phase.holding)])
    });
    let gaits = rows.gaits.iter().map(move |gait| {
        let mut labels = vec![
            ("gait", gait.finger.name().to_owned()),
            holding(gait.holding),
        ];
        if gait.step_m.is_finite() {
            labels.push(("step_mm", format!("{:.2}", 1e3 * gait.step_m)));
        }
        event(&gait.samples, labels)
    });
    phases.chain(gaits)
}
