//! Result of the inspection of a session: which checks ran, what they found.

use serde::{Deserialize, Serialize};

use crate::names::named;

named! {
    /// How much a result matters.
    #[derive(PartialOrd, Ord, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Level {
        /// Looked at, nothing to do.
        Ok = "ok",
        /// Worth knowing, or no evidence either way.
        Info = "info",
        /// A number may be wrong or data is lost.
        Warn = "warn",
        /// The take or the setting cannot be used as it is.
        Fail = "fail",
    }
}

/// Something that a check of a session found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SessionFinding {
    /// The check: a stable word for programs, by which the finding is accepted.
    pub id: String,
    /// How much it matters; kept where the finding is accepted.
    pub level: Level,
    /// Whether the settings accept it.
    pub accepted: bool,
    /// Takes in which it was found; empty for the session's settings.
    pub takes: Vec<String>,
    /// The marker, body, role or setting; may be empty.
    pub entity: String,
    /// Where in the first of the takes, from and to, seconds after its first sample, in order of time, the first 100;
    /// empty where it is everywhere or not at a time.
    #[serde(default)]
    pub places_s: Vec<[f64; 2]>,
    /// What was found; of several takes, in the first one.
    pub found: String,
    /// What to do about it.
    pub advice: String,
}

impl SessionFinding {
    /// Whether it is of this level or worse, and not accepted.
    pub fn counts_as(&self, level: Level) -> bool {
        self.level >= level && !self.accepted
    }

    /// Takes and entity, for messages; empty for the whole session.
    pub fn place(&self) -> String {
        let takes = match &self.takes[..] {
            [first, _, rest @ ..] if !rest.is_empty() => {
                format!("{first} and {} more takes", rest.len() + 1)
            }
            takes => takes.join(" and "),
        };
        let parts = [takes.as_str(), &self.entity];
        let parts: Vec<_> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        parts.join(", ")
    }
}

/// One line: identifier, place, what was found, what to do.
impl std::fmt::Display for SessionFinding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let place = self.place();
        let open = if place.is_empty() { "" } else { " (" };
        let close = if place.is_empty() { "" } else { ")" };
        write!(f, "{}{open}{place}{close}: {}", self.id, self.found)?;
        if !self.advice.is_empty() {
            write!(f, "; {}", self.advice)?;
        }
        f.write_str(if self.accepted { " [accepted]" } else { "" })
    }
}

/// What was looked at in a session, and what was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Inspection {
    /// Identifiers of the checks that ran.
    pub checks: Vec<String>,
    /// What they found, worst first.
    pub findings: Vec<SessionFinding>,
}

impl Inspection {
    /// Findings of a level or worse that are not accepted.
    pub fn counted(&self, level: Level) -> impl Iterator<Item = &SessionFinding> {
        self.findings.iter().filter(move |f| f.counts_as(level))
    }

    /// Checks that ran and found nothing worse than [`Level::Info`].
    pub fn passed(&self) -> Vec<&str> {
        let found = |id: &str| {
            self.findings
                .iter()
                .any(|f| f.id == id && f.level > Level::Info)
        };
        let checks = self.checks.iter().map(String::as_str);
        checks.filter(|id| !found(id)).collect()
    }
}
