//! `inhand process TAKE... -o OUTPUT`.

use std::path::PathBuf;

use anyhow::Result;
use inhand_model::Finger;
use inhand_session::{TakeContents, provenance, steps, write_take};

use crate::commands::{check_take_target, read_takes, targets};
use crate::console::Console;
use crate::exit::Exit;
use crate::options::{OutputOptions, ProcessOptions, SourceOptions};

/// Transform takes into the hand's frame, fill short gaps and filter; add the processed channels.
/// Bodies that are fitted to markers get one template over all the takes of the call.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Output file; a folder for several inputs.
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
    #[command(flatten, next_help_heading = "Processing")]
    process: ProcessOptions,
    #[command(flatten)]
    writing: OutputOptions,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let mut settings = args.source.effective(None)?;
    args.process.apply(&mut settings)?;
    settings.validate()?;
    let targets = targets(&args.inputs, &args.output, "mcap")?;
    let inputs: Vec<_> = args.inputs.iter().map(PathBuf::as_path).collect();
    let takes = read_takes(console, &args.inputs, &settings)?;
    for (take, target) in takes.iter().zip(&targets) {
        check_take_target(target, &inputs, &take.hash, args.writing.force)?;
    }
    let motions = steps::process_takes(&takes, &settings)?;
    for ((take, motion), target) in takes.iter().zip(&motions).zip(&targets) {
        let made = provenance("process", &settings, [take.hash.clone()]);
        let contents = TakeContents {
            take,
            motion,
            generated: None,
            made: &made,
            settings: &settings,
        };
        write_take(target, &contents, !args.writing.no_view)?;
        let of = |count: fn(&inhand_model::TrackCounts) -> usize| -> usize {
            Finger::ALL
                .into_iter()
                .map(|f| count(&motion.fingertips[f].counts()))
                .sum()
        };
        console.say(&format!(
            "wrote {} ({} samples; of all fingertip samples {} filled, {} missing)",
            target.display(),
            motion.len(),
            of(|counts| counts.filled),
            of(|counts| counts.missing),
        ));
    }
    Ok(Exit::Done)
}
