//! The public functions compared with closed forms, NumPy and SciPy, and their properties.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod curves;
mod smoothness;
mod velocity;
mod warping;

use serde_json::Value;

/// Values recorded from `reference/make.py`.
fn reference() -> Value {
    serde_json::from_str(include_str!("../reference/curves.json")).unwrap()
}

/// Values recorded from `reference/make_motion.py`.
fn motion_reference() -> Value {
    serde_json::from_str(include_str!("../reference/motion.json")).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}
