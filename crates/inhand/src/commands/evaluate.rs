//! `inhand evaluate --dictionary D TAKE... -o EVALUATION`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_session::tables::{Form, write_rows};
use inhand_session::{check_target, evaluate_stored, provenance, write_text};

use crate::commands::{read_takes, say_used};
use crate::console::{Console, data};
use crate::exit::{Exit, UsageError};
use crate::options::{EvaluateOptions, Format, ProcessOptions, SelectOptions, SourceOptions};

/// Compare the generated motion in takes with the recorded one and write evaluation.json.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes with generated channels, as `generate` and `run` write them.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Dictionary that the motion was generated with.
    #[arg(short, long, value_name = "FILE")]
    dictionary: PathBuf,
    /// evaluation.json to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Every judged instant behind it as a table: .parquet or .csv.
    #[arg(long, value_name = "FILE")]
    rows: Option<PathBuf>,
    /// Print the table as text, or evaluation.json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten, next_help_heading = "Source")]
    source: SourceOptions,
    #[command(flatten, next_help_heading = "Events")]
    select: SelectOptions,
    #[command(flatten, next_help_heading = "Processing")]
    process: ProcessOptions,
    /// Velocity bounds: training extremes times this [default: 1.1].
    #[arg(long, value_name = "FACTOR")]
    velocity_factor: Option<f64>,
    #[command(flatten, next_help_heading = "Evaluation")]
    evaluate: EvaluateOptions,
    /// Replace an output that is there.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let mut settings = args.source.effective(None)?;
    args.select.apply(&mut settings)?;
    args.process.apply(&mut settings)?;
    if let Some(factor) = args.velocity_factor {
        settings.plan.velocity_factor = factor;
    }
    args.evaluate.apply(&mut settings)?;
    settings.validate()?;
    let mut inputs: Vec<_> = args.inputs.iter().map(PathBuf::as_path).collect();
    inputs.push(&args.dictionary);
    for target in [Some(&args.output), args.rows.as_ref()]
        .into_iter()
        .flatten()
    {
        check_target(target, &inputs, || args.force)?;
    }
    if let Some(path) = &args.rows {
        check_rows(path, &args.output)?;
    }
    let dictionary = inhand_session::read_dictionary(&args.dictionary)?;
    let takes = read_takes(console, &args.inputs, &settings)?;
    say_used(console, &takes, &settings)?;
    let (evaluation, rows) = evaluate_stored(
        &takes,
        &dictionary,
        &settings,
        !args.process.ask_for_processing(),
    )?;
    let mut hashes: Vec<_> = takes.iter().map(|take| take.hash.clone()).collect();
    hashes.push(dictionary.hash.clone());
    let made = provenance("evaluate", &settings, hashes);
    let mut chain: Vec<_> = takes
        .iter()
        .flat_map(|take| take.provenance.clone())
        .collect();
    chain.push(made);
    let text = inhand_report::evaluation_json(&evaluation, &chain)?;
    write_text(&args.output, &text)?;
    if let Some(path) = &args.rows {
        write_rows(path, &evaluation.session.name, &rows)?;
    }
    match args.format {
        Format::Json => data(&text)?,
        Format::Text => data(&format!("{}\n", inhand_report::text_summary(&evaluation)))?,
    }
    console.say(&format!("wrote {}", args.output.display()));
    Ok(Exit::Done)
}

/// Refuses a table of no known form, or in the place of the evaluation.
fn check_rows(path: &Path, evaluation: &Path) -> Result<()> {
    if Form::of(path).is_none() {
        let message = format!(
            "--rows {}: expected a file that ends in .parquet or .csv",
            path.display()
        );
        return Err(UsageError(message).into());
    }
    if path == evaluation {
        let message = format!("--rows and -o both name {}", path.display());
        return Err(UsageError(message).into());
    }
    Ok(())
}
