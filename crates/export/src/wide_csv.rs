//! A wide CSV as a recording, and the JSON beside it: facts that its columns cannot hold.

use std::collections::BTreeMap;

use inhand_model::{
    BodyKind, Clock, Finding, LengthUnit, Marker, MarkerKind, PointTrack, Pose, PoseTrack,
    Position, Recording, RotationOrder, Setting, Source, StartTime, Status, TrackedBody, UpAxis,
    unguarded,
};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

use crate::error::{CsvFile, ExportError, shown};
use crate::take::{recording_entities, unique_names};

/// Rotations off unit length by more than this are no rotations; tables may be rounded.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Times may be off the even clock by this share of a period.
const TIME_TOLERANCE: f64 = 0.1;

/// A line is no longer than this: a name and ten cells for each of many thousand entities.
const MAX_LINE_BYTES: usize = 16 << 20;

/// Whether bytes start as a wide table does: its first column is `time_s` and another one ends in
/// `.x_m`.
pub fn looks_like_wide_csv(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(MAX_LINE_BYTES)];
    let line = head.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
    let first = line.split(|&byte| byte == b',').next().unwrap_or_default();
    let first = first.strip_suffix(b"\r").unwrap_or(first);
    first.trim_ascii() == b"time_s" && line.windows(4).any(|part| part == b".x_m")
}

/// Reads a wide table, as [`wide`](crate::wide) and [`write_csv`](crate::write_csv) make them, as a
/// recording. `facts` is the content of the JSON beside it, as
/// [`facts_json`] makes it; without it the rate comes from the times, entities with a
/// rotation are bodies, the take starts at an unknown time, and `up_axis` points up (y where it is not said,
/// with a finding).
///
/// # Errors
///
/// [`ExportError::Content`] with line and column for cells, and where headings, times or facts do not go
/// together.
pub fn read_wide_csv(
    bytes: &[u8],
    file: &str,
    facts: Option<&[u8]>,
    up_axis: Option<UpAxis>,
) -> Result<Recording, ExportError> {
    let facts_file = format!("{file}.json");
    let facts = (facts.map(|facts| Facts::parse(facts, &facts_file))).transpose()?;
    let csv = CsvFile::new(file, bytes);
    let mut reader = csv::Reader::from_reader(csv.bytes);
    let headings: csv::StringRecord = (reader.headers())
        .map_err(|error| csv.csv_error(&error))?
        .iter()
        .map(|heading| unguarded(heading.trim()))
        .collect();
    let mut columns = columns(file, &headings)?;
    let mut times_s = Vec::new();
    let mut row = csv::StringRecord::new();
    while (reader.read_record(&mut row)).map_err(|error| csv.csv_error(&error))? {
        let cells = Cells {
            csv,
            headings: &headings,
            row: &row,
        };
        let time_s = cells.number(0)?;
        times_s.push(time_s.ok_or_else(|| cells.error(0, "a time in seconds"))?);
        for column in &mut columns {
            column.push(&cells)?;
        }
    }
    let samples = times_s.len();
    let mut findings = Vec::new();
    let clock = match &facts {
        Some(facts) => facts.clock(&facts_file)?,
        None => clock_of(file, &times_s)?,
    };
    check_times(file, &times_s, clock)?;
    let (name, source) = match &facts {
        Some(facts) => (facts.name.as_str(), facts.source.clone()),
        None => {
            let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
            (stem, source_of(&columns, up_axis, &mut findings))
        }
    };
    findings.extend(columns.iter().filter_map(EntityColumns::finding));
    if let Some(stated) = (facts.as_ref().map(|facts| facts.samples)).filter(|&n| n != samples) {
        let message =
            format!("the facts beside the table state {stated} samples, it has {samples}");
        findings.push(Finding::warning("", message));
    }
    let (markers, bodies) = entities(&facts_file, columns, facts.as_ref())?;
    let mut recording = Recording::new(name.to_owned(), clock, source, samples, markers, bodies)
        .map_err(|error| {
            ExportError::file(
                file,
                "columns of one length",
                error,
                "write the table again",
            )
        })?;
    recording.findings = findings;
    Ok(recording)
}

/// The cells of a row.
struct Cells<'a> {
    csv: CsvFile<'a>,
    headings: &'a csv::StringRecord,
    row: &'a csv::StringRecord,
}

impl Cells<'_> {
    fn text(&self, column: usize) -> &str {
        self.row.get(column).unwrap_or_default().trim()
    }

    /// The number of a cell; nothing where it is blank or says NaN.
    fn number(&self, column: usize) -> Result<Option<f64>, ExportError> {
        let text = self.text(column);
        if text.is_empty() || text.eq_ignore_ascii_case("nan") {
            return Ok(None);
        }
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Some(number)),
            _ => Err(self.error(column, "a number, or a blank cell")),
        }
    }

    fn error(&self, column: usize, expected: &str) -> ExportError {
        let title = self.headings.get(column).unwrap_or_default();
        self.csv.cell_error(self.row, column, title, expected)
    }
}

/// The columns of one entity and its samples so far.
struct EntityColumns {
    name: String,
    position: [usize; 3],
    rotation: Option<[usize; 4]>,
    status: Option<usize>,
    /// Quality of a marker, error of a body.
    extra: Option<(usize, Vec<f64>)>,
    /// Position, then rotation; NaN where missing.
    samples: Vec<([f64; 7], Status)>,
    /// Samples of which only some coordinates are there, and the line of the first.
    partly: (usize, u64),
}

/// Columns by entity, in the order in which entities first appear.
fn columns(file: &str, headings: &csv::StringRecord) -> Result<Vec<EntityColumns>, ExportError> {
    // The first of each name and suffix.
    let mut places = BTreeMap::new();
    for (place, heading) in headings.iter().enumerate() {
        if let Some(parts) = heading.rsplit_once('.') {
            places.entry(parts).or_insert(place);
        }
    }
    let find = |name, suffix| places.get(&(name, suffix)).copied();
    let mut entities: Vec<EntityColumns> = Vec::new();
    for (place, heading) in headings.iter().enumerate() {
        let Some((name, "x_m")) = heading.rsplit_once('.') else {
            continue;
        };
        let need = |suffix| {
            find(name, suffix).ok_or_else(|| {
                let expected = format!("a column \"{name}.{suffix}\" beside \"{name}.x_m\"");
                ExportError::file(file, expected, "none", "keep all coordinates of an entity")
            })
        };
        let position = [need("x_m")?, need("y_m")?, need("z_m")?];
        if position[0] != place {
            let (expected, twice) = ("headings that differ", format!("\"{name}.x_m\" twice"));
            return Err(ExportError::file(
                file,
                expected,
                twice,
                "rename one of the entities",
            ));
        }
        let rotation = match find(name, "qx") {
            None => None,
            Some(qx) => Some([qx, need("qy")?, need("qz")?, need("qw")?]),
        };
        entities.push(EntityColumns {
            name: name.to_owned(),
            position,
            rotation,
            status: find(name, "status"),
            extra: match rotation {
                None => find(name, "quality"),
                Some(_) => find(name, "marker_error_m"),
            }
            .map(|column| (column, Vec::new())),
            samples: Vec::new(),
            partly: (0, 0),
        });
    }
    Ok(entities)
}

impl EntityColumns {
    fn push(&mut self, cells: &Cells<'_>) -> Result<(), ExportError> {
        let mut numbers = [None; 7];
        let rotation = self.rotation.unwrap_or_default();
        let used = if self.rotation.is_some() { 7 } else { 3 };
        let columns = self.position.iter().chain(&rotation).take(used);
        for (number, &column) in numbers.iter_mut().zip(columns) {
            *number = cells.number(column)?;
        }
        let there = numbers[..used].iter().flatten().count();
        if there > 0 && there < used {
            if self.partly.0 == 0 {
                self.partly.1 = cells
                    .row
                    .position()
                    .map_or(0, |place| cells.csv.line(place));
            }
            self.partly.0 += 1;
        }
        let status = self.status(cells, there == used)?;
        let numbers = numbers.map(|number| number.unwrap_or(f64::NAN));
        let norm: f64 = numbers[3..].iter().map(|v| v * v).sum::<f64>().sqrt();
        if self.rotation.is_some() && status.is_present() && (norm - 1.0).abs() > UNIT_TOLERANCE {
            return Err(cells.error(rotation[0], "a quaternion of unit length"));
        }
        self.samples.push((numbers, status));
        if let Some((column, series)) = &mut self.extra {
            series.push(cells.number(*column)?.unwrap_or(f64::NAN));
        }
        Ok(())
    }

    fn status(&self, cells: &Cells<'_>, whole: bool) -> Result<Status, ExportError> {
        let stated = self.status.map(|column| (column, cells.text(column)));
        let status = match stated {
            None | Some((_, "")) => Status::Measured,
            Some((column, word)) => Status::from_name(word)
                .ok_or_else(|| cells.error(column, "measured, filled or missing"))?,
        };
        Ok(if whole { status } else { Status::Missing })
    }

    fn finding(&self) -> Option<Finding> {
        let (count, line) = self.partly;
        (count > 0).then(|| {
            Finding::warning(
                self.name.clone(),
                format!(
                    "{count} samples have some of their coordinates only, the first in line \
                     {line}; they are missing now"
                ),
            )
        })
    }
}

/// The clock of evenly spaced times.
fn clock_of(file: &str, times_s: &[f64]) -> Result<Clock, ExportError> {
    let wrong = |found: &str| {
        let expected = "rising, evenly spaced times in column time_s";
        let hint = format!("state rate_hz in {file}.json, as inhand export writes it");
        ExportError::file(file, expected, found, &hint)
    };
    let (Some(first), Some(last)) = (times_s.first(), times_s.last()) else {
        return Err(wrong("no row"));
    };
    let rate_hz = (times_s.len() - 1) as f64 / (last - first);
    // Times in a table are rounded; a rate is hardly ever off a round number by a millionth.
    let round = (rate_hz * 1e3).round() / 1e3;
    let rate_hz = if (rate_hz - round).abs() < 1e-6 * rate_hz {
        round
    } else {
        rate_hz
    };
    Clock::new(0, StartTime::Unknown, rate_hz).map_err(|_| {
        wrong(&format!(
            "{} rows from {first} s to {last} s",
            times_s.len()
        ))
    })
}

/// Refuses rows that are not at the times of the clock, counted from the first one.
fn check_times(file: &str, times_s: &[f64], clock: Clock) -> Result<(), ExportError> {
    let first = times_s.first().copied().unwrap_or_default();
    let off = |(row, time_s): (usize, &f64)| {
        let expected = first + clock.time_s(row);
        let tolerance = TIME_TOLERANCE / clock.rate_hz();
        ((time_s - expected).abs() > tolerance).then_some((row, *time_s, expected))
    };
    match times_s.iter().enumerate().find_map(off) {
        None => Ok(()),
        Some((row, time_s, expected)) => Err(ExportError::file(
            file,
            format!("{expected} s in row {} at {} Hz", row + 1, clock.rate_hz()),
            format!("{time_s} s"),
            "a table has a row for every sample; leave rows of missing samples blank, but keep \
             them",
        )),
    }
}

fn source_of(
    columns: &[EntityColumns],
    up_axis: Option<UpAxis>,
    findings: &mut Vec<Finding>,
) -> Source {
    let up_axis = up_axis.unwrap_or_else(|| {
        findings.push(Finding::info(
            "",
            format!(
                "no facts are beside the table, so y is taken to point up; set it with {}",
                Setting::Up
            ),
        ));
        UpAxis::Y
    });
    Source {
        format: "wide CSV".to_owned(),
        length_unit: LengthUnit::Metres,
        up_axis,
        rotation: (columns.iter())
            .any(|column| column.rotation.is_some())
            .then_some(RotationOrder::Quaternion),
        header: Default::default(),
    }
}

type Entities = (Vec<Marker>, Vec<TrackedBody>);

fn entities(
    facts_file: &str,
    columns: Vec<EntityColumns>,
    facts: Option<&Facts>,
) -> Result<Entities, ExportError> {
    let (mut markers, mut bodies) = (Vec::new(), Vec::new());
    // Of several with one name the first counts.
    let all = facts.iter().flat_map(|facts| facts.entities.iter().rev());
    let all: BTreeMap<_, _> = all
        .map(|entity| (entity.columns.as_str(), entity))
        .collect();
    for column in columns {
        let stated = all.get(column.name.as_str());
        let (name, id) = match stated {
            Some(stated) => (stated.name.clone(), stated.id.clone()),
            None => (column.name.clone(), String::new()),
        };
        let kind = stated.map(|stated| stated.kind.as_str());
        let wrong = |expected| {
            let key = format!("entities: kind of {}", column.name);
            fact(facts_file, &key, expected, kind.unwrap_or_default())
        };
        let (_, extra) = column.extra.unzip();
        let samples = column.samples.into_iter();
        if column.rotation.is_none() {
            let mut track = PointTrack::missing(0);
            for ([x, y, z, ..], status) in samples {
                let position = Position::new(x, y, z);
                track.push(status.is_present().then_some(position), status);
            }
            markers.push(Marker {
                name,
                id,
                kind: MarkerKind::from_name(kind.unwrap_or(MarkerKind::Labelled.name()))
                    .ok_or_else(|| wrong("a kind of marker"))?,
                track,
                quality: extra,
            });
        } else {
            let mut track = PoseTrack::missing(0);
            for ([x, y, z, a, b, c, w], status) in samples {
                // Normalising again would change its last digits.
                let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, a, b, c));
                let pose = Isometry3::from_parts(Translation3::new(x, y, z), rotation);
                track.push(status.is_present().then(|| Pose::new(pose)), status);
            }
            bodies.push(TrackedBody {
                name,
                id,
                kind: BodyKind::from_name(kind.unwrap_or(BodyKind::RigidBody.name()))
                    .ok_or_else(|| wrong("a kind of body"))?,
                track,
                marker_error_m: extra,
            });
        }
    }
    Ok((markers, bodies))
}

/// Version of the file; raised when a key changes its meaning.
const FACTS_VERSION: u32 = 1;

/// Facts of a recording beside its wide table.
#[derive(Debug, Serialize, Deserialize)]
struct Facts {
    /// Version of the file.
    inhand_table: u32,
    name: String,
    samples: usize,
    rate_hz: f64,
    start_unix_nanos: u64,
    start_time: StartTime,
    source: Source,
    /// Bodies, then markers, in the order of the columns.
    entities: Vec<EntityFacts>,
    /// Unit of each kind of column, for readers who do not know the names.
    units: BTreeMap<String, String>,
}

#[derive(Debug, Serialize, Deserialize)]
struct EntityFacts {
    /// Prefix of its columns.
    columns: String,
    name: String,
    id: String,
    kind: String,
}

/// Facts of a recording that a wide table cannot hold, as JSON: clock, source, names and kinds. Written
/// beside the table as `<table>.json`, it lets [`read_wide_csv`] give the
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
        inhand_table: FACTS_VERSION,
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

const FACTS_HINT: &str = "write it again with inhand export, or remove it to read the table alone";

impl Facts {
    fn parse(text: &[u8], file: &str) -> Result<Self, ExportError> {
        let wrong = |found: &str| {
            let expected = format!("the facts of a table, version {FACTS_VERSION}");
            ExportError::file(file, expected, found, FACTS_HINT)
        };
        let facts: Facts =
            serde_json::from_slice(text).map_err(|error| wrong(&error.to_string()))?;
        match facts.inhand_table {
            FACTS_VERSION => Ok(facts),
            other => Err(wrong(&format!("version {other}"))),
        }
    }

    fn clock(&self, file: &str) -> Result<Clock, ExportError> {
        Clock::new(self.start_unix_nanos, self.start_time, self.rate_hz)
            .map_err(|error| fact(file, "rate_hz", "a positive number", &error.to_string()))
    }
}

fn fact(file: &str, key: &str, expected: &str, found: &str) -> ExportError {
    ExportError::file(
        file,
        format!("\"{key}\" to be {expected}"),
        shown(found),
        FACTS_HINT,
    )
}
