//! Many sessions together.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::evaluation::MethodEvaluation;
use crate::finger::HandAndFingers;
use crate::intervals::Intervals;
use crate::statistics::Statistics;
use crate::units::{Millimetres, Unit};

/// What many sessions say together. Statistics over sessions are those of all their instants together, not
/// means of the sessions' statistics.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The method to look at first: the one most sessions look at first.
    pub default_method: String,
    /// Methods that every session evaluated, in the order of the first.
    pub methods: Vec<MethodSummary>,
    /// Intervals over sessions.
    pub intervals: Intervals,
    /// The same under the held-out protocol; `None` where a session has no such errors or no rows of them.
    pub held_out: Option<HeldOutSummary>,
    /// The sessions, in the order given.
    pub sessions: Vec<SessionSummary>,
    /// Sessions of the same participant, object and task together: the default method and the best baseline.
    pub groups: Vec<GroupSummary>,
    /// Sessions in which something is far from what it is in the others.
    pub outliers: Vec<Outlier>,
    /// Settings that are not the same in all sessions.
    #[serde(rename = "settings_that_differ")]
    pub differences: Vec<SettingDifference>,
}

/// Methods over all sessions under the held-out protocol.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldOutSummary {
    /// Methods, in the order of the published protocol.
    pub methods: Vec<MethodSummary>,
    /// Intervals over sessions.
    pub intervals: Intervals,
}

/// One session among many.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SessionSummary {
    /// Name.
    pub name: String,
    /// File of its evaluation and the folder that it is in.
    pub file: String,
    /// Who was recorded, where that is stated.
    pub participant: Option<String>,
    /// Object shape in words.
    pub object: Option<String>,
    /// What they did, where that is stated.
    pub task: Option<String>,
    /// Test takes.
    pub takes: usize,
    /// Their length, seconds.
    pub duration_s: f64,
    /// Test segments.
    pub segments: usize,
    /// Segments that test takes without gaps would have given in addition.
    pub left_out: usize,
    /// Findings about its takes that are warnings.
    pub warnings: usize,
    /// What the session's own evaluation says of each method, in the order of the summary.
    pub methods: Vec<SessionMethod>,
}

/// One method in one session.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SessionMethod {
    /// Name.
    pub name: String,
    /// Error over all fingers and instants.
    #[serde(rename = "error_mm", with = "Millimetres")]
    pub error: HandAndFingers<Statistics>,
    /// The same under the held-out protocol, where all sessions have it.
    #[serde(rename = "held_out_error_mm", with = "Millimetres")]
    pub held_out: Option<HandAndFingers<Statistics>>,
    /// Contacts, where an object is known.
    #[serde(rename = "contact_instants")]
    pub contacts: Option<SharedContacts>,
}

impl SessionMethod {
    /// Error under the protocol to look at first.
    pub fn headline(&self) -> &HandAndFingers<Statistics> {
        self.held_out.as_ref().unwrap_or(&self.error)
    }
}

/// Instants with three or more contacts, counted so that sessions can be added up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SharedContacts {
    /// Instants judged.
    pub n: usize,
    /// Those with three or more contacts, planned.
    pub three_or_more: usize,
    /// The same, recorded.
    pub recorded_three_or_more: usize,
}

impl SharedContacts {
    /// Counts behind the shares that an evaluation states; shares of whole instants come back exactly. `None` without
    /// an object.
    pub fn stated(method: &MethodEvaluation) -> Option<Self> {
        let contact = method.contact.as_ref().filter(|contact| contact.n > 0)?;
        let count = |share: f64| (share * contact.n as f64).round() as usize;
        Some(Self {
            n: contact.n,
            three_or_more: count(contact.three_or_more),
            recorded_three_or_more: count(contact.recorded_three_or_more),
        })
    }

    /// Those of both.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            n: self.n.saturating_add(other.n),
            three_or_more: self.three_or_more.saturating_add(other.three_or_more),
            recorded_three_or_more: self
                .recorded_three_or_more
                .saturating_add(other.recorded_three_or_more),
        }
    }
}

/// One method over all sessions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodSummary {
    /// Name.
    pub name: String,
    /// What it knows and does, in a line.
    pub description: String,
    /// Whether it uses nothing learned.
    pub baseline: bool,
    /// Error over all fingers, instants and sessions.
    #[serde(rename = "error_mm", with = "Millimetres")]
    pub error: HandAndFingers<Statistics>,
    /// Contacts of the sessions with an object.
    #[serde(rename = "contact_instants")]
    pub contacts: Option<SharedContacts>,
}

/// Sessions of the same kind together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GroupSummary {
    /// Participant; `None` where it is not stated.
    pub participant: Option<String>,
    /// Object.
    pub object: Option<String>,
    /// Task.
    pub task: Option<String>,
    /// Sessions in it.
    pub sessions: usize,
    /// Method.
    pub method: String,
    /// Error over all fingers and instants of its sessions.
    #[serde(rename = "error_mm", with = "Millimetres")]
    pub error: HandAndFingers<Statistics>,
}

/// Something about a session that is far from what it is in the others.
///
/// Far is a modified z-score of more than 3.5: `0.6745 (value - median) / MAD`, with the median absolute deviation
/// from the median (Iglewicz and Hoaglin, *How to detect and handle outliers*, 1993); where that is 0, because most
/// sessions agree to the last digit, `0.7979 (value - median) / mean absolute deviation`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outlier {
    /// The session.
    #[serde(flatten)]
    pub session: OutlierSession,
    /// What is far off, in words.
    pub what: String,
    /// `mm`, `%` or nothing.
    pub unit: &'static str,
    /// What it is there, in that unit.
    pub value: f64,
    /// The median over sessions.
    pub median: f64,
    /// Modified z-score.
    #[serde(rename = "modified_z_score")]
    pub score: f64,
}

/// The session of an outlier.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutlierSession {
    /// Place in the summary.
    #[serde(skip)]
    pub place: usize,
    /// Name.
    #[serde(rename = "session")]
    pub name: String,
    /// File of its evaluation.
    pub file: String,
}

/// A setting that sessions do not share.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SettingDifference {
    /// Key, such as `learn.rank`.
    pub key: String,
    /// The value in each session, in their order; `not set` where it is not stated.
    pub values: Vec<String>,
}

impl SettingDifference {
    /// Differences among settings by key, those of each session.
    pub fn among(settings: &[BTreeMap<String, String>]) -> Vec<Self> {
        let keys: BTreeSet<&String> = settings.iter().flat_map(BTreeMap::keys).collect();
        let values = |key: &String| -> Vec<String> {
            let of_session = |own: &BTreeMap<String, String>| own.get(key).cloned();
            let values = settings.iter().map(of_session);
            values
                .map(|value| value.unwrap_or_else(|| "not set".to_owned()))
                .collect()
        };
        keys.into_iter()
            .map(|key| Self {
                key: key.clone(),
                values: values(key),
            })
            .filter(|own| own.values.iter().any(|value| *value != own.values[0]))
            .collect()
    }
}
