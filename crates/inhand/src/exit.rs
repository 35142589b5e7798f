//! Exit codes, in one place.

use std::io;
use std::process::ExitCode;

use inhand_session::SessionError;

/// Shown under `--help`.
pub(crate) const HELP: &str = "Exit codes: 0 done, 1 failed, 2 wrong usage, \
    3 finished but data was lost, a target was missed or a check did not pass, 130 ended by Ctrl-C, 143 by SIGTERM.";

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// Done.
    Done = 0,
    /// Failed: an input is missing or cannot be read, or there is no result.
    Failed = 1,
    /// The call or a setting was wrong, or an output exists.
    Usage = 2,
    /// Finished, but data was lost, a target was missed or a check did not pass.
    Lossy = 3,
}

impl Exit {
    /// The end of a command that did all, unless something was lost or a check did not pass.
    pub(crate) fn done_unless(lossy: bool) -> Self {
        if lossy { Exit::Lossy } else { Exit::Done }
    }

    /// The exit code of an error. A closed pipe is no failure, since the reader needs no more.
    pub(crate) fn from_error(error: &anyhow::Error) -> Self {
        for cause in error.chain() {
            let io = cause.downcast_ref::<io::Error>();
            if io.is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe) {
                return Exit::Done;
            }
            let session = cause.downcast_ref::<SessionError>();
            if session.is_some_and(SessionError::is_usage) || cause.is::<UsageError>() {
                return Exit::Usage;
            }
        }
        Exit::Failed
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> ExitCode {
        ExitCode::from(exit as u8)
    }
}

/// A call that cannot be carried out as it was typed.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct UsageError(pub(crate) String);

/// Refuses a call.
pub(crate) fn usage<T>(message: impl Into<String>) -> anyhow::Result<T> {
    Err(UsageError(message.into()).into())
}
