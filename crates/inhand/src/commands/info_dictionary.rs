//! Dictionary part of `inhand info`.

use inhand_model::{Dictionary, Provenance};
use serde_json::{Value, json};

/// Learning, reconstruction error and inputs of a dictionary as lines.
pub(super) fn text(dictionary: &Dictionary, made: &[Provenance]) -> String {
    let learning = &dictionary.learning;
    let mm = |metres: f64| format!("{:.4} mm rms", metres * 1000.0);
    let mut text = format!(
        "dictionary\n  {} primitives ({}) from {} segments of {} samples at {} Hz{}\n",
        dictionary.rank(),
        dictionary.kind.name(),
        learning.segments,
        dictionary.layout.samples,
        dictionary.layout.rate_hz,
        ["", ", with the object"][usize::from(dictionary.layout.object)],
    );
    text += &format!(
        "  {} after {} iterations ({}), seed {}\n",
        mm(learning.rms_m),
        learning.iterations,
        learning.stop_reason.name().replace('_', " "),
        learning.seed,
    );
    for restart in &learning.restarts {
        let (seed, rms, cosine) = (restart.seed, mm(restart.rms_m), restart.matched_cosine);
        text += &format!("  start with seed {seed}: {rms}, mean matched cosine {cosine:.4}\n");
    }
    if let Some(residual) = &dictionary.residual {
        text += &format!(
            "  deviations from the cubic baseline: {} primitives, {} demonstrations\n",
            residual.primitives.ncols(),
            residual.expectation.demonstrations(),
        );
    }
    if let Some(choice) = &dictionary.choice {
        text += &format!("  best method on left-out takes: {}\n", choice.method);
    }
    for input in made.iter().flat_map(|step| &step.inputs) {
        let short = input.sha256.get(..12).unwrap_or(&input.sha256);
        text += &format!("  from {} (sha256 {short}...)\n", input.name);
    }
    text
}

/// The same as JSON.
pub(super) fn to_json(dictionary: &Dictionary, made: &[Provenance]) -> Value {
    let learning = &dictionary.learning;
    let restarts: Vec<_> = (learning.restarts.iter())
        .map(|restart| {
            json!({
                "seed": restart.seed,
                "rms_mm": restart.rms_m * 1000.0,
                "objective_m2": restart.objective_m2,
                "matched_cosine": restart.matched_cosine,
            })
        })
        .collect();
    let inputs: Vec<_> = (made.iter().flat_map(|step| &step.inputs))
        .map(|input| json!({ "name": input.name, "sha256": input.sha256 }))
        .collect();
    json!({
        "kind": dictionary.kind.name(),
        "rank": dictionary.rank(),
        "samples": dictionary.layout.samples,
        "rate_hz": dictionary.layout.rate_hz,
        "object": dictionary.layout.object,
        "segments": learning.segments,
        "rms_mm": learning.rms_m * 1000.0,
        "relative_error": learning.relative_error,
        "iterations": learning.iterations,
        "stop_reason": learning.stop_reason.name(),
        "objective_history_m2": learning.objective_history_m2,
        "seed": learning.seed,
        "restarts": restarts,
        "demonstrations": dictionary.residual.as_ref().map(|r| r.expectation.demonstrations()),
        "method": dictionary.choice.as_ref().map(|choice| &choice.method),
        "inputs": inputs,
    })
}
