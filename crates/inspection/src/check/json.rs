//! Results for programs. The contract is `schemas/check.schema.json`.

use serde_json::{Value, json};

use super::checkup::{CheckResult, Checkup};
use super::rank::{Checked, Tally};

/// Raised when a key changes its meaning or goes away.
const SCHEMA_VERSION: u32 = 1;

/// The document, with two spaces of indent and a line break at the end.
pub fn to_json(takes: &[Checked]) -> String {
    let tally = Tally::of(takes);
    let document = json!({
        "schema_version": SCHEMA_VERSION,
        "summary": {
            "takes": takes.len(),
            "unreadable": tally.unreadable,
            "fail": tally.fail,
            "warn": tally.warn,
            "ok": tally.ok,
        },
        "takes": takes.iter().map(take).collect::<Vec<_>>(),
    });
    format!("{document:#}\n")
}

fn take(take: &Checked) -> Value {
    let (checkup, error) = match &take.outcome {
        Ok(checkup) => (content(checkup), Value::Null),
        Err(why) => (Value::Null, json!(why)),
    };
    json!({
        "file": take.file,
        "level": take.level().name(),
        "score": take.score(),
        "error": error,
        "checkup": checkup,
    })
}

fn content(checkup: &Checkup) -> Value {
    json!({
        "take": checkup.take,
        "format": checkup.format,
        "samples": checkup.samples,
        "rate_hz": checkup.rate_hz,
        "duration_s": checkup.duration_s,
        "segments": checkup.segments.map(|segments| json!({
            "usable": segments.usable,
            "possible": segments.possible,
            "share": segments.share(),
        })),
        "results": checkup.results.iter().map(result).collect::<Vec<_>>(),
    })
}

fn result(result: &CheckResult) -> Value {
    let places = result.places.iter();
    let numbers = result.numbers.iter();
    json!({
        "id": result.id,
        "level": result.level.name(),
        "entity": result.entity,
        "places": places.map(|p| json!({ "from_s": p.from_s, "to_s": p.to_s })).collect::<Vec<_>>(),
        "expected": result.expected,
        "found": result.found,
        "advice": result.advice,
        // A number that does not exist is null.
        "numbers": numbers
            .map(|x| json!({ "name": x.name, "value": x.value, "n": x.n }))
            .collect::<Vec<_>>(),
    })
}
