//! `batch.json`: what became of each session.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use inhand_session::write_text;
use serde::{Deserialize, Serialize};

use crate::exit::Exit;

/// Name of the file.
pub(super) const FILE: &str = "batch.json";

/// What became of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum State {
    /// Everything was made.
    Done,
    /// Made earlier, and nothing has changed since.
    UpToDate,
    /// Made, but some plans have no trajectory.
    PlansFailed,
    /// Not made.
    Failed,
}

impl State {
    pub(super) const ALL: [State; 4] = [
        State::Done,
        State::UpToDate,
        State::PlansFailed,
        State::Failed,
    ];

    pub(super) const fn words(self) -> &'static str {
        match self {
            State::Done => "done",
            State::UpToDate => "up to date",
            State::PlansFailed => "with plans that failed",
            State::Failed => "failed",
        }
    }
}

/// A session and what became of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Outcome {
    /// Folder of its results, beside the record.
    pub(super) name: String,
    /// The session, from the root.
    pub(super) session: String,
    pub(super) state: State,
    /// Why it failed.
    pub(super) error: Option<String>,
    pub(super) seconds: f64,
}

/// All sessions of a batch so far.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Record {
    pub(super) sessions: Vec<Outcome>,
}

impl Record {
    /// Whether a file is a record of ours.
    pub(super) fn is_one(path: &Path) -> bool {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        serde_json::from_str::<Record>(&text).is_ok()
    }

    /// What earlier calls did; nothing where there is no record.
    pub(super) fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// The folder of results that each session has had so far.
    pub(super) fn folders(&self) -> BTreeMap<String, String> {
        let folders = self.sessions.iter();
        folders
            .map(|s| (s.session.clone(), s.name.clone()))
            .collect()
    }

    /// Adds what became of a session, or replaces what became of it earlier.
    pub(super) fn set(&mut self, outcome: Outcome) {
        match self
            .sessions
            .iter_mut()
            .find(|known| known.session == outcome.session)
        {
            Some(known) => *known = outcome,
            None => self.sessions.push(outcome),
        }
    }

    pub(super) fn write(&self, path: &Path) -> Result<()> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        Ok(write_text(path, &text)?)
    }

    /// Failed where nothing was made; lossy where something is missing.
    pub(super) fn exit(&self) -> Exit {
        let is = |state: State| move |outcome: &Outcome| outcome.state == state;
        if self.sessions.iter().all(is(State::Failed)) {
            Exit::Failed
        } else if (self.sessions.iter()).any(|o| is(State::Failed)(o) || is(State::PlansFailed)(o))
        {
            Exit::Lossy
        } else {
            Exit::Done
        }
    }
}
