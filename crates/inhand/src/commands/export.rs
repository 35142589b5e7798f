//! `inhand export FILE -o MATRICES`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use inhand_pipeline::matrices::{self, Matrices};
use inhand_pipeline::{check_target, read_dictionary};
use serde_json::json;

use crate::console::{Console, data};
use crate::exit::{Exit, UsageError};
use crate::options::Format;

/// Writes the numbers of a dictionary as named matrices for NumPy (.npz) or MATLAB (.mat): metres,
/// seconds, columns as they are planned with.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A dictionary.
    input: PathBuf,
    /// File of matrices; .npz or .mat says its form.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Print the outcome as text or JSON.
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    /// Replace an output that is there.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(console: &Console, args: &Args) -> Result<Exit> {
    matrices::form_of(&args.output).map_err(|error| UsageError(format!("-o {error}")))?;
    check_target(&args.output, &[&args.input], || args.force)?;
    let matrices = matrices_of(&args.input)?;
    matrices::write(&args.output, &matrices)?;
    let shapes: Vec<_> = (matrices.iter())
        .filter_map(|(name, variable)| Some((name, variable.numbers()?.shape())))
        .collect();
    match args.format {
        Format::Json => {
            let sizes: serde_json::Map<_, _> = (shapes.iter())
                .map(|&(name, (rows, columns))| (name.clone(), json!([rows, columns])))
                .collect();
            data(&format!("{:#}\n", json!({ "matrices": sizes })))?;
        }
        Format::Text => {
            let lines: String = (shapes.iter())
                .map(|(name, (rows, columns))| format!("{name:<36} {rows} x {columns}\n"))
                .collect();
            data(&lines)?;
        }
    }
    console.say(&format!("wrote {}", args.output.display()));
    Ok(Exit::Done)
}

/// What there is to export in a file.
fn matrices_of(input: &Path) -> Result<Matrices> {
    let file = read_dictionary(input)?;
    Ok(matrices::export_dictionary(&file.dictionary))
}
