//! Inspection of a session: every take by itself, takes against each other, settings against the data.

mod alike;
mod hand;
mod object;
mod plausibility;

use inhand_model::{
    BodySource, Finger, Inspection, Level, Motion, PerFinger, Recording, Roles, SessionFinding,
    Shape,
};
use inhand_motion::MotionError;

use crate::check::CUT_SHORT;
use crate::check::{CheckResult, CheckSettings, check};
use crate::detect;
use crate::lookup::is_named_after;
use crate::suspect::{Suspect, SuspectKind};

pub use alike::{Alike, ExactPosition, exact_positions, takes_alike};
pub use plausibility::inspect_results;

/// Every check of a session, by the identifier that accepts its findings: those of takes, then those of takes
/// together, of settings and of results.
pub const SESSION_CHECKS: [&str; TAKE_CHECKS + 17] = [
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
    CUT_SHORT,
    "declared-count",
    "damaged-samples",
    "start-time",
    "up-axis",
    "duplicate-names",
    "source",
    "finger-order",
    "hand-rotation",
    "noise",
    "object-is-hand",
    "no-shape",
    "object-fit",
    "same-take",
    "takes-disagree",
    "hand-size",
    "object-size",
    "tau",
    "filter-window",
    "margin",
    "held-out-resampled",
    "primitives",
    "contact-share",
    "filter-moves",
];

/// How many of [`SESSION_CHECKS`] are those of [`check`] and of the detectors.
const TAKE_CHECKS: usize = 30;

/// Checks that say what they found wherever there is evidence: those silent about a take did not look at it.
const NEED_EVIDENCE: [&str; 6] = [
    "units",
    "axes",
    "orientation",
    "rigidity",
    "marker-error",
    "up-axis",
];

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
    /// Signed distance of each pad from the object's surface at each sample, metres; empty where its shape or pose
    /// is not known.
    pub distances_m: &'a [Option<PerFinger<f64>>],
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
    /// Length of the lines that held-out ends are taken from, seconds.
    pub ends_s: f64,
    /// Findings that are accepted: `ID`, or `ID:TAKE` in one take.
    pub accept: &'a [String],
    /// Whether recordings are resampled.
    pub resampled: bool,
}

/// What is kept of a take that was looked at, to compare it with others.
#[derive(Clone, Debug)]
pub struct TakeLook {
    name: String,
    train: bool,
    rate_hz: f64,
    checks: Vec<&'static str>,
    findings: Vec<SessionFinding>,
    tips: Option<hand::Tips>,
    thumb: Vec<ExactPosition>,
}

impl TakeLook {
    /// Looks at a take by itself.
    ///
    /// # Errors
    ///
    /// [`MotionError`] for roles that are not in the take.
    pub fn new(take: &SessionMotion<'_>, limits: &SessionLimits<'_>) -> Result<Self, MotionError> {
        let (mut checks, mut findings) = take_findings(take, limits)?;
        let mut look = |id, found: Vec<SessionFinding>| {
            checks.push(id);
            findings.extend(found);
        };
        let few = |found: Option<SessionFinding>| found.into_iter().collect();
        look("finger-order", few(plausibility::finger_order(take)));
        if let Some(found) = hand::hand_rotation(take) {
            look("hand-rotation", found);
        }
        look("noise", hand::noise(take));
        if take.roles.object.is_some() {
            look("object-is-hand", few(object::object_is_hand(take)));
        }
        if limits.shape.is_none() {
            look("no-shape", few(object::no_shape(take)));
        }
        if !take.distances_m.is_empty() {
            look("object-fit", few(object::object_fit(take, limits.tau_m)));
        }
        let thumb = take.recording.marker(&take.roles.fingers[Finger::Thumb]);
        Ok(Self {
            name: take.name.to_owned(),
            train: take.train,
            rate_hz: take.motion.clock.rate_hz(),
            checks,
            findings,
            tips: hand::median_tips(take),
            thumb: exact_positions(thumb.map(|marker| &marker.track)),
        })
    }
}

/// Looks at takes together and at settings before anything is learned.
pub fn inspect(takes: &[TakeLook], limits: &SessionLimits<'_>) -> Inspection {
    let mut inspection = Inspection::default();
    let ran = |id: &&&str| takes.iter().any(|take| take.checks.contains(id));
    let checks: Vec<_> = SESSION_CHECKS.iter().filter(ran).copied().collect();
    let found = takes
        .iter()
        .flat_map(|take| take.findings.clone())
        .collect();
    add(&mut inspection, &checks, found, limits);
    if takes.len() > 1 {
        let disagree = hand::takes_disagree(takes);
        let size = hand::hand_size(takes).into_iter().collect();
        add(&mut inspection, &["same-take"], same_takes(takes), limits);
        add(&mut inspection, &["takes-disagree"], disagree, limits);
        add(&mut inspection, &["hand-size"], size, limits);
    }
    let rate_hz = takes.first().map_or(f64::NAN, |take| take.rate_hz);
    plausibility::settings(&mut inspection, rate_hz, limits);
    inspection
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
        finding.accepted = finding.level > Level::Info && accepts(limits.accept, &finding);
        let is_alike = |other: &&mut SessionFinding| {
            let key = |f: &SessionFinding| (f.id.clone(), f.level, f.accepted, f.entity.clone());
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

/// Whether `ID` or `ID:TAKE` is accepted.
fn accepts(accept: &[String], finding: &SessionFinding) -> bool {
    accept.iter().any(|entry| match entry.split_once(':') {
        Some((id, take)) => id == finding.id && finding.takes == [take],
        None => *entry == finding.id,
    })
}

fn finding(id: &str, level: Level, found: String, advice: impl Into<String>) -> SessionFinding {
    SessionFinding {
        id: id.to_owned(),
        level,
        accepted: false,
        takes: Vec::new(),
        entity: String::new(),
        places_s: Vec::new(),
        found,
        advice: advice.into(),
    }
}

fn of_take(take: &SessionMotion<'_>, finding: SessionFinding) -> SessionFinding {
    SessionFinding {
        takes: vec![take.name.to_owned()],
        ..finding
    }
}

/// What `check` and the detectors of `clean` find in a take, after the checks for which it has evidence.
fn take_findings(
    take: &SessionMotion<'_>,
    limits: &SessionLimits<'_>,
) -> Result<(Vec<&'static str>, Vec<SessionFinding>), MotionError> {
    let suspects = detect::all(take.recording, Some(take.roles))?;
    let results = check(take.recording, Ok(take.roles), &suspects, &limits.check).results;
    let has_evidence = |id: &str| {
        let mut of_id = results.iter().filter(|result| result.id == id);
        of_id.any(|result| !result.is_without_evidence())
    };
    let ran = |id: &&str| match *id {
        "flips" => !take.recording.bodies.is_empty(),
        id => !NEED_EVIDENCE.contains(&id) || has_evidence(id),
    };
    let checks = SESSION_CHECKS[..TAKE_CHECKS]
        .iter()
        .copied()
        .filter(ran)
        .collect();
    let found = results
        .into_iter()
        .filter(|result| result.level > Level::Ok);
    let findings = found.map(|result| {
        let level = session_level(&result, take, &suspects);
        SessionFinding {
            entity: result.entity,
            places_s: result
                .places
                .iter()
                .map(|at| [at.from_s, at.to_s])
                .collect(),
            ..of_take(take, finding(result.id, level, result.found, result.advice))
        }
    });
    Ok((checks, findings.collect()))
}

/// How much a result matters in a session, where other takes and the roles are known.
fn session_level(result: &CheckResult, take: &SessionMotion<'_>, suspects: &[Suspect]) -> Level {
    let has_number = |name| result.numbers.iter().any(|number| number.name == name);
    match (result.id, result.level) {
        // Another unit makes it a hand: every length would be wrong.
        ("units", Level::Warn) if has_number("hand_then_mm") => Level::Fail,
        ("axes", Level::Warn)
            if has_number("wander_then_mm") && is_hand(&result.entity, take.roles) =>
        {
            Level::Fail
        }
        ("up-axis", Level::Warn) => Level::Info,
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

fn is_hand(body: &str, roles: &Roles) -> bool {
    matches!(&roles.hand, BodySource::RigidBody(hand) if hand == body)
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

/// Takes of one role that share most positions of the thumb.
fn same_takes(takes: &[TakeLook]) -> Vec<SessionFinding> {
    let of_role = |train| {
        let takes: Vec<_> = takes.iter().filter(|take| take.train == train).collect();
        let thumbs: Vec<_> = takes.iter().map(|take| &take.thumb).collect();
        let findings = takes_alike(&thumbs).into_iter().map(|alike| {
            let Alike { shared, own, .. } = alike;
            let other = &takes[alike.other].name;
            let found = format!("{shared} of {own} positions of the thumb are those of {other}");
            let advice = "remove one of the two takes";
            SessionFinding {
                takes: vec![takes[alike.take].name.clone()],
                ..finding("same-take", Level::Fail, found, advice)
            }
        });
        findings.collect::<Vec<_>>()
    };
    [true, false].into_iter().flat_map(of_role).collect()
}
