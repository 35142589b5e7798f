//! Metadata records: what messages cannot hold.
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
//! | `inhand.about` | what people say about the whole take, such as `subject`, `object`, `task` |
//! | `inhand.overlay` | `frame`, `align`, `layers` (JSON): motions over each other, which is no take |
//! | `inhand.provenance.<n>` | `tool`, `step`, `settings`, `inputs` (JSON); n counts the steps from 1 |

use std::collections::BTreeMap;
use std::str::FromStr;

use inhand_model::{
    BodyKind, BodySource, Clock, Finger, InputHash, LengthUnit, MarkerKind, PerFinger, Provenance,
    Recording, Roles, RotationOrder, Shape, Source, StartTime, UpAxis,
};
use serde_json::{Value, json};

use crate::error::ChannelError;

/// The metadata records of an MCAP file by name. Where a file has several of one name, the last
/// one counts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metadata(pub BTreeMap<String, BTreeMap<String, String>>);

pub(crate) const RECORDING: &str = "inhand.recording";
pub(crate) const CLEANED: &str = "inhand.cleaned";
pub(crate) const HEADER: &str = "inhand.header";
pub(crate) const ROLES: &str = "inhand.roles";
pub(crate) const MOTION: &str = "inhand.motion";
/// What `recover` says of a file that it saved a part of.
pub(crate) const RECOVERED: &str = "inhand.recovered";
pub(crate) const OBJECT: &str = "inhand.object";
/// How tables of annotations are laid out.
pub(crate) const ANNOTATIONS: &str = "inhand.annotations";
/// What people say about the whole take.
pub(crate) const ABOUT: &str = "inhand.about";
/// What makes a file an overlay.
pub(crate) const OVERLAY: &str = "inhand.overlay";
pub(crate) const PROVENANCE: &str = "inhand.provenance.";

/// Whether this is the provenance record of one of these steps.
fn is_step(name: &str, facts: &BTreeMap<String, String>, steps: &[&str]) -> bool {
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

pub(crate) struct MarkerFacts {
    pub(crate) name: String,
    pub(crate) id: String,
    pub(crate) kind: MarkerKind,
    pub(crate) has_quality: bool,
}

pub(crate) struct BodyFacts {
    pub(crate) name: String,
    pub(crate) id: String,
    pub(crate) kind: BodyKind,
    pub(crate) has_marker_error: bool,
}

impl Metadata {
    /// Facts of a recording that has, or will have, so many samples.
    pub(crate) fn add_recording(&mut self, recording: &Recording, samples: usize) {
        self.add_recording_as(RECORDING, recording, samples);
        (self.0).insert(HEADER.to_owned(), recording.source.header.clone());
    }

    pub(crate) fn add_cleaned(&mut self, cleaned: &Recording) {
        self.add_recording_as(CLEANED, cleaned, cleaned.len());
    }

    fn add_recording_as(&mut self, record: &str, recording: &Recording, samples: usize) {
        let Recording { clock, source, .. } = recording;
        let markers: Vec<Value> = (recording.markers.iter())
            .map(|marker| {
                json!({
                    "name": marker.name,
                    "id": marker.id,
                    "kind": marker.kind.name(),
                    "quality": marker.quality.is_some(),
                })
            })
            .collect();
        let bodies: Vec<Value> = (recording.bodies.iter())
            .map(|body| {
                json!({
                    "name": body.name,
                    "id": body.id,
                    "kind": body.kind.name(),
                    "marker_error": body.marker_error_m.is_some(),
                })
            })
            .collect();
        let mut facts = BTreeMap::from(
            [
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
                ("markers", Value::from(markers).to_string()),
                ("bodies", Value::from(bodies).to_string()),
            ]
            .map(|(key, value)| (key.to_owned(), value)),
        );
        if let Some(rotation) = source.rotation {
            facts.insert("source_rotation".to_owned(), rotation.to_string());
        }
        self.0.insert(record.to_owned(), facts);
    }

    pub(crate) fn add_roles(&mut self, roles: &Roles) {
        let mut facts = BTreeMap::from([("hand".to_owned(), body_source_text(&roles.hand))]);
        if let Some(object) = &roles.object {
            facts.insert("object".to_owned(), body_source_text(object));
        }
        for (finger, marker) in roles.fingers.iter() {
            facts.insert(finger.name().to_owned(), marker.clone());
        }
        self.0.insert(ROLES.to_owned(), facts);
    }

    pub(crate) fn add_fact(&mut self, record: &str, key: &str, value: String) {
        (self.0.entry(record.to_owned()).or_default()).insert(key.to_owned(), value);
    }

    pub(crate) fn add_shape(&mut self, shape: Shape) {
        self.add_fact(OBJECT, "shape", shape.to_string());
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

    /// Whether inhand wrote the file, and not only added annotations or views to a third-party one.
    #[must_use]
    pub fn is_written_by_inhand(&self) -> bool {
        (self.0.iter()).any(|(name, facts)| {
            name.starts_with("inhand.")
                && ![ANNOTATIONS, ABOUT].contains(&name.as_str())
                && !is_step(name, facts, &["annotate", "view"])
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
            let inputs: Vec<Value> = (step.inputs.iter())
                .map(|input| json!({"name": input.name, "sha256": input.sha256}))
                .collect();
            let facts = [
                ("tool", step.tool.clone()),
                ("step", step.step.clone()),
                ("settings", step.settings_json.clone()),
                ("inputs", Value::from(inputs).to_string()),
            ];
            for (key, value) in facts {
                self.add_fact(&format!("{PROVENANCE}{n}"), key, value);
            }
        }
    }

    /// The facts of the recording; `None` where the file holds none.
    pub(crate) fn recording(&self, file: &str) -> Result<Option<RecordingFacts>, ChannelError> {
        self.recording_as(file, RECORDING)
    }

    /// The facts of the cleaned recording; `None` where the file holds none.
    pub(crate) fn cleaned(&self, file: &str) -> Result<Option<RecordingFacts>, ChannelError> {
        self.recording_as(file, CLEANED)
    }

    /// The facts of the recording that everything made of the take follows: the cleaned one where there
    /// is one.
    pub(crate) fn used_recording(
        &self,
        file: &str,
    ) -> Result<Option<RecordingFacts>, ChannelError> {
        let measured = self.recording(file)?;
        Ok(self.cleaned(file)?.or(measured))
    }

    /// The object's shape, where the file states it.
    ///
    /// # Errors
    ///
    /// [`ChannelError::Metadata`] for a text that is no shape.
    pub fn shape(&self, file: &str) -> Result<Option<Shape>, ChannelError> {
        (self.record(file, OBJECT))
            .filter(|record| record.facts.contains_key("shape"))
            .map(|record| record.parsed("shape", "a shape such as cube:0.05"))
            .transpose()
    }

    fn recording_as(
        &self,
        file: &str,
        record: &str,
    ) -> Result<Option<RecordingFacts>, ChannelError> {
        let Some(record) = self.record(file, record) else {
            return Ok(None);
        };
        let rate_hz: f64 = record.parsed("rate_hz", "a number of samples per second")?;
        let start_unix_nanos = record.parsed("start_unix_nanos", "whole nanoseconds")?;
        let start_time = record.one_of(
            "start_time",
            &[StartTime::Stated, StartTime::AssumedUtc, StartTime::Unknown],
            StartTime::name,
        )?;
        let clock = Clock::new(start_unix_nanos, start_time, rate_hz)
            .map_err(|_| record.error("rate_hz", "a positive number"))?;
        let rotation = match record.facts.get("source_rotation") {
            None => None,
            Some(text) => Some(parse_rotation(text).ok_or_else(|| {
                record.error("source_rotation", "quaternion or an axis order such as XYZ")
            })?),
        };
        let source = Source {
            format: record.text("source_format")?.to_owned(),
            length_unit: record.one_of(
                "source_length_unit",
                &[
                    LengthUnit::Metres,
                    LengthUnit::Centimetres,
                    LengthUnit::Millimetres,
                    LengthUnit::Inches,
                    LengthUnit::Feet,
                ],
                LengthUnit::name,
            )?,
            up_axis: record.one_of("source_up_axis", &[UpAxis::Y, UpAxis::Z], UpAxis::name)?,
            rotation,
            header: self.0.get(HEADER).cloned().unwrap_or_default(),
        };
        let markers = record.list("markers", "name, id, kind, quality", |entry| {
            Some(MarkerFacts {
                name: text(entry, "name")?,
                id: text(entry, "id")?,
                kind: named(
                    entry,
                    &[
                        MarkerKind::Labelled,
                        MarkerKind::RigidBodyMarker,
                        MarkerKind::Unlabelled,
                    ],
                    MarkerKind::name,
                )?,
                has_quality: entry.get("quality")?.as_bool()?,
            })
        })?;
        let bodies = record.list("bodies", "name, id, kind, marker_error", |entry| {
            Some(BodyFacts {
                name: text(entry, "name")?,
                id: text(entry, "id")?,
                kind: named(
                    entry,
                    &[BodyKind::RigidBody, BodyKind::Bone],
                    BodyKind::name,
                )?,
                has_marker_error: entry.get("marker_error")?.as_bool()?,
            })
        })?;
        Ok(Some(RecordingFacts {
            name: record.text("name")?.to_owned(),
            clock,
            samples: record.parsed("samples", "a whole number")?,
            lossy: self.0.contains_key(RECOVERED),
            source,
            markers,
            bodies,
        }))
    }

    pub(crate) fn roles(&self, file: &str) -> Result<Option<Roles>, ChannelError> {
        let Some(record) = self.record(file, ROLES) else {
            return Ok(None);
        };
        let body = |key| {
            parse_body_source(record.text(key)?).ok_or_else(|| {
                record.error(key, r#"{"rigid_body": NAME} or {"markers": [NAME, ...]}"#)
            })
        };
        Ok(Some(Roles {
            hand: body("hand")?,
            object: (record.facts.contains_key("object"))
                .then(|| body("object"))
                .transpose()?,
            fingers: PerFinger::try_from_fn(|finger: Finger| {
                record.text(finger.name()).map(str::to_owned)
            })?,
        }))
    }

    /// Keys of labels in the order in which tables show them, where the file states it.
    pub(crate) fn annotation_keys(&self, file: &str) -> Result<Option<Vec<String>>, ChannelError> {
        (self.record(file, ANNOTATIONS))
            .filter(|record| record.facts.contains_key("keys"))
            .map(|record| {
                let text = record.text("keys")?;
                serde_json::from_str(text).map_err(|_| record.error("keys", "a JSON list of texts"))
            })
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
    /// [`ChannelError::Metadata`] for a record of a step that is not as this crate writes it.
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
                    inputs: record.list("inputs", "name, sha256", |entry| {
                        Some(InputHash {
                            name: text(entry, "name")?,
                            sha256: text(entry, "sha256")?,
                        })
                    })?,
                })
            })
            .collect()
    }

    fn record<'a>(&'a self, file: &'a str, name: &'a str) -> Option<Record<'a>> {
        let facts = self.0.get(name)?;
        Some(Record { file, name, facts })
    }
}

/// One metadata record with what an error about it has to say.
struct Record<'a> {
    file: &'a str,
    name: &'a str,
    facts: &'a BTreeMap<String, String>,
}

impl<'a> Record<'a> {
    fn error(&self, key: &str, expected: &str) -> ChannelError {
        ChannelError::Metadata {
            file: self.file.to_owned(),
            record: self.name.to_owned(),
            key: key.to_owned(),
            expected: expected.to_owned(),
            found: match self.facts.get(key) {
                None => "nothing".to_owned(),
                Some(text) => format!("\"{}\"", text.chars().take(80).collect::<String>()),
            },
        }
    }

    fn text(&self, key: &str) -> Result<&'a str, ChannelError> {
        (self.facts.get(key).map(String::as_str)).ok_or_else(|| self.error(key, "a text"))
    }

    fn parsed<T: FromStr>(&self, key: &str, expected: &str) -> Result<T, ChannelError> {
        let text = self.facts.get(key).and_then(|text| text.parse().ok());
        text.ok_or_else(|| self.error(key, expected))
    }

    fn one_of<T: Copy>(
        &self,
        key: &str,
        values: &[T],
        name: impl Fn(T) -> &'static str,
    ) -> Result<T, ChannelError> {
        let found = self.text(key)?;
        (values.iter().copied())
            .find(|&value| name(value) == found)
            .ok_or_else(|| {
                let names: Vec<_> = values.iter().map(|&value| name(value)).collect();
                self.error(key, &format!("one of {}", names.join(", ")))
            })
    }

    fn list<T>(
        &self,
        key: &str,
        entries: &str,
        read: impl Fn(&Value) -> Option<T>,
    ) -> Result<Vec<T>, ChannelError> {
        (serde_json::from_str::<Vec<Value>>(self.text(key)?).ok())
            .and_then(|values| values.iter().map(read).collect())
            .ok_or_else(|| self.error(key, &format!("a JSON list of objects with {entries}")))
    }
}

fn text(entry: &Value, key: &str) -> Option<String> {
    entry.get(key)?.as_str().map(str::to_owned)
}

fn named<T: Copy>(entry: &Value, kinds: &[T], name: impl Fn(T) -> &'static str) -> Option<T> {
    let found = entry.get("kind")?.as_str()?;
    kinds.iter().copied().find(|&kind| name(kind) == found)
}

fn body_source_text(source: &BodySource) -> String {
    match source {
        BodySource::RigidBody(name) => json!({"rigid_body": name}),
        BodySource::Markers(names) => json!({"markers": names}),
    }
    .to_string()
}

fn parse_body_source(text: &str) -> Option<BodySource> {
    let value: Value = serde_json::from_str(text).ok()?;
    if let Some(name) = value.get("rigid_body") {
        return Some(BodySource::RigidBody(name.as_str()?.to_owned()));
    }
    let names = value.get("markers")?.as_array()?;
    let names = names.iter().map(|name| name.as_str().map(str::to_owned));
    Some(BodySource::Markers(names.collect::<Option<_>>()?))
}

fn parse_rotation(text: &str) -> Option<RotationOrder> {
    if text == RotationOrder::Quaternion.to_string() {
        return Some(RotationOrder::Quaternion);
    }
    let axes: Option<Vec<u8>> = (text.chars())
        .map(|axis| "XYZ".find(axis).map(|index| index as u8))
        .collect();
    Some(RotationOrder::Euler(axes?.try_into().ok()?))
}
