//! `inhand report merge PARTS... -o FILE`.

use std::path::PathBuf;

use anyhow::Result;
use inhand_model::Summary;
use inhand_session::sessions::{MergeOptions, Part, merge};
use inhand_session::write_text;

use super::forms;
use crate::console::{Console, data};
use crate::exit::Exit;
use crate::output::check_outputs;

/// Join the evaluations of many sessions in one report
///
/// The report has errors with intervals over sessions, ranked sessions, outliers, and tables by participant, object,
/// task and finger.
///
/// Each evaluation.json needs the rows.parquet of the same run beside it, and nothing else: quantiles over
/// all sessions are exact, and recordings are not read. Sessions with different settings are refused unless
/// --allow-different is given.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Files evaluation.json, or folders with one.
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
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let forms = forms(&args.output, &["html", "htm", "md", "json", "csv"])?;
    let parts = Part::read_all(&args.parts)?;
    let inputs: Vec<_> = parts.iter().map(|part| &part.path).collect();
    check_outputs(&args.output, &inputs, args.force)?;
    let options = MergeOptions {
        allow_different: args.allow_different,
        draws: args.draws as usize,
        confidence: args.confidence,
    };
    let summary = merge(&parts, options)?;
    for (output, form) in args.output.iter().zip(forms) {
        write_text(output, &text_of(&summary, form)?)?;
    }
    data(&inhand_report::summary_text(&summary, false))?;
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
