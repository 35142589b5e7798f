//! One evaluation with the rows behind it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use inhand_export::RowsFile;
use inhand_model::{Evaluation, EvaluationRows, Finger, MethodEvaluation, Protocol, Provenance};

use crate::error::{Located, SessionError, in_words};
use crate::files::folder_and_name;

/// Names of the two files of a part.
const EVALUATION_FILE: &str = "evaluation.json";
const ROWS_FILE: &str = "rows.parquet";
/// Name of the rows under the held-out protocol.
const HELD_OUT_ROWS_FILE: &str = "rows.held_out.parquet";

/// More than adding up in another order does to a mean, relative.
const MEAN_ROUNDING: f64 = 1e-9;

/// More than storing rows does to a mean, metres.
const STORED_ROUNDING_M: f64 = 0.5e-9;

/// One evaluation with the rows behind it.
#[derive(Debug)]
pub struct Part {
    /// The evaluation's file, as it was given.
    pub path: PathBuf,
    /// The evaluation.
    pub evaluation: Evaluation,
    /// What made it.
    pub provenance: Vec<Provenance>,
    /// The rows; `None` where there is no file with rows beside it.
    rows: Option<RowsFile>,
    /// Those under the held-out protocol.
    held_out_rows: Option<RowsFile>,
}

impl Part {
    /// Reads an evaluation and opens the rows beside it. `path` is an `evaluation.json`, or a folder with one.
    ///
    /// # Errors
    ///
    /// [`SessionError::Io`], [`SessionError::Data`] for a file that is cut, of another version, or no
    /// evaluation, [`SessionError::At`] for rows that are cut, and [`SessionError::Data`] for rows of
    /// another evaluation.
    pub fn read(path: &Path) -> Result<Self, SessionError> {
        let path = match path.is_dir() {
            true => path.join(EVALUATION_FILE),
            false => path.to_owned(),
        };
        let text = std::fs::read_to_string(&path).map_err(SessionError::io("read", &path))?;
        let (evaluation, provenance) = inhand_report::read_evaluation_json(&text)
            .map_err(|error| SessionError::data(&path, in_words(&error)))?;
        let open = |name: &str| {
            let beside = path.with_file_name(name);
            let rows = beside
                .is_file()
                .then(|| RowsFile::open(&beside).in_file(&beside));
            rows.transpose()
        };
        let part = Self {
            rows: open(ROWS_FILE)?,
            held_out_rows: open(HELD_OUT_ROWS_FILE)?,
            path,
            evaluation,
            provenance,
        };
        part.check_rows(Protocol::Published)?;
        part.check_rows(Protocol::HeldOut)?;
        Ok(part)
    }

    /// The rows of a protocol with the name of their file.
    fn rows_of(&self, protocol: Protocol) -> (Option<&RowsFile>, &'static str) {
        match protocol {
            Protocol::Published => (self.rows.as_ref(), ROWS_FILE),
            Protocol::HeldOut => (self.held_out_rows.as_ref(), HELD_OUT_ROWS_FILE),
        }
    }

    /// Reads several, each [`for_summary`](Self::for_summary).
    ///
    /// # Errors
    ///
    /// As for [`read`](Self::read); the first one.
    pub fn read_all(paths: &[PathBuf]) -> Result<Vec<Self>, SessionError> {
        inhand_parallel::try_map(paths, |path| Ok(Self::read(path)?.for_summary()))
    }

    /// Without what no summary over sessions says, so that many parts fit into memory.
    #[must_use]
    pub fn for_summary(mut self) -> Self {
        self.evaluation.intervals = None;
        if let Some(held_out) = &mut self.evaluation.held_out {
            held_out.intervals = None;
        }
        self.evaluation.movement = None;
        self.evaluation.contacts = None;
        self
    }

    /// Folder and name of the evaluation's file: the same however it was given.
    pub(super) fn file(&self) -> String {
        folder_and_name(&self.path)
    }

    /// Name of the folder of the results.
    pub(super) fn folder(&self) -> Option<String> {
        Some(self.file().split_once('/')?.0.to_owned())
    }

    /// Whether the rows are of this evaluation: of the same key, and as far as names tell.
    fn check_rows(&self, protocol: Protocol) -> Result<(), SessionError> {
        let (Some(rows), file) = self.rows_of(protocol) else {
            return Ok(());
        };
        let beside = &self.path.with_file_name(file);
        if let (Some(own), Some(found)) = (self.evaluation.key.as_deref(), rows.key())
            && own != found
        {
            let [own, found] = [own, found].map(|key| key.get(..12).unwrap_or(key));
            let message = format!(
                "it carries the key {found}, and {} the key {own}: they are of different runs. Keep the files of a run \
                 together, or write both again (`inhand run`, `inhand evaluate --rows`)",
                self.path.display(),
            );
            return Err(SessionError::data(beside, message));
        }
        let methods = self.evaluation.methods(protocol).iter();
        let methods = methods.map(|method| &method.name);
        let (expected, found) = (&self.evaluation.session.name, rows.session());
        if !methods.eq(rows.methods()) || expected != found {
            let message = format!(
                "rows of session \"{found}\" and the methods {}, but {} is of session \"{expected}\" and \
                 the methods {}: they are of different runs, make both again",
                rows.methods().join(", "),
                self.path.display(),
                self.method_names().join(", "),
            );
            return Err(SessionError::data(beside, message));
        }
        Ok(())
    }

    /// What was found of a method under a protocol.
    pub(super) fn method(&self, protocol: Protocol, name: &str) -> Option<&MethodEvaluation> {
        let mut methods = self.evaluation.methods(protocol).iter();
        methods.find(|method| method.name == name)
    }

    /// Names of the methods, in their order.
    pub fn method_names(&self) -> Vec<&str> {
        let methods = self.evaluation.methods.iter();
        methods.map(|method| method.name.as_str()).collect()
    }

    /// The rows of a protocol.
    ///
    /// # Errors
    ///
    /// [`SessionError::Data`] where there are none.
    pub fn rows(&self, protocol: Protocol) -> Result<&RowsFile, SessionError> {
        let (rows, file) = self.rows_of(protocol);
        rows.ok_or_else(|| {
            let message = format!(
                "there is no {file} beside it, and without the rows quantiles over sessions cannot be exact: \
                 keep the two files of a run together, or write it with `inhand evaluate --rows`"
            );
            SessionError::data(&self.path, message)
        })
    }

    /// All rows of a protocol, for figures of single instants, after a check that they are those of the evaluation; `None` where there
    /// are none.
    ///
    /// # Errors
    ///
    /// [`SessionError::At`] for damaged ones, [`SessionError::Data`] for those of another run.
    pub fn read_rows(&self, protocol: Protocol) -> Result<Option<EvaluationRows>, SessionError> {
        let (Some(rows), _) = self.rows_of(protocol) else {
            return Ok(None);
        };
        let rows = rows.read().in_file(&self.path)?;
        for method in &rows.methods {
            for finger in Finger::ALL {
                let errors = method.error_m.iter().map(|errors| errors[finger]);
                let known: Vec<f64> = errors.filter(|error| error.is_finite()).collect();
                self.check_errors(protocol, &method.name, finger, &known)?;
            }
        }
        Ok(Some(rows))
    }

    /// Whether there are rows of a protocol.
    pub fn has_rows(&self, protocol: Protocol) -> bool {
        self.rows_of(protocol).0.is_some()
    }

    /// Errors of a finger under a protocol that were judged, metres, after a check that they are those of the evaluation.
    ///
    /// # Errors
    ///
    /// [`SessionError::Data`] without rows or with those of another run, [`SessionError::At`] for damaged
    /// ones.
    pub fn errors_m(
        &self,
        protocol: Protocol,
        method: &str,
        finger: Finger,
    ) -> Result<Vec<f64>, SessionError> {
        let mut errors = (self.rows(protocol)?.error_m(method, finger)).in_file(&self.path)?;
        errors.retain(|error| error.is_finite());
        self.check_errors(protocol, method, finger, &errors)?;
        Ok(errors)
    }

    /// Whether these are the errors that the evaluation was made from, as far as their number and mean tell.
    fn check_errors(
        &self,
        protocol: Protocol,
        method: &str,
        finger: Finger,
        errors: &[f64],
    ) -> Result<(), SessionError> {
        let stated = self.method(protocol, method);
        let stated = stated.map(|stated| stated.error.by_finger[finger]);
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let same = stated.is_some_and(|stated| {
            let rounding_m = MEAN_ROUNDING * stated.mean.abs() + STORED_ROUNDING_M;
            let off = (mean - stated.mean).abs() > rounding_m;
            stated.n == errors.len() && (errors.is_empty() || !off)
        });
        if same {
            return Ok(());
        }
        let stated = stated.unwrap_or_default();
        let message = format!(
            "the {finger} of {method} has {} errors of {} mm on average, in {} {} of {} mm: they are of \
             different runs, make both again",
            stated.n,
            stated.mean * 1e3,
            self.rows_of(protocol).1,
            errors.len(),
            mean * 1e3,
        );
        Err(SessionError::data(&self.path, message))
    }

    /// Names and hashes of the files that the takes it was judged on came from.
    pub(super) fn test_sources(&self) -> BTreeMap<&str, &str> {
        let first = self.provenance.first().map(|made| &made.step);
        let earliest = self
            .provenance
            .iter()
            .filter(|made| Some(&made.step) == first);
        let tests = &self.evaluation.session.test;
        let is_test = |file: &str| {
            let stem = Path::new(file)
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy();
            tests.iter().any(|take| take.name == stem)
        };
        earliest
            .flat_map(|made| &made.inputs)
            .filter(|input| is_test(&input.name))
            .map(|input| (input.name.as_str(), input.sha256.as_str()))
            .collect()
    }
}
