//! `inhand check TAKE...`.

use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum;
use inhand_inspection::{Checked, Level, ranked, to_json, to_markdown, to_text};
use inhand_session::{check_take, check_target, write_text};

use crate::console::{Console, data, with_flags};
use crate::exit::Exit;
use crate::options::SourceOptions;

/// Check the rate, gaps, bodies, units and axes that takes state against their data, and count the
/// usable segments. Several takes are listed worst first.
///
/// Changes nothing. Exits with 3 where --fail-on is met.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes: Motive CSV, Qualisys TSV, TRC, C3D, ROS 2 bags and other MCAP recordings.
    #[arg(required = true, value_name = "TAKE")]
    inputs: Vec<PathBuf>,
    /// Print as text, JSON (schemas/check.schema.json) or Markdown.
    #[arg(long, value_enum, default_value_t)]
    format: CheckFormat,
    /// From which level on to exit with 3.
    #[arg(long, value_enum, default_value_t, value_name = "LEVEL")]
    fail_on: FailOn,
    /// Write to this file instead of printing.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace the output if it exists.
    #[arg(long)]
    force: bool,
    /// Longest gap that is filled, seconds [default: 0.1].
    #[arg(long, value_name = "SECONDS")]
    max_gap: Option<f64>,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
}

/// Form of the results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum CheckFormat {
    /// For people.
    #[default]
    Text,
    /// For programs.
    Json,
    /// For a pull request or an issue.
    Markdown,
}

/// What makes the command exit with 3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum FailOn {
    /// A warning, or worse.
    Warn,
    /// A take that cannot be used as it is, or cannot be read.
    #[default]
    Fail,
    /// Nothing.
    Never,
}

impl FailOn {
    fn is_met(self, takes: &[Checked]) -> bool {
        let worst = takes.iter().map(Checked::level).max();
        match self {
            FailOn::Warn => worst >= Some(Level::Warn),
            FailOn::Fail => worst >= Some(Level::Fail),
            FailOn::Never => false,
        }
    }
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let mut settings = args.source.effective(None)?;
    if let Some(max_gap_s) = args.max_gap {
        settings.process.max_gap_s = max_gap_s;
    }
    settings.validate()?;
    if let Some(output) = &args.output {
        let inputs: Vec<_> = args.inputs.iter().map(PathBuf::as_path).collect();
        check_target(output, &inputs, || args.force)?;
    }
    // One take in memory at a time: results are small.
    let mut takes = Vec::with_capacity(args.inputs.len());
    for path in &args.inputs {
        let step = console.step(&format!("checking {}", path.display()));
        takes.push(check_take(path, &settings)?);
        step.clear();
    }
    let takes = ranked(takes);
    let shown = match args.format {
        CheckFormat::Text => with_flags(&to_text(&takes)),
        CheckFormat::Json => to_json(&takes),
        CheckFormat::Markdown => to_markdown(&takes),
    };
    match &args.output {
        Some(output) => {
            write_text(output, &shown)?;
            console.say(&format!("wrote {}", output.display()));
        }
        None => data(&shown)?,
    }
    Ok(if args.fail_on.is_met(&takes) {
        Exit::Lossy
    } else {
        Exit::Done
    })
}
