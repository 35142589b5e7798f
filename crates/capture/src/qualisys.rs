//! TSV files of Qualisys Track Manager (QTM): three-dimensional marker data.
//!
//! A file is lines of a key and its values, then, where the export writes them, a row of column
//! names (`Frame`, `Time`, `thumb_tip X`, ...), then one row for each frame.
//!
//! # Conventions
//!
//! * **Lengths** are millimetres in every export and become metres.
//! * **Time** of a sample is `(frame - first frame) / FREQUENCY` after `TIME_STAMP`, which has no
//!   zone and is taken as UTC. Frame and time columns are optional.
//! * **Missing** samples are blank cells, `nan`, or, in exports that write nulls as zeros, a marker
//!   exactly at the origin in all three coordinates: no measurement comes out as three zeros to a
//!   micrometre, so that is taken as missing and counted in a finding.
//! * **Up** is Z unless the user says otherwise; the file does not state it.
//! * `TRAJECTORY_TYPES` other than `Measured` mean that QTM filled samples of a marker without
//!   saying which: they read as measured, with a finding.

use std::collections::BTreeMap;

use inhand_model::{Finding, LengthUnit, MarkerKind, Recording, Source, StartTime, UpAxis};

use crate::assembly::{self, Entity, Opened, Take};
use crate::error::CaptureError;
use crate::settings::ReadSettings;
use crate::table::{Column, Table};
use crate::{start_time, text};

/// Keys with which a header may start.
const KEYS: [&[u8]; 6] = [
    b"FILE_VERSION",
    b"NO_OF_FRAMES",
    b"NO_OF_CAMERAS",
    b"NO_OF_MARKERS",
    b"FREQUENCY",
    b"DATA_INCLUDED",
];

/// Most lines of a header; every event of a recording adds one.
const MAX_HEADER_LINES: usize = 10_000;

/// Whether the bytes start as a QTM header does.
pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    KEYS.iter().any(|key| {
        bytes
            .strip_prefix(*key)
            .is_some_and(|rest| rest.starts_with(b"\t"))
    })
}

/// Reads a Qualisys TSV file.
///
/// # Errors
///
/// [`CaptureError`] where it is no such file, holds other data than positions, its header is cut,
/// or a row is damaged.
pub fn read(
    bytes: &[u8],
    file_name: &str,
    settings: &ReadSettings,
) -> Result<Recording, CaptureError> {
    assembly::read_text(open, bytes, file_name, settings)
}

/// Reads the header, from the beginning of a file without byte-order mark.
pub(crate) fn open(
    bytes: &[u8],
    file_name: &str,
    settings: &ReadSettings,
) -> Result<Opened, CaptureError> {
    if !looks_like(bytes) {
        return Err(CaptureError::UnknownFormat {
            file: file_name.to_owned(),
            found: text::beginning(bytes),
        });
    }
    let header = Header::parse(bytes, file_name)?;
    let included = header.fact("DATA_INCLUDED").unwrap_or("3D");
    if included != "3D" {
        return Err(CaptureError::UnsupportedFormat {
            file: file_name.to_owned(),
            found: format!("a Qualisys TSV of {included} data"),
            hint: "export the 3D data",
        });
    }
    let length_unit = settings.settle_length_unit(file_name, Some(LengthUnit::Millimetres))?;
    let start = start_time::parse(
        "TIME_STAMP",
        header
            .fact("TIME_STAMP")
            .and_then(|stamp| stamp.split('\t').next()),
    );
    let clock = start.clock(header.rate_hz(file_name)?, file_name)?;
    let mut findings = header.findings();
    // QTM counts hours from 0 to 23, so only an unreadable time is odd.
    findings.extend(start.finding.filter(|_| start.known == StartTime::Unknown));

    let layout = header.layout(bytes, file_name)?;
    let table = Table {
        file: file_name.to_owned(),
        delimiter: b'\t',
        columns: layout.columns,
        labels: layout.labels,
        may_end_after: None,
    };
    let entities = layout
        .marker_names
        .into_iter()
        .enumerate()
        .map(|(m, name)| Entity::Marker {
            kind: if name.is_empty() {
                MarkerKind::Unlabelled
            } else {
                MarkerKind::Labelled
            },
            name,
            id: String::new(),
            position: [3 * m, 3 * m + 1, 3 * m + 2],
            quality: None,
        })
        .collect();
    const ROWS: &str = "NO_OF_FRAMES";
    let declared_rows = assembly::declared_rows(ROWS, header.fact(ROWS), &mut findings);
    let version = header.fact("FILE_VERSION").unwrap_or_default();
    Ok(Opened {
        table,
        data_start: header.data_start,
        first_data_line: header.first_data_line,
        take: Take {
            name: text::stem(file_name).to_owned(),
            clock,
            source: Source {
                format: format!("Qualisys TSV {version}").trim_end().to_owned(),
                length_unit: length_unit.unwrap_or(LengthUnit::Millimetres),
                up_axis: settings.up_axis.unwrap_or(UpAxis::Z),
                rotation: None,
                header: header.facts,
            },
            entities,
            zero_is_missing: true,
            declared_rows,
            findings,
        },
    })
}

/// Columns that may stand before those of the markers.
const FRAME_AND_TIME: [(&str, Column); 2] = [("Frame", Column::Frame), ("Time", Column::Time)];

/// What the columns hold, what messages call them, and the markers in their order.
#[derive(Debug, Default)]
struct Layout {
    columns: Vec<Column>,
    labels: Vec<String>,
    marker_names: Vec<String>,
}

impl Layout {
    fn push_marker(&mut self, name: &str) {
        for axis in ["X", "Y", "Z"] {
            self.columns.push(Column::Value);
            self.labels.push(format!("\"{name}\" {axis}"));
        }
        self.marker_names.push(name.to_owned());
    }
}

/// What stands above the rows of data.
#[derive(Debug, Default)]
struct Header {
    facts: BTreeMap<String, String>,
    marker_names: Vec<String>,
    /// Line of `MARKER_NAMES`, from 1; 0 where there is none.
    names_line: usize,
    /// The row of column names, where the export wrote one, and its line.
    column_names: Option<(usize, Vec<String>)>,
    data_start: usize,
    first_data_line: usize,
}

impl Header {
    fn parse(bytes: &[u8], file: &str) -> Result<Self, CaptureError> {
        let mut header = Self::default();
        let mut repeats = BTreeMap::new();
        let mut start = 0;
        for number in 1..=MAX_HEADER_LINES {
            let end = memchr::memchr(b'\n', &bytes[start..])
                .map_or(bytes.len(), |length| start + length + 1);
            if start == bytes.len() || is_numbers(&bytes[start..end]) {
                header.data_start = start;
                header.first_data_line = number;
                return Ok(header);
            }
            let line = text::header_text(&bytes[start..end], number, file)?;
            let line = line.trim_end_matches(['\r', '\n']);
            start = end;
            let mut cells = line.split('\t');
            let key = cells.next().unwrap_or_default();
            if key == "MARKER_NAMES" {
                header.marker_names = without_trailing_blank(cells);
                header.names_line = number;
            } else if key == "Frame" || key.ends_with(" X") {
                header.column_names = Some((number, without_trailing_blank(line.split('\t'))));
                header.data_start = end;
                header.first_data_line = number + 1;
                return Ok(header);
            } else if !key.trim().is_empty() {
                let value = line.get(key.len() + 1..).unwrap_or_default();
                // Each event has a line of its own under the same key.
                let count = repeats.entry(key.to_owned()).or_insert(0_usize);
                *count += 1;
                let unique = match *count {
                    1 => key.to_owned(),
                    count => format!("{key} {count}"),
                };
                header.facts.insert(unique, value.to_owned());
            }
        }
        Err(CaptureError::Header {
            file: file.to_owned(),
            line: MAX_HEADER_LINES,
            expected: "rows of numbers".to_owned(),
            found: "header lines only".to_owned(),
            hint: "is this a Qualisys export?",
        })
    }

    fn fact(&self, key: &str) -> Option<&str> {
        self.facts.get(key).map(|value| value.trim())
    }

    fn rate_hz(&self, file: &str) -> Result<f64, CaptureError> {
        const KEY: &str = "FREQUENCY";
        self.fact(KEY)
            .and_then(|rate| rate.parse().ok())
            .filter(|rate: &f64| rate.is_finite() && *rate > 0.0)
            .ok_or_else(|| CaptureError::HeaderValue {
                file: file.to_owned(),
                line: 1,
                key: KEY,
                expected: "a rate in Hz, such as 100",
                found: self
                    .fact(KEY)
                    .map_or("missing".to_owned(), |value| format!("\"{value}\"")),
            })
    }

    fn findings(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        if let Some(declared) = self.fact("NO_OF_MARKERS").and_then(|n| n.parse().ok())
            && self.names_line > 0
            && self.marker_names.len() != declared
        {
            findings.push(Finding::warning(
                "NO_OF_MARKERS",
                format!(
                    "the header promises {declared} markers and names {}: read those it names",
                    self.marker_names.len()
                ),
            ));
        }
        if let Some(types) = self.fact("TRAJECTORY_TYPES") {
            let filled: Vec<&str> = (self.marker_names.iter())
                .zip(types.split('\t'))
                .filter(|(_, kind)| !kind.is_empty() && *kind != "Measured")
                .map(|(name, _)| name.as_str())
                .collect();
            if !filled.is_empty() {
                findings.push(Finding::info(
                    "TRAJECTORY_TYPES",
                    format!(
                        "the capture software filled samples of {}; the file does not say which, \
                         so they count as measured",
                        filled.join(", ")
                    ),
                ));
            }
        }
        findings
    }

    fn layout(&self, bytes: &[u8], file: &str) -> Result<Layout, CaptureError> {
        match &self.column_names {
            Some((line, names)) => layout_by_name(names, *line, file),
            None => self.layout_by_count(bytes, file),
        }
    }

    /// Without column names the number of cells tells whether frame and time stand first.
    fn layout_by_count(&self, bytes: &[u8], file: &str) -> Result<Layout, CaptureError> {
        let error = |line, expected: String, found: String| CaptureError::Header {
            file: file.to_owned(),
            line,
            expected,
            found,
            hint: "the header is cut; export the take again",
        };
        if self.names_line == 0 {
            let at = self.first_data_line;
            return Err(error(
                at,
                "MARKER_NAMES".to_owned(),
                "no such line".to_owned(),
            ));
        }
        let row = bytes[self.data_start..]
            .split(|&byte| byte == b'\n')
            .next()
            .unwrap_or_default();
        let row = row.strip_suffix(b"\r").unwrap_or(row);
        let cells = memchr::memchr_iter(b'\t', row).count() + 1;
        let coordinates = 3 * self.marker_names.len();
        // A tab may end the row.
        let ends_with_tab = row.ends_with(b"\t");
        let fits = |leading| {
            cells == coordinates + leading || (ends_with_tab && cells == coordinates + leading + 1)
        };
        let leading = if fits(2) {
            2
        } else if fits(0) || row.is_empty() {
            0
        } else {
            return Err(error(
                self.first_data_line,
                format!(
                    "{coordinates} cells for {} markers, or two more with frame and time",
                    self.marker_names.len()
                ),
                format!("{cells}"),
            ));
        };
        let mut layout = Layout::default();
        for (label, column) in FRAME_AND_TIME.into_iter().take(leading) {
            layout.columns.push(column);
            layout.labels.push(label.to_owned());
        }
        for name in &self.marker_names {
            layout.push_marker(name);
        }
        Ok(layout)
    }
}

fn layout_by_name(names: &[String], line: usize, file: &str) -> Result<Layout, CaptureError> {
    let mut layout = Layout::default();
    let mut rest = names;
    for (label, column) in FRAME_AND_TIME {
        if let [first, more @ ..] = rest
            && first == label
        {
            layout.columns.push(column);
            layout.labels.push(label.to_owned());
            rest = more;
        }
    }
    while !rest.is_empty() {
        let marker = match rest {
            [x, y, z, ..] => x.strip_suffix(" X").filter(|&marker| {
                y.strip_suffix(" Y") == Some(marker) && z.strip_suffix(" Z") == Some(marker)
            }),
            _ => None,
        };
        let Some(marker) = marker else {
            return Err(CaptureError::Header {
                file: file.to_owned(),
                line,
                expected: format!(
                    "the X, Y and Z of a marker from column {} on",
                    layout.columns.len() + 1
                ),
                found: format!("{:?}", &rest[..rest.len().min(3)]),
                hint: "the header is cut; export the take again",
            });
        };
        layout.push_marker(marker);
        rest = &rest[3..];
    }
    Ok(layout)
}

/// Whether a line is a row of data: it starts with a number, or with blank cells before one.
fn is_numbers(line: &[u8]) -> bool {
    let start = line.trim_ascii_start();
    start
        .first()
        .is_some_and(|&byte| byte == b'-' || byte.is_ascii_digit())
        || start
            .get(..4)
            .is_some_and(|cell| cell.eq_ignore_ascii_case(b"nan\t"))
}

/// The cells, without the blank one behind a tab at the end of the line.
fn without_trailing_blank<'a>(cells: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut cells: Vec<String> = cells.map(str::to_owned).collect();
    if cells.last().is_some_and(|cell| cell.trim().is_empty()) {
        cells.pop();
    }
    cells
}
