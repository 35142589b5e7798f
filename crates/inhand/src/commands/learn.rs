//! `inhand learn TAKE... -o DICTIONARY`, and the steps of a run that is spread over processes.

mod steps;
mod whole;

use anyhow::Result;
use clap::Subcommand;

use crate::console::Console;
use crate::exit::Exit;

/// Learn a dictionary of motion primitives from takes.
///
/// Takes with processed channels are used as they are, others are processed first. Memory does not grow with the
/// number of segments, except for ranges of ranks.
///
/// A run can also use several processes or machines that share a folder: `learn init` once, then
/// `learn stats` for every shard and `learn update` until it prints that learning has stopped, then
/// `learn finish`. The result has the same bits.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    step: Option<Step>,
    #[command(flatten)]
    whole: whole::WholeArgs,
}

#[derive(Debug, Subcommand)]
enum Step {
    /// Begin a run in a folder: read the takes, write where the primitives start
    Init(Box<steps::InitArgs>),
    /// Do a shard's part of a round
    Stats(steps::StatsArgs),
    /// Add up what the shards found, and go on to the next round
    Update(steps::UpdateArgs),
    /// Write the dictionary of a run that has stopped
    Finish(steps::FinishArgs),
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    match &args.step {
        Some(Step::Init(args)) => steps::init(console, args),
        Some(Step::Stats(args)) => steps::stats(console, args),
        Some(Step::Update(args)) => steps::update(args),
        Some(Step::Finish(args)) => steps::finish(console, args),
        None => whole::run(console, &args.whole),
    }
}
