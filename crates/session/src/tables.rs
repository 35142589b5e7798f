//! Takes as tables for other tools.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use inhand_channels::{EvaluatedSample, ReadMethod};
pub use inhand_export::TableLayout;
use inhand_export::bids::{self, BidsNames};
use inhand_export::{
    Entity, FingerColumn, FingerRow, MOTION_COLUMNS, RowPositions, Table, contact_rows,
    evaluation_rows, facts_json, finger_table, motion_entities, motion_rows, phase_rows,
    recording_entities, rows_facts, segment_rows, tidy, wide, write_csv, write_parquet,
};
use inhand_model::{Clock, MotionRows, PerFinger, Protocol, StartTime};

use crate::error::{Located, SessionError};
pub use crate::files::facts_path;
use crate::output::{write_atomic, write_text};
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
            if methods.is_empty() {
                let none = "no /generated channels: `inhand generate` writes them";
                return Err(take.error(none.to_owned()));
            }
            let starts = starts(&methods, what == TablePart::of(take));
            let rate_hz = clock.rate_hz();
            let rows = methods.iter().flat_map(|method| {
                motion_rows(
                    &method.name,
                    &method.configurations_m,
                    starts.as_ref(),
                    rate_hz,
                )
            });
            write(finger_table(rows.collect(), MOTION_COLUMNS, clock, layout))?;
        }
        TablePart::Errors => {
            let columns = [("error_m", "m", "")];
            write_evaluated(take, columns, layout, write, |sample| {
                Some(sample.error_m?.each_ref().map(|error_m| [*error_m]))
            })?;
        }
        TablePart::Contacts => {
            let columns = [("distance_m", "m", ""), ("in_contact", "1", "")];
            write_evaluated(take, columns, layout, write, |sample| {
                let contact = sample.contact?;
                Some(PerFinger::from_fn(|finger| {
                    let in_contact = f64::from(u8::from(contact.in_contact[finger]));
                    [contact.distance_m[finger], in_contact]
                }))
            })?;
        }
        _ => {
            let entities = entities(take, what)?;
            write(match layout {
                TableLayout::Wide => wide(&entities, clock, samples),
                TableLayout::Tidy => tidy(&entities, clock, samples),
            })?;
        }
    }
    if has_facts(what, layout, form) {
        write_text(&facts_path(path), &facts_json(recording))?;
    }
    Ok(())
}

/// Samples at which trajectories start: those of plans, which baselines share. The motion of a plan is one trajectory.
fn starts(methods: &[ReadMethod], is_plan: bool) -> Option<BTreeSet<usize>> {
    let plans = methods.iter().flat_map(|method| method.plans.keys());
    let starts: BTreeSet<usize> = plans.copied().collect();
    match is_plan {
        true => Some(starts.into_iter().take(1).collect()),
        false => (!starts.is_empty()).then_some(starts),
    }
}

/// Writes numbers of the fingers at every instant at which there are any.
fn write_evaluated<const N: usize>(
    take: &Take,
    columns: [FingerColumn; N],
    layout: TableLayout,
    write: impl FnOnce(Table<'_>) -> Result<(), SessionError>,
    numbers: impl Fn(&EvaluatedSample) -> Option<PerFinger<[f64; N]>>,
) -> Result<(), SessionError> {
    let methods = stored::read_evaluated_methods(take)?;
    let rows = methods.iter().flat_map(|method| {
        let row = |sample: &EvaluatedSample| {
            Some(FingerRow {
                method: &method.name,
                sample: sample.sample,
                numbers: numbers(sample)?,
            })
        };
        method.samples.iter().filter_map(row).collect::<Vec<_>>()
    });
    let rows: Vec<_> = rows.collect();
    if rows.is_empty() {
        let (heading, ..) = columns[0];
        return Err(take.error(format!(
            "no {heading} of fingertips is stored in it: `inhand run` writes it, distances to an object with its shape"
        )));
    }
    write(finger_table(rows, columns, take.recording.clock, layout))
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
    let whole = (planned.trajectory.as_ref())
        .ok_or_else(|| SessionError::usage(path, "the plan has no motion to write"))?;
    let layout = whole.layout();
    let configurations_m = (0..layout.samples).map(|k| (k, whole.configuration_m(k)));
    let (configurations_m, starts) = (configurations_m.collect(), BTreeSet::new());
    let rate_hz = layout.rate_hz;
    let name = planned.method.name();
    let rows = motion_rows(name, &configurations_m, Some(&starts), rate_hz);
    let clock = Clock::new(0, StartTime::Unknown, rate_hz).in_file(path)?;
    let table = finger_table(rows.collect(), MOTION_COLUMNS, clock, TableLayout::Wide);
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
    session: &str,
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
    let table = evaluation_rows(session, rows, positions);
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
