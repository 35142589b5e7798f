//! Output files of commands: checked before anything takes long, and named when written.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use inhand_session::{check_target, is_stream, write_text};

use crate::console::{Console, data};
use crate::exit::UsageError;

/// An output file.
#[derive(Clone, Debug, Args)]
pub(crate) struct OutputFile {
    /// Output file.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Replace an output that exists.
    #[arg(long)]
    pub(crate) force: bool,
}

impl OutputFile {
    /// Refuses an output that is an input, or exists without --force.
    pub(crate) fn check<P: AsRef<Path>>(&self, inputs: &[P]) -> Result<()> {
        check_outputs([&self.output], inputs, self.force)
    }

    /// The same for an MCAP file, whose name has to say so.
    pub(crate) fn check_mcap<P: AsRef<Path>>(&self, inputs: &[P]) -> Result<()> {
        ending(&self.output, &["mcap"])?;
        self.check(inputs)
    }
}

/// Text that is printed, or written to a file.
#[derive(Clone, Debug, Args)]
pub(crate) struct TextOutput {
    /// Output file [default: printed].
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Replace an output that exists.
    #[arg(long)]
    force: bool,
}

impl TextOutput {
    /// Refuses an output that is an input, or exists without --force.
    pub(crate) fn check<P: AsRef<Path>>(&self, inputs: &[P]) -> Result<()> {
        check_outputs(&self.output, inputs, self.force)
    }

    /// Writes or prints the text.
    pub(crate) fn write(&self, console: &Console, text: &str) -> Result<()> {
        let Some(output) = &self.output else {
            return Ok(data(text)?);
        };
        write_text(output, text)?;
        console.wrote(output);
        Ok(())
    }
}

/// The ending of an output, one of those that the command writes. A device or a FIFO needs none.
pub(crate) fn ending<'a>(output: &Path, known: &[&'a str]) -> Result<&'a str, UsageError> {
    let extension = (output.extension()).map(|e| e.to_string_lossy().to_lowercase());
    let found = (known.iter()).find(|known| Some(**known) == extension.as_deref());
    match found.or_else(|| is_stream(output).then(|| &known[0])) {
        Some(found) => Ok(found),
        None => Err(UsageError(format!(
            "-o {}: expected a file that ends in .{}",
            output.display(),
            known.join(", .")
        ))),
    }
}

/// Refuses outputs that are inputs, or exist and must not be replaced.
pub(crate) fn check_outputs<'a, P: AsRef<Path>>(
    outputs: impl IntoIterator<Item = &'a PathBuf>,
    inputs: &[P],
    force: bool,
) -> Result<()> {
    let inputs: Vec<&Path> = inputs.iter().map(AsRef::as_ref).collect();
    let mut outputs = outputs.into_iter();
    Ok(outputs.try_for_each(|output| check_target(output, &inputs, || force))?)
}
