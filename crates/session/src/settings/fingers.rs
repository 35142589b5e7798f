//! Tables by finger: each finger has one name in settings, in whatever way a file spells it.

use std::collections::BTreeMap;

use inhand_model::Finger;
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use toml::Table;

/// Every table by finger, by the keys that lead to it.
const BY_FINGER: [&[&str]; 3] = [
    &["fingers"],
    &["clean", "pad_mm"],
    &["evaluate", "pad_offset_mm"],
];

/// Reads a table by finger. A finger that it has twice is refused.
pub(super) fn by_finger<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<BTreeMap<String, T>, D::Error> {
    let mut found = BTreeMap::new();
    for (name, value) in BTreeMap::<String, T>::deserialize(deserializer)? {
        if found.insert(known(&name), value).is_some() {
            let finger = known(&name);
            return Err(D::Error::custom(format!(
                "expected each finger once, found {finger} under two names"
            )));
        }
    }
    Ok(found)
}

/// Names the fingers of a layer of settings as [`by_finger`] does, so that an upper layer replaces them.
pub(super) fn name_fingers(layer: &mut Table) {
    for keys in BY_FINGER {
        let table = keys.iter().try_fold(&mut *layer, |table, key| {
            table.get_mut(*key).and_then(toml::Value::as_table_mut)
        });
        if let Some(table) = table {
            let named = std::mem::take(table).into_iter();
            table.extend(named.map(|(name, value)| (known(&name), value)));
        }
    }
}

/// A finger's name; a word that names no finger stays, for the check of settings to report.
fn known(name: &str) -> String {
    let finger = name.parse::<Finger>();
    finger.map_or_else(|_| name.to_owned(), |finger| finger.name().to_owned())
}
