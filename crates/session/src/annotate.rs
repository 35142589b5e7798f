//! Events on the time line of any MCAP file: read, and written into a copy in which everything else
//! stays as it is.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use inhand_channels::{ChannelError, FileEvents, Metadata};
use inhand_container::{ChannelFacts, MetadataRecord, Selection};
use inhand_model::{Annotations, Clock, Event, Label, Provenance, StartTime};
use serde_json::json;

use crate::TOOL;
use crate::error::{Located, SessionError};
use crate::files::{RECORDING, filter, hash_file, name_of, open_take, refuse_folder, take_start};

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
    /// Whether the file is a ROS 2 bag, whose events are JSON in `std_msgs/msg/String`.
    pub ros2: bool,
    metadata: Metadata,
}

impl Annotated {
    /// The intervals of the file that are selected, nanoseconds since 1970, end exclusive. Of a take
    /// they begin and end with samples, those at both ends of an event included.
    pub fn stretches(&self, selection: &inhand_model::Selection) -> Vec<Range<u64>> {
        let events = [&self.own.events[..], &self.others].concat();
        let Some((clock, samples)) = self.take() else {
            return selection.intervals(&events);
        };
        (selection.samples(&events, clock, samples).into_iter())
            .map(|range| clock.unix_nanos(range.start)..clock.unix_nanos(range.end))
            .collect()
    }

    /// What is odd about the times of an event of a take: no part of it is in the take, or its end is more than
    /// a second after the take's.
    pub fn odd_times(&self, event: &Event) -> Option<&'static str> {
        const SECOND: u64 = 1_000_000_000;
        let (clock, samples) = self.take()?;
        let end = clock.unix_nanos(samples);
        if event.end_unix_nanos < clock.start_unix_nanos() || event.start_unix_nanos >= end {
            return Some("is outside the take");
        }
        (event.end_unix_nanos.saturating_sub(end) > SECOND).then_some("ends after the take")
    }

    /// Clock and samples of the take that the file holds.
    fn take(&self) -> Option<(Clock, usize)> {
        let facts = self.metadata.0.get(RECORDING)?;
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
    refuse_folder(path)?;
    let Some(mut source) = open_take(path, &path.display().to_string())? else {
        return Err(SessionError::data(
            path,
            "events are kept in MCAP files: `inhand convert` makes one of a take".to_owned(),
        ));
    };
    let events = inhand_channels::read_file_events(&mut source).in_file(path)?;
    let start = take_start(&events.metadata).or(events.first_unix_nanos);
    let FileEvents {
        own,
        others,
        metadata,
        ros2,
        ..
    } = events;
    Ok(Annotated {
        start_unix_nanos: start.unwrap_or_default(),
        own,
        others,
        ros2,
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
    inhand_export::events::read(&bytes, &name_of(path), annotated.start_unix_nanos).in_file(path)
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
    // The events themselves are in the file; the step says that they were written.
    let made = Provenance {
        tool: TOOL.to_owned(),
        step: "annotate".to_owned(),
        settings_json: json!({ "events": annotations.events.len() }).to_string(),
        inputs: vec![hash_file(input)?],
    };
    let had_events = !annotated.own.events.is_empty();
    let changed = (annotations, annotated.ros2);
    let exchange = Exchange::new(&annotated.metadata, had_events, changed, Some(&made));
    let exchange = exchange.in_file(output)?;
    let stays = |channel: &ChannelFacts| exchange.keeps(channel);
    let selection = Selection {
        channels: had_events.then_some(&stays),
        replace: exchange.replace.clone(),
        add: exchange.add.clone(),
        append: exchange.append.as_deref(),
        ..Selection::default()
    };
    filter(input, output, &selection)?;
    Ok(())
}

/// The changes to a file that put annotations in the place of its own.
pub(crate) struct Exchange {
    had_events: bool,
    pub(crate) replace: BTreeMap<String, BTreeMap<String, String>>,
    pub(crate) add: Vec<MetadataRecord>,
    /// A file of the new events; `None` without any.
    pub(crate) append: Option<Vec<u8>>,
}

impl Exchange {
    /// For a file with this metadata, which may have events of its own and may be a ROS 2 bag; `made` is added as a
    /// step.
    pub(crate) fn new(
        metadata: &Metadata,
        had_events: bool,
        (annotations, ros2): (&Annotations, bool),
        made: Option<&Provenance>,
    ) -> Result<Self, ChannelError> {
        let records = inhand_channels::annotation_records(annotations).0;
        let known = &metadata.0;
        let (mut replace, new): (BTreeMap<_, _>, BTreeMap<_, _>) =
            (records.into_iter()).partition(|(name, _)| known.contains_key(name));
        // What is no longer said must not stay.
        for name in ["inhand.annotations", "inhand.about"] {
            if known.contains_key(name) {
                replace.entry(name.to_owned()).or_default();
            }
        }
        let steps = made.map(|made| metadata.next_provenance(made).0);
        let add = new.into_iter().chain(steps.unwrap_or_default());
        let mut events = Vec::new();
        if !annotations.events.is_empty() {
            inhand_channels::write_annotations(&mut events, annotations, ros2)?;
        }
        Ok(Self {
            had_events,
            replace,
            add: add
                .map(|(name, facts)| MetadataRecord { name, facts })
                .collect(),
            append: Some(events).filter(|events| !events.is_empty()),
        })
    }

    /// Whether a channel of the file stays.
    pub(crate) fn keeps(&self, channel: &ChannelFacts) -> bool {
        !(self.had_events && channel.topic == TOPIC)
    }
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
        Some(event) => Err(SessionError::data(
            path,
            format!(
                "an event ends {} ns after 1970: expected a time before the year 2106, the last \
                 that viewers know",
                event.end_unix_nanos
            ),
        )),
    }
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
        let table: toml::Table = (text.parse())
            .map_err(|error: toml::de::Error| wrong(error.to_string().trim_end().to_owned()))?;
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
    /// [`SessionError::Usage`] with what may be used instead.
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
            return Err(SessionError::usage(
                file,
                format!("the label {label}: expected {allowed}"),
            ));
        }
        Ok(())
    }
}
