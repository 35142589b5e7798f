//! `inhand report EVALUATION -o FILE`, and `inhand report merge`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Subcommand;
use inhand_model::{Protocol, Summary};
use inhand_report::Report;
use inhand_session::sessions::{MergeOptions, Part, merge};
use inhand_session::{plan_times_beside, write_text};

use super::batch;
use crate::console::{Console, data};
use crate::exit::{Exit, UsageError, usage};
use crate::options::Format;
use crate::output::{check_outputs, ending, reads_part, write_output};

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
    Merge(MergeArgs),
}

/// Join the evaluations of many sessions in one report
///
/// The report has errors with intervals over sessions, ranked sessions, outliers, and tables by participant, object,
/// task and finger.
///
/// Each evaluation.json needs the rows.parquet of the same run beside it, and nothing else: quantiles over
/// all sessions are exact, and recordings are not read. Sessions with different settings are refused unless
/// --allow-different is given.
#[derive(Debug, clap::Args)]
pub(crate) struct MergeArgs {
    /// Files evaluation.json, folders with one, or a folder that `batch` wrote.
    #[arg(required = true)]
    parts: Vec<PathBuf>,
    /// File to write: .html for a page, .md for Markdown, .json, .csv for a table of sessions; several may
    /// be named.
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,
    /// Join sessions although settings or methods differ; the report lists the differences.
    #[arg(long)]
    allow_different: bool,
    /// Draws of the bootstrap over sessions.
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(100..=1_000_000))]
    draws: u32,
    /// Confidence of intervals, 0 to 1.
    #[arg(long, value_name = "SHARE", default_value_t = MergeOptions::default().confidence)]
    confidence: f64,
    /// Print the summary as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    if let Some(OfMany::Merge(args)) = &args.of_many {
        return run_merge(console, args);
    }
    let Some(path) = &args.evaluation else {
        // The parser asks for it.
        return usage("no evaluation was named");
    };
    let forms = forms(&args.output, &["html", "htm", "md"])?;
    let part = Part::read(path)?;
    reads_part(&part);
    check_outputs::<&Path>(&args.output, &[])?;
    let rows = part.read_rows(Protocol::Published)?;
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
        write_output(output, args.force, |path| write_text(path, &text))?;
        console.wrote(output);
    }
    Ok(Exit::Done)
}

fn run_merge(console: &Console, args: &MergeArgs) -> Result<Exit> {
    let forms = forms(&args.output, &["html", "htm", "md", "json", "csv"])?;
    let named = args.parts.iter();
    let named = named.flat_map(|path| batch::results(path).unwrap_or_else(|| vec![path.clone()]));
    let parts = Part::read_all(&named.collect::<Vec<_>>())?;
    parts.iter().for_each(reads_part);
    check_outputs::<&Path>(&args.output, &[])?;
    let options = MergeOptions {
        allow_different: args.allow_different,
        draws: args.draws as usize,
        confidence: args.confidence,
    };
    let summary = merge(&parts, options)?;
    for (output, form) in args.output.iter().zip(forms) {
        let text = text_of(&summary, form)?;
        write_output(output, args.force, |path| write_text(path, &text))?;
    }
    data(&match args.format {
        Format::Text => inhand_report::summary_text(&summary, false),
        Format::Json => inhand_report::summary_json(&summary)?,
    })?;
    args.output.iter().for_each(|output| console.wrote(output));
    Ok(Exit::Done)
}

fn text_of(summary: &Summary, form: &str) -> Result<String> {
    Ok(match form {
        "md" => inhand_report::summary_text(summary, true),
        "json" => inhand_report::summary_json(summary)?,
        "csv" => inhand_report::summary_table(summary).csv(),
        _ => inhand_report::summary_html(summary),
    })
}

/// The format of each output, as its extension names it.
fn forms<'a>(outputs: &[PathBuf], known: &[&'a str]) -> Result<Vec<&'a str>, UsageError> {
    let mut forms = Vec::with_capacity(outputs.len());
    for (place, output) in outputs.iter().enumerate() {
        if outputs[..place].contains(output) {
            return Err(UsageError(format!("-o names {} twice", output.display())));
        }
        forms.push(ending(output, known)?);
    }
    Ok(forms)
}
