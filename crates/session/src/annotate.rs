//! Events on the time line of any MCAP file: read, and written into a copy in which everything else
//! stays as it is.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use inhand_channels::Metadata;
use inhand_container::{ChannelFacts, MetadataRecord, Selection};
use inhand_model::{Annotations, Clock, Event, InputHash, Label, Provenance, StartTime};
use serde_json::json;

use crate::containers::{self, sha256};
use crate::error::{Located, SessionError};
use crate::output::write_atomic;
use crate::run::TOOL;
use crate::tables::start_unix_nanos;

/// Topic of the events that inhand writes; those of other topics are never changed.
const TOPIC: &str = "/annotations";

/// The events of a file and when its time line starts.
#[derive(Clone, Debug)]
pub struct Annotated {
    /// Of the take's first sample, else of the first message, nanoseconds since 1970-01-01 UTC.
    pub start_unix_nanos: u64,
    /// What inhand may change.
    pub own: Annotations,
    /// Events on topics of others.
    pub others: Vec<Event>,
    /// What kind of content the file says it has.
    profile: String,
    /// What the file says wrote it.
    library: String,
    metadata: Metadata,
}

impl Annotated {
    /// The stretches of the file that are selected, nanoseconds since 1970, end exclusive. Of a take
    /// they begin and end with samples, those at both ends of an event included.
    pub fn stretches(&self, selection: &inhand_model::Selection) -> Vec<Range<u64>> {
        let events: Vec<Event> = self
            .own
            .events
            .iter()
            .chain(&self.others)
            .cloned()
            .collect();
        let Some((clock, samples)) = self.take() else {
            return selection.intervals(&events);
        };
        (selection.samples(&events, clock, samples).into_iter())
            .map(|range| clock.unix_nanos(range.start)..clock.unix_nanos(range.end))
            .collect()
    }

    /// Whether no part of an event lies in the take that the file holds.
    pub fn is_outside(&self, event: &Event) -> bool {
        self.take().is_some_and(|(clock, samples)| {
            event.end_unix_nanos < clock.start_unix_nanos()
                || event.start_unix_nanos >= clock.unix_nanos(samples)
        })
    }

    /// Clock and samples of the take that the file holds.
    fn take(&self) -> Option<(Clock, usize)> {
        let facts = self.metadata.0.get("inhand.recording")?;
        let rate_hz = facts.get("rate_hz")?.parse().ok()?;
        let clock = Clock::new(self.start_unix_nanos, StartTime::Unknown, rate_hz).ok()?;
        Some((clock, facts.get("samples")?.parse().ok()?))
    }
}

/// Reads the events of a file.
///
/// # Errors
///
/// [`SessionError::Data`] for a file that is no MCAP, [`SessionError::At`] for one that
/// is damaged or holds an event that cannot be read, [`SessionError::Io`].
pub fn read(path: &Path) -> Result<Annotated, SessionError> {
    let bytes = std::fs::read(path).map_err(SessionError::io("read", path))?;
    if !inhand_channels::is_mcap(&bytes) {
        return Err(wrong(
            path,
            "events are kept in MCAP files: `inhand convert` makes one of a take".to_owned(),
        ));
    }
    let name = path.display().to_string();
    let channels = |source: inhand_channels::ChannelError| SessionError::at(path.display(), source);
    let own = inhand_channels::read_own_annotations(&bytes, &name).map_err(channels)?;
    let all = inhand_channels::read_annotations(&bytes, &name).map_err(channels)?;
    let metadata = inhand_channels::read_metadata(&bytes, &name).map_err(channels)?;
    let info = inhand_channels::info(&bytes, &name).map_err(channels)?;
    if let Some(problem) = info.problem {
        return Err(channels(problem));
    }
    let mut others = all.events;
    // Each own event is among all of them once.
    for event in &own.events {
        if let Some(place) = others.iter().position(|other| other == event) {
            others.remove(place);
        }
    }
    Ok(Annotated {
        start_unix_nanos: start_unix_nanos(path, &bytes)?,
        own,
        others,
        profile: info.profile,
        library: info.library,
        metadata,
    })
}

/// Reads events from a CSV file (see [`inhand_export::events`]) on the time line of `annotated`.
///
/// # Errors
///
/// [`SessionError::At`] with line and column, [`SessionError::Io`].
pub fn read_csv(path: &Path, annotated: &Annotated) -> Result<Annotations, SessionError> {
    let bytes = std::fs::read(path).map_err(SessionError::io("read", path))?;
    let name = path.file_name().unwrap_or(path.as_os_str());
    let name = name.to_string_lossy();
    inhand_export::events::read(&bytes, &name, annotated.start_unix_nanos).in_file(path)
}

/// Writes `input` with these annotations in place of its own; every other record stays byte for
/// byte. A step `annotate` is added to the provenance.
///
/// # Errors
///
/// [`SessionError::Data`] for an event before the file's time line or past the year 2105, which
/// viewers cannot show; what reading and writing can find.
pub fn write(
    input: &Path,
    output: &Path,
    annotated: &Annotated,
    annotations: &Annotations,
) -> Result<(), SessionError> {
    check_times(input, annotations)?;
    let made = provenance(input, annotations)?;
    put(input, output, annotated, annotations, Some(&made))
}

/// As [`write`], with a step of the file's making to add or none.
pub(crate) fn put(
    input: &Path,
    output: &Path,
    annotated: &Annotated,
    annotations: &Annotations,
    made: Option<&Provenance>,
) -> Result<(), SessionError> {
    let records = inhand_channels::annotation_records(annotations).0;
    let known = &annotated.metadata.0;
    let is_known = |name: &String| known.contains_key(name);
    let mut replace: BTreeMap<_, _> = records.clone();
    replace.retain(|name, _| is_known(name));
    // What is no longer said must not stay.
    for name in ["inhand.annotations", "inhand.about"] {
        if known.contains_key(name) && !records.contains_key(name) {
            replace.insert(name.to_owned(), BTreeMap::new());
        }
    }
    let new = records.into_iter().filter(|(name, _)| !is_known(name));
    let steps = made.map(|made| annotated.metadata.next_provenance(made).0);
    let add = new
        .chain(steps.unwrap_or_default())
        .map(|(name, facts)| MetadataRecord { name, facts });
    let not_own = |channel: &ChannelFacts| channel.topic != TOPIC;
    let without_events = Selection {
        channels: known_events(annotated).then_some(&not_own),
        replace,
        add: add.collect(),
        ..Selection::default()
    };
    if annotations.events.is_empty() {
        containers::filter(input, output, &without_events)?;
        return Ok(());
    }
    let folder = output
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    let scratch = tempfile::Builder::new()
        .prefix(".inhand-unfinished-")
        .tempdir_in(folder)
        .map_err(SessionError::io("write", output))?;
    let rest = scratch.path().join("rest.mcap");
    containers::filter(input, &rest, &without_events)?;
    let events = scratch.path().join("events.mcap");
    write_atomic(&events, |out| {
        inhand_channels::write_annotations(out, annotations, &annotated.profile).in_file(output)
    })?;
    containers::merge_as(&annotated.library, &[&rest, &events], output, false)?;
    Ok(())
}

/// Whether the file has events of ours that others have to take the place of.
fn known_events(annotated: &Annotated) -> bool {
    !annotated.own.events.is_empty()
}

/// The events themselves are in the file; the step says that they were written.
fn provenance(input: &Path, annotations: &Annotations) -> Result<Provenance, SessionError> {
    let name = input.file_name().unwrap_or(input.as_os_str());
    Ok(Provenance {
        tool: TOOL.to_owned(),
        step: "annotate".to_owned(),
        settings_json: json!({ "events": annotations.events.len() }).to_string(),
        inputs: vec![InputHash {
            name: name.to_string_lossy().into_owned(),
            sha256: sha256(input)?,
        }],
    })
}

/// Viewers state times with 32 bits of seconds.
fn check_times(path: &Path, annotations: &Annotations) -> Result<(), SessionError> {
    const LAST: u64 = u32::MAX as u64 * 1_000_000_000 + 999_999_999;
    match annotations
        .events
        .iter()
        .find(|event| event.end_unix_nanos > LAST)
    {
        None => Ok(()),
        Some(event) => Err(wrong(
            path,
            format!(
                "an event ends {} ns after 1970: expected a time before the year 2106, the last \
                 that viewers know",
                event.end_unix_nanos
            ),
        )),
    }
}

fn wrong(path: &Path, message: String) -> SessionError {
    SessionError::data(path, message)
}

/// Which labels may be used: for each key its values, or any where there is none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Vocabulary(BTreeMap<String, Option<Vec<String>>>);

impl Vocabulary {
    /// Reads a vocabulary: a TOML file with a line for each key, its values as a list, or `"any"`.
    ///
    /// ```toml
    /// task = ["rotate", "regrasp", "lift"]
    /// label = ["slip", "drop"]
    /// note = "any"
    /// ```
    ///
    /// # Errors
    ///
    /// [`SessionError::Usage`] with the place, [`SessionError::Io`].
    pub fn read(path: &Path) -> Result<Self, SessionError> {
        let text = std::fs::read_to_string(path).map_err(SessionError::io("read", path))?;
        let wrong = |message: String| SessionError::usage(path, message);
        let table: toml::Table = toml::from_str(&text)
            .map_err(|error| wrong(error.to_string().trim_end().to_owned()))?;
        let values = |key: &str, value: toml::Value| {
            match value {
                toml::Value::String(word) if word == "any" => Ok(None),
                toml::Value::Array(values) => (values.into_iter())
                    .map(|value| value.as_str().map(str::to_owned))
                    .collect::<Option<Vec<_>>>()
                    .map(Some)
                    .ok_or(()),
                _ => Err(()),
            }
            .map_err(|()| wrong(format!("{key}: expected a list of texts, or \"any\"")))
        };
        let entries = table.into_iter().map(|(key, value)| {
            let values = values(&key, value)?;
            Ok((key, values))
        });
        Ok(Self(entries.collect::<Result<_, SessionError>>()?))
    }

    /// Refuses labels that are not in the vocabulary; those of events that inhand found are its own.
    ///
    /// # Errors
    ///
    /// [`SessionError::Data`] with what may be used instead.
    pub fn check(&self, file: &Path, events: &[Event]) -> Result<(), SessionError> {
        let given = events.iter().filter(|event| !event.is_found());
        for (key, value) in given.flat_map(|event| &event.labels) {
            let label = Label::new(key, value);
            let allowed = match self.0.get(key) {
                Some(None) => continue,
                Some(Some(values)) if values.contains(value) => continue,
                Some(Some(values)) => format!("{key} to be one of {}", values.join(", ")),
                None => {
                    let keys: Vec<&str> = self.0.keys().map(String::as_str).collect();
                    format!("a key of the vocabulary, {}", keys.join(", "))
                }
            };
            return Err(wrong(
                file,
                format!("the label {label}: expected {allowed}"),
            ));
        }
        Ok(())
    }
}
