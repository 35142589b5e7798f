//! JSON beside a wide table, for what its columns cannot hold.

use std::collections::BTreeMap;

use inhand_model::{
    BodyKind, Clock, LengthUnit, MarkerKind, Recording, RotationOrder, Source, StartTime, UpAxis,
};
use serde::{Deserialize, Serialize};

use crate::entity::recording_entities;
use crate::error::{TableError, shown};
use crate::table::unique_names;

/// Version of the file; raised when a key changes its meaning.
const VERSION: u32 = 1;

/// Facts of a recording beside its wide table.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Facts {
    /// What the file is.
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
    /// What its columns begin with.
    pub(crate) columns: String,
    pub(crate) name: String,
    pub(crate) id: String,
    pub(crate) kind: String,
}

/// What a wide table of a recording cannot hold, as JSON: clock, source, names and kinds. Written
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

impl Facts {
    pub(crate) fn parse(text: &[u8], file: &str) -> Result<Self, TableError> {
        let wrong = |found: String| TableError::File {
            file: file.to_owned(),
            expected: format!("the facts of a table, version {VERSION}"),
            found,
            hint: "write it again with inhand export, or take it away to read the table alone"
                .to_owned(),
        };
        let facts: Facts =
            serde_json::from_slice(text).map_err(|error| wrong(error.to_string()))?;
        if facts.inhand_table == VERSION {
            Ok(facts)
        } else {
            Err(wrong(format!("version {}", facts.inhand_table)))
        }
    }

    pub(crate) fn clock(&self, file: &str) -> Result<Clock, TableError> {
        let start_time = one_of(
            file,
            "start_time",
            &self.start_time,
            &[StartTime::Stated, StartTime::AssumedUtc, StartTime::Unknown],
            StartTime::name,
        )?;
        Clock::new(self.start_unix_nanos, start_time, self.rate_hz)
            .map_err(|error| fact(file, "rate_hz", "a positive number", &error.to_string()))
    }

    pub(crate) fn source(&self, file: &str) -> Result<Source, TableError> {
        let source = &self.source;
        let rotation = match source.rotation.as_deref() {
            None => None,
            Some("quaternion") => Some(RotationOrder::Quaternion),
            Some(order) => {
                let axes: Option<Vec<u8>> = (order.chars())
                    .map(|axis| "XYZ".find(axis).map(|index| index as u8))
                    .collect();
                let axes = axes.and_then(|axes| axes.try_into().ok());
                Some(RotationOrder::Euler(axes.ok_or_else(|| {
                    fact(
                        file,
                        "source.rotation",
                        "quaternion or an order such as XYZ",
                        order,
                    )
                })?))
            }
        };
        Ok(Source {
            format: source.format.clone(),
            length_unit: one_of(
                file,
                "source.length_unit",
                &source.length_unit,
                &[
                    LengthUnit::Metres,
                    LengthUnit::Centimetres,
                    LengthUnit::Millimetres,
                    LengthUnit::Inches,
                    LengthUnit::Feet,
                ],
                LengthUnit::name,
            )?,
            up_axis: one_of(
                file,
                "source.up_axis",
                &source.up_axis,
                &[UpAxis::Y, UpAxis::Z],
                UpAxis::name,
            )?,
            rotation,
            header: source.header.clone(),
        })
    }
}

/// The kind of a body by its name in files.
pub(crate) fn body_kind(name: &str) -> Option<BodyKind> {
    [BodyKind::RigidBody, BodyKind::Bone]
        .into_iter()
        .find(|kind| kind.name() == name)
}

/// The kind of a marker by its name in files.
pub(crate) fn marker_kind(name: &str) -> Option<MarkerKind> {
    [
        MarkerKind::Labelled,
        MarkerKind::RigidBodyMarker,
        MarkerKind::Unlabelled,
    ]
    .into_iter()
    .find(|kind| kind.name() == name)
}

fn one_of<T: Copy>(
    file: &str,
    key: &str,
    found: &str,
    values: &[T],
    name: impl Fn(T) -> &'static str,
) -> Result<T, TableError> {
    let value = values.iter().copied().find(|&value| name(value) == found);
    value.ok_or_else(|| {
        let names: Vec<_> = values.iter().map(|&value| name(value)).collect();
        fact(file, key, &names.join(", "), found)
    })
}

pub(crate) fn fact(file: &str, key: &str, expected: &str, found: &str) -> TableError {
    TableError::File {
        file: file.to_owned(),
        expected: format!("\"{key}\" to be {expected}"),
        found: shown(found),
        hint: "write it again with inhand export, or take it away to read the table alone"
            .to_owned(),
    }
}
