//! The public functions compared with closed forms and NumPy, and their properties.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod bootstrap;
mod quantiles;

use serde_json::Value;

/// Values recorded from `reference/make_quantiles.py`.
fn reference() -> Value {
    serde_json::from_str(include_str!("../reference/quantiles.json")).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}
