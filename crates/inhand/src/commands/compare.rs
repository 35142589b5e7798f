//! `inhand compare BEFORE AFTER`.

mod condition;

use std::path::PathBuf;

use anyhow::Result;
use inhand_session::sessions::{CompareOptions, Part, compare};
use inhand_session::{EvaluateSection, write_text};

use crate::console::{Console, data};
use crate::exit::{Exit, usage};
use crate::options::Format;
use crate::output::check_outputs;
use condition::Condition;

/// Compare two evaluations or two methods, with intervals; fail on a condition
///
/// Compares an evaluation with an earlier one, or two methods of one evaluation, with bootstrap intervals over
/// segments. For use in tests: with --fail-if the exit code is 3 where the condition holds.
///
/// Segments that both evaluations share are drawn together, which gives the narrowest intervals.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// evaluation.json before the change, or the folder with it.
    before: PathBuf,
    /// evaluation.json after the change; none to compare two methods of one.
    after: Option<PathBuf>,
    /// Method after the change [default: every method that both have].
    #[arg(long, value_name = "METHOD")]
    method: Option<String>,
    /// Method before the change, where it is another one.
    #[arg(long, value_name = "METHOD")]
    against: Option<String>,
    /// Exit with 3 if this holds: `[METHOD:]STATISTIC[.FINGER][.low|.high] OP NUMBER[%|mm]`.
    ///
    /// STATISTIC is mean, rmse, p50, p75, p95 or three_or_more, OP one of > >= < <=. The number is the change from
    /// before to after: "p75 > 5%" holds if the third quartile of the error of the first method grew by more than
    /// 5 %, "prior:p95.thumb > 0.2mm" if the 95 % quantile of the thumb with prior grew by more than 0.2 mm. For
    /// three_or_more, % are percentage points. With .low the lower end of the interval is compared: "p75.low > 0%"
    /// holds only if the whole interval is above zero.
    #[arg(long, value_name = "CONDITION")]
    fail_if: Vec<Condition>,
    /// Draws of the bootstrap; 0 for no intervals.
    #[arg(long, value_name = "N", default_value_t = EvaluateSection::default().draws, value_parser = draws)]
    draws: usize,
    /// Confidence of intervals, 0 to 1.
    #[arg(long, value_name = "SHARE", default_value_t = EvaluateSection::default().confidence)]
    confidence: f64,
    /// Markdown for a pull request.
    #[arg(short, long, value_name = "FILE.md")]
    output: Option<PathBuf>,
    /// Print as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    if args.after.is_none() && args.method.is_none() && args.against.is_none() {
        return usage(
            "nothing to compare: name another evaluation, or two methods of this one with --method and --against",
        );
    }
    let before = Part::read(&args.before)?;
    let after = Part::read(args.after.as_ref().unwrap_or(&args.before))?;
    check_outputs(&args.output, &[&before.path, &after.path], args.force)?;
    let options = CompareOptions {
        method: args.method.clone(),
        against: args.against.clone(),
        draws: args.draws,
        confidence: args.confidence,
    };
    let comparison = compare(&before, &after, &options)?;
    match args.format {
        Format::Json => data(&inhand_report::comparison_json(&comparison)?)?,
        Format::Text => data(&inhand_report::comparison_text(&comparison))?,
    }
    if let Some(output) = &args.output {
        write_text(output, &inhand_report::comparison_markdown(&comparison))?;
        console.wrote(output);
    }
    let mut exit = Exit::Done;
    for condition in &args.fail_if {
        if let Some(holds) = condition.holds(&comparison)? {
            // Not even a quiet console hides why a check fails.
            console.error(&anyhow::anyhow!("check failed: {holds}"));
            exit = Exit::Lossy;
        }
    }
    Ok(exit)
}

/// None, or as many as intervals need and memory holds.
fn draws(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(draws @ (0 | 100..=1_000_000)) => Ok(draws),
        _ => Err("expected 0, or 100 to 1000000".to_owned()),
    }
}
