//! `inhand check TAKE...`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::ValueEnum;
use inhand_inspection::{CUT_SHORT, Checked, ranked, to_json, to_markdown, to_text};
use inhand_session::{
    Role, SessionTake, Settings, check_take, is_take, list_takes, locate, take_name,
};

use crate::console::{Console, with_flags};
use crate::exit::Exit;
use crate::input_settings::is_settings;
use crate::options::{FailOn, SourceOptions};
use crate::output::{TextOutput, reads, with_files};

/// Check takes for gaps, swapped markers, wrong rates, units and axes, and count the usable segments.
///
/// Several takes are listed worst first, by a score: 100 for each failed check, 10 for each warning, 50 times the
/// share of segments that cannot be used. Nothing is changed. The exit code is 1 where a file is missing, 3 where
/// --fail-on is met.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes: Motive CSV, Qualisys TSV, TRC, C3D, ROS 2 bags and other MCAP recordings; or sessions.
    #[arg(required = true, value_name = "TAKE|SESSION")]
    inputs: Vec<PathBuf>,
    /// Print as text, json (schemas/check.schema.json) or markdown.
    #[arg(long, value_enum, default_value_t)]
    format: CheckFormat,
    /// Exit with 3 from this level on.
    #[arg(long, value_enum, default_value_t, value_name = "LEVEL")]
    fail_on: FailOn,
    #[command(flatten)]
    output: TextOutput,
    /// Longest gap to fill, seconds [default: 0.1].
    #[arg(long, value_name = "SECONDS")]
    max_gap: Option<f64>,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
}

/// Form of the results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum CheckFormat {
    /// For reading.
    #[default]
    Text,
    /// For programs.
    Json,
    /// For a pull request or an issue.
    Markdown,
}

/// A take, or those of a session, and whether it is one.
fn entries(input: &Path, settings: Option<&Path>) -> Result<(Vec<SessionTake>, bool)> {
    if (input.is_dir() && !is_take(input)) || is_settings(input) {
        let settings = settings
            .map(Settings::read)
            .transpose()?
            .unwrap_or_default();
        let session = list_takes(&locate(input)?.folder, &settings)?;
        return Ok((session.takes, true));
    }
    let take = SessionTake {
        path: input.to_owned(),
        role: Role::Test,
        name: take_name(input),
        from_s: None,
        to_s: None,
        part: [0.0, 1.0],
    };
    Ok((vec![take], false))
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    args.output.check(&args.inputs)?;
    // One take in memory at a time: results are small.
    let mut takes = Vec::with_capacity(args.inputs.len());
    let mut missing = false;
    let task = console.task("checking", args.inputs.len() as f64);
    for input in &args.inputs {
        let file = args.source.file(console, &[input])?;
        let (entries, in_session) = entries(input, file.as_deref())?;
        let share = 1.0 / entries.len() as f64;
        for entry in entries {
            task.part(entry.path.display(), share);
            reads(&[&entry.path]);
            let read = (&[&*entry.path][..], file.as_deref());
            let settings = args.source.layered(read, &[], &|settings| {
                let process = &mut settings.process;
                process.max_gap_s = args.max_gap.unwrap_or(process.max_gap_s);
            })?;
            let mut checked = check_take(&entry, &settings)?;
            checked.role = checked.role.filter(|_| in_session);
            takes.push(checked);
            missing |= with_files(&[&entry.path]).iter().any(|file| !file.exists());
        }
    }
    drop(task);
    let takes = ranked(takes);
    let shown = match args.format {
        CheckFormat::Text => with_flags(&to_text(&takes)),
        CheckFormat::Json => to_json(&takes),
        CheckFormat::Markdown => to_markdown(&takes),
    };
    args.output.write(console, &shown)?;
    if missing {
        return Ok(Exit::Failed);
    }
    let worst = takes.iter().map(Checked::level).max();
    let checkups = takes.iter().filter_map(|take| take.outcome.as_ref().ok());
    let cut = (checkups.flat_map(|checkup| &checkup.results)).any(|result| result.id == CUT_SHORT);
    Ok(Exit::done_unless(cut || args.fail_on.is_met(worst)))
}
