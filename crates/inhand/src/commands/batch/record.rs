//! `batch.json`: the outcome of each session.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use inhand_session::write_text;
use serde::{Deserialize, Serialize};

use crate::exit::Exit;

/// Name of the file.
pub(super) const FILE: &str = "batch.json";

/// State of a session.
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

/// Outcome of a session.
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
    /// The record of earlier calls, where there is one.
    pub(super) fn read(path: &Path) -> Option<Self> {
        let text = std::fs::read_to_string(path).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// The folder of results that each session has had so far.
    pub(super) fn folders(&self) -> BTreeMap<String, String> {
        let folders = self.sessions.iter();
        folders
            .map(|s| (s.session.clone(), s.name.clone()))
            .collect()
    }

    /// Adds the outcome of a session, or replaces an earlier one.
    pub(super) fn set(&mut self, outcome: Outcome) {
        let mut known = self.sessions.iter_mut();
        match known.find(|known| known.session == outcome.session) {
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
        let complete = |o: &Outcome| matches!(o.state, State::Done | State::UpToDate);
        if self.sessions.iter().all(|o| o.state == State::Failed) {
            Exit::Failed
        } else if self.sessions.iter().all(complete) {
            Exit::Done
        } else {
            Exit::Lossy
        }
    }
}
