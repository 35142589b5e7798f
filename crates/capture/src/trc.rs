//! TRC files (track, row, column): marker positions as Cortex, Motive, OpenSim and many scripts
//! write them.
//!
//! Three lines of facts, two rows of column labels, an optional blank line, then a row for each
//! frame, all separated by tabs:
//!
//! ```text
//! PathFileType  4  (X/Y/Z)  take.trc
//! DataRate  CameraRate  NumFrames  NumMarkers  Units  OrigDataRate  OrigDataStartFrame  ...
//! 100       100         2          2           mm     100           1                   ...
//! Frame#  Time  Thumb          Index
//!               X1   Y1   Z1   X2   Y2   Z2
//!
//! 1       0.00  1.0  2.0  3.0  4.0  5.0  6.0
//! ```
//!
//! The second row of labels says which columns make a marker, the first one what it is called.
//! Columns between `Time` and the first marker, as some software has them, are passed over.
//!
//! # Conventions
//!
//! * **Lengths** are in `Units` and become metres.
//! * **Time** of a sample is `(frame - first frame) / DataRate`. The time column is only a check.
//!   The file states no start time: the first frame is at 0 s, and a finding says so where that is not the
//!   start of its trial.
//! * **Missing** samples are blank cells, a row that ends behind its time, `nan`, or, as programs
//!   without a notion of missing write them, a marker exactly at the origin in all three
//!   coordinates, which is counted in a finding.
//! * **Axes** are not stated: Y is up, as Motive and OpenSim have it, with a finding, unless the user
//!   says it, as for most exports of Cortex. What is written is turned so that Y is up.

use std::collections::BTreeMap;
use std::io::{self, Write};

use inhand_model::{Finding, LengthUnit, Position, Recording, Setting, Source, UpAxis};

use crate::assembly::Series;
use crate::error::CaptureError;
use crate::header::{Facts, HeaderLines, Opened, add_markers};
use crate::settings::ReadSettings;
use crate::start_time;
use crate::table::{Column, Table};
use crate::text::{self, excerpt, is_unlabelled};

/// Beginning of every file.
const MAGIC: &str = "PathFileType";

/// Line of the facts' values.
const VALUES_LINE: usize = 3;

/// Columns of `Frame#` and `Time`.
const LEADING_COLUMNS: usize = 2;

/// Whether the bytes start as a TRC file does.
pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    let rest = bytes.strip_prefix(MAGIC.as_bytes());
    rest.is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace))
}

/// Reads the header, from the beginning of a file without byte-order mark.
pub(crate) fn open(
    bytes: &[u8],
    file: &str,
    settings: &ReadSettings,
) -> Result<Opened, CaptureError> {
    let mut lines = HeaderLines::new(bytes, file);
    let (facts, version) = facts(&mut lines, file)?;
    let (table, series) = columns(&mut lines, file)?;

    let length_unit = match facts.length_unit("Units", "m, cm, mm, in or ft", settings)? {
        Some(unit) => unit,
        // Without any marker there is no length to misread.
        None if series.is_empty() => LengthUnit::Metres,
        None => return Err(CaptureError::no_units(file, "Units")),
    };
    let start = start_time::parse("", None);
    let rate_hz = facts.rate_hz("DataRate", "a rate in Hz, such as 100.00")?;
    let clock = start.clock(rate_hz, file)?;

    let mut findings: Vec<Finding> = start.finding.into_iter().collect();
    // Both are laid out the same.
    if !["3", "4"].contains(&version.as_str()) {
        let found = excerpt(version.as_bytes());
        let message = format!("expected type 4, found \"{found}\": read as type 4");
        findings.push(Finding::info(MAGIC, message));
    }
    if settings.up_axis.is_none() {
        let message = format!(
            "TRC does not say which axis points up: y is assumed; set {} to y or z",
            Setting::Up
        );
        findings.push(Finding::info("", message));
    }
    let declared_rows = facts.count("NumFrames", &mut findings);
    facts.check_markers("NumMarkers", series.len(), &mut findings);
    let source = Source {
        format: "TRC".to_owned(),
        length_unit,
        up_axis: settings.up_axis.unwrap_or(UpAxis::Y),
        rotation: None,
        header: facts.by_key,
    };
    Ok(lines.opened(table, series, clock, source, declared_rows, findings))
}

/// The cells of the next line.
fn cells<'a>(lines: &mut HeaderLines<'a>, expected: &str) -> Result<Vec<&'a str>, CaptureError> {
    let Some(line) = lines.next_line()? else {
        return Err(CaptureError::header_end(lines.file, lines.number, expected));
    };
    Ok(text::cells(line))
}

/// A cell, for a message.
fn describe(cells: &[&str], index: usize) -> String {
    match cells.get(index) {
        None => "the end of the line".to_owned(),
        Some(&"") => "a blank cell".to_owned(),
        Some(cell) => format!("\"{}\"", excerpt(cell.as_bytes())),
    }
}

/// The three lines of facts, and the version of the format.
fn facts<'a>(
    lines: &mut HeaderLines<'_>,
    file: &'a str,
) -> Result<(Facts<'a>, String), CaptureError> {
    let first = cells(lines, MAGIC)?;
    // Some scripts put spaces here and tabs everywhere else.
    let mut words = first
        .iter()
        .flat_map(|cell| cell.split_whitespace())
        .skip(1);
    let version = words.next().unwrap_or_default().to_owned();
    let order = words.next().unwrap_or_default();
    if !order.is_empty() && !order.eq_ignore_ascii_case("(X/Y/Z)") {
        let order = excerpt(order.as_bytes());
        let found = format_args!("a TRC file with coordinates \"{order}\" (line 1)");
        let hint = "export it with coordinates (X/Y/Z)";
        return Err(CaptureError::unsupported(file, found, hint));
    }
    let rest = first.join(" ").split_off(MAGIC.len()).trim().to_owned();
    let mut by_key = BTreeMap::from([(MAGIC.to_owned(), rest)]);
    let keys = cells(
        lines,
        "a line of keys (DataRate, CameraRate, NumFrames, ...)",
    )?;
    if !keys.contains(&"DataRate") {
        let expected = "a line of keys with DataRate among them, separated by tabs";
        return Err(lines.error(expected, describe(&keys, 0)));
    }
    let values = cells(lines, "a line of values for the keys of line 2")?;
    for (key, value) in keys.iter().zip(&values).filter(|(key, _)| !key.is_empty()) {
        let fact = by_key.entry((*key).to_owned());
        fact.or_insert_with(|| (*value).to_owned());
    }
    let facts = Facts {
        file,
        line: VALUES_LINE,
        by_key,
    };
    Ok((facts, version))
}

/// The two rows of column labels.
fn columns(lines: &mut HeaderLines<'_>, file: &str) -> Result<(Table, Vec<Series>), CaptureError> {
    const LABELS: &str = "a row of labels (Frame#, Time, then marker names)";
    let names = cells(lines, LABELS)?;
    for (column, label) in ["Frame#", "Time"].into_iter().enumerate() {
        let start = &label.to_ascii_lowercase()[..4];
        if !(names.get(column)).is_some_and(|name| name.to_ascii_lowercase().starts_with(start)) {
            let expected = format_args!("{LABELS} with {label} in column {}", column + 1);
            return Err(lines.error(expected, describe(&names, column)));
        }
    }
    let axes = cells(lines, "a row of axes (X1, Y1, Z1, X2, ...)")?;
    let first = first_marker_column(&axes, lines)?;
    let marker_names = marker_names(&names, first, axes.len(), lines)?;

    let mut table = Table::new(file, b'\t');
    // Cortex ends a row there before the first marker is seen.
    table.may_end_after = Some(LEADING_COLUMNS);
    table.push(Column::Frame, "Frame#".to_owned());
    table.push(Column::Time, "Time".to_owned());
    for column in LEADING_COLUMNS..first {
        let label = names.get(column).copied().unwrap_or_default();
        table.push(Column::Skip, label.to_owned());
    }
    let series = add_markers(&mut table, marker_names, is_unlabelled);
    Ok((table, series))
}

/// Index of the first column of the first marker, after a check that from there on every three
/// columns are an X, a Y and a Z.
fn first_marker_column(axes: &[&str], lines: &HeaderLines<'_>) -> Result<usize, CaptureError> {
    let first = axes.iter().position(|cell| !cell.is_empty());
    let first = first.unwrap_or(LEADING_COLUMNS);
    if first < LEADING_COLUMNS {
        let expected = "a row of axes (X1, Y1, Z1, X2, ...) from column 3 on";
        let found = format_args!("{} in column {}", describe(axes, first), first + 1);
        return Err(lines.error(expected, found));
    }
    let coordinates = axes.len().saturating_sub(first).next_multiple_of(3);
    for index in first..first + coordinates {
        let axis = ["X", "Y", "Z"][(index - first) % 3];
        let fits = axes.get(index).is_some_and(|cell| {
            cell.get(..1).is_some_and(|c| c.eq_ignore_ascii_case(axis))
                && cell[1..].bytes().all(|byte| byte.is_ascii_digit())
        });
        if !fits {
            let expected = format_args!("{axis} of a marker in column {}", index + 1);
            return Err(lines.error(expected, describe(axes, index)));
        }
    }
    Ok(first)
}

/// A name for each three columns from `first` to `end`: the one above its X, or, where a program
/// did not leave the two blank cells behind each name, one after the other.
fn marker_names<'a>(
    names: &[&'a str],
    first: usize,
    end: usize,
    lines: &HeaderLines<'_>,
) -> Result<Vec<&'a str>, CaptureError> {
    let markers = end.saturating_sub(first) / 3;
    let named = || (names.iter().enumerate().skip(first)).filter(|(_, name)| !name.is_empty());
    let misplaced = named().find(|&(index, _)| index >= end || !(index - first).is_multiple_of(3));
    let Some((index, name)) = misplaced else {
        let above_x = |m: usize| names.get(first + 3 * m).copied().unwrap_or_default();
        return Ok((0..markers).map(above_x).collect());
    };
    if named().count() == markers {
        return Ok(named().map(|(_, name)| *name).collect());
    }
    let expected = format!(
        "an X, a Y and a Z below the name \"{}\" of line {}, column {}",
        excerpt(name.as_bytes()),
        lines.number - 1,
        index + 1
    );
    Err(lines.error(
        expected,
        format_args!("axes of {markers} markers, up to column {end}"),
    ))
}

/// Writes the markers of a recording as TRC: metres, frames from 1, blank cells for missing samples.
///
/// Y is up, which readers take for granted because the format cannot say it: a recording whose Z is
/// up is turned by a quarter about X, (x, y, z) becomes (x, z, -y), which changes no digit.
///
/// Numbers have as many digits as it takes to read them back unchanged. What the format cannot hold
/// is lost: bodies, qualities, the mark on filled samples, the start time, findings.
///
/// `out` should be buffered.
///
/// # Errors
///
/// [`CaptureError::Output`] where `out` fails.
pub fn write(recording: &Recording, out: &mut dyn Write) -> Result<(), CaptureError> {
    write_all(recording, out).map_err(|source| CaptureError::Output {
        format: "TRC",
        source,
    })
}

fn write_all(recording: &Recording, out: &mut dyn Write) -> io::Result<()> {
    write_header(recording, out)?;
    for k in 0..recording.len() {
        write!(out, "{}\t{:.6}", k + 1, recording.clock.time_s(k))?;
        for marker in &recording.markers {
            match (
                marker.track.get(k).map(Position::to_array),
                recording.source.up_axis,
            ) {
                (Some([x, y, z]), UpAxis::Y) => write!(out, "\t{x}\t{y}\t{z}")?,
                // The inverse of `UpAxis::upright_from_world` for Y, exactly.
                (Some([x, y, z]), UpAxis::Z) => write!(out, "\t{x}\t{z}\t{}", -y)?,
                (None, _) => out.write_all(b"\t\t\t")?,
            }
        }
        out.write_all(b"\r\n")?;
    }
    out.flush()
}

fn write_header(recording: &Recording, out: &mut dyn Write) -> io::Result<()> {
    let (rate_hz, frames) = (recording.clock.rate_hz(), recording.len());
    let markers = recording.markers.len();
    write!(
        out,
        "{MAGIC}\t4\t(X/Y/Z)\t{}.trc\r\n\
         DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t\
         OrigNumFrames\r\n\
         {rate_hz}\t{rate_hz}\t{frames}\t{markers}\tm\t{rate_hz}\t1\t{frames}\r\n\
         Frame#\tTime",
        cell(&recording.name)
    )?;
    for marker in &recording.markers {
        // A name is above the first of its three columns.
        write!(out, "\t{}\t\t", cell(&marker.name))?;
    }
    write!(out, "\r\n\t")?;
    for number in 1..=markers {
        write!(out, "\tX{number}\tY{number}\tZ{number}")?;
    }
    write!(out, "\r\n\r\n")
}

/// A text that stays within its cell.
fn cell(text: &str) -> String {
    text.replace(|c: char| c.is_control(), " ")
}
