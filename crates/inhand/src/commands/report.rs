//! `inhand report EVALUATION -o HTML`.

use std::path::PathBuf;

use anyhow::{Context, Result};
use inhand_pipeline::{check_target, write_text};

use crate::console::Console;
use crate::exit::Exit;

/// Makes the HTML page of an evaluation.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An evaluation.json.
    evaluation: PathBuf,
    /// Page to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Replace a page that is there.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    check_target(&args.output, &[&args.evaluation], || args.force)?;
    let shown = args.evaluation.display();
    let text = std::fs::read_to_string(&args.evaluation)
        .with_context(|| format!("cannot read {shown}"))?;
    let (evaluation, provenance) =
        inhand_report::read_evaluation_json(&text).with_context(|| shown.to_string())?;
    write_text(
        &args.output,
        &inhand_report::html(&inhand_report::Report::new(&evaluation, &provenance))?,
    )?;
    console.say(&format!("wrote {}", args.output.display()));
    Ok(Exit::Done)
}
