//! Settings in which evaluations differ.

use std::collections::{BTreeMap, BTreeSet};

use inhand_model::SettingDifference;
use serde_json::Value;

use super::part::Part;

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

/// Value shown for a setting that is not there.
const NOT_SET: &str = "not set";

/// Settings that are not the same in all parts, those that say what was recorded left out, and the version of
/// the tool.
pub(super) fn differences(parts: &[&Part]) -> Vec<SettingDifference> {
    let settings: Vec<BTreeMap<String, String>> = parts.iter().map(|part| of(part)).collect();
    let keys: BTreeSet<&String> = settings.iter().flat_map(BTreeMap::keys).collect();
    keys.into_iter()
        .filter_map(|key| {
            let values: Vec<String> = (settings.iter())
                .map(|of_part| of_part.get(key).map_or(NOT_SET, String::as_str).to_owned())
                .collect();
            let differ = values.iter().any(|value| *value != values[0]);
            differ.then(|| SettingDifference {
                key: key.clone(),
                values,
            })
        })
        .collect()
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

fn flatten(key: &str, value: &Value, found: &mut BTreeMap<String, String>) {
    match value {
        Value::Object(inner) => {
            for (name, value) in inner {
                flatten(&format!("{key}.{name}"), value, found);
            }
        }
        Value::String(word) => {
            found.insert(key.to_owned(), word.clone());
        }
        other => {
            found.insert(key.to_owned(), other.to_string());
        }
    }
}
