//! Metadata records: facts that messages cannot hold.
//!
//! | record | keys |
//! | --- | --- |
//! | `inhand.recording` | `name`, `samples`, `rate_hz`, `start_unix_nanos`, `start_time`, `length_unit` (always metres), `frame`, `source_format`, `source_length_unit`, `source_up_axis`, `source_rotation`, `markers`, `bodies` (JSON) |
//! | `inhand.cleaned` | as `inhand.recording`, of the recording after cleaning |
//! | `inhand.header` | every other fact of the source's header, verbatim |
//! | `inhand.roles` | `hand`, `object`, `thumb` ... `little` |
//! | `inhand.motion` | `name` |
//! | `inhand.object` | `shape` |
//! | `inhand.recovered` | `lost_bytes`, `messages`: the file was damaged, and samples may have no message |
//! | `inhand.annotations` | `keys` (JSON): labels of events in the order in which tables show them |
//! | `inhand.about` | statements about the whole take, such as `subject`, `object`, `task` |
//! | `inhand.overlay` | `frame`, `align`, `layers` (JSON): overlaid motions, which are no take |
//! | `inhand.provenance.<n>` | `tool`, `step`, `settings`, `inputs` (JSON); n counts the steps from 1 |

use std::collections::BTreeMap;
use std::str::FromStr;

use inhand_container::MetadataRecord;
use inhand_model::{
    Annotations, BodyKind, Clock, Finger, LengthUnit, MarkerKind, PerFinger, Provenance, Recording,
    Roles, Shape, Source,
};
use serde::de::DeserializeOwned;
use serde::de::value::StrDeserializer;
use serde::{Deserialize, Serialize};

use crate::error::ChannelError;

/// Key and value of a record.
type Facts = BTreeMap<String, String>;

/// The metadata records of an MCAP file by name. Where a file has several of one name, the last
/// one counts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metadata(pub BTreeMap<String, Facts>);

impl FromIterator<MetadataRecord> for Metadata {
    fn from_iter<T: IntoIterator<Item = MetadataRecord>>(records: T) -> Self {
        let named = (records.into_iter()).map(|record| (record.name, record.facts));
        Self(named.collect())
    }
}

pub(crate) const RECORDING: &str = "inhand.recording";
pub(crate) const CLEANED: &str = "inhand.cleaned";
pub(crate) const HEADER: &str = "inhand.header";
pub(crate) const ROLES: &str = "inhand.roles";
pub(crate) const MOTION: &str = "inhand.motion";
/// Losses of a file that `recover` saved a part of.
pub(crate) const RECOVERED: &str = "inhand.recovered";
pub(crate) const OBJECT: &str = "inhand.object";
/// Order of labels in tables of annotations.
pub(crate) const ANNOTATIONS: &str = "inhand.annotations";
/// Statements about the whole take, such as its subject.
pub(crate) const ABOUT: &str = "inhand.about";
/// Frame and layers of an overlay.
pub(crate) const OVERLAY: &str = "inhand.overlay";
pub(crate) const PROVENANCE: &str = "inhand.provenance.";

/// Whether this is the provenance record of one of these steps.
fn is_step(name: &str, facts: &Facts, steps: &[&str]) -> bool {
    let step = facts.get("step").map_or("", String::as_str);
    name.starts_with(PROVENANCE) && steps.contains(&step)
}

/// Facts of a recording that are no samples.
pub(crate) struct RecordingFacts {
    pub(crate) name: String,
    pub(crate) clock: Clock,
    pub(crate) samples: usize,
    /// Whether messages of some samples may be lost: those are missing then.
    pub(crate) lossy: bool,
    pub(crate) source: Source,
    pub(crate) markers: Vec<MarkerFacts>,
    pub(crate) bodies: Vec<BodyFacts>,
}

/// A marker of the record, by the alphabet of its keys.
#[derive(Serialize, Deserialize)]
pub(crate) struct MarkerFacts {
    pub(crate) id: String,
    pub(crate) kind: MarkerKind,
    pub(crate) name: String,
    #[serde(rename = "quality")]
    pub(crate) has_quality: bool,
}

/// A body of the record, by the alphabet of its keys.
#[derive(Serialize, Deserialize)]
pub(crate) struct BodyFacts {
    pub(crate) id: String,
    pub(crate) kind: BodyKind,
    #[serde(rename = "marker_error")]
    pub(crate) has_marker_error: bool,
    pub(crate) name: String,
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("texts and numbers can be written as JSON")
}

impl Metadata {
    /// Facts of a recording that has, or will have, so many samples.
    pub(crate) fn add_recording(&mut self, record: &str, recording: &Recording, samples: usize) {
        let Recording { clock, source, .. } = recording;
        let markers = recording.markers.iter().map(|marker| MarkerFacts {
            id: marker.id.clone(),
            kind: marker.kind,
            name: marker.name.clone(),
            has_quality: marker.quality.is_some(),
        });
        let bodies = recording.bodies.iter().map(|body| BodyFacts {
            id: body.id.clone(),
            kind: body.kind,
            has_marker_error: body.marker_error_m.is_some(),
            name: body.name.clone(),
        });
        let facts = [
            ("name", recording.name.clone()),
            ("samples", samples.to_string()),
            // The shortest text that reads back as the same number.
            ("rate_hz", clock.rate_hz().to_string()),
            ("start_unix_nanos", clock.start_unix_nanos().to_string()),
            ("start_time", clock.start_time().name().to_owned()),
            ("length_unit", LengthUnit::Metres.name().to_owned()),
            ("frame", "world".to_owned()),
            ("source_format", source.format.clone()),
            ("source_length_unit", source.length_unit.name().to_owned()),
            ("source_up_axis", source.up_axis.name().to_owned()),
            ("markers", json(&markers.collect::<Vec<_>>())),
            ("bodies", json(&bodies.collect::<Vec<_>>())),
        ];
        let rotation = source
            .rotation
            .map(|order| ("source_rotation", order.to_string()));
        for (key, value) in facts.into_iter().chain(rotation) {
            self.add_fact(record, key, value);
        }
    }

    /// The record of a recording that is cut to so many samples and starts at another time.
    pub(crate) fn cut_recording(
        &self,
        record: &str,
        samples: usize,
        start_unix_nanos: u64,
    ) -> Facts {
        let mut facts = self.0.get(record).cloned().unwrap_or_default();
        facts.insert("samples".to_owned(), samples.to_string());
        facts.insert("start_unix_nanos".to_owned(), start_unix_nanos.to_string());
        facts
    }

    pub(crate) fn add_roles(&mut self, roles: &Roles) {
        self.add_fact(ROLES, "hand", json(&roles.hand));
        if let Some(object) = &roles.object {
            self.add_fact(ROLES, "object", json(object));
        }
        for (finger, marker) in roles.fingers.iter() {
            self.add_fact(ROLES, finger.name(), marker.clone());
        }
    }

    /// Facts about annotations, where there are any.
    pub(crate) fn add_annotations(&mut self, annotations: &Annotations) {
        if !annotations.events.is_empty() {
            self.add_fact(ANNOTATIONS, "keys", json(&annotations.all_keys()));
        }
        if !annotations.about.is_empty() {
            self.0.insert(ABOUT.to_owned(), annotations.about.clone());
        }
    }

    pub(crate) fn add_fact(&mut self, record: &str, key: &str, value: String) {
        (self.0.entry(record.to_owned()).or_default()).insert(key.to_owned(), value);
    }

    /// Whether the file is a take that inhand wrote.
    #[must_use]
    pub fn is_take(&self) -> bool {
        self.0.contains_key(RECORDING)
    }

    /// Whether `inhand view` added its channels to the file.
    #[must_use]
    pub fn has_added_views(&self) -> bool {
        (self.0.iter()).any(|(name, facts)| is_step(name, facts, &["view"]))
    }

    /// Whether inhand wrote the file in its own messages: neither a third-party one with annotations or views, nor a
    /// ROS 2 bag.
    #[must_use]
    pub fn is_written_by_inhand(&self) -> bool {
        // A bag keeps the steps of the take that it was made of.
        let is_bag = (self.0.iter()).any(|(name, facts)| is_step(name, facts, &["ros2"]));
        (self.0.iter()).any(|(name, facts)| {
            let is_added = [ANNOTATIONS, ABOUT].contains(&name.as_str())
                || is_step(name, facts, &["annotate", "view"]);
            let is_kept = is_bag && name.starts_with(PROVENANCE);
            name.starts_with("inhand.") && !is_added && !is_kept
        })
    }

    /// The record of a step after those that are here.
    #[must_use]
    pub fn next_provenance(&self, step: &Provenance) -> Self {
        let numbers = self
            .0
            .keys()
            .filter_map(|name| name.strip_prefix(PROVENANCE)?.parse().ok());
        let last: u64 = numbers.max().unwrap_or_default();
        let mut record = Self::default();
        record.add_steps(last.saturating_add(1), std::slice::from_ref(step));
        record
    }

    pub(crate) fn add_provenance(&mut self, provenance: &[Provenance]) {
        self.add_steps(1, provenance);
    }

    fn add_steps(&mut self, first: u64, provenance: &[Provenance]) {
        for (n, step) in (first..).zip(provenance) {
            let record = format!("{PROVENANCE}{n}");
            self.add_fact(&record, "tool", step.tool.clone());
            self.add_fact(&record, "step", step.step.clone());
            self.add_fact(&record, "settings", step.settings_json.clone());
            self.add_fact(&record, "inputs", json(&step.inputs));
        }
    }

    /// The facts of the recording that everything made of the take follows: the cleaned one where there
    /// is one.
    pub(crate) fn used_recording(
        &self,
        file: &str,
    ) -> Result<Option<RecordingFacts>, ChannelError> {
        let measured = self.recording(file, RECORDING)?;
        Ok(self.recording(file, CLEANED)?.or(measured))
    }

    /// The object's shape, where the file states it.
    ///
    /// # Errors
    ///
    /// [`ChannelError::Mismatch`] for a text that is no shape.
    pub fn shape(&self, file: &str) -> Result<Option<Shape>, ChannelError> {
        (self.record(file, OBJECT))
            .filter(|record| record.facts.contains_key("shape"))
            .map(|record| record.parsed("shape", "a shape such as cube:0.05"))
            .transpose()
    }

    /// The facts of the recording of this record; `None` where the file has none.
    pub(crate) fn recording(
        &self,
        file: &str,
        record: &str,
    ) -> Result<Option<RecordingFacts>, ChannelError> {
        let Some(record) = self.record(file, record) else {
            return Ok(None);
        };
        let rate_hz: f64 = record.parsed("rate_hz", "a number of samples per second")?;
        let start_unix_nanos = record.parsed("start_unix_nanos", "whole nanoseconds")?;
        let clock = Clock::new(start_unix_nanos, record.named("start_time")?, rate_hz)
            .map_err(|_| record.error("rate_hz", "a positive number"))?;
        let has_rotation = record.facts.contains_key("source_rotation");
        Ok(Some(RecordingFacts {
            name: record.text("name")?.to_owned(),
            clock,
            samples: record.parsed("samples", "a whole number")?,
            lossy: self.0.contains_key(RECOVERED),
            source: Source {
                format: record.text("source_format")?.to_owned(),
                length_unit: record.named("source_length_unit")?,
                up_axis: record.named("source_up_axis")?,
                rotation: (has_rotation.then(|| record.named("source_rotation"))).transpose()?,
                header: self.0.get(HEADER).cloned().unwrap_or_default(),
            },
            markers: record.json(
                "markers",
                "a JSON list of objects with name, id, kind, quality",
            )?,
            bodies: record.json(
                "bodies",
                "a JSON list of objects with name, id, kind, marker_error",
            )?,
        }))
    }

    pub(crate) fn roles(&self, file: &str) -> Result<Option<Roles>, ChannelError> {
        let Some(record) = self.record(file, ROLES) else {
            return Ok(None);
        };
        let body = |key| record.json(key, r#"{"rigid_body": NAME} or {"markers": [NAME, ...]}"#);
        let has_object = record.facts.contains_key("object");
        Ok(Some(Roles {
            hand: body("hand")?,
            object: has_object.then(|| body("object")).transpose()?,
            fingers: PerFinger::try_from_fn(|finger: Finger| {
                record.text(finger.name()).map(str::to_owned)
            })?,
        }))
    }

    /// Keys of labels in the order in which tables show them, where the file states it.
    pub(crate) fn annotation_keys(&self, file: &str) -> Result<Option<Vec<String>>, ChannelError> {
        (self.record(file, ANNOTATIONS))
            .filter(|record| record.facts.contains_key("keys"))
            .map(|record| record.json("keys", "a JSON list of texts"))
            .transpose()
    }

    pub(crate) fn motion_name(&self, file: &str) -> Result<Option<String>, ChannelError> {
        (self.record(file, MOTION))
            .map(|record| record.text("name").map(str::to_owned))
            .transpose()
    }

    /// The steps that made the file, first to last; `file` is what messages call it.
    ///
    /// # Errors
    ///
    /// [`ChannelError::Mismatch`] for a record of a step that is not as this crate writes it.
    pub fn provenance(&self, file: &str) -> Result<Vec<Provenance>, ChannelError> {
        let mut steps: Vec<(u64, &str)> = (self.0.keys())
            .filter_map(|name| {
                let n = name.strip_prefix(PROVENANCE)?.parse().ok()?;
                Some((n, name.as_str()))
            })
            .collect();
        steps.sort_unstable();
        (steps.into_iter())
            .filter_map(|(_, name)| self.record(file, name))
            .map(|record| {
                Ok(Provenance {
                    tool: record.text("tool")?.to_owned(),
                    step: record.text("step")?.to_owned(),
                    settings_json: record.text("settings")?.to_owned(),
                    inputs: record.json("inputs", "a JSON list of objects with name, sha256")?,
                })
            })
            .collect()
    }

    fn record<'a>(&'a self, file: &'a str, name: &'a str) -> Option<Record<'a>> {
        let facts = self.0.get(name)?;
        Some(Record { file, name, facts })
    }
}

/// One metadata record, with the file for errors.
struct Record<'a> {
    file: &'a str,
    name: &'a str,
    facts: &'a Facts,
}

impl<'a> Record<'a> {
    fn error(&self, key: &str, expected: &str) -> ChannelError {
        let found = match self.facts.get(key) {
            None => "nothing".to_owned(),
            Some(text) => format!("\"{}\"", text.chars().take(80).collect::<String>()),
        };
        let (file, record) = (self.file, self.name);
        let what = format!("{file}: metadata record \"{record}\", key \"{key}\"");
        ChannelError::mismatch(what, expected, found)
    }

    fn text(&self, key: &str) -> Result<&'a str, ChannelError> {
        (self.facts.get(key).map(String::as_str)).ok_or_else(|| self.error(key, "a text"))
    }

    fn parsed<T: FromStr>(&self, key: &str, expected: &str) -> Result<T, ChannelError> {
        let text = self.facts.get(key).and_then(|text| text.parse().ok());
        text.ok_or_else(|| self.error(key, expected))
    }

    /// A value of a few that have names.
    fn named<T: DeserializeOwned>(&self, key: &str) -> Result<T, ChannelError> {
        let text = StrDeserializer::<serde_json::Error>::new(self.text(key)?);
        T::deserialize(text).map_err(|error| {
            let error = error.to_string();
            let expected = error
                .rsplit_once("expected ")
                .map_or(&*error, |(_, names)| names);
            self.error(key, expected)
        })
    }

    fn json<T: DeserializeOwned>(&self, key: &str, expected: &str) -> Result<T, ChannelError> {
        serde_json::from_str(self.text(key)?).map_err(|_| self.error(key, expected))
    }
}
