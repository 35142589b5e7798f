//! `inhand settings [SESSION]`.

use std::path::PathBuf;

use anyhow::Result;
use inhand_session::locate;

use crate::console::data;
use crate::describe::commented;
use crate::exit::Exit;
use crate::options::SourceOptions;

/// Print every setting with its effective value and meaning: defaults, then the session's inhand.toml.
///
/// The output is an inhand.toml that gives them again; keys that are not set are comments.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Session folder or settings file; without it, the defaults.
    session: Option<PathBuf>,
}

pub(crate) fn run(args: &Args) -> Result<Exit> {
    let file = match &args.session {
        Some(session) => locate(session)?.settings,
        None => None,
    };
    let settings = SourceOptions::default().effective(file.as_deref())?;
    settings.validate()?;
    data(&commented(&settings.to_toml()?))?;
    Ok(Exit::Done)
}
