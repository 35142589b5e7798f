//! JSON beside a wide table: facts that its columns cannot hold.

use std::collections::BTreeMap;

use inhand_model::{Clock, Recording, Source, StartTime};
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
    start_time: StartTime,
    pub(crate) source: Source,
    /// Bodies, then markers, in the order of the columns.
    pub(crate) entities: Vec<EntityFacts>,
    /// Unit of each kind of column, for readers who do not know the names.
    units: BTreeMap<String, String>,
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
        start_time: recording.clock.start_time(),
        source: recording.source.clone(),
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
        Clock::new(self.start_unix_nanos, self.start_time, self.rate_hz)
            .map_err(|error| fact(file, "rate_hz", "a positive number", &error.to_string()))
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
