//! `inhand process TAKE... -o OUTPUT`.

use std::path::PathBuf;

use anyhow::Result;
use inhand_model::{Finger, TrackCounts};
use inhand_session::{Settings, TakeContents, provenance, steps, write_take};
use serde_json::json;

use crate::commands::{WRITING, file_part, files_task, takes_and_targets};
use crate::console::{Console, by_finger, print};
use crate::exit::Exit;
use crate::options::{Format, OutputOptions, ProcessOptions, SourceOptions};
use crate::output::write_output;

/// Transform takes into the hand's frame, fill short gaps and filter; add the processed channels.
///
/// Bodies fitted to markers get one template over all takes of the call.
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
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    writing: OutputOptions,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let typed = |settings: &mut Settings| args.process.apply(settings);
    let settings = args.source.for_all(console, &args.inputs, &[], &typed)?;
    let (takes, targets) =
        takes_and_targets(console, (&args.inputs, None), &args.output, &settings)?;
    let task = files_task(console, "process", &args.inputs, 1.0 + WRITING);
    args.inputs
        .iter()
        .for_each(|input| file_part(&task, input, 1.0));
    let motions = steps::process_takes(&takes, &settings)?;
    let mut files = Vec::with_capacity(takes.len());
    for ((take, motion), target) in takes.iter().zip(&motions).zip(&targets) {
        file_part(&task, &take.path, WRITING);
        let made = provenance("process", &settings, [take.hash.clone()]);
        let contents = TakeContents {
            take,
            motion,
            generated: None,
            hulls: None,
            made: &made,
            settings: &settings,
        };
        write_output(target, args.writing.force, |path| {
            write_take(path, &contents, args.writing.views)
        })?;
        let counts = Finger::ALL.map(|finger| motion.fingertips[finger].counts());
        let content = format!(
            "{} samples; of all fingertip samples {} filled, {} missing",
            motion.len(),
            counts.iter().map(|counts| counts.filled).sum::<usize>(),
            counts.iter().map(|counts| counts.missing).sum::<usize>(),
        );
        console.wrote_with(target, &content);
        files.push(json!({
            "input": take.path.display().to_string(),
            "output": target.display().to_string(),
            "samples": motion.len(),
            "rate_hz": motion.clock.rate_hz(),
            "has_object": motion.object.is_some(),
            "fingertips": by_finger(&motion.fingertips, |track| {
                let TrackCounts { measured, filled, missing } = track.counts();
                json!({ "measured": measured, "filled": filled, "missing": missing })
            }),
        }));
    }
    print(args.format, String::new, || json!({ "files": files }))?;
    Ok(Exit::Done)
}
