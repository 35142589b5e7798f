//! Provenance: tool, inputs and settings of this report.

use inhand_model::Provenance;
use maud::{Markup, html};

use crate::json::settings_value;
use crate::words::counted;

/// The section's content.
pub(super) fn section(provenance: &[Provenance]) -> Markup {
    html! {
        @if provenance.is_empty() {
            p { "No provenance was recorded." }
        } @else {
            p { "Every step that led here, with all settings that had an effect and the SHA-256 of what went in. The same inputs and settings give the same bytes." }
        }
        @for step in provenance {
            details {
                summary {
                    b { (step.step) }
                    " " (step.tool) ", " (counted(step.inputs.len(), "input"))
                }
                h4 { "Settings" }
                pre { (pretty(&step.settings_json)) }
                @if !step.inputs.is_empty() {
                    h4 { "Inputs" }
                    dl.hashes {
                        @for input in &step.inputs {
                            dt { (input.name) }
                            dd { code { (input.sha256) } }
                        }
                    }
                }
            }
        }
    }
}

/// JSON on several lines; other text as it is.
fn pretty(settings_json: &str) -> String {
    match settings_value(settings_json) {
        serde_json::Value::String(text) => text,
        // Writing a value that has just been read cannot fail; the text itself is a safe answer.
        value => serde_json::to_string_pretty(&value).unwrap_or_else(|_| settings_json.to_owned()),
    }
}
