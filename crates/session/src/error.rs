//! Errors of the steps between a session and its report.

use std::error::Error as StdError;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use inhand_model::SessionFinding;
use thiserror::Error;

/// An error of a step, with the file or the step it happened in. Errors of other crates are the
/// [`source`](std::error::Error::source) of [`At`](SessionError::At).
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SessionError {
    /// A file or folder could not be read or written.
    #[error("cannot {action} {}", path.display())]
    Io {
        /// What was tried: `read`, `write`, ...
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// A setting that cannot be used.
    #[error("setting {key}: expected {expected}, found {found}")]
    Settings {
        /// Name of the setting.
        key: String,
        /// What it can be.
        expected: String,
        /// What it is.
        found: String,
    },
    /// A settings file that cannot be read, or an output that must not be written.
    #[error("{}: {message}", path.display())]
    Usage {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong, and what to do.
        message: String,
    },
    /// A take, an evaluation, a learning folder or another input that cannot be used.
    #[error("{place}: {message}")]
    Data {
        /// The file, or the take and its time.
        place: String,
        /// What was expected, what was found, what to do.
        message: String,
    },
    /// A session with findings that make its results wrong.
    #[error("{session}: {message}")]
    Refused {
        /// Name of the session.
        session: String,
        /// The findings in words, and what to do.
        message: String,
        /// The same for programs.
        findings: Vec<SessionFinding>,
    },
    /// An error of another crate.
    #[error("{place}")]
    At {
        /// The file, or the step.
        place: String,
        /// Where in it, and why.
        source: Box<dyn StdError + Send + Sync>,
    },
    /// A report could not be made.
    #[error("report")]
    Report(#[from] inhand_report::ReportError),
    /// Contacts could not be judged over time.
    #[error("contacts over time")]
    Contacts(#[from] inhand_contact::ContactError),
    /// Intervals could not be worked out.
    #[error("bootstrap intervals")]
    Intervals(#[from] inhand_statistics::BootstrapError),
    /// A simulation could not be made.
    #[error("simulation")]
    Simulation(#[from] inhand_simulation::SimulationError),
}

impl SessionError {
    /// For `map_err` on file operations.
    pub fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| SessionError::Io {
            action,
            path,
            source,
        }
    }

    pub(crate) fn at(
        place: impl Display,
        source: impl Into<Box<dyn StdError + Send + Sync>>,
    ) -> Self {
        SessionError::At {
            place: place.to_string(),
            source: source.into(),
        }
    }

    pub(crate) fn usage(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        SessionError::Usage {
            path: path.as_ref().to_owned(),
            message: message.into(),
        }
    }

    /// An input that cannot be used: `path` is the file or another place.
    pub fn data(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        SessionError::Data {
            place: path.as_ref().display().to_string(),
            message: message.into(),
        }
    }

    pub(crate) fn session(path: &Path, message: impl Into<String>) -> Self {
        SessionError::data(format!("session {}", path.display()), message)
    }

    /// Whether the call was wrong, rather than the data: exit code 2.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            SessionError::Settings { .. } | SessionError::Usage { .. }
        )
    }
}

/// Says where an error of another crate happened.
pub trait Located<T> {
    /// In this file.
    ///
    /// # Errors
    ///
    /// [`SessionError::At`] for each error.
    fn in_file(self, path: impl AsRef<Path>) -> Result<T, SessionError>;

    /// In this step.
    ///
    /// # Errors
    ///
    /// [`SessionError::At`] for each error.
    fn during(self, step: impl Display) -> Result<T, SessionError>;
}

impl<T, E: Into<Box<dyn StdError + Send + Sync>>> Located<T> for Result<T, E> {
    fn in_file(self, path: impl AsRef<Path>) -> Result<T, SessionError> {
        self.during(path.as_ref().display())
    }

    fn during(self, step: impl Display) -> Result<T, SessionError> {
        self.map_err(|source| SessionError::at(step, source))
    }
}

/// An error about one setting.
pub(crate) fn invalid(key: &str, expected: &str, found: &impl Display) -> SessionError {
    SessionError::Settings {
        key: key.to_owned(),
        expected: expected.to_owned(),
        found: found.to_string(),
    }
}

/// An error with its causes.
pub(crate) fn in_words(error: &dyn StdError) -> String {
    let causes = std::iter::successors(error.source(), |cause| (*cause).source());
    causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}
