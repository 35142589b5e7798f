//! `inhand check TAKE...`.

use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum;
use inhand_inspection::{Checked, ranked, to_json, to_markdown, to_text};
use inhand_session::check_take;

use crate::console::{Console, with_flags};
use crate::exit::Exit;
use crate::options::{FailOn, SourceOptions};
use crate::output::TextOutput;

/// Check takes for gaps, swapped markers, wrong rates, units and axes, and count the usable segments.
///
/// Several takes are listed worst first, by a score: 100 for each failed check, 10 for each warning, 50 times the
/// share of segments that cannot be used. Nothing is changed. The exit code is 1 where a file is missing, 3 where
/// --fail-on is met.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes: Motive CSV, Qualisys TSV, TRC, C3D, ROS 2 bags and other MCAP recordings.
    #[arg(required = true, value_name = "TAKE")]
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

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let mut settings = args.source.effective(None)?;
    let process = &mut settings.process;
    process.max_gap_s = args.max_gap.unwrap_or(process.max_gap_s);
    settings.validate()?;
    args.output.check(&args.inputs)?;
    // One take in memory at a time: results are small.
    let mut takes = Vec::with_capacity(args.inputs.len());
    for path in &args.inputs {
        let step = console.step(&format!("checking {}", path.display()));
        takes.push(check_take(path, &settings)?);
        step.finish_and_clear();
    }
    let takes = ranked(takes);
    let shown = match args.format {
        CheckFormat::Text => with_flags(&to_text(&takes)),
        CheckFormat::Json => to_json(&takes),
        CheckFormat::Markdown => to_markdown(&takes),
    };
    args.output.write(console, &shown)?;
    if args.inputs.iter().any(|path| !path.exists()) {
        return Ok(Exit::Failed);
    }
    let worst = takes.iter().map(Checked::level).max();
    Ok(Exit::done_unless(args.fail_on.is_met(worst)))
}
