//! Findings about data that could still be used.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::names::named;

named! {
    /// How much a finding matters.
    #[derive(PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Severity {
        /// Worth knowing.
        Info = "info",
        /// A number may be affected.
        Warning = "warning",
    }
}

/// Something found in data that was read all the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Finding {
    /// How much it matters.
    pub severity: Severity,
    /// Where: a line, column, marker or time, in words; empty for the whole take.
    pub place: String,
    /// What was expected, what was found, what was done about it.
    pub message: String,
}

impl Finding {
    /// A finding that may affect a number.
    pub fn warning(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Warning,
            place: place.into(),
            message: message.into(),
        }
    }

    /// A finding worth knowing.
    pub fn info(place: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Info,
            place: place.into(),
            message: message.into(),
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.place.is_empty() {
            f.write_str(&self.message)
        } else {
            write!(f, "{}: {}", self.place, self.message)
        }
    }
}
