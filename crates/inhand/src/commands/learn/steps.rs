//! The steps of a run in a folder.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use inhand_model::{DictionaryKind, Inspection, StopReason};
use inhand_training::{LearningFolder, Shard};
use serde_json::json;

use super::super::run::fails;
use super::{RunOptions, round_text, write_learned};
use crate::console::{Console, print};
use crate::exit::{Exit, usage};
use crate::interrupt;
use crate::options::Format;
use crate::output::OutputFile;

#[derive(Debug, clap::Args)]
pub(super) struct InitArgs {
    /// Training takes.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Folder of the run.
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    options: RunOptions,
}

#[derive(Debug, clap::Args)]
pub(super) struct StatsArgs {
    /// Folder of the run.
    folder: PathBuf,
    /// Which part of the blocks: I/N, from 1/N to N/N.
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    shard: Shard,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Debug, clap::Args)]
pub(super) struct UpdateArgs {
    /// Folder of the run.
    folder: PathBuf,
    /// Sums of all shards, where they are not in the round's folder.
    sums: Vec<PathBuf>,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Debug, clap::Args)]
pub(super) struct FinishArgs {
    /// Folder of the run.
    folder: PathBuf,
    #[command(flatten)]
    output: OutputFile,
    /// Print the outcome as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(super) fn init(console: &Console, args: &InitArgs) -> Result<Exit> {
    args.options.learn.check_one_rank()?;
    let settings = args.options.settings(console, &args.inputs)?;
    if settings.learn.kind != DictionaryKind::Nmf {
        return usage(
            "--kind pca: principal components have no rounds; learn them with \
                       `inhand learn TAKES... -o DICTIONARY`",
        );
    }
    if LearningFolder::exists(&args.output) {
        let message = format!(
            "-o {}: there is a run in it already; go on with it, or name another folder",
            args.output.display()
        );
        return usage(message);
    }
    let inspection = args.options.look(console, &args.inputs, &settings)?;
    let folder = (args.options).init(console, &args.output, &args.inputs, &settings)?;
    inhand_training::begin_rounds(&folder)?;
    let plan = folder.plan();
    let (takes, segments, blocks) = (plan.takes.len(), plan.segments, plan.blocks);
    let text = || {
        format!(
            "{segments} segments from {takes} takes, {blocks} blocks: at most {blocks} shards have work\n"
        )
    };
    let json = || {
        json!({
            "id": folder.id(),
            "takes": takes,
            "segments": segments,
            "left_out": plan.left_out,
            "blocks": blocks,
            "inspection": inspection,
        })
    };
    print(args.format, text, json)?;
    let fail_on = args.options.look.fail_on;
    Ok(Exit::done_unless(fails(&inspection, fail_on)))
}

/// A folder that this call does a part in.
fn open(folder: &Path) -> Result<LearningFolder> {
    interrupt::keeps(format!(
        "what other calls wrote is kept in {}; run the same command again",
        folder.display()
    ));
    Ok(LearningFolder::open(folder)?)
}

pub(super) fn stats(console: &Console, args: &StatsArgs) -> Result<Exit> {
    let folder = open(&args.folder)?;
    let begin = Instant::now();
    let mut blocks = 0;
    let file = inhand_training::stats(&folder, args.shard, &mut || blocks += 1)?;
    if args.format == Format::Text {
        console.wrote_with(&file, &format!("{blocks} blocks"));
    }
    let json = || {
        json!({
            "file": file,
            "blocks": blocks,
            "time_s": begin.elapsed().as_secs_f64(),
            "peak_memory_bytes": inhand_session::peak_memory_bytes(),
        })
    };
    print(args.format, String::new, json)?;
    Ok(Exit::Done)
}

pub(super) fn update(args: &UpdateArgs) -> Result<Exit> {
    let folder = open(&args.folder)?;
    let updated = inhand_training::update(&folder, &args.sums)?;
    let measured = &updated.measured;
    let done = updated.progress.is_done();
    let text = || {
        let done = match done {
            true => "done: write the dictionary with `inhand learn finish`\n",
            false => "",
        };
        format!("{}\n{done}", round_text(measured))
    };
    let json = || {
        json!({
            "start": measured.start,
            "round": measured.round,
            "rms_mm": measured.rms_m.map(|rms_m| rms_m * 1000.0),
            "stop_reason": measured.stop.map(StopReason::name),
            "done": done,
        })
    };
    print(args.format, text, json)?;
    Ok(Exit::Done)
}

pub(super) fn finish(console: &Console, args: &FinishArgs) -> Result<Exit> {
    args.output.check_mcap::<PathBuf>(&[])?;
    let folder = LearningFolder::open(&args.folder)?;
    let learned = inhand_training::finish(&folder)?;
    write_learned(
        console,
        (&args.output.output, args.output.force),
        &learned,
        (None, &Inspection::default()),
        0.0,
        args.format,
    )?;
    Ok(Exit::Done)
}
