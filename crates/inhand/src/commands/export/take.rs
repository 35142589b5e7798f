//! A take as a table or as part of a BIDS dataset.

use std::collections::BTreeMap;

use anyhow::Result;
use inhand_export::bids::BidsNames;
use inhand_session::Take;
use inhand_session::tables::{self, Form};

use super::Args;
use crate::commands::read_take;
use crate::console::Console;
use crate::exit::{Exit, UsageError, usage};
use crate::output::check_outputs;

pub(super) fn to_table(console: &Console, args: &Args, form: Form) -> Result<Exit> {
    let (what, layout) = (args.what, args.layout);
    let mut outputs = vec![args.output.clone()];
    if tables::has_facts(what, layout, form) {
        outputs.push(tables::facts_path(&args.output));
    }
    check_outputs(&outputs, &[&args.input], args.force)?;
    let take = take(console, args)?;
    tables::write_table(&args.output, &take, what, layout, form)?;
    outputs.iter().for_each(|output| console.wrote(output));
    Ok(Exit::Done)
}

pub(super) fn to_bids(console: &Console, args: &Args, names: &str) -> Result<Exit> {
    if args.output.is_file() {
        return usage(format!(
            "-o {}: expected the folder of a BIDS dataset, found a file",
            args.output.display()
        ));
    }
    let take = take(console, args)?;
    let names = bids_names(names, &take.annotations.about)?;
    let outputs = tables::bids_paths(&args.output, &take, &names)?;
    check_outputs(&outputs, &[&args.input], args.force)?;
    tables::write_bids(&args.output, &take, &names)?;
    outputs.iter().for_each(|output| console.wrote(output));
    Ok(Exit::Done)
}

fn take(console: &Console, args: &Args) -> Result<Take> {
    let settings = args.source.effective(None)?;
    let take = read_take(console, &args.input, &settings);
    if take.is_err() && inhand_session::read_dictionary(&args.input).is_ok() {
        let input = args.input.display();
        return usage(format!(
            "{input} is a dictionary: expected -o to end in .npz or .mat"
        ));
    }
    take
}

/// Names from `KEY=LABEL,...`, and for what is not there from the facts stored with the take.
fn bids_names(text: &str, about: &BTreeMap<String, String>) -> Result<BidsNames, UsageError> {
    let mut given = BTreeMap::new();
    for pair in text.split(',').filter(|pair| !pair.trim().is_empty()) {
        let (key, label) = pair.split_once('=').ok_or_else(|| {
            UsageError(format!("--bids {pair}: expected KEY=LABEL, such as sub=01"))
        })?;
        let key = key.trim();
        if !["sub", "ses", "task", "run", "tracksys"].contains(&key) {
            let message = format!("--bids {key}: expected sub, ses, task, run or tracksys");
            return Err(UsageError(message));
        }
        given.insert(key, label.trim());
    }
    let label = |key: &str, fact: &str| {
        let fact = about.get(fact).map(String::as_str);
        given.get(key).copied().or(fact).map(str::to_owned)
    };
    let needed = |key: &str, fact: &str| {
        label(key, fact).ok_or_else(|| {
            UsageError(format!(
                "--bids: expected {key}=LABEL, as the take does not state its {fact}"
            ))
        })
    };
    let run = given.get("run").map(|run| {
        run.parse()
            .map_err(|_| UsageError(format!("--bids run={run}: expected a whole number")))
    });
    Ok(BidsNames {
        subject: needed("sub", "subject")?,
        session: label("ses", "session"),
        task: needed("task", "task")?,
        tracking_system: label("tracksys", "tracking_system").unwrap_or_else(|| "OptiTrack".into()),
        run: run.transpose()?,
    })
}
