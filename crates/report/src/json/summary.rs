//! Many sessions as JSON.

use inhand_model::{
    Finger, GroupSummary, MethodSummary, Outlier, PerFinger, SessionMethod, SessionSummary,
    SettingDifference, SharedContacts, Statistics, Summary,
};
use serde::Serialize;

use super::intervals;
use super::wire::{ByFinger, Distribution, Number};
use super::write::distribution;

/// Raised when a key changes its meaning or goes away; new keys alone do not raise it.
const SCHEMA_VERSION: u32 = 1;

#[derive(Serialize)]
pub(super) struct Document<'a> {
    schema_version: u32,
    default_method: &'a str,
    methods: Vec<Method<'a>>,
    intervals: intervals::Document,
    sessions: Vec<Session<'a>>,
    groups: Vec<Group<'a>>,
    outliers: Vec<Unlike<'a>>,
    settings_that_differ: Vec<Setting<'a>>,
}

#[derive(Serialize)]
struct Errors {
    all: Distribution,
    #[serde(flatten)]
    fingers: ByFinger<Distribution>,
}

#[derive(Serialize)]
struct Contacts {
    n: usize,
    three_or_more: usize,
    recorded_three_or_more: usize,
}

#[derive(Serialize)]
struct Method<'a> {
    name: &'a str,
    description: &'a str,
    baseline: bool,
    error_mm: Errors,
    contact_instants: Option<Contacts>,
}

#[derive(Serialize)]
struct Session<'a> {
    name: &'a str,
    file: &'a str,
    participant: Option<&'a str>,
    object: Option<&'a str>,
    task: Option<&'a str>,
    takes: usize,
    duration_s: Number,
    segments: usize,
    left_out: usize,
    warnings: usize,
    methods: Vec<OfSession<'a>>,
}

#[derive(Serialize)]
struct OfSession<'a> {
    name: &'a str,
    error_mm: Errors,
    contact_instants: Option<Contacts>,
}

#[derive(Serialize)]
struct Group<'a> {
    participant: Option<&'a str>,
    object: Option<&'a str>,
    task: Option<&'a str>,
    sessions: usize,
    method: &'a str,
    error_mm: Errors,
}

#[derive(Serialize)]
struct Unlike<'a> {
    session: &'a str,
    file: &'a str,
    what: &'a str,
    unit: &'a str,
    value: Number,
    median: Number,
    modified_z_score: Number,
}

#[derive(Serialize)]
struct Setting<'a> {
    key: &'a str,
    values: &'a [String],
}

/// What is written.
pub(super) fn document(summary: &Summary) -> Document<'_> {
    Document {
        schema_version: SCHEMA_VERSION,
        default_method: &summary.default_method,
        methods: summary.methods.iter().map(method).collect(),
        intervals: intervals::document(&summary.intervals),
        sessions: (summary.sessions.iter())
            .map(|found| session(found, &summary.methods))
            .collect(),
        groups: summary.groups.iter().map(group).collect(),
        outliers: (summary.outliers.iter())
            .map(|found| outlier(found, &summary.sessions))
            .collect(),
        settings_that_differ: summary.differences.iter().map(setting).collect(),
    }
}

fn errors(all: &Statistics, by_finger: &PerFinger<Statistics>) -> Errors {
    Errors {
        all: distribution(all),
        fingers: ByFinger::from_fn(|finger: Finger| distribution(&by_finger[finger])),
    }
}

fn contacts(found: &SharedContacts) -> Contacts {
    Contacts {
        n: found.n,
        three_or_more: found.three_or_more,
        recorded_three_or_more: found.recorded_three_or_more,
    }
}

fn method(found: &MethodSummary) -> Method<'_> {
    Method {
        name: &found.name,
        description: &found.description,
        baseline: found.baseline,
        error_mm: errors(&found.error, &found.error_by_finger),
        contact_instants: found.contacts.as_ref().map(contacts),
    }
}

fn session<'a>(found: &'a SessionSummary, methods: &'a [MethodSummary]) -> Session<'a> {
    let of_session = |(method, own): (&'a MethodSummary, &SessionMethod)| OfSession {
        name: &method.name,
        error_mm: errors(&own.error, &own.error_by_finger),
        contact_instants: own.contacts.as_ref().map(contacts),
    };
    Session {
        name: &found.name,
        file: &found.file,
        participant: found.participant.as_deref(),
        object: found.object.as_deref(),
        task: found.task.as_deref(),
        takes: found.takes,
        duration_s: Number::finite(found.duration_s),
        segments: found.segments,
        left_out: found.left_out,
        warnings: found.warnings,
        methods: methods.iter().zip(&found.methods).map(of_session).collect(),
    }
}

fn group(found: &GroupSummary) -> Group<'_> {
    Group {
        participant: found.participant.as_deref(),
        object: found.object.as_deref(),
        task: found.task.as_deref(),
        sessions: found.sessions,
        method: &found.method,
        error_mm: errors(&found.error, &found.error_by_finger),
    }
}

fn outlier<'a>(found: &'a Outlier, sessions: &'a [SessionSummary]) -> Unlike<'a> {
    let session = &sessions[found.session];
    Unlike {
        session: &session.name,
        file: &session.file,
        what: &found.what,
        unit: found.unit,
        value: Number::finite(found.value),
        median: Number::finite(found.median),
        modified_z_score: Number::finite(found.score),
    }
}

fn setting(found: &SettingDifference) -> Setting<'_> {
    Setting {
        key: &found.key,
        values: &found.values,
    }
}
