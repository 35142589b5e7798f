//! Dictionary part of `inhand info`.

use std::fmt::Write as _;

use inhand_model::{Dictionary, Provenance};
use serde_json::{Value, json};

/// The facts that judge a dictionary, and what it was made from, as lines.
pub(super) fn lines(
    dictionary: &Dictionary,
    made: &[Provenance],
    out: &mut String,
) -> std::fmt::Result {
    let learning = &dictionary.learning;
    writeln!(out, "dictionary")?;
    writeln!(
        out,
        "  {} primitives ({}) from {} segments of {} samples at {} Hz{}",
        dictionary.rank(),
        dictionary.kind.name(),
        learning.segments,
        dictionary.layout.samples,
        dictionary.layout.rate_hz,
        if dictionary.layout.object {
            ", with the object"
        } else {
            ""
        },
    )?;
    writeln!(
        out,
        "  {:.4} mm rms after {} iterations ({}), seed {}",
        learning.rms_m * 1000.0,
        learning.iterations,
        learning.stop_reason.name().replace('_', " "),
        learning.seed,
    )?;
    for restart in &learning.restarts {
        writeln!(
            out,
            "  start with seed {}: {:.4} mm rms, mean matched cosine {:.4}",
            restart.seed,
            restart.rms_m * 1000.0,
            restart.matched_cosine
        )?;
    }
    if let Some(residual) = &dictionary.residual {
        writeln!(
            out,
            "  deviations from the smooth curve: {} primitives, {} demonstrations",
            residual.primitives.ncols(),
            residual.expectation.demonstrations(),
        )?;
    }
    if let Some(choice) = &dictionary.choice {
        writeln!(out, "  best method on left-out takes: {}", choice.method)?;
    }
    for input in made.iter().flat_map(|step| &step.inputs) {
        let short = input.sha256.get(..12).unwrap_or(&input.sha256);
        writeln!(out, "  from {} (sha256 {short}...)", input.name)?;
    }
    Ok(())
}

/// The same for programs.
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
