//! Results for programs. The contract is `schemas/check.schema.json`.

use serde_json::{Value, json};

use super::checkup::Checkup;
use super::rank::{Checked, Tally};

/// Raised when a key changes its meaning or goes away.
const SCHEMA_VERSION: u32 = 1;

/// The document, with two spaces of indent and a line break at the end.
pub fn to_json(takes: &[Checked]) -> String {
    let tally = Tally::count(takes);
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
        "level": take.level(),
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
        // A number that does not exist is null.
        "results": checkup.results,
    })
}
