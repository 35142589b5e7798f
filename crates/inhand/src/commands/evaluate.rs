//! `inhand evaluate --dictionary D TAKE... -o EVALUATION`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_model::Finding;
use inhand_session::steps::ProtocolRows;
use inhand_session::tables::{TableFormat, write_rows};
use inhand_session::{
    Settings, Take, evaluate_stored, generated_by, provenance, results_key, write_text,
};

use crate::commands::{read_takes, say_held_out, say_used};
use crate::console::{Console, data, wrapped};
use crate::exit::{Exit, usage};
use crate::options::{EvaluateOptions, Format, TakeOptions};
use crate::output::{OutputFile, check_outputs, ending, write_output};

/// Compare generated with recorded motion in takes and write evaluation.json.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Takes with generated channels, written by `generate` or `run`.
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Dictionary that the motion was generated with.
    #[arg(short, long, value_name = "FILE")]
    dictionary: PathBuf,
    #[command(flatten)]
    output: OutputFile,
    /// Write every evaluated instant as a table, .parquet or .csv; those of the held-out protocol beside it.
    #[arg(long, value_name = "FILE")]
    rows: Option<PathBuf>,
    /// Write planned and recorded positions into the rows too.
    #[arg(long, requires = "rows")]
    row_positions: bool,
    /// Print the evaluation as text or json.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    takes: TakeOptions,
    /// Velocity bounds as a multiple of the training extremes [default: 1.1].
    #[arg(long, value_name = "FACTOR")]
    velocity_factor: Option<f64>,
    #[command(flatten, next_help_heading = "Evaluation")]
    evaluate: EvaluateOptions,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    let typed = |settings: &mut Settings| {
        let plan = &mut settings.plan;
        plan.velocity_factor = args.velocity_factor.unwrap_or(plan.velocity_factor);
        args.evaluate.apply(settings);
    };
    let settings = args.takes.for_all(console, &args.inputs, &[], &typed)?;
    let output = &args.output.output;
    ending(output, &["json"])?;
    let inputs: Vec<_> = args.inputs.iter().chain([&args.dictionary]).collect();
    // Beside x.parquet there is x.held_out.parquet.
    let held_out_path = args.rows.as_ref().and_then(|path| {
        let ending = path.extension()?.to_str()?;
        Some(path.with_extension(format!("held_out.{ending}")))
    });
    let outputs = [output].into_iter().chain(&args.rows).chain(&held_out_path);
    check_outputs(outputs, &inputs)?;
    if let Some(path) = &args.rows {
        let shown = path.display();
        if TableFormat::from_path(path).is_none() {
            return usage(format!(
                "--rows {shown}: expected a file that ends in .parquet or .csv"
            ));
        }
    }
    let dictionary = inhand_session::read_dictionary(&args.dictionary)?;
    let mut takes = read_takes(console, &args.inputs, &settings)?;
    say_used(console, &takes, &settings)?;
    say_held_out(console, &dictionary.dictionary);
    for take in &takes {
        if let Some(found) = processed_otherwise(take, &settings) {
            console.finding(&take.path.display().to_string(), &found);
        }
    }
    let task = console.step("evaluating");
    let tables = args.rows.is_some();
    let mut evaluated = evaluate_stored(&mut takes, &dictionary, &settings, tables)?;
    drop(task);
    let hashes = takes.iter().map(|take| &take.hash);
    let hashes = hashes.chain([&dictionary.hash]).cloned();
    let made = provenance("evaluate", &evaluated.settings, hashes);
    let steps = takes.iter().flat_map(|take| take.provenance.clone());
    let chain: Vec<_> = steps.chain([made]).collect();
    evaluated.evaluation.key = Some(results_key(&evaluated.evaluation.session.name, &chain));
    let evaluation = &evaluated.evaluation;
    let text = inhand_report::evaluation_json(evaluation, &chain)?;
    let write = |path: &Path, rows: Option<ProtocolRows<'_>>| {
        write_output(path, args.output.force, |path| match rows {
            Some(rows) => write_rows(path, evaluation, rows, args.row_positions),
            None => write_text(path, &text),
        })
    };
    let published = args.rows.as_ref().zip(evaluated.published.as_ref());
    let held_out = held_out_path.as_ref().zip(evaluated.held_out.as_ref());
    let tables = published.into_iter().chain(held_out);
    let tables = tables.map(|(path, rows)| (path, Some(rows.as_rows())));
    // The evaluation is last: where it is, so are its rows. Outputs that must not be replaced are only compared, and
    // before any other is written.
    let outputs = tables.chain([(output, None)]);
    let (kept, others): (Vec<_>, Vec<_>) =
        outputs.partition(|(path, _)| !args.output.force && path.is_file());
    for (path, rows) in kept.into_iter().chain(others) {
        write(path, rows)?;
    }
    match args.format {
        Format::Json => data(&text)?,
        Format::Text => data(&(wrapped(&inhand_report::text_summary(evaluation)) + "\n"))?,
    }
    console.wrote(output);
    Ok(Exit::Done)
}

/// A warning where trajectories were generated from motion that was processed in another way than these settings say.
fn processed_otherwise(take: &Take, settings: &Settings) -> Option<Finding> {
    let [then, now] = [&generated_by(take)?, settings].map(|s| s.to_json()["process"].take());
    let then = then.as_object()?.iter();
    let differing: Vec<_> = then
        .filter(|(key, then)| now[key] != **then)
        .map(|(key, then)| format!("process.{key} {then}, here it is {}", now[key]))
        .collect();
    let message = format!(
        "trajectories were generated with {}: published errors compare different motion",
        differing.join(", and with ").replace('"', "")
    );
    (!differing.is_empty()).then(|| Finding::warning("", message))
}
