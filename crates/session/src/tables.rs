//! Takes as tables for other tools.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use inhand_channels::{EvaluatedMethod, EvaluatedSample};
pub use inhand_export::TableLayout;
use inhand_export::bids::{self, BidsNames};
use inhand_export::{
    CONTACT_COLUMNS, ERROR_COLUMNS, Entity, FingerRow, RESULTS_KEY, RowPositions, Table,
    contact_rows, evaluation_rows, facts_json, finger_table, motion_entities, motion_table,
    phase_rows, recording_entities, rows_facts, segment_rows, tidy, trajectory_table, wide,
    write_csv, write_parquet,
};
use inhand_model::{Evaluation, MotionRows, PerFinger, Protocol};

use crate::error::{Located, SessionError};
pub use crate::files::facts_path;
use crate::output::{is_stream, write_atomic, write_text};
use crate::plan::Planned;
use crate::steps::ProtocolRows;
use crate::stored;
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
    /// Positions and velocities of fingertips that methods generated, in the frame `hand`.
    Generated,
    /// Distances of generated from recorded fingertips.
    Errors,
    /// Distances of fingertips to the object, and whether they touch it, as recorded and by method.
    Contacts,
}

impl TablePart {
    /// The part that a table holds where none is named: what was recorded, else what was generated.
    pub fn of(take: &Take) -> Self {
        let recording = &take.recording;
        match recording.markers.is_empty() && recording.bodies.is_empty() {
            true => TablePart::Generated,
            false => TablePart::Recorded,
        }
    }
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

/// Whether a table has facts beside it: those of a wide CSV are needed to read it as a take again. Beside a device or a
/// FIFO there is no place for them.
pub fn has_facts(path: &Path, what: TablePart, layout: TableLayout, form: TableFormat) -> bool {
    matches!(what, TablePart::Recorded | TablePart::Measured)
        && (layout, form) == (TableLayout::Wide, TableFormat::Csv)
        && !is_stream(path)
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
    let recording = match what {
        TablePart::Measured => take.measured(),
        _ => &take.recording,
    };
    let (clock, samples) = (recording.clock, recording.len());
    let about = [("inhand.recording", facts_json(recording))];
    let write = |table: Table<'_>| write_file(path, form, &table, table.rows, &about);
    match what {
        TablePart::Generated => {
            let methods = stored::read_methods(take, Protocol::Published)?;
            let methods = some_of(take, methods, "/generated", "generate")?;
            // Plans have starts, which baselines share; a file of a plan holds one trajectory.
            let starts = methods.iter().flat_map(|method| method.plans.keys());
            let is_plan = what == TablePart::of(take);
            let starts: BTreeSet<usize> = (starts.copied())
                .take(if is_plan { 1 } else { usize::MAX })
                .collect();
            let starts = (!starts.is_empty()).then_some(&starts);
            let methods = (methods.iter()).map(|m| (m.name.as_str(), &m.configurations_m));
            write(motion_table(methods, starts, clock, layout))?;
        }
        TablePart::Errors => {
            let methods = stored::read_evaluated_methods(take)?;
            let methods = some_of(take, methods, "/evaluation", "run")?;
            let rows = finger_rows(&methods, |sample| {
                Some(sample.error_m?.map(|error_m| [error_m]))
            });
            write(finger_table(rows, ERROR_COLUMNS, clock, layout))?;
        }
        TablePart::Contacts => {
            let methods = stored::read_evaluated_methods(take)?;
            let methods = some_of(take, methods, "/evaluation", "run")?;
            let rows = finger_rows(&methods, |sample| {
                let contact = sample.contact?;
                Some(PerFinger::from_fn(|finger| {
                    let in_contact = u8::from(contact.in_contact[finger]);
                    [contact.distance_m[finger], in_contact.into()]
                }))
            });
            if rows.is_empty() {
                let none = "no contacts are stored in it: `inhand run` writes them of an object with its shape";
                return Err(take.error(none.to_owned()));
            }
            write(finger_table(rows, CONTACT_COLUMNS, clock, layout))?;
        }
        _ => {
            let entities = entities(take, what)?;
            if entities.is_empty() {
                let none = "nothing was recorded in it: --what generated";
                return Err(take.error(none.to_owned()));
            }
            write(match layout {
                TableLayout::Wide => wide(&entities, clock, samples),
                TableLayout::Tidy => tidy(&entities, clock, samples),
            })?;
        }
    }
    if has_facts(path, what, layout, form) {
        write_text(&facts_path(path), &facts_json(recording))?;
    }
    Ok(())
}

/// Methods that a take stores in channels of a root, if it stores any.
fn some_of<T>(
    take: &Take,
    methods: Vec<T>,
    root: &str,
    writer: &str,
) -> Result<Vec<T>, SessionError> {
    match methods.is_empty() {
        true => Err(take.error(format!("no {root} channels: `inhand {writer}` writes them"))),
        false => Ok(methods),
    }
}

/// Numbers of the fingers at every instant at which there are any.
fn finger_rows<const N: usize>(
    methods: &[EvaluatedMethod],
    numbers: impl Fn(&EvaluatedSample) -> Option<PerFinger<[f64; N]>>,
) -> Vec<FingerRow<'_, N>> {
    let instants =
        (methods.iter()).flat_map(|m| m.samples.iter().map(move |sample| (&*m.name, sample)));
    let row = |(method, sample): (_, &EvaluatedSample)| {
        Some(FingerRow {
            method,
            sample: sample.sample,
            numbers: numbers(sample)?,
        })
    };
    instants.filter_map(row).collect()
}

/// Writes planned motion as a table: times, positions and velocities.
///
/// # Errors
///
/// [`SessionError::Usage`] for a plan without a motion; [`SessionError::At`], [`SessionError::Io`].
pub fn write_plan_table(
    path: &Path,
    planned: &Planned,
    form: TableFormat,
) -> Result<(), SessionError> {
    let whole = planned.motion(path)?;
    let table = trajectory_table(planned.method.name(), whole).in_file(path)?;
    write_file(path, form, &table, table.rows, &[])
}

/// Writes every evaluated instant as a table, in the form that the extension names; Parquet
/// where it names none.
///
/// # Errors
///
/// [`SessionError::At`], [`SessionError::Io`].
pub fn write_rows(
    path: &Path,
    evaluation: &Evaluation,
    compared: ProtocolRows<'_>,
    with_positions: bool,
) -> Result<(), SessionError> {
    let ProtocolRows {
        rows,
        segments,
        generated,
    } = compared;
    let planned: Vec<_> = generated.iter().map(|g| &*g.trajectories).collect();
    let positions = with_positions.then_some(RowPositions {
        segments,
        planned: &planned,
    });
    let session = &evaluation.session.name;
    let table = evaluation_rows(session, rows, positions);
    let form = TableFormat::from_path(path).unwrap_or(TableFormat::Parquet);
    let about = [rows_facts(session, rows), key_fact(evaluation)];
    write_file(path, form, &table, rows.instants(), &about)
}

fn key_fact(evaluation: &Evaluation) -> (&'static str, String) {
    (RESULTS_KEY, evaluation.key.clone().unwrap_or_default())
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
    evaluation: &Evaluation,
    rows: &MotionRows,
) -> Result<(), SessionError> {
    let session = &evaluation.session.name;
    for (path, table) in [
        (&files.segments, segment_rows(session, rows)),
        (&files.contacts, contact_rows(session, rows)),
        (&files.phases, phase_rows(session, rows)),
    ] {
        let form = TableFormat::from_path(path).unwrap_or(TableFormat::Parquet);
        write_file(path, form, &table, table.rows, &[key_fact(evaluation)])?;
    }
    Ok(())
}

fn entities(take: &Take, what: TablePart) -> Result<Vec<Entity<'_>>, SessionError> {
    match what {
        TablePart::Measured => Ok(recording_entities(take.measured())),
        TablePart::Processed => match &take.stored_motion {
            Some(motion) => Ok(motion_entities(motion)),
            None => Err(take.error(
                "no processed motion is stored in it: `inhand process` writes it".to_owned(),
            )),
        },
        _ => Ok(recording_entities(&take.recording)),
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
