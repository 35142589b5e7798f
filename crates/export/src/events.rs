//! Events of a take as CSV and back.
//!
//! The first two columns are `start_s` and `end_s`, seconds after the take's first sample, exact to
//! the nanosecond; every other column is a label, its heading the key and a blank cell no label.
//! Reading also takes `start_time` and `end_time` (RFC 3339 with a zone, or nanoseconds since 1970)
//! and BIDS's `onset` and `duration`, in any place, and a blank or `n/a` end as that of the start.
//! [`read`] and [`write`](fn@write) of a file reproduce it to the byte.

use std::collections::BTreeMap;
use std::io::Write;

use inhand_model::{Annotations, Event, unguarded};

use crate::error::{CsvFile, ExportError, shown};
use crate::table::{Table, table_of, write_csv};

const NANOS_PER_SECOND: i128 = 1_000_000_000;

/// Digits before the decimal point; more seconds than any clock counts.
const MOST_DIGITS: usize = 15;

/// Writes events in their order, times in seconds after `start_unix_nanos`.
///
/// # Errors
///
/// [`ExportError::Write`].
pub fn write(
    annotations: &Annotations,
    start_unix_nanos: u64,
    out: &mut dyn Write,
) -> Result<(), ExportError> {
    let times = |event: &Event| {
        [event.start_unix_nanos, event.end_unix_nanos]
            .map(|unix_nanos| seconds_after(unix_nanos, start_unix_nanos))
    };
    let events = annotations.events.iter().collect();
    write_csv(
        &table(annotations, events, ["start_s", "end_s"], times),
        out,
    )
}

/// A table of events: two columns of times, then one for each label.
pub(crate) fn table<'a>(
    annotations: &'a Annotations,
    events: Vec<&'a Event>,
    titles: [&str; 2],
    times: impl Fn(&Event) -> [String; 2] + Copy + Sync + 'a,
) -> Table<'a> {
    let mut table = table_of(events);
    for (place, title) in titles.into_iter().enumerate() {
        table.words(title, move |event| {
            let [start, end] = times(event);
            if place == 0 { start } else { end }
        });
    }
    for key in annotations.all_keys() {
        table.words(key, move |event| {
            event.labels.get(key).map_or("", String::as_str)
        });
    }
    table.finish()
}

/// An instant in seconds after another, exact to the nanosecond and without digits that say nothing.
pub fn seconds_after(unix_nanos: u64, start_unix_nanos: u64) -> String {
    let nanos = i128::from(unix_nanos) - i128::from(start_unix_nanos);
    let sign = if nanos < 0 { "-" } else { "" };
    let (whole, rest) = (
        nanos.abs() / NANOS_PER_SECOND,
        nanos.abs() % NANOS_PER_SECOND,
    );
    let text = format!("{sign}{whole}.{rest:09}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// An instant as people write it: seconds after `start_unix_nanos`, or a time with its zone
/// (RFC 3339). `None` where it is neither, or not between 1970 and 2554.
///
/// ```
/// use inhand_export::events::parse_instant;
///
/// assert_eq!(parse_instant("1.5", 1_000), Some(1_500_001_000));
/// assert_eq!(parse_instant("1970-01-01T00:00:02Z", 1_000), Some(2_000_000_000));
/// assert_eq!(parse_instant("soon", 0), None);
/// ```
pub fn parse_instant(text: &str, start_unix_nanos: u64) -> Option<u64> {
    let text = text.trim();
    let nanos = match parse_seconds(text.strip_suffix('s').unwrap_or(text)) {
        Some(nanos) => i128::from(start_unix_nanos) + nanos,
        None => text.parse::<jiff::Timestamp>().ok()?.as_nanosecond(),
    };
    u64::try_from(nanos).ok()
}

/// Reads events; times are seconds after `start_unix_nanos`, unless they are instants.
///
/// # Errors
///
/// [`ExportError::Content`] without columns for the times, and with line and column for a time that is none, an
/// event that ends before it starts or is before 1970.
pub fn read(bytes: &[u8], file: &str, start_unix_nanos: u64) -> Result<Annotations, ExportError> {
    let csv = CsvFile::new(file, bytes);
    let mut lines = csv.bytes.split(|&byte| byte == b'\n');
    let tabs = lines.next().is_some_and(|line| line.contains(&b'\t'));
    let start = |delimiter: u8| {
        let mut reader = (csv::ReaderBuilder::new().delimiter(delimiter)).from_reader(csv.bytes);
        let headings = reader.headers().map_err(|error| csv.csv_error(&error))?;
        let headings = headings.clone();
        Ok::<_, ExportError>((TimeColumns::find(file, &headings)?, headings, reader))
    };
    // A label of a table with commas may have a tab in its name.
    let by_tabs = if tabs { start(b'\t').ok() } else { None };
    let (columns, headings, mut reader) = by_tabs.map_or_else(|| start(b','), Ok)?;
    let labels: Vec<usize> = (0..headings.len())
        .filter(|&column| column != columns.start && Some(column) != columns.end)
        .collect();
    let keys = (labels.iter()).map(|&column| unguarded(headings[column].trim()).to_owned());
    let mut annotations = Annotations {
        keys: keys.collect(),
        ..Annotations::default()
    };
    check_keys(file, &annotations.keys)?;
    let mut row = csv::StringRecord::new();
    let mut last = None;
    while (reader.read_record(&mut row)).map_err(|error| csv.csv_error(&error))? {
        last = row.position().cloned().zip(open_cell(&row));
        let (start, end) = columns.times(csv, &row, start_unix_nanos)?;
        let pairs = labels
            .iter()
            .zip(&annotations.keys)
            .filter_map(|(&column, key)| {
                let value = row.get(column)?;
                let absent =
                    value.trim().is_empty() || columns.kind == TimeKind::Onset && value == "n/a";
                (!absent).then(|| (key.clone(), unguarded(value).to_owned()))
            });
        let labels: BTreeMap<String, String> = pairs.collect();
        annotations.events.push(Event {
            start_unix_nanos: start,
            end_unix_nanos: end,
            labels,
        });
    }
    if let Some((place, (column, cell))) = last {
        check_quotes(csv, &place, column, &cell)?;
    }
    Ok(annotations)
}

/// The first cell of a row that goes on over lines, and its column.
fn open_cell(row: &csv::StringRecord) -> Option<(usize, String)> {
    let column = row.iter().position(|cell| cell.contains('\n'))?;
    Some((column, row[column].to_owned()))
}

/// A quote that is opened and not closed takes in all lines behind it, so it can only be in the last row.
fn check_quotes(
    csv: CsvFile<'_>,
    last: &csv::Position,
    column: usize,
    cell: &str,
) -> Result<(), ExportError> {
    let start = usize::try_from(last.byte())
        .unwrap_or(usize::MAX)
        .min(csv.bytes.len());
    let quotes = csv.bytes[start..].iter().filter(|&&byte| byte == b'"');
    if quotes.count() % 2 == 0 {
        return Ok(());
    }
    let (column, found) = (column + 1, shown(cell));
    let message = format!("column {column}: expected a quote that is closed, found {found}");
    Err(csv.line_error(csv.line(last), message))
}

fn check_keys(file: &str, keys: &[String]) -> Result<(), ExportError> {
    let wrong = |found: &str| {
        let expected = "a name of its own over each column";
        ExportError::file(file, expected, found, "name the column, or take it out")
    };
    for (n, key) in keys.iter().enumerate() {
        if key.is_empty() {
            return Err(wrong("a column without a heading"));
        }
        if keys[..n].contains(key) {
            return Err(wrong(&format!("the heading \"{key}\" twice")));
        }
    }
    Ok(())
}

/// Meaning of the two time columns.
#[derive(Clone, Copy, PartialEq, Eq)]
enum TimeKind {
    /// Seconds after the take's start.
    Seconds,
    /// Instants.
    Instants,
    /// Seconds after the start, and a length.
    Onset,
}

struct TimeColumns {
    kind: TimeKind,
    titles: [&'static str; 2],
    start: usize,
    end: Option<usize>,
}

impl TimeColumns {
    fn find(file: &str, headings: &csv::StringRecord) -> Result<Self, ExportError> {
        let find = |name: &str| {
            headings
                .iter()
                .position(|h| h.trim().eq_ignore_ascii_case(name))
        };
        for (kind, titles) in [
            (TimeKind::Seconds, ["start_s", "end_s"]),
            (TimeKind::Instants, ["start_time", "end_time"]),
            (TimeKind::Onset, ["onset", "duration"]),
        ] {
            if let Some(start) = find(titles[0]) {
                return Ok(Self {
                    kind,
                    titles,
                    start,
                    end: find(titles[1]),
                });
            }
        }
        let found: Vec<&str> = headings.iter().take(12).collect();
        Err(ExportError::file(
            file,
            "a column start_s, start_time or onset in the first line",
            format!("the columns {}", found.join(", ")),
            "name the column of the start of events so, and that of their end end_s, end_time or \
             duration",
        ))
    }

    /// Start and end of an event, nanoseconds since 1970.
    fn times(
        &self,
        csv: CsvFile<'_>,
        row: &csv::StringRecord,
        origin: u64,
    ) -> Result<(u64, u64), ExportError> {
        let error = |column: usize, expected: &str| {
            let title = self.titles[usize::from(column != self.start)];
            csv.cell_error(row, column, title, expected)
        };
        let text = |column: usize| row.get(column).unwrap_or_default().trim();
        let time = |column: usize, origin: i128| {
            let (time, expected) = match self.kind {
                TimeKind::Instants => (
                    instant(text(column)),
                    "a time such as 2026-11-03T10:12:00.5Z",
                ),
                TimeKind::Seconds | TimeKind::Onset => (
                    parse_seconds(text(column)).map(|nanos| origin + nanos),
                    "a number of seconds",
                ),
            };
            time.ok_or_else(|| error(column, expected))
        };
        let start = time(self.start, origin.into())?;
        let end = match self.end {
            Some(column) if !["", "n/a"].contains(&text(column)) => match self.kind {
                TimeKind::Onset => time(column, start)?,
                TimeKind::Seconds | TimeKind::Instants => time(column, origin.into())?,
            },
            _ => start,
        };
        let end_column = self.end.unwrap_or(self.start);
        if end < start {
            return Err(error(end_column, "an end that is not before the start"));
        }
        let nanos = |time: i128, column| {
            u64::try_from(time).map_err(|_| error(column, "a time after 1970 and before 2554"))
        };
        Ok((nanos(start, self.start)?, nanos(end, end_column)?))
    }
}

/// Nanoseconds of a decimal number of seconds, exact as far as it has nine decimals.
pub fn parse_seconds(text: &str) -> Option<i128> {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(rest) => (-1, rest),
        None => (1, text.strip_prefix('+').unwrap_or(text)),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let plain = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if !plain(whole) || !plain(fraction) || whole.len() + fraction.len() == 0 {
        // Numbers such as 1e-3 have no exact reading worth the trouble.
        let number: f64 = text.parse().ok()?;
        let nanos = (number * 1e9).round();
        return (nanos.abs() < 1e27).then_some(nanos as i128);
    }
    if whole.len() > MOST_DIGITS {
        return None;
    }
    // In front of a blank whole part, as of ".5", a zero is meant.
    let whole: i128 = format!("0{whole}").parse().ok()?;
    let nanos: i128 = format!("{fraction:0<9}")[..9].parse().ok()?;
    let round_up = fraction.as_bytes().get(9) >= Some(&b'5');
    let total = whole.checked_mul(NANOS_PER_SECOND)? + nanos + i128::from(round_up);
    Some(sign * total)
}

/// Nanoseconds since 1970 of an instant.
fn instant(text: &str) -> Option<i128> {
    if !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit()) {
        return text.parse().ok();
    }
    let time: jiff::Timestamp = text.parse().ok()?;
    Some(time.as_nanosecond())
}
