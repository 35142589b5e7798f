//! `inhand learn TAKE... -o DICTIONARY`.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use inhand_pipeline::{Role, check_target, provenance, steps, write_dictionary};
use serde_json::json;

use crate::commands::read_takes;
use crate::console::{Console, data};
use crate::exit::Exit;
use crate::options::{Format, LearnOptions, MethodOptions, ProcessOptions, SourceOptions};

/// Learns a dictionary of motion primitives. Takes with processed channels are used as they are,
/// others are processed on the way.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Training takes.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Dictionary file.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Print the outcome as text or JSON.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
    #[command(flatten, next_help_heading = "Processing")]
    process: ProcessOptions,
    #[command(flatten, next_help_heading = "Learning")]
    learn: LearnOptions,
    #[command(flatten)]
    method: MethodOptions,
    /// Replace an output that is there.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let mut settings = args.source.effective(None)?;
    args.process.apply(&mut settings)?;
    args.learn.apply(&mut settings);
    args.method.apply(&mut settings)?;
    settings.validate()?;
    let inputs: Vec<_> = args.inputs.iter().map(PathBuf::as_path).collect();
    check_target(&args.output, &inputs, || args.force)?;

    let begin = Instant::now();
    let takes = read_takes(console, &args.inputs, &settings)?;
    let motions = steps::motions(&takes, &settings, !args.process.ask_for_processing())?;
    let motions: Vec<_> = motions.iter().collect();
    let object = steps::carries_object(&motions, &settings)?;
    let segments = steps::segments(&motions, Role::Train, object, &settings)?;
    let read_s = begin.elapsed().as_secs_f64();

    let begin = Instant::now();
    let dictionary = steps::learn_and_choose(&segments, steps::demonstrated(&motions)?, &settings)?;
    let learn_s = begin.elapsed().as_secs_f64();

    let made = provenance(
        "learn",
        &settings,
        takes.iter().map(|take| take.hash.clone()),
    );
    write_dictionary(&args.output, &dictionary, &[made])?;
    let learning = &dictionary.learning;
    let rms_mm = learning.rms_m * 1000.0;
    match args.format {
        Format::Json => {
            let outcome = json!({
                "rms_mm": rms_mm,
                "relative_error": learning.relative_error,
                "iterations": learning.iterations,
                "stop_reason": learning.stop_reason.name(),
                "segments": learning.segments,
                "rank": dictionary.rank(),
                "timings_s": { "read": read_s, "learn": learn_s },
            });
            data(&format!("{outcome:#}\n"))?;
        }
        Format::Text => data(&format!(
            "{} primitives from {} segments: {rms_mm:.3} mm rms after {} iterations ({})\n",
            dictionary.rank(),
            learning.segments,
            learning.iterations,
            learning.stop_reason.name().replace('_', " "),
        ))?,
    }
    console.say(&format!("wrote {}", args.output.display()));
    Ok(Exit::Done)
}
