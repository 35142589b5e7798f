//! `inhand report EVALUATION -o HTML`, or `-o MARKDOWN`.

use std::path::PathBuf;

use anyhow::{Context, Result};
use inhand_pipeline::{check_target, write_text};

use crate::console::Console;
use crate::exit::Exit;

/// Makes the HTML page of an evaluation, or its summary in Markdown.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// An evaluation.json.
    evaluation: PathBuf,
    /// Page to write; a name that ends in .md gets a summary in Markdown instead.
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
    let report = inhand_report::Report::new(&evaluation, &provenance);
    let is_markdown = (args.output.extension()).is_some_and(|own| own.eq_ignore_ascii_case("md"));
    let page = if is_markdown {
        inhand_report::markdown(&report)?
    } else {
        inhand_report::html(&report)?
    };
    write_text(&args.output, &page)?;
    console.say(&format!("wrote {}", args.output.display()));
    Ok(Exit::Done)
}
