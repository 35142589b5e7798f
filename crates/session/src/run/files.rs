//! Paths of the results, and whether they may be written.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::{FIGURES, RunOptions};
use crate::error::SessionError;
use crate::manifest;
use crate::output;
use crate::scope::OutputScope;
use crate::session::{SETTINGS_FILE, Session, SessionTake};
use crate::settings::Role;
use crate::tables::MotionFiles;

/// Where a run's results are.
#[derive(Clone, Debug)]
pub struct RunFiles {
    /// A recording for each take that is written, in the session's order.
    pub takes: Vec<PathBuf>,
    /// The dictionary.
    pub dictionary: PathBuf,
    /// The evaluation.
    pub evaluation: PathBuf,
    /// Every instant behind the evaluation, as a table.
    pub rows: PathBuf,
    /// The same of the held-out protocol.
    pub held_out_rows: PathBuf,
    /// Every segment, contact and phase behind it, as tables.
    pub motion: MotionFiles,
    /// The report.
    pub report: PathBuf,
    /// Folder of the report's figures and the numbers behind them.
    pub figures: PathBuf,
    /// Times, memory, threads.
    pub run: PathBuf,
    /// What an earlier run of the same inputs, settings and version left unchanged.
    pub(super) kept: BTreeSet<PathBuf>,
}

impl RunFiles {
    pub(super) fn new(folder: &Path, session: &Session, scope: OutputScope) -> Self {
        let takes = (session.takes.iter())
            .filter(|take| scope.train_takes || take.role == Role::Test)
            .map(|take| folder.join(format!("{}.mcap", take.name)));
        Self {
            takes: takes.collect(),
            dictionary: folder.join("dictionary.mcap"),
            evaluation: folder.join("evaluation.json"),
            rows: folder.join("rows.parquet"),
            held_out_rows: folder.join("rows.held_out.parquet"),
            motion: MotionFiles::in_folder(folder),
            report: folder.join("report.html"),
            figures: folder.join(FIGURES),
            run: folder.join(manifest::RUN_FILE),
            kept: BTreeSet::new(),
        }
    }

    /// Whether a file need not be written.
    pub(super) fn is_kept(&self, path: &Path) -> bool {
        self.kept.contains(path)
    }

    /// The files that depend on inputs and settings alone, but for the figures, whose number depends on what
    /// there is to see.
    pub(super) fn reproducible(&self) -> Vec<&Path> {
        let rest = [
            &self.dictionary,
            &self.evaluation,
            &self.rows,
            &self.held_out_rows,
            &self.report,
        ];
        self.takes
            .iter()
            .chain(rest)
            .chain(self.motion.all())
            .map(PathBuf::as_path)
            .collect()
    }
}

/// Refuses a folder whose files are neither results of this session nor free to be replaced.
///
/// # Errors
///
/// [`SessionError::Usage`].
pub(super) fn check_output(
    options: &RunOptions,
    session: &Session,
    files: &RunFiles,
) -> Result<(), SessionError> {
    let settings = options.folder.join(SETTINGS_FILE);
    let takes = session.takes.iter().map(|take| take.path.as_path());
    let inputs: Vec<_> = takes.chain([&*settings]).collect();
    // Results of an earlier run are ours to replace; anything else only by force.
    let ours = options.force || manifest::is_run_of(&files.run, &session.name);
    for folder in [&options.output, &files.figures] {
        refuse_take_folder(folder, session)?;
    }
    if !ours && has_files(&files.figures) {
        return Err(output::already_exists(&files.figures));
    }
    let mut targets = files.reproducible();
    targets.push(&files.run);
    targets
        .into_iter()
        .try_for_each(|path| output::check_target(path, &inputs, || ours))
}

fn has_files(folder: &Path) -> bool {
    std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some())
}

/// Results among the takes would be takes of the next run.
fn refuse_take_folder(folder: &Path, session: &Session) -> Result<(), SessionError> {
    let output = folder.canonicalize().ok();
    let holds_takes = |take: &SessionTake| {
        let folder = take
            .path
            .parent()
            .and_then(|folder| folder.canonicalize().ok());
        output.is_some() && folder == output
    };
    match session.takes.iter().find(|take| holds_takes(take)) {
        None => Ok(()),
        Some(take) => Err(SessionError::usage(
            folder,
            format!(
                "the folder holds the take {}: name another one for the results",
                take.path.display()
            ),
        )),
    }
}
