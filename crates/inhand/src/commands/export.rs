//! `inhand export FILE -o OUTPUT`.

mod dictionary;
mod take;

use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_session::tables::{Form, Layout, What};

use crate::console::Console;
use crate::exit::{Exit, UsageError, usage};
use crate::options::{Format, SourceOptions, one_of};

/// Write a take as a table (.csv, .parquet) or into a BIDS dataset (--bids), or a dictionary as matrices.
///
/// Dictionaries become named matrices for NumPy (.npz) or MATLAB (.mat). Lengths are metres, times seconds.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A take of any format, or a dictionary.
    input: PathBuf,
    /// Output: .csv or .parquet for a take, .npz or .mat for a dictionary.
    ///
    /// With --bids, the folder of the dataset.
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
    /// Layout of a table.
    ///
    /// wide has a row for each sample, tidy one for each sample of each marker and body. A wide .csv can be read
    /// as a take again, with the .csv.json beside it.
    #[arg(long, value_parser = one_of(&LAYOUTS), default_value = "wide")]
    layout: Layout,
    /// Part of a take.
    ///
    /// recorded are markers and bodies, after cleaning where the take was cleaned; measured are those before
    /// cleaning; processed are fingertips and object in the hand's frame.
    #[arg(long, value_parser = one_of(&PARTS), default_value = "recorded")]
    what: What,
    /// Write the take into a BIDS dataset, such as sub=01,task=rotate.
    ///
    /// The labels are sub, task, and optionally ses, run (a number) and tracksys. Without sub and task, those that
    /// `annotate about` stored are used.
    #[arg(long, value_name = "KEY=LABEL,...", num_args = 0..=1, default_missing_value = "",
          conflicts_with_all = ["layout", "what"])]
    bids: Option<String>,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
    /// Print the sizes of a dictionary's matrices as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Replace outputs that exist.
    #[arg(long)]
    force: bool,
}

const LAYOUTS: [(&str, Layout); 2] = [("wide", Layout::Wide), ("tidy", Layout::Tidy)];

const PARTS: [(&str, What); 3] = [
    ("recorded", What::Recorded),
    ("measured", What::Measured),
    ("processed", What::Processed),
];

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    if let Some(names) = &args.bids {
        if Form::of(&args.output).is_some() || is_matrices(&args.output) {
            return usage(format!(
                "-o {}: expected the folder of a BIDS dataset with --bids",
                args.output.display()
            ));
        }
        return take::to_bids(console, args, names);
    }
    match Form::of(&args.output) {
        Some(form) => take::to_table(console, args, form),
        None if is_matrices(&args.output) => dictionary::run(console, args),
        None => Err(UsageError(format!(
            "-o {}: expected .csv or .parquet for a take, .npz or .mat for a dictionary, or --bids \
             with the folder of a dataset; `inhand convert` writes .trc, .c3d and Motive's .csv",
            args.output.display()
        ))
        .into()),
    }
}

fn is_matrices(path: &Path) -> bool {
    inhand_session::matrices::form_of(path).is_ok()
}
