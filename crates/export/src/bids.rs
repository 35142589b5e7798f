//! A take as files of a BIDS dataset (Motion-BIDS, BIDS 1.10: `sub-*/[ses-*/]motion/`).
//!
//! Coordinates are metres in the frame `world`, rotations unit quaternions (world from body); a
//! missing value is `n/a`. A channel of type `MISC` marks the filled samples of each entity that has
//! any.

use std::io::Write;
use std::path::{Path, PathBuf};

use inhand_model::{Annotations, Event, Recording, Status};
use serde_json::json;

use crate::error::ExportError;
use crate::events::{self, seconds_after};
use crate::table::{TableBuilder, write_tsv};
use crate::take::{Entity, recording_entities, unique_names};

/// Version of BIDS that the files follow.
const BIDS_VERSION: &str = "1.10.0";

/// A value that is not there.
const MISSING: &str = "n/a";

/// BIDS's names of the components of a channel, in the order of an entity's.
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
    /// [`ExportError::Content`].
    pub fn check(&self) -> Result<(), ExportError> {
        for (_, name, label) in self.labels() {
            let Some(label) = label else { continue };
            if label.is_empty() || !label.chars().all(|c| c.is_ascii_alphanumeric()) {
                let expected = "letters and digits alone, as BIDS wants them in file names";
                let message = format!("{name} is \"{label}\": expected {expected}");
                return Err(ExportError::Content(message));
            }
        }
        Ok(())
    }

    /// Key, name for people and label of each.
    fn labels(&self) -> [(&'static str, &'static str, Option<&String>); 4] {
        [
            ("sub", "the subject", Some(&self.subject)),
            ("ses", "the session", self.session.as_ref()),
            ("task", "the task", Some(&self.task)),
            (
                "tracksys",
                "the tracking system",
                Some(&self.tracking_system),
            ),
        ]
    }

    /// The first labels as parts of a name, such as `sub-01`.
    fn parts(&self, count: usize) -> Vec<String> {
        let labels = self.labels().into_iter().take(count);
        labels
            .filter_map(|(key, _, label)| Some(format!("{key}-{}", label?)))
            .collect()
    }

    /// A file of the take, relative to the dataset; events belong to the task, not to a tracking system.
    fn file(&self, tracking_system: bool, suffix: &str) -> PathBuf {
        let mut name = self.parts(if tracking_system { 4 } else { 3 });
        name.extend(self.run.map(|run| format!("run-{run:02}")));
        name.push(suffix.to_owned());
        let folder: PathBuf = self.parts(2).into_iter().collect();
        folder.join("motion").join(name.join("_"))
    }
}

/// Writes the content of a file.
type Content<'a> = Box<dyn Fn(&mut dyn Write) -> Result<(), ExportError> + 'a>;

/// A file of a dataset.
pub struct BidsFile<'a> {
    /// Its place, relative to the dataset.
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
    /// [`ExportError::Write`].
    pub fn write(&self, out: &mut dyn Write) -> Result<(), ExportError> {
        (self.content)(out)
    }
}

/// The files of a take: motion with its channels, events, and what a dataset needs around them.
///
/// # Errors
///
/// [`ExportError::Content`].
pub fn files<'a>(
    recording: &'a Recording,
    annotations: &'a Annotations,
    names: &BidsNames,
) -> Result<Vec<BidsFile<'a>>, ExportError> {
    names.check()?;
    let file = |tracking_system, suffix| names.file(tracking_system, suffix);
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

/// File of the events of a take, relative to the dataset.
pub fn events_path(names: &BidsNames) -> PathBuf {
    names.file(false, "events.tsv")
}

/// Entities of a take with their names and whether any of their samples is filled.
fn entities(recording: &Recording) -> Vec<(Entity<'_>, String, bool)> {
    let entities = recording_entities(recording);
    let names = unique_names(&entities);
    (entities.into_iter().zip(names))
        .map(|(entity, name)| {
            let filled = (0..recording.len()).any(|k| (entity.status)(k) == Status::Filled);
            (entity, name, filled)
        })
        .collect()
}

fn write_motion(recording: &Recording, out: &mut dyn Write) -> Result<(), ExportError> {
    let entities = entities(recording);
    let mut table = TableBuilder::new(recording.len(), |sample| sample);
    for (entity, name, filled) in &entities {
        for component in 0..entity.components {
            table.numbers(name, "", move |k| entity.number(k, component));
        }
        if *filled {
            table.counts(name, |k| ((entity.status)(k) == Status::Filled).into());
        }
    }
    write_tsv(&table.finish(), false, out)
}

fn write_channels(recording: &Recording, out: &mut dyn Write) -> Result<(), ExportError> {
    let mut channels = Vec::new();
    for (entity, name, filled) in entities(recording) {
        for (component, letter) in COMPONENTS[..entity.components].iter().enumerate() {
            let (kind, unit) = [("ORNT", ""), ("POS", "m")][usize::from(component < 3)];
            let channel = format!("{name}_{letter}");
            let cells = [&*channel, letter, kind, &*name, unit, entity.frame];
            channels.push(cells.map(str::to_owned));
        }
        if filled {
            let channel = format!("{name}_filled");
            channels.push([&*channel, "", "MISC", &*name, "", ""].map(str::to_owned));
        }
    }
    let mut table = TableBuilder::new(channels.len(), |row| &channels[row]);
    let titles = "name component type tracked_point units reference_frame";
    for (place, title) in titles.split(' ').enumerate() {
        table.words(title, move |channel| &channel[place]);
    }
    write_tsv(&table.finish(), true, out)
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
    let filled = entities.iter().filter(|(.., filled)| *filled).count();
    let components: usize = entities.iter().map(|(e, ..)| e.components).sum();
    let positions = 3 * entities.len();
    let rotations = components - positions;
    let rate_hz = recording.clock.rate_hz();
    json!({
        "TaskName": names.task,
        "SamplingFrequency": rate_hz,
        "SamplingFrequencyEffective": rate_hz,
        "TrackingSystemName": names.tracking_system,
        "RecordingDuration": recording.clock.time_s(recording.len()),
        "TrackedPointsCount": entities.len(),
        "MotionChannelCount": components + filled,
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
) -> Result<(), ExportError> {
    let mut events: Vec<_> = annotations.events.iter().collect();
    // BIDS wants events in the order of their onset.
    events.sort_by_key(|event| event.start_unix_nanos);
    let times = |event: &Event| {
        let start = event.start_unix_nanos;
        [
            seconds_after(start, start_unix_nanos),
            seconds_after(event.end_unix_nanos, start),
        ]
    };
    let table = events::table(annotations, events, ["onset", "duration"], times);
    write_tsv(&table, true, out)
}
