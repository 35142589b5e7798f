//! `inhand annotate VERB FILE`.

mod change;
mod show;

use std::path::PathBuf;

use anyhow::Result;

use crate::console::Console;
use crate::exit::Exit;
use crate::options::Format;
use crate::output::{OutputFile, TextOutput};

/// Edit the events of an MCAP file of any origin.
///
/// Events are `foxglove.Event` messages, which viewers show; everything else in the file stays byte for byte.
/// Other commands select data by events (--event, --without).
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, clap::Subcommand)]
enum Verb {
    /// Add an event
    Add(AddArgs),
    /// Add the events of a CSV file
    Import(ImportArgs),
    /// Change one event
    Edit(EditArgs),
    /// Remove events
    Remove(RemoveArgs),
    /// State facts about the whole take: subject, object, task, ...
    About(AboutArgs),
    /// Print events and facts
    List(ListArgs),
    /// Write events as CSV
    Export(ExportArgs),
}

/// The file to change, and the output.
#[derive(Debug, clap::Args)]
struct Target {
    /// An MCAP file.
    file: PathBuf,
    #[command(flatten)]
    output: OutputFile,
    /// Refuse labels that are not in this vocabulary: a TOML file with a line for each key, such as
    /// task = ["rotate", "lift"], or note = "any".
    #[arg(long, value_name = "FILE")]
    vocabulary: Option<PathBuf>,
}

/// Add an event: `--at 63.4..63.6 --label slip --label finger=index`.
#[derive(Debug, clap::Args)]
struct AddArgs {
    #[command(flatten)]
    target: Target,
    /// Start and end, both included, or one instant: seconds after the file's start, or times
    /// such as 2026-11-03T10:12:00Z.
    #[arg(long, value_name = "FROM..TO", allow_hyphen_values = true)]
    at: String,
    /// A label as KEY=VALUE, or a word (short for label=WORD); repeat for more.
    #[arg(long, value_name = "LABEL", required = true)]
    label: Vec<String>,
}

/// Add the events of a CSV file. Its first columns are start_s and end_s, seconds after the file's
/// start (or start_time and end_time, or BIDS's onset and duration); every other column is a label.
#[derive(Debug, clap::Args)]
struct ImportArgs {
    #[command(flatten)]
    target: Target,
    /// Events.
    csv: PathBuf,
    /// Remove the existing events first.
    #[arg(long)]
    replace: bool,
}

/// Change one event.
#[derive(Debug, clap::Args)]
struct EditArgs {
    #[command(flatten)]
    target: Target,
    /// Number of the event, as `annotate list` prints it.
    #[arg(long, value_name = "N")]
    event: usize,
    /// Its new times, as for `add`.
    #[arg(long, value_name = "FROM..TO", allow_hyphen_values = true)]
    at: Option<String>,
    /// A label to set; repeat for more.
    #[arg(long, value_name = "LABEL")]
    label: Vec<String>,
    /// Key of a label to remove; repeat for more.
    #[arg(long, value_name = "KEY")]
    remove_label: Vec<String>,
}

/// Remove events, by number or by label.
#[derive(Debug, clap::Args)]
struct RemoveArgs {
    #[command(flatten)]
    target: Target,
    /// Number of an event, as `annotate list` prints it; repeat for more.
    #[arg(long, value_name = "N", required_unless_present = "label")]
    event: Vec<usize>,
    /// Every event with this label; repeat for any of several.
    #[arg(long, value_name = "LABEL")]
    label: Vec<String>,
}

/// State facts about the whole take.
#[derive(Debug, clap::Args)]
struct AboutArgs {
    #[command(flatten)]
    target: Target,
    /// A fact, such as subject=s01; repeat for more.
    #[arg(long, value_name = "KEY=VALUE", required_unless_present = "unset")]
    set: Vec<String>,
    /// Key of a fact to remove; repeat for more.
    #[arg(long, value_name = "KEY")]
    unset: Vec<String>,
}

/// Print events and facts.
#[derive(Debug, clap::Args)]
struct ListArgs {
    /// An MCAP file.
    file: PathBuf,
    /// Print as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Write events as CSV that `annotate import` reads again.
#[derive(Debug, clap::Args)]
struct ExportArgs {
    /// An MCAP file.
    file: PathBuf,
    #[command(flatten)]
    output: TextOutput,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    match &args.verb {
        Verb::Add(args) => change::add(console, args),
        Verb::Import(args) => change::import(console, args),
        Verb::Edit(args) => change::edit(console, args),
        Verb::Remove(args) => change::remove(console, args),
        Verb::About(args) => change::about(console, args),
        Verb::List(args) => show::list(args),
        Verb::Export(args) => show::export(console, args),
    }
}
