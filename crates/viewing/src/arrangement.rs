//! Arrangement of panels in the window.

use serde_json::{Value, json};

/// Two parts side by side; the first takes `percent` of the width.
pub(crate) fn beside(first: Value, second: Value, percent: f64) -> Value {
    split("row", first, second, percent)
}

/// Two parts one above the other; the upper takes `percent` of the height.
pub(crate) fn stacked(first: Value, second: Value, percent: f64) -> Value {
    split("column", first, second, percent)
}

fn split(direction: &str, first: Value, second: Value, percent: f64) -> Value {
    let fields = [
        ("direction", json!(direction)),
        ("first", first),
        ("second", second),
        ("splitPercentage", json!(percent)),
    ];
    let fields = fields.map(|(name, value)| (name.to_owned(), value));
    Value::Object(fields.into_iter().collect())
}

/// All parts, each with the same share; `None` for none.
pub(crate) fn evenly(parts: Vec<Value>, join: fn(Value, Value, f64) -> Value) -> Option<Value> {
    let mut joined: Option<(Value, u32)> = None;
    for part in parts.into_iter().rev() {
        joined = Some(match joined {
            None => (part, 1),
            Some((others, n)) => (join(part, others, 100.0 / f64::from(n + 1)), n + 1),
        });
    }
    joined.map(|(parts, _)| parts)
}
