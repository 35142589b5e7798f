//! A wide CSV as a recording.

use inhand_model::{
    BodyKind, Clock, Finding, LengthUnit, Marker, MarkerKind, Pose, Position, Recording,
    RotationOrder, Setting, Source, StartTime, Status, Track, TrackedBody, UpAxis,
};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use crate::error::{TableError, line_of, shown};
use crate::facts::{Facts, body_kind, fact, marker_kind};

/// Rotations off unit length by more than this are no rotations; tables may be rounded.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Times may be off the even clock by this share of a period.
const TIME_TOLERANCE: f64 = 0.1;

/// A line is no longer than this: a name and ten cells for each of many thousand entities.
const MAX_LINE_BYTES: usize = 16 << 20;

/// What a user may say of a table without facts beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WideSettings {
    /// Axis that points up; y where nothing is said, with a finding.
    pub up_axis: Option<UpAxis>,
}

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
/// [`facts_json`](crate::facts_json) makes it; without it the rate comes from the times, bodies are
/// what has a rotation, and the take starts at an unknown time.
///
/// # Errors
///
/// [`TableError::Cell`] with line and column, [`TableError::File`] where headings, times or facts do
/// not go together, [`TableError::Csv`] for lines of another length.
pub fn read_wide_csv(
    bytes: &[u8],
    file: &str,
    facts: Option<&[u8]>,
    settings: WideSettings,
) -> Result<Recording, TableError> {
    let facts = facts
        .map(|facts| Facts::parse(facts, &format!("{file}.json")))
        .transpose()?;
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = csv::Reader::from_reader(bytes);
    let headings = (reader.headers())
        .map_err(|error| TableError::csv(file, bytes, &error))?
        .clone();
    let mut columns = columns(file, &headings)?;
    let mut times_s = Vec::new();
    let mut row = csv::StringRecord::new();
    while (reader.read_record(&mut row)).map_err(|error| TableError::csv(file, bytes, &error))? {
        let cells = Cells {
            file,
            bytes,
            headings: &headings,
            row: &row,
        };
        let time_s = cells.number(0)?;
        times_s.push(time_s.ok_or_else(|| cells.error(0, "a time in seconds"))?);
        for column in &mut columns {
            column.push(&cells)?;
        }
    }
    let mut findings = Vec::new();
    let clock = match &facts {
        Some(facts) => facts.clock(&format!("{file}.json"))?,
        None => clock_of(file, &times_s)?,
    };
    check_times(file, &times_s, clock)?;
    let source = match &facts {
        Some(facts) => facts.source(&format!("{file}.json"))?,
        None => source_of(&columns, settings, &mut findings),
    };
    for column in &columns {
        findings.extend(column.finding());
    }
    let name = match &facts {
        Some(facts) => facts.name.clone(),
        None => file
            .rsplit_once('.')
            .map_or(file, |(stem, _)| stem)
            .to_owned(),
    };
    let (markers, bodies) = entities(file, columns, facts.as_ref())?;
    let samples = times_s.len();
    if let Some(facts) = &facts
        && facts.samples != samples
    {
        findings.push(Finding::warning(
            "",
            format!(
                "the facts beside the table state {} samples, it has {samples}",
                facts.samples
            ),
        ));
    }
    let mut recording =
        Recording::new(name, clock, source, samples, markers, bodies).map_err(|error| {
            TableError::File {
                file: file.to_owned(),
                expected: "columns of one length".to_owned(),
                found: error.to_string(),
                hint: "write the table again".to_owned(),
            }
        })?;
    recording.findings = findings;
    Ok(recording)
}

/// The cells of a row.
struct Cells<'a> {
    file: &'a str,
    bytes: &'a [u8],
    headings: &'a csv::StringRecord,
    row: &'a csv::StringRecord,
}

impl Cells<'_> {
    fn line(&self) -> u64 {
        (self.row.position()).map_or(0, |place| line_of(self.bytes, place))
    }

    fn text(&self, column: usize) -> &str {
        self.row.get(column).unwrap_or_default().trim()
    }

    /// The number of a cell; nothing where it is blank or says NaN.
    fn number(&self, column: usize) -> Result<Option<f64>, TableError> {
        let text = self.text(column);
        if text.is_empty() || text.eq_ignore_ascii_case("nan") {
            return Ok(None);
        }
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Some(number)),
            _ => Err(self.error(column, "a number, or a blank cell")),
        }
    }

    fn error(&self, column: usize, expected: &str) -> TableError {
        TableError::Cell {
            file: self.file.to_owned(),
            line: self.line(),
            column: column + 1,
            title: self.headings.get(column).unwrap_or_default().to_owned(),
            expected: expected.to_owned(),
            found: shown(self.text(column)),
        }
    }
}

/// The columns of one entity with what was read from them.
struct EntityColumns {
    name: String,
    position: [usize; 3],
    rotation: Option<[usize; 4]>,
    status: Option<usize>,
    quality: Option<(usize, Vec<f64>)>,
    marker_error: Option<(usize, Vec<f64>)>,
    samples: Samples,
    /// Samples of which only some coordinates are there, and the line of the first.
    partly: (usize, u64),
}

enum Samples {
    Points(Track<Position<inhand_model::World>>),
    Poses(Track<Pose<inhand_model::World, inhand_model::Body>>),
}

/// Columns by entity, in the order in which entities first appear.
fn columns(file: &str, headings: &csv::StringRecord) -> Result<Vec<EntityColumns>, TableError> {
    let find = |name: &str, suffix: &str| {
        headings.iter().position(|heading| {
            (heading.trim().rsplit_once('.')).is_some_and(|(n, s)| n == name && s == suffix)
        })
    };
    let mut entities: Vec<EntityColumns> = Vec::new();
    for heading in headings {
        let Some((name, "x_m")) = heading.trim().rsplit_once('.') else {
            continue;
        };
        let need = |suffix| {
            find(name, suffix).ok_or_else(|| TableError::File {
                file: file.to_owned(),
                expected: format!("a column \"{name}.{suffix}\" beside \"{name}.x_m\""),
                found: "none".to_owned(),
                hint: "keep all coordinates of an entity".to_owned(),
            })
        };
        let position = [need("x_m")?, need("y_m")?, need("z_m")?];
        if entities.iter().any(|e| e.position[0] == position[0]) {
            return Err(TableError::File {
                file: file.to_owned(),
                expected: "headings that differ".to_owned(),
                found: format!("\"{name}.x_m\" twice"),
                hint: "rename one of the entities".to_owned(),
            });
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
            quality: find(name, "quality").map(|column| (column, Vec::new())),
            marker_error: find(name, "marker_error_m").map(|column| (column, Vec::new())),
            samples: match rotation {
                None => Samples::Points(Track::missing(0)),
                Some(_) => Samples::Poses(Track::missing(0)),
            },
            partly: (0, 0),
        });
    }
    Ok(entities)
}

impl EntityColumns {
    fn push(&mut self, cells: &Cells<'_>) -> Result<(), TableError> {
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
                self.partly.1 = cells.line();
            }
            self.partly.0 += 1;
        }
        let status = self.status(cells, there == used)?;
        let [x, y, z, a, b, c, w] = numbers.map(|number| number.unwrap_or(f64::NAN));
        match &mut self.samples {
            Samples::Points(track) => {
                let present = status.is_present();
                track.push(present.then(|| Position::new(x, y, z)), status);
            }
            Samples::Poses(track) => {
                let quaternion = Quaternion::new(w, a, b, c);
                if status.is_present() && (quaternion.norm() - 1.0).abs() > UNIT_TOLERANCE {
                    return Err(cells.error(rotation[0], "a quaternion of unit length"));
                }
                // Normalising again would change its last digits.
                let rotation = UnitQuaternion::new_unchecked(quaternion);
                let pose = Isometry3::from_parts(Translation3::new(x, y, z), rotation);
                track.push(status.is_present().then(|| Pose::new(pose)), status);
            }
        }
        for series in [&mut self.quality, &mut self.marker_error]
            .into_iter()
            .flatten()
        {
            series.1.push(cells.number(series.0)?.unwrap_or(f64::NAN));
        }
        Ok(())
    }

    fn status(&self, cells: &Cells<'_>, whole: bool) -> Result<Status, TableError> {
        let Some(column) = self.status.filter(|&column| !cells.text(column).is_empty()) else {
            return Ok(if whole {
                Status::Measured
            } else {
                Status::Missing
            });
        };
        let word = cells.text(column);
        let status = [Status::Measured, Status::Filled, Status::Missing]
            .into_iter()
            .find(|status| status.name() == word)
            .ok_or_else(|| cells.error(column, "measured, filled or missing"))?;
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
fn clock_of(file: &str, times_s: &[f64]) -> Result<Clock, TableError> {
    let wrong = |found: String| TableError::File {
        file: file.to_owned(),
        expected: "rising, evenly spaced times in column time_s".to_owned(),
        found,
        hint: format!("state rate_hz in {file}.json, as inhand export writes it"),
    };
    let (Some(first), Some(last)) = (times_s.first(), times_s.last()) else {
        return Err(wrong("no row".to_owned()));
    };
    let rate_hz = (times_s.len() - 1) as f64 / (last - first);
    // Times in a table are rounded; a rate is hardly ever off a round number by a millionth.
    let round = (rate_hz * 1e3).round() / 1e3;
    let rate_hz = if (rate_hz - round).abs() < 1e-6 * rate_hz {
        round
    } else {
        rate_hz
    };
    Clock::new(0, StartTime::Unknown, rate_hz)
        .map_err(|_| wrong(format!("{} rows from {first} s to {last} s", times_s.len())))
}

/// Every row is where the clock says, seen from the first one.
fn check_times(file: &str, times_s: &[f64], clock: Clock) -> Result<(), TableError> {
    let first = times_s.first().copied().unwrap_or_default();
    let off = |(row, time_s): (usize, &f64)| {
        let expected = first + clock.time_s(row);
        let tolerance = TIME_TOLERANCE / clock.rate_hz();
        ((time_s - expected).abs() > tolerance).then_some((row, *time_s, expected))
    };
    match times_s.iter().enumerate().find_map(off) {
        None => Ok(()),
        Some((row, time_s, expected)) => Err(TableError::File {
            file: file.to_owned(),
            expected: format!("{expected} s in row {} at {} Hz", row + 1, clock.rate_hz()),
            found: format!("{time_s} s"),
            hint: "a table has a row for every sample; leave rows of missing samples blank, but \
                   keep them"
                .to_owned(),
        }),
    }
}

fn source_of(
    columns: &[EntityColumns],
    settings: WideSettings,
    findings: &mut Vec<Finding>,
) -> Source {
    let up_axis = settings.up_axis.unwrap_or_else(|| {
        findings.push(Finding::info(
            "",
            format!(
                "no facts are beside the table, so y is taken to point up; say it with {}",
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
    file: &str,
    columns: Vec<EntityColumns>,
    facts: Option<&Facts>,
) -> Result<Entities, TableError> {
    let (mut markers, mut bodies) = (Vec::new(), Vec::new());
    for column in columns {
        let stated = facts.and_then(|facts| {
            let mut entities = facts.entities.iter();
            entities.find(|entity| entity.columns == column.name)
        });
        let (name, id) = match stated {
            Some(stated) => (stated.name.clone(), stated.id.clone()),
            None => (column.name.clone(), String::new()),
        };
        let wrong = |expected: &str, found: &str| {
            let key = format!("entities: kind of {}", column.name);
            fact(&format!("{file}.json"), &key, expected, found)
        };
        match column.samples {
            Samples::Points(track) => markers.push(Marker {
                name,
                id,
                kind: match stated {
                    None => MarkerKind::Labelled,
                    Some(stated) => marker_kind(&stated.kind)
                        .ok_or_else(|| wrong("a kind of marker", &stated.kind))?,
                },
                track,
                quality: column.quality.map(|(_, series)| series),
            }),
            Samples::Poses(track) => bodies.push(TrackedBody {
                name,
                id,
                kind: match stated {
                    None => BodyKind::RigidBody,
                    Some(stated) => body_kind(&stated.kind)
                        .ok_or_else(|| wrong("a kind of body", &stated.kind))?,
                },
                track,
                marker_error_m: column.marker_error.map(|(_, series)| series),
            }),
        }
    }
    Ok((markers, bodies))
}
