//! Layers of settings: what earlier steps stored in files, a settings file, what is typed.

use std::collections::BTreeMap;
use std::path::Path;

use inhand_channels::Metadata;
use inhand_model::Provenance;
use serde::Serialize;
use serde_json::{Value, json};
use toml::{Table, Value as Toml};

use super::Settings;
use super::fingers::name_fingers;
use crate::error::{Located, SessionError};
use crate::files::{name_of, open_take};

/// Steps that store their settings in a take, in their order.
const STEPS: [&str; 5] = ["convert", "clean", "process", "generate", "run"];

/// Settings that later steps read from a file, each with the first step that applies them. A step that comes before it
/// only hands on what is no default.
const STORED: [(&str, &str); 6] = [
    ("object", "process"),
    ("process", "process"),
    ("select", "generate"),
    ("segments", "generate"),
    ("plan", "generate"),
    ("evaluate", "run"),
];

impl Settings {
    /// Settings for these files together: what earlier steps stored in them, under a settings file, under what `typed`
    /// sets. Stored settings of the keys in `unused` do not count.
    ///
    /// # Errors
    ///
    /// [`SessionError::Usage`] where files store different values of a setting that neither the settings file nor
    /// `typed` sets, [`SessionError::Settings`] for a setting that cannot be used.
    pub fn layered(
        inputs: &[&Path],
        file: Option<&Path>,
        unused: &[&str],
        typed: &dyn Fn(&mut Settings),
    ) -> Result<Self, SessionError> {
        let set = file.map_or_else(|| Ok(Table::new()), read_table)?;
        let settle = |mut layers: Table| {
            merge(&mut layers, &set);
            let mut settings: Self = layers.try_into().map_err(|error: toml::de::Error| {
                SessionError::usage("settings", error.message())
            })?;
            typed(&mut settings);
            settings.validate()?;
            Ok::<_, SessionError>(settings)
        };
        let stored = inputs.iter().map(|input| stored_in(input, unused));
        let stored = stored.collect::<Result<Vec<_>, _>>()?;
        let mut all = Table::new();
        stored.iter().for_each(|layer| merge(&mut all, layer));
        let settings = settle(all)?;
        let together = flat(&settings);
        for (input, layer) in inputs.iter().zip(&stored) {
            let own = flat(&settle(layer.clone())?);
            let differs = |key: &String| own.get(key) != together.get(key);
            if let Some(key) = flat(layer).into_keys().find(differs) {
                let mut others = inputs.iter().zip(&stored);
                let other = others.find(|(_, layer)| flat(layer).get(&key) == together.get(&key));
                let other = other.map_or(input.display(), |(other, _)| other.display());
                let value = |all: &BTreeMap<_, String>| all.get(&key).cloned().unwrap_or_default();
                let message = format!(
                    "{key} is {} here and {} in {other}: set it for all by its option or in a \
                     settings file, or use one file at a time",
                    value(&own),
                    value(&together)
                );
                return Err(SessionError::usage(input, message));
            }
        }
        Ok(settings)
    }

    /// The settings by which a take was made; defaults where it does not state them.
    pub(crate) fn of_steps(steps: &[Provenance]) -> Self {
        stored(steps).try_into().unwrap_or_default()
    }
}

/// What earlier steps stored in a file. A file that is no MCAP file stores nothing, and one that cannot be read is
/// reported by the step that reads its content.
fn stored_in(input: &Path, unused: &[&str]) -> Result<Table, SessionError> {
    let name = name_of(input);
    let Ok(metadata) = metadata(input, &name) else {
        return Ok(Table::new());
    };
    let mut found = stored(&metadata.provenance(&name).in_file(input)?);
    if let Some(shape) = metadata.shape(&name).in_file(input)? {
        let object = json!({ "object": { "shape": shape.to_string() } });
        merge(&mut found, &table(&object));
    }
    for key in unused {
        match key.split_once('.') {
            None => found.remove(*key),
            Some((section, key)) => {
                (found.get_mut(section)).and_then(|section| section.as_table_mut()?.remove(key))
            }
        };
    }
    Ok(found)
}

/// The metadata of a take; none of a stream, which can be read only once.
fn metadata(input: &Path, name: &str) -> Result<Metadata, SessionError> {
    match open_take(input, name)? {
        Some(mut source) => inhand_channels::metadata_of_source(&mut source).in_file(input),
        None => Ok(Metadata::default()),
    }
}

/// What the last of the steps that store settings has stored. A section that this version cannot read is left out.
fn stored(steps: &[Provenance]) -> Table {
    let place = |step: &str| STEPS.iter().position(|known| *known == step);
    let mut found = Table::new();
    let Some(last) = (steps.iter().rev()).find(|made| place(&made.step).is_some()) else {
        return found;
    };
    let settings: Value = serde_json::from_str(&last.settings_json).unwrap_or_default();
    let defaults = table(&Settings::default());
    for (section, step) in STORED {
        let Some(value) = settings.get(section) else {
            continue;
        };
        let mut one = table(&json!({ section: value }));
        if one.clone().try_into::<Settings>().is_err() {
            continue;
        }
        name_fingers(&mut one);
        if place(&last.step) < place(step)
            && let Some(Toml::Table(keys)) = one.get_mut(section)
        {
            let default = |key: &str| defaults.get(section)?.get(key);
            keys.retain(|key, value| default(key) != Some(value));
        }
        found.extend(one);
    }
    found
}

/// A settings file as it is, once it is known to hold settings: an error has its place in the text.
fn read_table(path: &Path) -> Result<Table, SessionError> {
    Settings::read(path)?;
    let text = std::fs::read_to_string(path).map_err(SessionError::io("read", path))?;
    let mut layer = toml::from_str(&text).unwrap_or_default();
    name_fingers(&mut layer);
    Ok(layer)
}

fn table(value: &impl Serialize) -> Table {
    Table::try_from(value).unwrap_or_default()
}

/// Puts the settings of one layer over those of another.
fn merge(below: &mut Table, above: &Table) {
    for (key, value) in above {
        match (below.get_mut(key), value) {
            (Some(Toml::Table(below)), Toml::Table(above)) => merge(below, above),
            _ => drop(below.insert(key.clone(), value.clone())),
        }
    }
}

/// Every setting by its dotted key.
fn flat(settings: &impl Serialize) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    flatten(
        "",
        &serde_json::to_value(settings).unwrap_or_default(),
        &mut found,
    );
    found
}

/// Adds the values below a key by their dotted keys.
pub(crate) fn flatten(key: &str, value: &Value, found: &mut BTreeMap<String, String>) {
    match value {
        Value::Object(inner) => {
            for (name, value) in inner {
                let key = format!("{key}.{name}");
                flatten(key.trim_start_matches('.'), value, found);
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
