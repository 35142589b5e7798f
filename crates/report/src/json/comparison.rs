//! Two evaluations side by side as JSON.

use inhand_model::{Drawn, Estimate, EvaluationComparison, Finger};
use serde::Serialize;

use super::intervals::{Interval, interval};
use super::wire::Number;
use crate::number::to_mm;

const SCHEMA_VERSION: u32 = 1;
const MM_PER_M: f64 = 1e3;

#[derive(Serialize)]
pub(super) struct Document<'a> {
    schema_version: u32,
    before: Side<'a>,
    after: Side<'a>,
    segments_drawn: &'static str,
    draws: usize,
    seed: u64,
    confidence: f64,
    errors: Vec<Error<'a>>,
    contacts: Vec<Contact<'a>>,
    settings_that_differ: Vec<Setting<'a>>,
}

#[derive(Serialize)]
struct Side<'a> {
    file: &'a str,
    session: &'a str,
}

#[derive(Serialize)]
struct Error<'a> {
    before_method: &'a str,
    after_method: &'a str,
    finger: &'static str,
    measure: &'static str,
    before_mm: Number,
    after_mm: Number,
    relative_change: Number,
    absolute_mm: Option<Interval>,
    relative: Option<Interval>,
}

#[derive(Serialize)]
struct Contact<'a> {
    before_method: &'a str,
    after_method: &'a str,
    three_or_more_before: Number,
    three_or_more_after: Number,
    absolute: Option<Interval>,
}

#[derive(Serialize)]
struct Setting<'a> {
    key: &'a str,
    before: &'a str,
    after: &'a str,
}

/// What is written.
pub(super) fn document(comparison: &EvaluationComparison) -> Document<'_> {
    let scaled =
        |found: &Option<Estimate>, factor| found.as_ref().map(|found| interval(found, factor));
    Document {
        schema_version: SCHEMA_VERSION,
        before: Side {
            file: &comparison.before.file,
            session: &comparison.before.session,
        },
        after: Side {
            file: &comparison.after.file,
            session: &comparison.after.session,
        },
        segments_drawn: match comparison.drawn {
            Drawn::Together => "together",
            Drawn::Apart => "apart",
            Drawn::NotAtAll => "not_at_all",
        },
        draws: comparison.bootstrap.draws,
        seed: comparison.bootstrap.seed,
        confidence: comparison.bootstrap.confidence,
        errors: (comparison.errors.iter())
            .map(|change| Error {
                before_method: &change.before_method,
                after_method: &change.after_method,
                finger: change.finger.map_or("all", Finger::name),
                measure: change.measure.name(),
                before_mm: Number::finite(to_mm(change.before_m)),
                after_mm: Number::finite(to_mm(change.after_m)),
                relative_change: Number::finite(change.relative_change()),
                absolute_mm: scaled(&change.absolute, MM_PER_M),
                relative: scaled(&change.relative, 1.0),
            })
            .collect(),
        contacts: (comparison.contacts.iter())
            .map(|change| Contact {
                before_method: &change.before_method,
                after_method: &change.after_method,
                three_or_more_before: Number::finite(change.before),
                three_or_more_after: Number::finite(change.after),
                absolute: scaled(&change.absolute, 1.0),
            })
            .collect(),
        settings_that_differ: (comparison.settings.iter())
            .map(|difference| Setting {
                key: &difference.key,
                before: difference.values.first().map_or("", String::as_str),
                after: difference.values.last().map_or("", String::as_str),
            })
            .collect(),
    }
}
