//! Commands, one file each.

mod annotate;
mod batch;
mod check;
mod clean;
mod compare;
mod convert;
mod cut;
mod demo;
mod evaluate;
mod export;
mod filter;
mod generate;
mod info;
mod layout;
mod learn;
mod learn_rank;
mod merge;
mod overlay;
mod plan;
mod play;
mod process;
mod recover;
mod report;
mod run;
mod settings;
mod simulate;
mod verify;
mod view;

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Subcommand;
use inhand_model::{Dictionary, InputHash, Recording};
use inhand_session::{Settings, Take, take_name};

use crate::console::Console;
use crate::exit::{Exit, UsageError, usage};
use crate::output::{check_outputs, ending};
use crate::progress::Task;

/// The commands; a variant without a line of its own takes the first line of its arguments.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run every step on a session: one MCAP per take, dictionary, evaluation and report
    Run(Box<run::Args>),
    Batch(Box<batch::Args>),
    /// Simulate a session and run everything on it
    Demo(demo::Args),
    /// Print what is in an MCAP file
    Info(info::Args),
    /// Check takes for gaps, swapped markers, wrong units and axes
    Check(check::Args),
    /// Convert takes to MCAP recordings, or a recording to Motive CSV, TRC or C3D
    Convert(convert::Args),
    /// Find and repair swaps, flips, spikes and gaps in takes
    Clean(Box<clean::Args>),
    /// Transform takes into the hand's frame, fill short gaps and filter
    Process(process::Args),
    /// Add, import, list, edit, remove or export events of a file; state facts about a take
    Annotate(annotate::Args),
    /// Learn a dictionary of motion primitives from takes
    Learn(Box<learn::Args>),
    /// Generate trajectories between the ends of a take's segments
    Generate(generate::Args),
    /// Plan one motion from a start to a goal
    Plan(plan::Args),
    /// Compare generated with recorded motion
    Evaluate(evaluate::Args),
    Report(report::Args),
    Compare(compare::Args),
    /// Export a take as CSV, Parquet or BIDS, or a dictionary as matrices for NumPy or MATLAB
    Export(export::Args),
    View(view::Args),
    Overlay(overlay::Args),
    /// Cut a time range from any MCAP file
    Cut(cut::Args),
    /// Select topics of any MCAP file, or change its compression
    Filter(filter::Args),
    /// Merge several MCAP files into one, by time
    Merge(merge::Args),
    /// Recover intact data from a damaged MCAP file
    Recover(recover::Args),
    Verify(verify::Args),
    Play(play::Args),
    Layout(layout::Args),
    /// Simulate a session of a hand that turns an object
    Simulate(simulate::Args),
    /// Print the effective settings as an inhand.toml
    Settings(settings::Args),
}

impl Command {
    pub(crate) fn run(&self, console: &Console) -> Result<Exit> {
        match self {
            Command::Run(args) => run::run(console, args),
            Command::Demo(args) => demo::run(console, args),
            Command::Info(args) => info::run(console, args),
            Command::Check(args) => check::run(console, args),
            Command::Convert(args) => convert::run(console, args),
            Command::Clean(args) => clean::run(console, args),
            Command::Process(args) => process::run(console, args),
            Command::Annotate(args) => annotate::run(console, args),
            Command::Learn(args) => learn::run(console, args),
            Command::Generate(args) => generate::run(console, args),
            Command::Plan(args) => plan::run(console, args),
            Command::Evaluate(args) => evaluate::run(console, args),
            Command::Report(args) => report::run(console, args),
            Command::Compare(args) => compare::run(console, args),
            Command::Batch(args) => batch::run(console, args),
            Command::Export(args) => export::run(console, args),
            Command::View(args) => view::run(console, args),
            Command::Overlay(args) => overlay::run(console, args),
            Command::Cut(args) => cut::run(console, args),
            Command::Filter(args) => filter::run(console, args),
            Command::Merge(args) => merge::run(console, args),
            Command::Recover(args) => recover::run(console, args),
            Command::Verify(args) => verify::run(console, args),
            Command::Play(args) => play::run(console, args),
            Command::Layout(args) => layout::run(console, args),
            Command::Simulate(args) => simulate::run(console, args),
            Command::Settings(args) => settings::run(args),
        }
    }
}

/// Output file of each input: `-o` itself for one input, which has one of these endings, a file in the folder `-o`
/// for several.
fn targets(inputs: &[PathBuf], output: &Path, endings: &[&str]) -> Result<Vec<PathBuf>> {
    if let [_] = inputs
        && !output.is_dir()
    {
        ending(output, endings)
            .map_err(|error| UsageError(format!("{error}, or a folder that exists")))?;
        return Ok(vec![output.to_owned()]);
    }
    if output.exists() && !output.is_dir() {
        return usage(format!(
            "-o {}: expected a folder for {} inputs",
            output.display(),
            inputs.len()
        ));
    }
    let mut targets = Vec::with_capacity(inputs.len());
    for input in inputs {
        let target = output.join(format!("{}.mcap", take_name(input)));
        if targets.contains(&target) {
            return usage(format!(
                "two inputs would both be written as {}",
                target.display()
            ));
        }
        targets.push(target);
    }
    Ok(targets)
}

/// Reads takes in order and names the output of each. Inputs may have another file that is read.
fn takes_and_targets(
    console: &Console,
    (inputs, also_read): (&[PathBuf], Option<&PathBuf>),
    output: &Path,
    settings: &Settings,
) -> Result<(Vec<Take>, Vec<PathBuf>)> {
    let targets = targets(inputs, output, &["mcap"])?;
    let read: Vec<&PathBuf> = inputs.iter().chain(also_read).collect();
    check_outputs(&targets, &read)?;
    Ok((read_takes(console, inputs, settings)?, targets))
}

/// Reads takes in order and prints the findings of each.
fn read_takes(console: &Console, paths: &[PathBuf], settings: &Settings) -> Result<Vec<Take>> {
    let task = files_task(console, "reading", paths, 1.0);
    let takes = paths.iter().map(|path| {
        file_part(&task, path, 1.0);
        read_take(console, path, settings)
    });
    takes.collect()
}

/// Time of writing a take with what viewers draw, in times of reading it.
const WRITING: f64 = 5.0;

/// Work on files, in bytes that are read; `times` of them where more than reading is done.
fn files_task(console: &Console, name: &str, files: &[PathBuf], times: f64) -> Task {
    let bytes: f64 = files.iter().map(|file| bytes(file)).sum();
    console.task(name, times * bytes)
}

/// Begins the part of a file.
fn file_part(task: &Task, file: &Path, times: f64) {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    task.part(name, times * bytes(file));
}

/// Size of a file, 1 at least.
fn bytes(file: &Path) -> f64 {
    std::fs::metadata(file).map_or(1.0, |facts| facts.len().max(1) as f64)
}

fn read_take(console: &Console, path: &Path, settings: &Settings) -> Result<Take> {
    let take = inhand_session::read_clean(path, settings)?;
    say_findings(console, &take.hash, &take.recording);
    Ok(take)
}

/// Prints how much of the takes the selected events leave.
fn say_used(console: &Console, takes: &[Take], settings: &Settings) -> Result<()> {
    if let Some(used) = inhand_session::steps::used(takes, settings)? {
        console.say(&format!(
            "events   {:.1} of {:.1} s are used ({} events)",
            used.used_s, used.whole_s, used.events
        ));
    }
    Ok(())
}

/// Reports a dictionary that was learned before there was a held-out protocol.
fn say_held_out(console: &Console, dictionary: &Dictionary) {
    if dictionary.residual.is_some() && dictionary.residual_held_out.is_none() {
        console.say(
            "held out  the dictionary has no deviations of this protocol: residual uses the published ones",
        );
    }
}

fn say_findings(console: &Console, take: &InputHash, recording: &Recording) {
    for finding in &recording.findings {
        console.finding(&take.name, finding);
    }
}
