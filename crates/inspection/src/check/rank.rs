//! Many takes, the worst first.

use super::checkup::{Checkup, Level};

/// A file that was checked, or the reason why it could not be.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The file, as its user named it.
    pub file: String,
    /// What was found, or why the file cannot be read.
    pub outcome: Result<Checkup, String>,
}

impl Checked {
    /// The worst level; a file that cannot be read fails.
    pub fn level(&self) -> Level {
        self.outcome.as_ref().map_or(Level::Fail, Checkup::level)
    }

    /// [`Checkup::score`], `None` for a file that cannot be read.
    pub fn score(&self) -> Option<f64> {
        self.outcome.as_ref().ok().map(Checkup::score)
    }
}

/// Files in the order in which a person should look at them: those that cannot be read, then by
/// score, the highest first; equal ones stay in order.
pub fn ranked(mut takes: Vec<Checked>) -> Vec<Checked> {
    // No score counts as more than any.
    let place = |take: &Checked| take.score().unwrap_or(f64::INFINITY);
    takes.sort_by(|a, b| place(b).total_cmp(&place(a)));
    takes
}

/// How many takes have which level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub(crate) unreadable: usize,
    pub(crate) fail: usize,
    pub(crate) warn: usize,
    pub(crate) ok: usize,
}

impl Tally {
    pub(crate) fn count(takes: &[Checked]) -> Self {
        let mut tally = Self::default();
        for take in takes {
            let counter = match (&take.outcome, take.level()) {
                (Err(_), _) => &mut tally.unreadable,
                (Ok(_), Level::Fail) => &mut tally.fail,
                (Ok(_), Level::Warn) => &mut tally.warn,
                (Ok(_), Level::Ok | Level::Info) => &mut tally.ok,
            };
            *counter += 1;
        }
        tally
    }

    /// `2 cannot be read, 3 fail, 1 with warnings, 12 without`.
    pub(crate) fn words(self) -> String {
        let parts = [
            (self.unreadable, "cannot be read"),
            (self.fail, if self.fail == 1 { "fails" } else { "fail" }),
            (self.warn, "with warnings"),
            (self.ok, "with nothing to look at"),
        ];
        let there = parts.iter().filter(|(n, _)| *n > 0);
        there
            .map(|(n, words)| format!("{n} {words}"))
            .collect::<Vec<_>>()
            .join(", ")
    }
}
