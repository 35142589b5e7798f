//! Output files of commands: checked before anything takes long, and named when written.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Error, Result};
use clap::Args;
use inhand_session::containers::hash_file;
use inhand_session::sessions::Part;
use inhand_session::tables::facts_path;
use inhand_session::{
    BAG_FACTS, already_exists, check_target, is_stream, scratch_folder, take_files, write_text,
};

use crate::console::{Console, data};
use crate::exit::UsageError;

/// Files that this call reads: no output may replace them.
static READ: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

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
    /// Refuses an output that is an input or does not end in .mcap.
    pub(crate) fn check_mcap<P: AsRef<Path>>(&self, inputs: &[P]) -> Result<()> {
        ending(&self.output, &["mcap"])?;
        check_outputs([&self.output], inputs)
    }

    /// Writes it by [`write_output`].
    pub(crate) fn write<T, E: Into<Error>>(
        &self,
        write: impl FnOnce(&Path) -> Result<T, E>,
    ) -> Result<T> {
        write_output(&self.output, self.force, write)
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
    /// Refuses an output that is an input.
    pub(crate) fn check<P: AsRef<Path>>(&self, inputs: &[P]) -> Result<()> {
        check_outputs(&self.output, inputs)
    }

    /// Writes or prints the text.
    pub(crate) fn write(&self, console: &Console, text: &str) -> Result<()> {
        let Some(output) = &self.output else {
            return Ok(data(text)?);
        };
        write_output(output, self.force, |path| write_text(path, text))?;
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

/// Writes an output. Without --force one that exists may only be written again as it is: the identical call can be
/// repeated, and no other replaces its results.
pub(crate) fn write_output<T, E: Into<Error>>(
    target: &Path,
    force: bool,
    write: impl FnOnce(&Path) -> Result<T, E>,
) -> Result<T> {
    check_output(target, || true)?;
    if force || !target.is_file() || is_stream(target) {
        return write(target).map_err(Into::into);
    }
    let scratch = scratch_folder(target)?;
    let beside = |folder: &Path, name: &OsStr| hash_file(&folder.join(name)).ok();
    let name = target.file_name().unwrap_or_default();
    let done = write(&scratch.path().join(name)).map_err(Into::into)?;
    // Some outputs have files of facts beside them.
    for file in scratch.path().read_dir()? {
        let name = file?.file_name();
        let earlier = beside(target.parent().unwrap_or(target), &name);
        if earlier.is_none() || earlier != beside(scratch.path(), &name) {
            return Err(already_exists(target).into());
        }
    }
    Ok(done)
}

/// Refuses outputs that are inputs, files of a bag among the inputs, or folders.
pub(crate) fn check_outputs<'a, P: AsRef<Path>>(
    outputs: impl IntoIterator<Item = &'a PathBuf>,
    inputs: &[P],
) -> Result<()> {
    reads(inputs);
    (outputs.into_iter()).try_for_each(|output| check_output(output, || true))
}

/// Refuses an output that is a folder or a file which this call reads, or that exists and may not be replaced.
pub(crate) fn check_output(output: &Path, may_replace: impl FnOnce() -> bool) -> Result<()> {
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    let inputs: Vec<&Path> = read.iter().map(PathBuf::as_path).collect();
    Ok(check_target(output, &inputs, may_replace)?)
}

/// Notes files that this call reads, with those that belong to them: files of a bag, facts of a wide CSV.
pub(crate) fn reads<P: AsRef<Path>>(inputs: &[P]) {
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    read.extend(inputs.iter().map(|input| facts_path(input.as_ref())));
    read.extend(with_files(inputs));
}

/// Notes an evaluation that this call reads, with the rows and facts of its run beside it.
pub(crate) fn reads_part(part: &Part) {
    let beside = ["rows.parquet", "rows.held_out.parquet", "run.json"];
    reads(&beside.map(|name| part.path.with_file_name(name)));
    reads(&[&part.path]);
}

/// Inputs with the files of those that are bag folders.
pub(crate) fn with_files<P: AsRef<Path>>(inputs: &[P]) -> Vec<PathBuf> {
    let folders = inputs.iter().map(AsRef::as_ref).filter(|i| i.is_dir());
    // A folder that is no bag is reported where it is read.
    let files = folders.filter_map(|folder| Some((folder, take_files(folder).ok()?)));
    let files =
        files.flat_map(|(folder, files)| std::iter::once(folder.join(BAG_FACTS)).chain(files));
    (inputs.iter().map(|input| input.as_ref().to_owned()))
        .chain(files)
        .collect()
}
