//! Events of a C3D file: the group `EVENT`.

use inhand_model::Finding;

use super::parameters::Parameters;
use crate::trial::{TrialEvent, labels};

/// Texts of an event by the key of the label that they become.
const TEXTS: [(&str, &str); 4] = [
    ("label", "LABELS"),
    ("context", "CONTEXTS"),
    ("subject", "SUBJECTS"),
    ("description", "DESCRIPTIONS"),
];

/// Label of an event that has none.
const UNNAMED: &str = "event";

/// The events that a file states. `TIMES` holds minutes and seconds of each in turn, counted from frame 1 of the trial.
pub(super) fn stated(parameters: &Parameters, findings: &mut Vec<Finding>) -> Vec<TrialEvent> {
    let times = parameters.reals("EVENT", "TIMES");
    let used = parameters
        .number("EVENT", "USED")
        .map_or(times.len() / 2, |used| used as usize);
    let texts = TEXTS.map(|(key, name)| (key, parameters.texts("EVENT", name)));
    let mut events = Vec::new();
    for (k, time) in times.chunks_exact(2).take(used).enumerate() {
        let time_s = 60.0 * f64::from(time[0]) + f64::from(time[1]);
        if !(time_s.is_finite() && time_s >= 0.0) {
            let message = format!("event {} is at {time_s} s: left out", k + 1);
            findings.push(Finding::warning("EVENT:TIMES", message));
            continue;
        }
        let texts = texts
            .iter()
            .filter_map(|(key, texts)| Some((*key, texts.get(k)?.as_str())));
        let mut labels = labels(texts);
        labels
            .entry("label".to_owned())
            .or_insert_with(|| UNNAMED.to_owned());
        events.push(TrialEvent { time_s, labels });
    }
    if events.len() < used {
        let message = format!(
            "{used} events are counted, {} have a time: the others are left out",
            events.len()
        );
        findings.push(Finding::warning("EVENT:USED", message));
    }
    events
}
