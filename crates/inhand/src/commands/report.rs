//! `inhand report EVALUATION -o FILE`, and `inhand report merge`.

mod merge;

use std::path::PathBuf;

use anyhow::Result;
use clap::Subcommand;
use inhand_report::Report;
use inhand_session::sessions::Part;
use inhand_session::{plan_times_beside, write_text};

use crate::console::Console;
use crate::exit::{Exit, UsageError, usage};
use crate::output::check_outputs;

/// Write an evaluation as a page or in Markdown; join many into one report
///
/// Figures of single instants come from the rows.parquet beside the evaluation, times of plans from the run.json
/// beside it. Only the page that `run` writes has figures of takes and primitives.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    of_many: Option<OfMany>,
    /// An evaluation.json, or the folder that `run` wrote it into.
    #[arg(required = true)]
    evaluation: Option<PathBuf>,
    /// File to write: .html for a page, .md for Markdown; several may be named.
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

/// Reports over several evaluations.
#[derive(Debug, Subcommand)]
enum OfMany {
    Merge(merge::Args),
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    if let Some(OfMany::Merge(args)) = &args.of_many {
        return merge::run(console, args);
    }
    let Some(path) = &args.evaluation else {
        // The parser asks for it.
        return usage("no evaluation was named");
    };
    let forms = forms(&args.output, &["html", "htm", "md"])?;
    let part = Part::read(path)?;
    check_outputs(&args.output, &[&part.path], args.force)?;
    let rows = part.read_rows()?;
    let plan_times = plan_times_beside(&part.path);
    let report = Report {
        rows: rows.as_ref(),
        plan_times: &plan_times,
        ..Report::new(&part.evaluation, &part.provenance)
    };
    for (output, form) in args.output.iter().zip(forms) {
        let text = match form {
            "md" => inhand_report::markdown(&report)?,
            _ => inhand_report::html(&report)?,
        };
        write_text(output, &text)?;
        console.wrote(output);
    }
    Ok(Exit::Done)
}

/// The format of each output, as its extension names it.
fn forms<'a>(outputs: &[PathBuf], known: &[&'a str]) -> Result<Vec<&'a str>, UsageError> {
    let form = |path: &PathBuf| {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let mut known = known.iter().copied();
        known.find(|known| Some(*known) == extension.as_deref())
    };
    let mut forms = Vec::with_capacity(outputs.len());
    for (place, output) in outputs.iter().enumerate() {
        let shown = output.display();
        if outputs[..place].contains(output) {
            return Err(UsageError(format!("-o names {shown} twice")));
        }
        forms.push(form(output).ok_or_else(|| {
            let endings = known.join(", .");
            UsageError(format!(
                "-o {shown}: expected a file that ends in .{endings}"
            ))
        })?);
    }
    Ok(forms)
}
