//! `evaluation.json`, the form that outside scripts read (the contract is `schemas/evaluation.schema.json`), and
//! summaries and comparisons in the same form.

use inhand_model::{Evaluation, InputHash, Provenance};
use serde::{Deserialize, Serialize};

use crate::error::ReportError;

/// Raised when a key changes its meaning or goes away; new keys alone do not raise it.
const SCHEMA_VERSION: u32 = 1;

/// A document with what is not part of it.
#[derive(Serialize)]
struct Versioned<'a, T> {
    schema_version: u32,
    #[serde(flatten)]
    document: &'a T,
    #[serde(skip_serializing_if = "Option::is_none")]
    provenance: Option<Vec<Step>>,
}

#[derive(Serialize, Deserialize)]
pub(crate) struct Step {
    tool: String,
    step: String,
    settings: serde_json::Value,
    inputs: Vec<InputHash>,
}

/// Writes the document with two spaces of indent and a trailing newline.
pub(crate) fn write(
    evaluation: &Evaluation,
    provenance: &[Provenance],
) -> Result<String, ReportError> {
    let steps = provenance.iter().map(|step| Step {
        tool: step.tool.clone(),
        step: step.step.clone(),
        settings: settings_value(&step.settings_json),
        inputs: step.inputs.clone(),
    });
    pretty(evaluation, &evaluation.session.name, Some(steps.collect()))
}

/// Writes a document about `session` in that form.
pub(crate) fn pretty(
    document: &impl Serialize,
    session: &str,
    provenance: Option<Vec<Step>>,
) -> Result<String, ReportError> {
    let versioned = Versioned {
        schema_version: SCHEMA_VERSION,
        document,
        provenance,
    };
    let mut text =
        serde_json::to_string_pretty(&versioned).map_err(|source| ReportError::Json {
            session: session.to_owned(),
            source,
        })?;
    text.push('\n');
    Ok(text)
}

/// Reads an evaluation. Its version comes first: keys of another version must not be guessed at.
pub(crate) fn read(text: &str) -> Result<(Evaluation, Vec<Provenance>), ReportError> {
    #[derive(Deserialize)]
    struct Version {
        schema_version: u64,
    }
    #[derive(Deserialize)]
    struct Steps {
        provenance: Vec<Step>,
    }
    let not_an_evaluation = |source| ReportError::NotAnEvaluation { source };
    let version: Version = serde_json::from_str(text).map_err(not_an_evaluation)?;
    if version.schema_version != u64::from(SCHEMA_VERSION) {
        return Err(ReportError::Version {
            found: version.schema_version,
            expected: SCHEMA_VERSION,
        });
    }
    // Read apart from the evaluation: within one flattened struct errors would lose their line.
    let evaluation = serde_json::from_str(text).map_err(not_an_evaluation)?;
    let steps: Steps = serde_json::from_str(text).map_err(not_an_evaluation)?;
    Ok((evaluation, steps.provenance.into_iter().map(step).collect()))
}

/// Settings that were no JSON were kept as a string, and go back to what they were.
fn step(step: Step) -> Provenance {
    Provenance {
        tool: step.tool,
        step: step.step,
        settings_json: match step.settings {
            serde_json::Value::String(text) => text,
            value => value.to_string(),
        },
        inputs: step.inputs,
    }
}

/// Settings as JSON; text that is no JSON (another tool's provenance) is kept as a string.
pub(crate) fn settings_value(settings_json: &str) -> serde_json::Value {
    serde_json::from_str(settings_json)
        .unwrap_or_else(|_| serde_json::Value::String(settings_json.to_owned()))
}
