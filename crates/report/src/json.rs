//! `evaluation.json`: the form that outside scripts read. The contract is
//! `schemas/evaluation.schema.json`.

mod comparison;
mod intervals;
mod read;
mod summary;
mod wire;
mod write;

use inhand_model::{Evaluation, EvaluationComparison, Finger, PerFinger, Provenance, Summary};
use serde::Serialize;

use crate::error::ReportError;

pub(crate) use read::read;

/// Writes the document with two spaces of indent and a trailing newline.
pub(crate) fn write(
    evaluation: &Evaluation,
    provenance: &[Provenance],
) -> Result<String, ReportError> {
    pretty(
        &write::document(evaluation, provenance),
        &evaluation.session.name,
    )
}

/// Writes many sessions in the same form.
pub(crate) fn write_summary(sessions: &Summary) -> Result<String, ReportError> {
    pretty(&summary::document(sessions), "many sessions")
}

/// Writes two evaluations side by side in the same form.
pub(crate) fn write_comparison(both: &EvaluationComparison) -> Result<String, ReportError> {
    pretty(&comparison::document(both), &both.after.session)
}

fn pretty(document: &impl Serialize, session: &str) -> Result<String, ReportError> {
    let mut text = serde_json::to_string_pretty(document).map_err(|source| ReportError::Json {
        session: session.to_owned(),
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
