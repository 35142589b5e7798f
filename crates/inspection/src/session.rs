//! Inspection of a session: every take by itself, takes against each other, settings against the data.

mod plausibility;

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use inhand_model::{
    BodySource, Finger, Inspection, Level, Motion, Recording, Roles, SessionFinding, Shape,
};
use inhand_motion::MotionError;
use rayon::prelude::*;

use crate::check::{CheckResult, CheckSettings, check};
use crate::detect;
use crate::lookup::is_named_after;
use crate::suspect::{Suspect, SuspectKind};

pub use plausibility::{filter_moves_m, inspect_results};

/// Every check of a session, by the identifier that accepts its findings: those of takes, then those of takes
/// together, of settings and of results.
pub const SESSION_CHECKS: [&str; TAKE_CHECKS + 11] = [
    "units",
    "finger-place",
    "finger-spread",
    "axes",
    "orientation",
    "rigidity",
    "marker-error",
    "swaps",
    "flips",
    "spikes",
    "unlabelled-stretches",
    "frozen",
    "frozen-other",
    "segments",
    "gaps",
    "gaps-other",
    "never-seen",
    "unlabelled",
    "rate",
    "exported-rate",
    "repeated-frames",
    "frame-jumps",
    "time-column",
    "declared-count",
    "damaged-samples",
    "start-time",
    "up-axis",
    "duplicate-names",
    "source",
    "same-take",
    "object-is-hand",
    "no-shape",
    "object-size",
    "tau",
    "filter-window",
    "margin",
    "primitives",
    "contact-share",
    "filter-moves",
    "finger-order",
];

/// How many of [`SESSION_CHECKS`] look at single takes.
const TAKE_CHECKS: usize = 29;

/// Distance from its path from which a spike of a fingertip is more than noise, metres...
const SPIKE_M: f64 = 0.01;

/// ...and share of a marker's samples in spikes from which it is.
const SPIKE_SHARE: f64 = 0.02;

/// A take of a session and its motion in the hand's frame.
#[derive(Clone, Copy, Debug)]
pub struct SessionMotion<'a> {
    /// Name of the take.
    pub name: &'a str,
    /// What is used of it.
    pub recording: &'a Recording,
    /// Hand, object and fingertips.
    pub roles: &'a Roles,
    /// In the hand's frame, gaps filled, not filtered.
    pub motion: &'a Motion,
    /// Whether it is for training.
    pub train: bool,
}

/// Settings of a session as its inspection needs them.
#[derive(Clone, Debug)]
pub struct SessionLimits<'a> {
    /// Limits of the checks of takes; how takes are processed.
    pub check: CheckSettings,
    /// Shape of the object, where it is given.
    pub shape: Option<Shape>,
    /// Largest distance that counts as contact, metres.
    pub tau_m: f64,
    /// Identifiers of findings that are accepted.
    pub accept: &'a [String],
}

/// Looks at takes and settings before anything is learned.
///
/// # Errors
///
/// [`MotionError`] for roles that are not in a take.
pub fn inspect(
    takes: &[SessionMotion<'_>],
    limits: &SessionLimits<'_>,
) -> Result<Inspection, MotionError> {
    let mut inspection = Inspection::default();
    let looks: Vec<_> = (takes.par_iter())
        .map(|take| take_findings(take, limits))
        .collect::<Result<_, _>>()?;
    let found = looks.into_iter().flatten().collect();
    add(
        &mut inspection,
        &SESSION_CHECKS[..TAKE_CHECKS],
        found,
        limits,
    );
    if takes.len() > 1 {
        add(&mut inspection, &["same-take"], same_takes(takes), limits);
    }
    plausibility::settings(&mut inspection, takes, limits);
    Ok(inspection)
}

/// Adds checks that ran and what they found. Findings alike in several takes become one.
fn add(
    inspection: &mut Inspection,
    checks: &[&str],
    found: Vec<SessionFinding>,
    limits: &SessionLimits<'_>,
) {
    (inspection.checks).extend(checks.iter().map(|&id| id.to_owned()));
    for mut finding in found {
        finding.accepted = finding.level > Level::Info && limits.accept.contains(&finding.id);
        let is_alike = |other: &&mut SessionFinding| {
            let key = |f: &SessionFinding| (f.id.clone(), f.level, f.entity.clone());
            key(other) == key(&finding) && !finding.takes.iter().any(|t| other.takes.contains(t))
        };
        match inspection.findings.iter_mut().find(is_alike) {
            Some(other) => other.takes.extend(finding.takes),
            None => inspection.findings.push(finding),
        }
    }
    // Stable: findings of one level stay in the order of the checks.
    (inspection.findings).sort_by_key(|finding| std::cmp::Reverse(finding.level));
}

fn finding(id: &str, level: Level, found: String, advice: impl Into<String>) -> SessionFinding {
    SessionFinding {
        id: id.to_owned(),
        level,
        accepted: false,
        takes: Vec::new(),
        entity: String::new(),
        found,
        advice: advice.into(),
    }
}

/// What `check` and the detectors of `clean` find in a take.
fn take_findings(
    take: &SessionMotion<'_>,
    limits: &SessionLimits<'_>,
) -> Result<Vec<SessionFinding>, MotionError> {
    let suspects = detect::all(take.recording, Some(take.roles))?;
    let results = check(take.recording, Ok(take.roles), &suspects, &limits.check).results;
    let findings = (results.into_iter())
        .filter(|result| result.level > Level::Ok)
        .map(|result| {
            let level = session_level(&result, take, &suspects);
            let CheckResult {
                id,
                entity,
                found,
                advice,
                ..
            } = result;
            SessionFinding {
                takes: vec![take.name.to_owned()],
                entity,
                ..finding(id, level, found, advice)
            }
        });
    Ok(findings.collect())
}

/// How much a result matters in a session, where other takes and the roles are known.
fn session_level(result: &CheckResult, take: &SessionMotion<'_>, suspects: &[Suspect]) -> Level {
    let has_number = |name| result.numbers.iter().any(|number| number.name == name);
    match (result.id, result.level) {
        // Another unit makes it a hand: every length would be wrong.
        ("units", Level::Warn) if has_number("hand_then_mm") => Level::Fail,
        // What gaps cost is said by the segments; a take may give none where others do.
        ("gaps", Level::Warn) => Level::Info,
        ("segments", Level::Fail) => Level::Warn,
        ("spikes" | "flips" | "orientation" | "rigidity" | "marker-error" | "axes", level)
            if level > Level::Info =>
        {
            let slight = result.id == "spikes" && !are_large(&result.entity, take, suspects);
            if slight || !plays_a_role(&result.entity, take.roles) {
                Level::Info
            } else {
                level
            }
        }
        (_, level) => level,
    }
}

/// Whether spikes of a marker are more than noise, which the filter removes.
fn are_large(marker: &str, take: &SessionMotion<'_>, suspects: &[Suspect]) -> bool {
    let (mut off, mut samples) = (0.0_f64, 0);
    for suspect in suspects {
        if let SuspectKind::Spike { name, off_m, .. } = &suspect.kind
            && name == marker
        {
            off = off.max(*off_m);
            samples += suspect.samples.len();
        }
    }
    off >= SPIKE_M || samples as f64 > SPIKE_SHARE * take.recording.len() as f64
}

/// Whether a marker or body has a role or belongs to a body that has one.
fn plays_a_role(name: &str, roles: &Roles) -> bool {
    let in_source = |source: &BodySource| match source {
        BodySource::RigidBody(body) => body == name || is_named_after(name, body),
        BodySource::Markers(markers) => markers.iter().any(|marker| marker == name),
    };
    let mut sources = std::iter::once(&roles.hand).chain(&roles.object);
    roles.fingers.as_array().iter().any(|marker| marker == name) || sources.any(in_source)
}

/// Takes of one role that share most positions of the thumb to the last digit, whenever these were.
fn same_takes(takes: &[SessionMotion<'_>]) -> Vec<SessionFinding> {
    let mut findings = Vec::new();
    let mut first_seen: HashMap<(bool, [u64; 3]), usize> = HashMap::new();
    let mut samples = Vec::with_capacity(takes.len());
    for (n, take) in takes.iter().enumerate() {
        let marker = take.recording.marker(&take.roles.fingers[Finger::Thumb]);
        let mut shared = vec![0; n];
        let mut own = 0;
        for place in marker
            .into_iter()
            .flat_map(|marker| marker.track.iter().flatten())
        {
            own += 1;
            match first_seen.entry((take.train, place.to_array().map(f64::to_bits))) {
                Entry::Vacant(entry) => {
                    entry.insert(n);
                }
                Entry::Occupied(entry) if *entry.get() < n => shared[*entry.get()] += 1,
                Entry::Occupied(_) => {}
            }
        }
        samples.push(own);
        let most = (0..n).max_by_key(|&other| shared[other]);
        if let Some(other) = most
            && 2 * shared[other] > own.min(samples[other])
        {
            let found = format!(
                "{} of {own} positions of the thumb are those of {}",
                shared[other], takes[other].name
            );
            findings.push(SessionFinding {
                takes: vec![take.name.to_owned()],
                ..finding(
                    "same-take",
                    Level::Fail,
                    found,
                    "remove one of the two takes",
                )
            });
        }
    }
    findings
}
