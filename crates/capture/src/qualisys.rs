//! TSV files of Qualisys Track Manager (QTM): three-dimensional marker data.
//!
//! A file is lines of a key and its values, then, where the export writes them, a row of column
//! names (`Frame`, `Time`, `thumb_tip X`, ...), then one row for each frame.
//!
//! # Conventions
//!
//! * **Lengths** are millimetres in every export and become metres.
//! * **Time** of a sample is `(frame - 1) / FREQUENCY` after `TIME_STAMP`, which has no zone and is taken
//!   as UTC. Frame and time columns are optional; without them the first row is at `TIME_STAMP`.
//! * **Events** are the lines `EVENT`: name, frame and time in seconds.
//! * **Missing** samples are blank cells, `nan`, or, in exports that write nulls as zeros, a marker
//!   exactly at the origin in all three coordinates: no measurement comes out as three zeros to a
//!   micrometre, so that is taken as missing and counted in a finding.
//! * **Up** is Z unless the user says otherwise; the file does not state it.
//! * `TRAJECTORY_TYPES` other than `Measured` mean that QTM filled samples of a marker without
//!   saying which: they read as measured, with a finding.

use std::collections::BTreeMap;

use inhand_model::{Finding, LengthUnit, Setting, Source, StartTime, UpAxis};

use crate::assembly::Series;
use crate::error::CaptureError;
use crate::header::{Facts, HeaderLines, Opened, add_markers};
use crate::settings::{ReadSettings, settle};
use crate::start_time;
use crate::table::{Column, Table, cell_number};
use crate::text::cells;
use crate::trial::{TrialEvent, labels};

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

/// Columns that may come before those of the markers.
const FRAME_AND_TIME: [(&str, Column); 2] = [("Frame", Column::Frame), ("Time", Column::Time)];

/// Whether the bytes start as a QTM header does.
pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    let mut behind = KEYS.iter().filter_map(|key| bytes.strip_prefix(*key));
    behind.any(|rest| rest.first().is_none_or(|byte| b"\t\r\n".contains(byte)))
}

/// Reads the header, from the beginning of a file without byte-order mark.
pub(crate) fn open(
    bytes: &[u8],
    file: &str,
    settings: &ReadSettings,
) -> Result<Opened, CaptureError> {
    let mut lines = HeaderLines::new(bytes, file);
    let header = Header::parse(&mut lines, file)?;
    let facts = &header.facts;
    let included = facts.get("DATA_INCLUDED").unwrap_or("3D");
    if included != "3D" {
        let found = format_args!("a Qualisys TSV of {included} data");
        return Err(CaptureError::unsupported(file, found, "export the 3D data"));
    }
    let length_unit = LengthUnit::Millimetres;
    let (unit, given) = (Some(length_unit), settings.length_unit);
    settle(file, Setting::Units, unit, given, LengthUnit::name)?;
    let stamp = facts
        .get("TIME_STAMP")
        .and_then(|stamp| stamp.split('\t').next());
    let start = start_time::parse("TIME_STAMP", stamp);
    let rate_hz = facts.rate_hz("FREQUENCY", "a rate in Hz, such as 100")?;
    let clock = start.clock(rate_hz, file)?;
    let mut findings = header.findings();
    // QTM counts hours from 0 to 23, so only an unreadable time is odd.
    findings.extend(start.finding.filter(|_| start.known == StartTime::Unknown));
    let events = header.events(rate_hz, &mut findings);
    let (table, series) = header.columns(&lines, file)?;
    let declared_rows = facts.count("NO_OF_FRAMES", &mut findings);
    let version = facts.get("FILE_VERSION").unwrap_or_default();
    let source = Source {
        format: format!("Qualisys TSV {version}").trim_end().to_owned(),
        length_unit,
        up_axis: settings.up_axis.unwrap_or(UpAxis::Z),
        rotation: None,
        header: header.facts.by_key,
    };
    let mut opened = lines.opened(table, series, clock, source, declared_rows, findings);
    opened.take.events = events;
    Ok(opened)
}

/// Everything above the rows of data.
struct Header<'a> {
    facts: Facts<'a>,
    /// The names in the line `MARKER_NAMES`, where there is one.
    marker_names: Option<Vec<&'a str>>,
    /// The row of column names, where the export wrote one.
    column_names: Option<Vec<&'a str>>,
    /// Name, frame and time of each event.
    events: Vec<Vec<&'a str>>,
}

impl<'a> Header<'a> {
    fn parse(lines: &mut HeaderLines<'a>, file: &'a str) -> Result<Self, CaptureError> {
        let mut header = Self {
            facts: Facts {
                file,
                line: 1,
                by_key: BTreeMap::new(),
            },
            marker_names: None,
            column_names: None,
            events: Vec::new(),
        };
        let mut repeats = BTreeMap::new();
        while !lines.peek().is_empty() && !is_numbers(lines.peek()) {
            if lines.number == MAX_HEADER_LINES {
                return Err(lines.error("rows of numbers", "header lines only"));
            }
            let line = lines.next_line()?.unwrap_or_default();
            let cells = cells(line);
            let (&key, values) = cells.split_first().unwrap_or((&"", &[]));
            if key == "MARKER_NAMES" {
                header.marker_names = Some(values.to_vec());
            } else if FRAME_AND_TIME.iter().any(|(label, _)| key == *label) || key.ends_with(" X") {
                header.column_names = Some(cells);
                break;
            } else if !key.is_empty() {
                if key == "EVENT" {
                    header.events.push(values.to_vec());
                }
                // Each event has a line of its own under the same key.
                let count = repeats.entry(key).or_insert(0_usize);
                *count += 1;
                let unique = match *count {
                    1 => key.to_owned(),
                    count => format!("{key} {count}"),
                };
                header.facts.by_key.insert(unique, values.join("\t"));
            }
        }
        Ok(header)
    }

    fn findings(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        let Some(names) = &self.marker_names else {
            return findings;
        };
        (self.facts).check_markers("NO_OF_MARKERS", names.len(), &mut findings);
        let types = self.facts.get("TRAJECTORY_TYPES").unwrap_or_default();
        let filled: Vec<&str> = (names.iter().zip(types.split('\t')))
            .filter(|(_, kind)| !kind.is_empty() && *kind != "Measured")
            .map(|(name, _)| *name)
            .collect();
        if !filled.is_empty() {
            let message = format!(
                "the capture software filled samples of {}; the file does not say which, so they \
                 count as measured",
                filled.join(", ")
            );
            findings.push(Finding::info("TRAJECTORY_TYPES", message));
        }
        findings
    }

    /// The events at their times; one without a time is at that of its frame.
    fn events(&self, rate_hz: f64, findings: &mut Vec<Finding>) -> Vec<TrialEvent> {
        let mut events = Vec::new();
        for cells in &self.events {
            let cell = |k: usize| cells.get(k).copied().unwrap_or_default();
            let number = |k: usize| cell_number(cell(k).as_bytes()).filter(|n| n.is_finite());
            let time_s = number(2).or_else(|| Some((number(1)? - 1.0) / rate_hz));
            let Some(time_s) = time_s.filter(|&time_s| time_s >= 0.0) else {
                let message = format!(
                    "expected a name, a frame and a time in seconds, found \"{}\": left out",
                    cells.join(" ")
                );
                findings.push(Finding::warning("EVENT", message));
                continue;
            };
            let name = Some(cell(0)).filter(|name| !name.is_empty());
            let labels = labels([("label", name.unwrap_or("event"))]);
            events.push(TrialEvent { time_s, labels });
        }
        events
    }

    /// The columns by their names, else by their number. `lines` are at the first row of data.
    fn columns(
        &self,
        lines: &HeaderLines<'_>,
        file: &str,
    ) -> Result<(Table, Vec<Series>), CaptureError> {
        let (leading, names) = match (&self.column_names, &self.marker_names) {
            (Some(names), _) => columns_by_name(names, lines)?,
            (None, Some(names)) => (leading_columns(names.len(), lines, file)?, names.clone()),
            (None, None) => {
                let (line, expected) = (lines.number + 1, "MARKER_NAMES");
                return Err(match lines.peek() {
                    [] => CaptureError::header_end(file, line, expected),
                    _ => CaptureError::header(file, line, expected, "no such line"),
                });
            }
        };
        let mut table = Table::new(file, b'\t');
        for (label, column) in leading {
            table.push(column, label.to_owned());
        }
        let series = add_markers(&mut table, names, |_| false);
        Ok((table, series))
    }
}

/// Columns before those of the markers.
type Leading = Vec<(&'static str, Column)>;

/// Without column names the number of cells tells whether frame and time come first.
fn leading_columns(
    markers: usize,
    lines: &HeaderLines<'_>,
    file: &str,
) -> Result<Leading, CaptureError> {
    let row = lines.peek();
    let is_blank = |cell: &&[u8]| cell.trim_ascii().is_empty();
    let row: Vec<&[u8]> = row.split(|&byte| byte == b'\t').collect();
    let cells = row.len();
    let used = cells - row.iter().rev().take_while(|cell| is_blank(cell)).count();
    // Tabs may end the row: one, or as many as fill it up.
    for count in [cells, used, used.max(cells - 1)] {
        for leading in [&FRAME_AND_TIME[..], &[]] {
            if count == 3 * markers + leading.len() {
                return Ok(leading.to_vec());
            }
        }
    }
    if used == 0 {
        return Ok(Vec::new());
    }
    let expected = format!(
        "{} cells for {markers} markers, or two more with frame and time",
        3 * markers
    );
    Err(CaptureError::header(
        file,
        lines.number + 1,
        expected,
        cells,
    ))
}

fn columns_by_name<'a>(
    names: &[&'a str],
    lines: &HeaderLines<'_>,
) -> Result<(Leading, Vec<&'a str>), CaptureError> {
    let (mut leading, mut markers) = (Vec::new(), Vec::new());
    let mut rest = names;
    for (label, column) in FRAME_AND_TIME {
        if rest.first() == Some(&label) {
            leading.push((label, column));
            rest = &rest[1..];
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
            let column = names.len() - rest.len() + 1;
            let expected = format_args!("the X, Y and Z of a marker from column {column} on");
            let found = format!("{:?}", &rest[..rest.len().min(3)]);
            return Err(lines.error(expected, found));
        };
        markers.push(marker);
        rest = &rest[3..];
    }
    Ok((leading, markers))
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
