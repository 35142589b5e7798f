//! Settings in which evaluations differ.

use std::collections::BTreeMap;

use inhand_model::SettingDifference;
use serde_json::Value;

use super::part::Part;
use crate::settings::flatten;

/// Settings that say what was recorded, not how it was worked on: sessions may differ in them.
const OF_THE_RECORDING: [&str; 9] = [
    "name",
    "participant",
    "task",
    "takes",
    "allow_shared_takes",
    "source",
    "topics",
    "roles",
    "fingers",
];

/// Settings that are not the same in all parts, those that say what was recorded left out, and the version of
/// the tool.
pub(super) fn differences(parts: &[&Part]) -> Vec<SettingDifference> {
    SettingDifference::among(&parts.iter().map(|part| of(part)).collect::<Vec<_>>())
}

/// Settings that make the motion and the segments that a part is judged on, each with the step that applies it;
/// `run` applies all of them.
const OF_THE_REFERENCE: [(&str, &str); 9] = [
    ("source", "convert"),
    ("topics", "convert"),
    ("clean", "clean"),
    ("roles", "process"),
    ("fingers", "process"),
    ("object.offset_m", "process"),
    ("process", "process"),
    ("select", "generate"),
    ("segments", "generate"),
];

/// Differences in the recorded motion that parts are judged on: settings that make it, test files, segments.
pub(super) fn reference(parts: &[&Part]) -> Vec<SettingDifference> {
    let mut found =
        SettingDifference::among(&parts.iter().map(|part| judged_on(part)).collect::<Vec<_>>());
    // Files that one of them does not name are unknown.
    found.retain(|own| !own.values.contains(&String::new()));
    found
}

fn judged_on(part: &Part) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for (key, step) in OF_THE_REFERENCE {
        let steps = part.provenance.iter();
        let applied = (steps.clone().rev()).filter(|made| [step, "run"].contains(&&*made.step));
        let stated = applied.chain(steps).find_map(|made| {
            let settings: Value = serde_json::from_str(&made.settings_json).ok()?;
            let value = settings.pointer(&format!("/{}", key.replace('.', "/")));
            value.cloned()
        });
        if let Some(value) = stated {
            flatten(key, &value, &mut found);
        }
    }
    let session = &part.evaluation.session;
    let segments: usize = session.test.iter().map(|take| take.segments).sum();
    let files: Vec<String> = (part.test_sources().into_iter())
        .map(|(name, sha256)| format!("{name} ({})", sha256.get(..8).unwrap_or(sha256)))
        .collect();
    for (key, value) in [
        ("rate_hz", session.rate_hz.to_string()),
        ("segment_samples", session.segment_samples.to_string()),
        ("test segments", segments.to_string()),
        ("test files", files.join(", ")),
    ] {
        found.insert(key.to_owned(), value);
    }
    found
}

/// Effective settings of the last step that made a part, by dotted key.
fn of(part: &Part) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let Some(last) = part.provenance.last() else {
        return found;
    };
    found.insert("tool".to_owned(), last.tool.clone());
    if let Ok(Value::Object(settings)) = serde_json::from_str(&last.settings_json) {
        for (key, value) in &settings {
            // The shape of the object is of the recording too; where tau or pads differ, the rule does.
            if !OF_THE_RECORDING.contains(&key.as_str()) && key != "object" {
                flatten(key, value, &mut found);
            }
        }
    }
    found
}
