//! `evaluation.json`: the form that outside scripts read. The contract is
//! `schemas/evaluation.schema.json`.

mod intervals;
mod read;
mod wire;
mod write;

use inhand_model::{Evaluation, Finger, PerFinger, Provenance};

use crate::error::ReportError;

pub(crate) use read::read;

/// Writes the document with two spaces of indent and a trailing newline.
pub(crate) fn write(
    evaluation: &Evaluation,
    provenance: &[Provenance],
) -> Result<String, ReportError> {
    let document = write::document(evaluation, provenance);
    let mut text = serde_json::to_string_pretty(&document).map_err(|source| ReportError::Json {
        session: evaluation.session.name.clone(),
        source,
    })?;
    text.push('\n');
    Ok(text)
}

/// Settings as JSON; text that is no JSON (another tool's provenance) is kept as a string.
pub(crate) fn settings_value(settings_json: &str) -> serde_json::Value {
    serde_json::from_str(settings_json)
        .unwrap_or_else(|_| serde_json::Value::String(settings_json.to_owned()))
}

/// Share over all fingers; each finger was judged at the same number of instants.
pub(crate) fn mean(shares: &PerFinger<f64>) -> f64 {
    shares.as_array().iter().sum::<f64>() / Finger::COUNT as f64
}
