//! Errors of processing takes.

use std::fmt;

use thiserror::Error;

/// Why takes could not be processed or cut.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MotionError {
    /// A setting outside its range.
    #[error("{setting} is {found}: expected {expected}")]
    Setting {
        /// The setting, as in the settings' fields.
        setting: &'static str,
        /// The value found.
        found: String,
        /// What it may be.
        expected: String,
    },
    /// A role names something that the take does not contain.
    #[error(
        "take \"{take}\" has no {kind} \"{name}\", wanted as {role}: it has {}; map the role to one of these",
        listed(.available)
    )]
    NotInTake {
        /// The take.
        take: String,
        /// What was wanted of it, such as `hand` or `thumb`.
        role: String,
        /// `rigid body` or `marker`.
        kind: &'static str,
        /// The name looked for.
        name: String,
        /// The names there are of that kind.
        available: Vec<String>,
    },
    /// A body whose frame cannot be defined or fitted, in words.
    #[error("{0}")]
    Body(String),
    /// A take of another rate than the others, or than segments are laid out for.
    #[error("take \"{take}\" is sampled at {rate_hz} Hz, {expected}")]
    Rate {
        /// A take.
        take: String,
        /// Its rate.
        rate_hz: f64,
        /// Which rate is needed, and why.
        expected: String,
    },
}

impl MotionError {
    /// A setting outside its range.
    pub fn setting(
        setting: &'static str,
        found: impl fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self::Setting {
            setting,
            found: format!("{found}"),
            expected: expected.into(),
        }
    }

    /// Fails unless a setting is in its range.
    pub(crate) fn unless(
        in_range: bool,
        setting: &'static str,
        found: impl fmt::Display,
        expected: &str,
    ) -> Result<(), Self> {
        match in_range {
            true => Ok(()),
            false => Err(Self::setting(setting, found, expected)),
        }
    }
}

/// Names in quotes.
pub(crate) fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    quoted.join(", ")
}
