//! A take as files of a BIDS dataset (Motion-BIDS, BIDS 1.10: `sub-*/[ses-*/]motion/`).
//!
//! Coordinates are metres in the frame `world`, rotations unit quaternions (world from body); a
//! missing value is `n/a`. Which samples are filled says a channel of type `MISC` for each entity
//! that has any.

use std::io::Write;
use std::path::{Path, PathBuf};

use inhand_model::{Annotations, Recording, Status};
use serde_json::json;

use crate::entity::{Entity, recording_entities};
use crate::error::TableError;
use crate::events::seconds;
use crate::table::unique_names;

/// Version of BIDS that the files follow.
const BIDS_VERSION: &str = "1.10.0";

/// What stands in a file for a value that is not there.
const MISSING: &str = "n/a";

/// Components of a channel by BIDS's names, with the letters of our columns' order.
const COMPONENTS: [&str; 7] = ["x", "y", "z", "quat_x", "quat_y", "quat_z", "quat_w"];

/// The labels that make up file names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BidsNames {
    /// Participant, `sub-<label>`.
    pub subject: String,
    /// Session, `ses-<label>`, where there are several.
    pub session: Option<String>,
    /// Task, `task-<label>`.
    pub task: String,
    /// Tracking system, `tracksys-<label>`.
    pub tracking_system: String,
    /// Run, `run-<index>`, where a task was recorded more than once.
    pub run: Option<u32>,
}

impl BidsNames {
    /// Checks that every label is of letters and digits alone, as BIDS wants it.
    ///
    /// # Errors
    ///
    /// [`TableError::Name`].
    pub fn check(&self) -> Result<(), TableError> {
        let labels = [
            ("the subject", Some(&self.subject)),
            ("the session", self.session.as_ref()),
            ("the task", Some(&self.task)),
            ("the tracking system", Some(&self.tracking_system)),
        ];
        for (what, label) in labels {
            let Some(label) = label else { continue };
            if label.is_empty() || !label.chars().all(|c| c.is_ascii_alphanumeric()) {
                return Err(TableError::Name {
                    what,
                    found: label.clone(),
                    expected: "letters and digits alone, as BIDS wants them in file names",
                });
            }
        }
        Ok(())
    }

    /// Folder of the take's files, relative to the dataset.
    fn folder(&self) -> PathBuf {
        let mut folder = PathBuf::from(format!("sub-{}", self.subject));
        if let Some(session) = &self.session {
            folder.push(format!("ses-{session}"));
        }
        folder.join("motion")
    }

    /// What file names begin with; events belong to the task, not to a tracking system.
    fn prefix(&self, tracking_system: bool) -> String {
        let mut prefix = format!("sub-{}", self.subject);
        if let Some(session) = &self.session {
            prefix += &format!("_ses-{session}");
        }
        prefix += &format!("_task-{}", self.task);
        if tracking_system {
            prefix += &format!("_tracksys-{}", self.tracking_system);
        }
        if let Some(run) = self.run {
            prefix += &format!("_run-{run:02}");
        }
        prefix
    }
}

/// Writes what a file holds.
type Content<'a> = Box<dyn Fn(&mut dyn Write) -> Result<(), TableError> + 'a>;

/// A file of a dataset.
pub struct BidsFile<'a> {
    /// Where it belongs, relative to the dataset.
    pub path: PathBuf,
    /// Whether it is of the dataset as a whole, and stays as it is where there is one.
    pub of_dataset: bool,
    content: Content<'a>,
}

impl std::fmt::Debug for BidsFile<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "BidsFile({})", self.path.display())
    }
}

impl<'a> BidsFile<'a> {
    fn new(path: PathBuf, content: Content<'a>) -> Self {
        Self {
            path,
            of_dataset: false,
            content,
        }
    }

    fn json(path: PathBuf, value: serde_json::Value) -> Self {
        Self::new(path, Box::new(move |out| Ok(writeln!(out, "{value:#}")?)))
    }

    /// Writes the file's content.
    ///
    /// # Errors
    ///
    /// [`TableError::Write`].
    pub fn write(&self, out: &mut dyn Write) -> Result<(), TableError> {
        (self.content)(out)
    }
}

/// The files of a take: motion with its channels, events, and what a dataset needs around them.
///
/// # Errors
///
/// [`TableError::Name`].
pub fn files<'a>(
    recording: &'a Recording,
    annotations: &'a Annotations,
    names: &BidsNames,
) -> Result<Vec<BidsFile<'a>>, TableError> {
    names.check()?;
    let folder = names.folder();
    let file = |tracking_system, suffix: &str| {
        folder.join(format!("{}_{suffix}", names.prefix(tracking_system)))
    };
    let mut files = vec![
        BidsFile {
            of_dataset: true,
            ..BidsFile::json(
                Path::new("dataset_description.json").to_owned(),
                json!({
                    "Name": "in-hand manipulation",
                    "BIDSVersion": BIDS_VERSION,
                    "DatasetType": "raw",
                    "GeneratedBy": [{"Name": "inhand", "Version": env!("CARGO_PKG_VERSION")}],
                }),
            )
        },
        BidsFile::new(
            file(true, "motion.tsv"),
            Box::new(|out| write_motion(recording, out)),
        ),
        BidsFile::new(
            file(true, "channels.tsv"),
            Box::new(|out| write_channels(recording, out)),
        ),
        BidsFile::json(file(true, "channels.json"), frames_json(recording)),
        BidsFile::json(file(true, "motion.json"), motion_json(recording, names)),
    ];
    if !annotations.events.is_empty() {
        let start = recording.clock.start_unix_nanos();
        files.push(BidsFile::new(
            file(false, "events.tsv"),
            Box::new(move |out| write_events(annotations, start, out)),
        ));
    }
    Ok(files)
}

/// Where the events of a take belong, relative to the dataset.
pub fn events_path(names: &BidsNames) -> PathBuf {
    names
        .folder()
        .join(format!("{}_events.tsv", names.prefix(false)))
}

/// Entities of a take with their names and whether any of their samples is filled.
fn entities(recording: &Recording) -> Vec<(Entity<'_>, String, bool)> {
    let entities = recording_entities(recording);
    let names = unique_names(&entities);
    (entities.into_iter().zip(names))
        .map(|(entity, name)| {
            let filled = (0..recording.len()).any(|k| entity.track.status(k) == Status::Filled);
            (entity, name, filled)
        })
        .collect()
}

fn write_motion(recording: &Recording, out: &mut dyn Write) -> Result<(), TableError> {
    let entities = entities(recording);
    let mut line = String::new();
    for k in 0..recording.len() {
        line.clear();
        for (entity, _, filled) in &entities {
            let value = entity.track.value(k);
            let components = if entity.has_rotation { 7 } else { 3 };
            for component in 0..components {
                let number = value.and_then(|(position, rotation)| match component {
                    0..3 => Some(position[component]),
                    _ => rotation.map(|quaternion| quaternion[component - 3]),
                });
                push_cell(
                    &mut line,
                    number.map(|number| number.to_string()).as_deref(),
                );
            }
            if *filled {
                let is_filled = entity.track.status(k) == Status::Filled;
                push_cell(&mut line, Some(if is_filled { "1" } else { "0" }));
            }
        }
        line.push('\n');
        out.write_all(line.as_bytes())?;
    }
    Ok(())
}

fn push_cell(line: &mut String, cell: Option<&str>) {
    if !line.is_empty() {
        line.push('\t');
    }
    line.push_str(cell.unwrap_or(MISSING));
}

fn write_channels(recording: &Recording, out: &mut dyn Write) -> Result<(), TableError> {
    writeln!(
        out,
        "name\tcomponent\ttype\ttracked_point\tunits\treference_frame"
    )?;
    for (entity, name, filled) in entities(recording) {
        let name = one_line(&name);
        for (component, letter) in COMPONENTS.iter().enumerate() {
            let (kind, unit) = match component {
                0..3 => ("POS", "m"),
                _ if entity.has_rotation => ("ORNT", MISSING),
                _ => continue,
            };
            writeln!(
                out,
                "{name}_{letter}\t{letter}\t{kind}\t{name}\t{unit}\t{}",
                entity.frame
            )?;
        }
        if filled {
            writeln!(
                out,
                "{name}_filled\t{MISSING}\tMISC\t{name}\t{MISSING}\t{MISSING}"
            )?;
        }
    }
    Ok(())
}

/// A name without what would break a line or a cell.
fn one_line(text: &str) -> String {
    text.replace(['\t', '\n', '\r'], " ")
}

fn frames_json(recording: &Recording) -> serde_json::Value {
    json!({
        "reference_frame": {
            "Levels": {
                "world": {
                    // Which way a person faces in the room is not known, only which way is up.
                    "SpatialAxes": MISSING,
                    "RotationRule": "right-hand",
                    "RotationOrder": MISSING,
                    "Description": format!(
                        "the axes of the capture system; {} points up",
                        recording.source.up_axis.name()
                    ),
                }
            }
        }
    })
}

fn motion_json(recording: &Recording, names: &BidsNames) -> serde_json::Value {
    let entities = entities(recording);
    let with_rotation = entities
        .iter()
        .filter(|(entity, ..)| entity.has_rotation)
        .count();
    let filled = entities.iter().filter(|(.., filled)| *filled).count();
    let (positions, rotations) = (3 * entities.len(), 4 * with_rotation);
    let rate_hz = recording.clock.rate_hz();
    json!({
        "TaskName": names.task,
        "SamplingFrequency": rate_hz,
        "SamplingFrequencyEffective": rate_hz,
        "TrackingSystemName": names.tracking_system,
        "RecordingDuration": recording.clock.time_s(recording.len()),
        "TrackedPointsCount": entities.len(),
        "MotionChannelCount": positions + rotations + filled,
        "POSChannelCount": positions,
        "ORNTChannelCount": rotations,
        "MISCChannelCount": filled,
        "MissingValues": MISSING,
        "SoftwareVersions": recording.source.format,
    })
}

fn write_events(
    annotations: &Annotations,
    start_unix_nanos: u64,
    out: &mut dyn Write,
) -> Result<(), TableError> {
    let keys = annotations.all_keys();
    let headings = ["onset", "duration"]
        .into_iter()
        .chain(keys.iter().copied());
    let headings: Vec<String> = headings.map(one_line).collect();
    writeln!(out, "{}", headings.join("\t"))?;
    let mut events: Vec<_> = annotations.events.iter().collect();
    // BIDS wants events in the order of their onset.
    events.sort_by_key(|event| event.start_unix_nanos);
    for event in events {
        let (start, end) = (event.start_unix_nanos, event.end_unix_nanos);
        let mut line = seconds(i128::from(start) - i128::from(start_unix_nanos));
        push_cell(&mut line, Some(&seconds(i128::from(end - start))));
        for key in &keys {
            push_cell(
                &mut line,
                event
                    .labels
                    .get(*key)
                    .map(|value| one_line(value))
                    .as_deref(),
            );
        }
        writeln!(out, "{line}")?;
    }
    Ok(())
}
