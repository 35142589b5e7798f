//! What can go wrong between a session and its report.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// An error of a step, with the file it happened in.
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
    /// A settings file that cannot be read.
    #[error("{}: {message}", path.display())]
    SettingsFile {
        /// The file.
        path: PathBuf,
        /// Line, column and reason.
        message: String,
    },
    /// A session that cannot be used.
    #[error("session {}: {message}", path.display())]
    Session {
        /// Its folder.
        path: PathBuf,
        /// What was expected, what was found, what to do.
        message: String,
    },
    /// Where a hand is to start or to end, or something on the way, that cannot be used.
    #[error("{place}: expected {expected}, found {found}")]
    State {
        /// The file, or the take and its time.
        place: String,
        /// What was expected.
        expected: String,
        /// What was found.
        found: String,
    },
    /// A take that cannot be used.
    #[error("{}: {message}", path.display())]
    Take {
        /// Its file.
        path: PathBuf,
        /// What was expected, what was found, what to do.
        message: String,
    },
    /// A vendor file that cannot be read.
    #[error("{}", path.display())]
    Capture {
        /// The file.
        path: PathBuf,
        /// Where in it, and why.
        source: Box<inhand_capture::CaptureError>,
    },
    /// A take that could not be cleaned.
    #[error("{}", path.display())]
    Cleaning {
        /// Its file.
        path: PathBuf,
        /// Why not.
        source: Box<inhand_cleaning::CleaningError>,
    },
    /// An MCAP file that cannot be read or written.
    #[error("{}", path.display())]
    Channels {
        /// The file.
        path: PathBuf,
        /// Where in it, and why.
        source: Box<inhand_channels::ChannelError>,
    },
    /// Events that cannot be written, or a file that cannot hold any.
    #[error("{}: {message}", path.display())]
    Annotate {
        /// The file.
        path: PathBuf,
        /// What is wrong, and what to do.
        message: String,
    },
    /// A table that cannot be read or written.
    #[error("{}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// Where in it, and why.
        source: Box<inhand_tables::TableError>,
    },
    /// An MCAP file whose records cannot be copied.
    #[error("{}", path.display())]
    Container {
        /// The file.
        path: PathBuf,
        /// Where in it, and why.
        source: Box<inhand_container::ContainerError>,
    },
    /// Processing failed.
    #[error("processing {take}")]
    Motion {
        /// The take, or the session.
        take: String,
        /// Why.
        source: Box<inhand_motion::MotionError>,
    },
    /// Learning failed.
    #[error("learning")]
    Learn(#[source] Box<inhand_dictionary::LearnError>),
    /// A learning folder, or a file of one, that cannot be used.
    #[error("{}: {message}", path.display())]
    Learning {
        /// The folder or file.
        path: PathBuf,
        /// What was expected, what was found, what to do.
        message: String,
    },
    /// A dictionary that does not fit the takes.
    #[error(
        "the dictionary has segments of {found}: expected {expected}; learn one from takes of this rate"
    )]
    Dictionary {
        /// What would fit.
        expected: String,
        /// What it has.
        found: String,
    },
    /// Planning failed.
    #[error("planning with {method}")]
    Plan {
        /// The method.
        method: String,
        /// Why.
        source: Box<inhand_planner::PlanError>,
    },
    /// Geometry failed.
    #[error("training hull of the {finger} finger")]
    Hull {
        /// The finger.
        finger: inhand_model::Finger,
        /// Why.
        source: Box<inhand_contact::ContactError>,
    },
    /// A report could not be made.
    #[error("report")]
    Report(#[from] inhand_report::ReportError),
    /// Contacts could not be judged over time.
    #[error("contacts over time")]
    Contacts(#[from] inhand_contact::ContactError),
    /// An evaluation that cannot be joined or compared with others.
    #[error("{}: {message}", path.display())]
    Part {
        /// The file.
        path: PathBuf,
        /// What was expected, what was found, what to do.
        message: String,
    },
    /// Intervals could not be worked out.
    #[error("bootstrap intervals")]
    Intervals(#[from] inhand_statistics::BootstrapError),
    /// A simulation could not be made.
    #[error("simulation")]
    Simulation(#[from] inhand_simulation::SimulationError),
    /// An output that must not be written.
    #[error("{}: {message}", path.display())]
    Output {
        /// The file or folder.
        path: PathBuf,
        /// Why not, and what to do.
        message: String,
    },
}

impl SessionError {
    /// For `map_err` on file operations.
    pub(crate) fn io(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| SessionError::Io {
            action,
            path,
            source,
        }
    }

    /// Whether the call was wrong, rather than the data: exit code 2.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            SessionError::Settings { .. }
                | SessionError::SettingsFile { .. }
                | SessionError::Output { .. }
        )
    }
}
