//! Exit codes, in one place.

use std::io;
use std::process::ExitCode;

use inhand_session::SessionError;
use inhand_session::matrices::MatricesError;

/// Shown under `--help`.
pub(crate) const HELP: &str = "Exit codes: 0 done, 1 failed, 2 wrong usage, \
    3 finished but data was lost or a check did not pass.";

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Done.
    Done,
    /// Failed; no output was written.
    Failed,
    /// The call was wrong.
    Usage,
    /// Finished, but data was lost or a check did not pass.
    Lossy,
}

impl Exit {
    /// The exit that an error stands for. A closed pipe is no failure: the reader had enough.
    pub(crate) fn of(error: &anyhow::Error) -> Self {
        let closed_pipe = |e: &(dyn std::error::Error + 'static)| {
            e.downcast_ref::<io::Error>()
                .is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
        };
        if error.chain().any(closed_pipe) {
            return Exit::Done;
        }
        let usage = error.chain().any(|e| {
            e.downcast_ref::<SessionError>()
                .is_some_and(SessionError::is_usage)
                || e.downcast_ref::<MatricesError>()
                    .is_some_and(MatricesError::is_usage)
                || e.downcast_ref::<UsageError>().is_some()
        });
        if usage { Exit::Usage } else { Exit::Failed }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> ExitCode {
        ExitCode::from(match exit {
            Exit::Done => 0,
            Exit::Failed => 1,
            Exit::Usage => 2,
            Exit::Lossy => 3,
        })
    }
}

/// A call that cannot be carried out as it was typed.
#[derive(Debug)]
pub(crate) struct UsageError(pub(crate) String);

impl std::fmt::Display for UsageError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}
