//! `inhand report EVALUATION -o FILE`, and `inhand report merge`.

mod merge;

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Subcommand;
use inhand_report::Report;
use inhand_session::sessions::Part;
use inhand_session::{check_target, plan_times_beside, write_text};

use crate::console::Console;
use crate::exit::{Exit, UsageError};

/// Write an evaluation as a page or in Markdown; join many into one report
///
/// The rows.parquet beside the evaluation gives it the figures of single instants, the run.json beside it the
/// times of plans. Figures of takes and primitives are in the page that `run` writes alone.
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
    /// Replace a file that is there.
    #[arg(long)]
    force: bool,
}

/// What is made from several evaluations.
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
        return Err(UsageError("no evaluation was named".to_owned()).into());
    };
    let forms = forms(&args.output, &["html", "htm", "md"])?;
    let part = Part::read(path)?;
    for output in &args.output {
        check_target(output, &[&part.path], || args.force)?;
    }
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
        console.say(&format!("wrote {}", output.display()));
    }
    Ok(Exit::Done)
}

/// The form of each output, as its extension names it.
fn forms<'a>(outputs: &[PathBuf], known: &[&'a str]) -> Result<Vec<&'a str>> {
    let form = |path: &PathBuf| {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let found = known
            .iter()
            .find(|known| Some(**known) == extension.as_deref());
        found.copied().ok_or_else(|| unknown_form(path, known))
    };
    let forms = outputs.iter().map(form).collect::<Result<_>>()?;
    let twice = |path: &&PathBuf| outputs.iter().filter(|other| other == path).count() > 1;
    match outputs.iter().find(twice) {
        Some(path) => Err(UsageError(format!("-o names {} twice", path.display())).into()),
        None => Ok(forms),
    }
}

fn unknown_form(path: &Path, known: &[&str]) -> anyhow::Error {
    let endings: Vec<String> = known.iter().map(|known| format!(".{known}")).collect();
    let message = format!(
        "-o {}: expected a file that ends in {}",
        path.display(),
        endings.join(", ")
    );
    UsageError(message).into()
}
