//! `inhand export FILE -o OUTPUT`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_export::bids::BidsNames;
use inhand_session::tables::{self, TableFormat, TableLayout, TablePart};
use inhand_session::{Take, is_stream, matrices, read_dictionary};
use serde_json::json;

use crate::commands::read_take;
use crate::console::{Console, print};
use crate::exit::{Exit, UsageError, usage};
use crate::options::{Format, SourceOptions, one_of};
use crate::output::{check_output, check_outputs, reads, write_output};

/// Write a take or plan as a table (.csv, .parquet) or into a BIDS dataset (--bids), or a dictionary as matrices.
///
/// Dictionaries become named matrices for NumPy (.npz) or MATLAB (.mat). Lengths are metres, times seconds.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A take of any format, a plan, or a dictionary.
    input: PathBuf,
    /// Output: .csv or .parquet for a take, .npz or .mat for a dictionary.
    ///
    /// With --bids, the folder of the dataset.
    #[arg(short, long, value_name = "PATH")]
    output: PathBuf,
    /// Layout of a table.
    ///
    /// wide has a row for each sample, tidy one for each sample of each marker, body or finger. A wide .csv can be read
    /// as a take again, with the .csv.json beside it.
    #[arg(long, value_parser = one_of(&LAYOUTS), default_value = "wide")]
    layout: TableLayout,
    /// Part of a take or plan [default: recorded; generated of a plan].
    ///
    /// recorded are markers and bodies, after cleaning where the take was cleaned; measured are those before
    /// cleaning; processed are fingertips and object in the hand's frame; generated are positions and velocities of
    /// fingertips by every method, in the hand's frame; errors are their distances from the recorded fingertips
    /// after the filter (published protocol); `evaluate --rows` has the held-out ones; contacts are distances to the object, recorded and by method, and 1 where a finger touches.
    #[arg(long, value_parser = one_of(&PARTS))]
    what: Option<TablePart>,
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

const LAYOUTS: [(&str, TableLayout); 2] =
    [("wide", TableLayout::Wide), ("tidy", TableLayout::Tidy)];

const PARTS: [(&str, TablePart); 6] = [
    ("recorded", TablePart::Recorded),
    ("measured", TablePart::Measured),
    ("processed", TablePart::Processed),
    ("generated", TablePart::Generated),
    ("errors", TablePart::Errors),
    ("contacts", TablePart::Contacts),
];

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    if let Some(names) = &args.bids {
        if TableFormat::from_path(&args.output).is_some() || is_matrices(&args.output) {
            return usage(format!(
                "-o {}: expected the folder of a BIDS dataset with --bids",
                args.output.display()
            ));
        }
        return to_bids(console, args, names);
    }
    match TableFormat::from_path(&args.output) {
        Some(form) => to_table(console, args, form),
        None if is_matrices(&args.output) => to_matrices(console, args),
        None if is_stream(&args.output) => to_table(console, args, TableFormat::Csv),
        None => usage(format!(
            "-o {}: expected .csv or .parquet for a take, .npz or .mat for a dictionary, or --bids \
             with the folder of a dataset; `inhand convert` writes .trc, .c3d and Motive's .csv",
            args.output.display()
        )),
    }
}

fn is_matrices(path: &Path) -> bool {
    matrices::form_of(path).is_ok()
}

fn to_table(console: &Console, args: &Args, form: TableFormat) -> Result<Exit> {
    check_outputs([&args.output], &[&args.input])?;
    let take = take(console, args)?;
    let (what, layout) = (
        args.what.unwrap_or_else(|| TablePart::of(&take)),
        args.layout,
    );
    let mut outputs = vec![args.output.clone()];
    if tables::has_facts(&args.output, what, layout, form) {
        let facts = tables::facts_path(&args.output);
        check_output(&facts, || args.force || args.output.exists())?;
        outputs.push(facts);
    }
    write_output(&args.output, args.force, |path| {
        tables::write_table(path, &take, what, layout, form)
    })?;
    outputs.iter().for_each(|output| console.wrote(output));
    Ok(Exit::Done)
}

fn to_bids(console: &Console, args: &Args, names: &str) -> Result<Exit> {
    if args.output.is_file() {
        return usage(format!(
            "-o {}: expected the folder of a BIDS dataset, found a file",
            args.output.display()
        ));
    }
    let take = take(console, args)?;
    let names = bids_names(names, &take.annotations.about)?;
    reads(&[&args.input]);
    let outputs = tables::bids_paths(&args.output, &take, &names)?;
    for output in &outputs {
        check_output(output, || args.force)?;
    }
    tables::write_bids(&args.output, &take, &names)?;
    outputs.iter().for_each(|output| console.wrote(output));
    Ok(Exit::Done)
}

fn take(console: &Console, args: &Args) -> Result<Take> {
    let settings = args.source.for_all(console, &[&args.input], &[], &|_| ())?;
    let take = read_take(console, &args.input, &settings);
    if take.is_err() && read_dictionary(&args.input).is_ok() {
        let input = args.input.display();
        return usage(format!(
            "{input} is a dictionary: expected -o to end in .npz or .mat"
        ));
    }
    take
}

/// Names from `KEY=LABEL,...`, and otherwise from the facts stored with the take.
fn bids_names(text: &str, about: &BTreeMap<String, String>) -> Result<BidsNames> {
    let mut labels = BTreeMap::new();
    for (key, fact) in [("sub", "subject"), ("ses", "session"), ("task", "task")] {
        labels.insert(key, about.get(fact).map(String::as_str));
    }
    labels.insert("tracksys", about.get("tracking_system").map(String::as_str));
    labels.insert("run", None);
    for pair in text.split(',').filter(|pair| !pair.trim().is_empty()) {
        let Some((key, label)) = pair.split_once('=') else {
            return usage(format!("--bids {pair}: expected KEY=LABEL, such as sub=01"));
        };
        let Some(known) = labels.get_mut(key.trim()) else {
            let key = key.trim();
            return usage(format!(
                "--bids {key}: expected sub, ses, task, run or tracksys"
            ));
        };
        *known = Some(label.trim());
    }
    let label = |key: &str| labels[key].map(str::to_owned);
    let needed = |key: &str| {
        let message = || format!("--bids: expected {key}=LABEL, since the take does not state it");
        label(key).ok_or_else(|| UsageError(message()))
    };
    let run = labels["run"].map(|run| {
        let message = |_| UsageError(format!("--bids run={run}: expected a whole number"));
        run.parse().map_err(message)
    });
    Ok(BidsNames {
        subject: needed("sub")?,
        session: label("ses"),
        task: needed("task")?,
        tracking_system: label("tracksys").unwrap_or_else(|| "OptiTrack".into()),
        run: run.transpose()?,
    })
}

fn to_matrices(console: &Console, args: &Args) -> Result<Exit> {
    check_outputs([&args.output], &[&args.input])?;
    let matrices = matrices::export_dictionary(&read_dictionary(&args.input)?.dictionary);
    write_output(&args.output, args.force, |path| {
        matrices::write(path, &matrices)
    })?;
    let sizes: Vec<_> = (matrices.iter())
        .filter_map(|(name, variable)| Some((name, variable.numbers()?.shape())))
        .collect();
    let line = |&(name, (rows, columns)): &(&String, (usize, usize))| {
        format!("{name:<36} {rows} x {columns}\n")
    };
    let text = || sizes.iter().map(line).collect();
    let json = || json!({ "matrices": sizes.iter().copied().collect::<BTreeMap<_, _>>() });
    print(args.format, text, json)?;
    console.wrote(&args.output);
    Ok(Exit::Done)
}
