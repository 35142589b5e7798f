//! Checks of source findings, names and roles.

use std::collections::BTreeMap;

use inhand_model::{Finding, MarkerKind, Recording, Setting, Severity};

use super::checkup::{CheckResult, Level};
use super::subject::Subject;
use super::words::{count, names};

/// Identifier of files that end before they should: data was lost.
pub const CUT_SHORT: &str = "cut-short";

/// Whether a finding says that the file ends before it should.
pub fn is_cut_short(finding: &Finding) -> bool {
    finding_id(finding) == CUT_SHORT
}

/// Identifiers of what readers find, by words of their messages; anything else is `source`.
const FINDINGS: [(&str, &str); 8] = [
    ("leaves out", "frame-jumps"),
    ("the file was cut", CUT_SHORT),
    ("time column", "time-column"),
    ("promises", "declared-count"),
    ("start time", "start-time"),
    ("the take starts at", "start-time"),
    ("half of the day", "start-time"),
    ("taken as missing", "damaged-samples"),
];

/// What the reader found, in its order.
pub(crate) fn findings(recording: &Recording) -> Vec<CheckResult> {
    let result = |finding: &Finding| {
        let level = match finding.severity {
            Severity::Info => Level::Info,
            Severity::Warning => Level::Warn,
        };
        let advice = match (level, finding_id(finding)) {
            (Level::Warn, "frame-jumps") => {
                "the file was cut or edited after the export: use the original, if there is one"
            }
            // The finding says what happened to the file.
            (Level::Warn, "declared-count" | CUT_SHORT) => "use the original, if there is one",
            (Level::Warn, "time-column") => "check the rate that the file states",
            (Level::Warn, "damaged-samples") => "export again",
            _ => "",
        };
        CheckResult::new(finding_id(finding), level, "")
            .found(finding.to_string())
            .advice(advice)
    };
    recording.findings.iter().map(result).collect()
}

pub(crate) fn finding_id(finding: &Finding) -> &'static str {
    let known = FINDINGS
        .iter()
        .find(|(words, _)| finding.message.contains(words));
    known.map_or("source", |(_, id)| id)
}

/// Names that more than one entity of a kind has.
pub(crate) fn duplicate_names(subject: &Subject<'_>) -> Option<CheckResult> {
    let Recording {
        markers, bodies, ..
    } = subject.recording;
    let markers_named = (markers.iter())
        .filter(|m| m.kind != MarkerKind::Unlabelled)
        .map(|m| (m.kind.name(), m.name.as_str()));
    let named = markers_named.chain(bodies.iter().map(|b| (b.kind.name(), b.name.as_str())));
    let mut seen: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    named.for_each(|name| *seen.entry(name).or_default() += 1);
    seen.retain(|_, n| *n > 1);
    if seen.is_empty() {
        return None;
    }
    let (level, advice) = if seen.keys().any(|(_, name)| subject.plays_a_role(name)) {
        (
            Level::Warn,
            "the first one is used: rename them in the capture software",
        )
    } else {
        (Level::Info, "")
    };
    let double = count(seen.len(), ["name that", "names that"]);
    let listed = names(seen.keys().map(|&(_, name)| name));
    Some(
        CheckResult::new("duplicate-names", level, "")
            .expected("a name of its own for each entity of a kind")
            .found(format!("{double} more than one entity has: {listed}"))
            .advice(advice)
            .number("names", seen.len() as f64, markers.len() + bodies.len()),
    )
}

/// Roles that are not known, with the reason.
pub(crate) fn roles_open(why: &str) -> CheckResult {
    let (fingers, hand) = (Setting::Fingers, Setting::Hand);
    CheckResult::new("roles", Level::Fail, "")
        .expected("a hand and a marker on each of five fingertips")
        .found(what_and_what_there_is(why))
        .advice(format!(
            "assign roles with {fingers} FINGER=MARKER and {hand} NAME, or in inhand.toml"
        ))
}

/// A message with what the take has, in a line; the advice has a place of its own.
pub(crate) fn what_and_what_there_is(why: &str) -> String {
    let lines = why.lines().map(str::trim);
    let lines: Vec<_> = lines.filter(|line| !line.starts_with("say it")).collect();
    lines.join("; ")
}
