//! JSON beside a wide table: facts that its columns cannot hold.

use std::collections::BTreeMap;

use inhand_model::{Clock, LengthUnit, Recording, RotationOrder, Source, StartTime, UpAxis};
use serde::{Deserialize, Serialize};

use crate::error::{ExportError, shown};
use crate::take::{recording_entities, unique_names};

/// Version of the file; raised when a key changes its meaning.
const VERSION: u32 = 1;

/// Facts of a recording beside its wide table.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Facts {
    /// Version of the file.
    inhand_table: u32,
    pub(crate) name: String,
    pub(crate) samples: usize,
    pub(crate) rate_hz: f64,
    pub(crate) start_unix_nanos: u64,
    pub(crate) start_time: String,
    pub(crate) source: SourceFacts,
    /// Bodies, then markers, in the order of the columns.
    pub(crate) entities: Vec<EntityFacts>,
    /// Unit of each kind of column, for readers who do not know the names.
    units: BTreeMap<String, String>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SourceFacts {
    format: String,
    length_unit: String,
    up_axis: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    rotation: Option<String>,
    header: BTreeMap<String, String>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct EntityFacts {
    /// Prefix of its columns.
    pub(crate) columns: String,
    pub(crate) name: String,
    pub(crate) id: String,
    pub(crate) kind: String,
}

/// Facts of a recording that a wide table cannot hold, as JSON: clock, source, names and kinds. Written
/// beside the table as `<table>.json`, it lets [`read_wide_csv`](crate::read_wide_csv) give the
/// recording again.
pub fn facts_json(recording: &Recording) -> String {
    let entities = recording_entities(recording);
    let ids = (recording.bodies.iter().map(|body| &body.id))
        .chain(recording.markers.iter().map(|marker| &marker.id));
    let source = &recording.source;
    let units = [
        ("time_s", "s"),
        (".x_m, .y_m, .z_m", "m, frame world"),
        (".qx, .qy, .qz, .qw", "unit quaternion, world from body"),
        (".status", "measured, filled or missing"),
        (".marker_error_m", "m"),
        (".quality", "0 to 1"),
    ];
    let facts = Facts {
        inhand_table: VERSION,
        name: recording.name.clone(),
        samples: recording.len(),
        rate_hz: recording.clock.rate_hz(),
        start_unix_nanos: recording.clock.start_unix_nanos(),
        start_time: recording.clock.start_time().name().to_owned(),
        source: SourceFacts {
            format: source.format.clone(),
            length_unit: source.length_unit.name().to_owned(),
            up_axis: source.up_axis.name().to_owned(),
            rotation: source.rotation.map(|rotation| rotation.to_string()),
            header: source.header.clone(),
        },
        entities: (entities.iter().zip(unique_names(&entities)).zip(ids))
            .map(|((entity, columns), id)| EntityFacts {
                columns,
                name: entity.name.clone(),
                id: id.clone(),
                kind: entity.kind.to_owned(),
            })
            .collect(),
        units: (units.iter())
            .map(|(columns, unit)| ((*columns).to_owned(), (*unit).to_owned()))
            .collect(),
    };
    let mut text = serde_json::to_string_pretty(&facts)
        .expect("texts and finite numbers, which a recording has, are JSON");
    text.push('\n');
    text
}

const HINT: &str = "write it again with inhand export, or remove it to read the table alone";

impl Facts {
    pub(crate) fn parse(text: &[u8], file: &str) -> Result<Self, ExportError> {
        let wrong = |found: &str| {
            let expected = format!("the facts of a table, version {VERSION}");
            ExportError::file(file, expected, found, HINT)
        };
        let facts: Facts =
            serde_json::from_slice(text).map_err(|error| wrong(&error.to_string()))?;
        match facts.inhand_table {
            VERSION => Ok(facts),
            other => Err(wrong(&format!("version {other}"))),
        }
    }

    pub(crate) fn clock(&self, file: &str) -> Result<Clock, ExportError> {
        let names = StartTime::ALL.map(StartTime::name);
        let start_time = StartTime::from_name(&self.start_time)
            .ok_or_else(|| fact(file, "start_time", &names.join(", "), &self.start_time))?;
        Clock::new(self.start_unix_nanos, start_time, self.rate_hz)
            .map_err(|error| fact(file, "rate_hz", "a positive number", &error.to_string()))
    }

    pub(crate) fn source(&self, file: &str) -> Result<Source, ExportError> {
        let source = &self.source;
        let wrong = |key: &str, expected: &str, found: &str| {
            fact(file, &format!("source.{key}"), expected, found)
        };
        let rotation = match source.rotation.as_deref() {
            None => None,
            Some("quaternion") => Some(RotationOrder::Quaternion),
            Some(order) => {
                let axes: Option<Vec<u8>> = (order.chars())
                    .map(|axis| "XYZ".find(axis).map(|index| index as u8))
                    .collect();
                let axes = axes.and_then(|axes| axes.try_into().ok());
                let expected = "quaternion or an order such as XYZ";
                let axes = axes.ok_or_else(|| wrong("rotation", expected, order))?;
                Some(RotationOrder::Euler(axes))
            }
        };
        let (unit, up) = (&source.length_unit, &source.up_axis);
        let units = LengthUnit::ALL.map(LengthUnit::name).join(", ");
        let axes = UpAxis::ALL.map(UpAxis::name).join(", ");
        Ok(Source {
            format: source.format.clone(),
            length_unit: LengthUnit::from_name(unit)
                .ok_or_else(|| wrong("length_unit", &units, unit))?,
            up_axis: UpAxis::from_name(up).ok_or_else(|| wrong("up_axis", &axes, up))?,
            rotation,
            header: source.header.clone(),
        })
    }
}

pub(crate) fn fact(file: &str, key: &str, expected: &str, found: &str) -> ExportError {
    ExportError::file(
        file,
        format!("\"{key}\" to be {expected}"),
        shown(found),
        HINT,
    )
}
