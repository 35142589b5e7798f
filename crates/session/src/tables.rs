//! Takes as tables for other tools.

use std::path::{Path, PathBuf};

use inhand_export::bids::{self, BidsNames};
use inhand_export::{
    Entity, Table, contact_rows, evaluation_rows, facts_json, motion_entities, phase_rows,
    recording_entities, rows_facts, segment_rows, tidy, wide, write_csv, write_parquet,
};
use inhand_model::{EvaluationRows, MotionRows};

use crate::error::{Located, SessionError};
pub use crate::files::facts_path;
use crate::output::{write_atomic, write_text};
use crate::take::Take;

/// Part of a take that a table holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TablePart {
    /// Markers and bodies in `world`, after cleaning where the take was cleaned.
    Recorded,
    /// Markers and bodies in `world` as measured.
    Measured,
    /// Fingertips and object in the frame `hand`, as `process` stored them.
    Processed,
}

/// Layout of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableLayout {
    /// A row for each sample, columns for each entity.
    Wide,
    /// A row for each sample of each entity.
    Tidy,
}

/// The kind of file that a table becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Text.
    Csv,
    /// Parquet.
    Parquet,
}

impl TableFormat {
    /// The form that a file's extension names.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "csv" => Some(TableFormat::Csv),
            "parquet" => Some(TableFormat::Parquet),
            _ => None,
        }
    }
}

/// Whether a table has facts beside it: those of a wide CSV are needed to read it as a take again.
pub const fn has_facts(what: TablePart, layout: TableLayout, form: TableFormat) -> bool {
    matches!(
        (what, layout, form),
        (
            TablePart::Recorded | TablePart::Measured,
            TableLayout::Wide,
            TableFormat::Csv
        )
    )
}

/// Writes a take as a table, with its facts beside it where [`has_facts`] says so.
///
/// # Errors
///
/// [`SessionError::Data`] where the take does not store that part,
/// [`SessionError::At`], [`SessionError::Io`].
pub fn write_table(
    path: &Path,
    take: &Take,
    what: TablePart,
    layout: TableLayout,
    form: TableFormat,
) -> Result<(), SessionError> {
    let entities = entities(take, what)?;
    let recording = match what {
        TablePart::Measured => take.measured(),
        TablePart::Recorded | TablePart::Processed => &take.recording,
    };
    let (clock, samples) = (recording.clock, recording.len());
    let table = match layout {
        TableLayout::Wide => wide(&entities, clock, samples),
        TableLayout::Tidy => tidy(&entities, clock, samples),
    };
    let about = [("inhand.recording", facts_json(recording))];
    write_file(path, form, &table, table.rows, &about)?;
    if has_facts(what, layout, form) {
        write_text(&facts_path(path), &facts_json(recording))?;
    }
    Ok(())
}

/// Writes every evaluated instant as a table, in the form that the extension names; Parquet
/// where it names none.
///
/// # Errors
///
/// [`SessionError::At`], [`SessionError::Io`].
pub fn write_rows(path: &Path, session: &str, rows: &EvaluationRows) -> Result<(), SessionError> {
    let table = evaluation_rows(session, rows);
    let form = TableFormat::from_path(path).unwrap_or(TableFormat::Parquet);
    let about = [rows_facts(session, rows)];
    write_file(path, form, &table, rows.instants(), &about)
}

fn write_file(
    path: &Path,
    form: TableFormat,
    table: &Table<'_>,
    part_rows: usize,
    about: &[(&str, String)],
) -> Result<(), SessionError> {
    write_atomic(path, |out| {
        match form {
            TableFormat::Csv => write_csv(table, out),
            TableFormat::Parquet => write_parquet(table, part_rows, about, out),
        }
        .in_file(path)
    })
}

/// Files of the tables behind the motion and contacts of an evaluation.
#[derive(Clone, Debug)]
pub struct MotionFiles {
    /// Measures of each segment.
    pub segments: PathBuf,
    /// Contacts of fingers.
    pub contacts: PathBuf,
    /// Contact states, phases, gait steps.
    pub phases: PathBuf,
}

impl MotionFiles {
    /// `segments.parquet`, `contacts.parquet` and `phases.parquet` in a folder.
    pub fn in_folder(folder: &Path) -> Self {
        Self {
            segments: folder.join("segments.parquet"),
            contacts: folder.join("contacts.parquet"),
            phases: folder.join("phases.parquet"),
        }
    }

    /// All of them.
    pub fn all(&self) -> [&PathBuf; 3] {
        [&self.segments, &self.contacts, &self.phases]
    }
}

/// Writes the segments, contacts and phases behind an evaluation as tables, each in the form that its extension
/// names; Parquet where it names none. Without an object those of contacts and phases have no rows.
///
/// # Errors
///
/// [`SessionError::At`], [`SessionError::Io`].
pub fn write_motion_rows(
    files: &MotionFiles,
    session: &str,
    rows: &MotionRows,
) -> Result<(), SessionError> {
    for (path, table) in [
        (&files.segments, segment_rows(session, rows)),
        (&files.contacts, contact_rows(session, rows)),
        (&files.phases, phase_rows(session, rows)),
    ] {
        let form = TableFormat::from_path(path).unwrap_or(TableFormat::Parquet);
        write_file(path, form, &table, table.rows, &[])?;
    }
    Ok(())
}

fn entities(take: &Take, what: TablePart) -> Result<Vec<Entity<'_>>, SessionError> {
    match what {
        TablePart::Recorded => Ok(recording_entities(&take.recording)),
        TablePart::Measured => Ok(recording_entities(take.measured())),
        TablePart::Processed => match &take.stored_motion {
            Some(motion) => Ok(motion_entities(motion)),
            None => Err(take.error(
                "no processed motion is stored in it: `inhand process` writes it".to_owned(),
            )),
        },
    }
}

/// The files that [`write_bids`] writes of a take, in the dataset `folder`; those of the dataset as a
/// whole only where they are not there yet.
///
/// # Errors
///
/// [`SessionError::At`] for names that BIDS does not take.
pub fn bids_paths(
    folder: &Path,
    take: &Take,
    names: &BidsNames,
) -> Result<Vec<PathBuf>, SessionError> {
    let files = bids::files(&take.recording, &take.annotations, names);
    let files = files.in_file(folder)?;
    let paths = files.iter().map(|file| (file, folder.join(&file.path)));
    let new = paths.filter(|(file, path)| !(file.of_dataset && path.exists()));
    Ok(new.map(|(_, path)| path).collect())
}

/// Writes a take into a BIDS dataset.
///
/// # Errors
///
/// [`SessionError::At`], [`SessionError::Io`].
pub fn write_bids(folder: &Path, take: &Take, names: &BidsNames) -> Result<(), SessionError> {
    let new = bids_paths(folder, take, names)?;
    // Events of another take of these names must not stay beside this one.
    let events = folder.join(bids::events_path(names));
    if take.annotations.events.is_empty() && events.exists() {
        std::fs::remove_file(&events).map_err(SessionError::io("remove", &events))?;
    }
    let files = bids::files(&take.recording, &take.annotations, names);
    for file in files.in_file(folder)? {
        let path = folder.join(&file.path);
        if new.contains(&path) {
            write_atomic(&path, |out| file.write(out).in_file(&path))?;
        }
    }
    Ok(())
}
