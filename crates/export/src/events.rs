//! Events of a take as CSV and back.
//!
//! The first two columns are `start_s` and `end_s`, seconds after the take's first sample, exact to
//! the nanosecond; every other column is a label, its heading the key and a blank cell no label.
//! Reading also takes `start_time` and `end_time` (RFC 3339 with a zone, or nanoseconds since 1970)
//! and BIDS's `onset` and `duration`, in any place, and a blank or `n/a` end as that of the start.
//! What [`write`](fn@write) makes comes back from [`read`] as it was, to the byte.

use std::collections::BTreeMap;
use std::io::Write;

use inhand_model::{Annotations, Event};

use crate::csv_file::csv_error;
use crate::error::{TableError, line_of, shown};

const NANOS_PER_SECOND: i128 = 1_000_000_000;

/// Digits before the decimal point; more seconds than any clock counts.
const MOST_DIGITS: usize = 15;

/// Writes events in their order, times in seconds after `start_unix_nanos`.
///
/// # Errors
///
/// [`TableError::Write`].
pub fn write(
    annotations: &Annotations,
    start_unix_nanos: u64,
    out: impl Write,
) -> Result<(), TableError> {
    let keys = annotations.all_keys();
    let mut writer = csv::Writer::from_writer(out);
    let headings = ["start_s", "end_s"].into_iter().chain(keys.iter().copied());
    writer.write_record(headings).map_err(csv_error)?;
    for event in &annotations.events {
        let time = |unix_nanos| seconds(i128::from(unix_nanos) - i128::from(start_unix_nanos));
        let times = [time(event.start_unix_nanos), time(event.end_unix_nanos)];
        for time in times {
            writer.write_field(time).map_err(csv_error)?;
        }
        for key in &keys {
            let value = event.labels.get(*key).map_or("", String::as_str);
            writer.write_field(value).map_err(csv_error)?;
        }
        writer.write_record(None::<&[u8]>).map_err(csv_error)?;
    }
    Ok(writer.flush()?)
}

/// An instant in seconds after another, exact to the nanosecond.
pub fn seconds_after(unix_nanos: u64, start_unix_nanos: u64) -> String {
    seconds(i128::from(unix_nanos) - i128::from(start_unix_nanos))
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

/// Nanoseconds as seconds, without digits that say nothing.
pub(crate) fn seconds(nanos: i128) -> String {
    let sign = if nanos < 0 { "-" } else { "" };
    let (whole, rest) = (
        nanos.abs() / NANOS_PER_SECOND,
        nanos.abs() % NANOS_PER_SECOND,
    );
    let text = format!("{sign}{whole}.{rest:09}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Reads events; times are seconds after `start_unix_nanos`, unless they are instants.
///
/// # Errors
///
/// [`TableError::File`] without columns for the times, [`TableError::Cell`] with line and column for
/// a time that is none, an event that ends before it starts or lies before 1970.
pub fn read(bytes: &[u8], file: &str, start_unix_nanos: u64) -> Result<Annotations, TableError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let tabs =
        (bytes.split(|&byte| byte == b'\n').next()).is_some_and(|line| line.contains(&b'\t'));
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(if tabs { b'\t' } else { b',' })
        .from_reader(bytes);
    let headings = (reader.headers())
        .map_err(|error| TableError::csv(file, bytes, &error))?
        .clone();
    let columns = TimeColumns::of(file, &headings)?;
    let labels: Vec<usize> = (0..headings.len())
        .filter(|&column| column != columns.start && Some(column) != columns.end)
        .collect();
    let keys = labels
        .iter()
        .map(|&column| headings[column].trim().to_owned());
    let mut annotations = Annotations {
        keys: keys.collect(),
        ..Annotations::default()
    };
    check_keys(file, &annotations.keys)?;
    let mut row = csv::StringRecord::new();
    let mut last = None;
    while (reader.read_record(&mut row)).map_err(|error| TableError::csv(file, bytes, &error))? {
        last = row.position().cloned().zip(open_cell(&row));
        let (start, end) = columns.times(file, bytes, &row, start_unix_nanos)?;
        let pairs = labels
            .iter()
            .zip(&annotations.keys)
            .filter_map(|(&column, key)| {
                let value = row.get(column)?;
                let absent =
                    value.trim().is_empty() || columns.kind == Kind::Onset && value == "n/a";
                (!absent).then(|| (key.clone(), value.to_owned()))
            });
        let labels: BTreeMap<String, String> = pairs.collect();
        annotations.events.push(Event {
            start_unix_nanos: start,
            end_unix_nanos: end,
            labels,
        });
    }
    if let Some((place, (column, cell))) = last {
        check_quotes(file, bytes, &place, column, &cell)?;
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
    file: &str,
    bytes: &[u8],
    last: &csv::Position,
    column: usize,
    cell: &str,
) -> Result<(), TableError> {
    let start = usize::try_from(last.byte())
        .unwrap_or(usize::MAX)
        .min(bytes.len());
    let quotes = bytes[start..].iter().filter(|&&byte| byte == b'"').count();
    if quotes % 2 == 0 {
        return Ok(());
    }
    Err(TableError::Csv {
        file: file.to_owned(),
        line: line_of(bytes, last),
        message: format!(
            "column {}: expected a quote that is closed, found {}",
            column + 1,
            shown(cell)
        ),
    })
}

fn check_keys(file: &str, keys: &[String]) -> Result<(), TableError> {
    let wrong = |found: String| TableError::File {
        file: file.to_owned(),
        expected: "a name of its own over each column".to_owned(),
        found,
        hint: "name the column, or take it out".to_owned(),
    };
    for (n, key) in keys.iter().enumerate() {
        if key.is_empty() {
            return Err(wrong("a column without a heading".to_owned()));
        }
        if keys[..n].contains(key) {
            return Err(wrong(format!("the heading \"{key}\" twice")));
        }
    }
    Ok(())
}

/// How the two time columns are to be read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Seconds after the take's start.
    Seconds,
    /// Instants.
    Instants,
    /// Seconds after the start, and a length.
    Onset,
}

struct TimeColumns {
    kind: Kind,
    start: usize,
    end: Option<usize>,
}

impl TimeColumns {
    fn title(&self, column: usize) -> &'static str {
        let [start, end] = self.kind.titles();
        if column == self.start { start } else { end }
    }
}

impl Kind {
    fn titles(self) -> [&'static str; 2] {
        match self {
            Kind::Seconds => ["start_s", "end_s"],
            Kind::Instants => ["start_time", "end_time"],
            Kind::Onset => ["onset", "duration"],
        }
    }
}

impl TimeColumns {
    fn of(file: &str, headings: &csv::StringRecord) -> Result<Self, TableError> {
        let find = |name: &str| {
            headings
                .iter()
                .position(|h| h.trim().eq_ignore_ascii_case(name))
        };
        for kind in [Kind::Seconds, Kind::Instants, Kind::Onset] {
            let [start, end] = kind.titles();
            if let Some(start) = find(start) {
                let end = find(end);
                return Ok(Self { kind, start, end });
            }
        }
        let found: Vec<&str> = headings.iter().take(12).collect();
        Err(TableError::File {
            file: file.to_owned(),
            expected: "a column start_s, start_time or onset in the first line".to_owned(),
            found: format!("the columns {}", found.join(", ")),
            hint: "name the column of the start of events so, and that of their end end_s, \
                   end_time or duration"
                .to_owned(),
        })
    }

    fn times(
        &self,
        file: &str,
        bytes: &[u8],
        row: &csv::StringRecord,
        origin: u64,
    ) -> Result<(u64, u64), TableError> {
        let error = |column: usize, expected: &str| TableError::Cell {
            file: file.to_owned(),
            line: row.position().map_or(0, |place| line_of(bytes, place)),
            column: column + 1,
            title: self.title(column).to_owned(),
            expected: expected.to_owned(),
            found: shown(row.get(column).unwrap_or_default()),
        };
        let text = |column: usize| row.get(column).unwrap_or_default().trim();
        let origin = i128::from(origin);
        let start = match self.kind {
            Kind::Instants => instant(text(self.start))
                .ok_or_else(|| error(self.start, "a time such as 2026-11-03T10:12:00.5Z")),
            Kind::Seconds | Kind::Onset => parse_seconds(text(self.start))
                .map(|nanos| origin + nanos)
                .ok_or_else(|| error(self.start, "a number of seconds")),
        }?;
        let given = self.end.map(|column| (column, text(column)));
        let end = match given.filter(|(_, text)| !text.is_empty() && *text != "n/a") {
            None => start,
            Some((column, text)) => match self.kind {
                Kind::Instants => instant(text)
                    .ok_or_else(|| error(column, "a time such as 2026-11-03T10:12:00.5Z"))?,
                Kind::Seconds => parse_seconds(text)
                    .map(|nanos| origin + nanos)
                    .ok_or_else(|| error(column, "a number of seconds"))?,
                Kind::Onset => parse_seconds(text)
                    .map(|nanos| start + nanos)
                    .ok_or_else(|| error(column, "a number of seconds"))?,
            },
        };
        let nanos = |time: i128, column| {
            u64::try_from(time).map_err(|_| error(column, "a time after 1970 and before 2554"))
        };
        if end < start {
            let column = self.end.unwrap_or(self.start);
            return Err(error(column, "an end that is not before the start"));
        }
        Ok((
            nanos(start, self.start)?,
            nanos(end, self.end.unwrap_or(self.start))?,
        ))
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
    let whole: i128 = if whole.is_empty() {
        0
    } else {
        whole.parse().ok()?
    };
    let mut nanos = 0;
    for digit in fraction.bytes().chain(std::iter::repeat(b'0')).take(9) {
        nanos = nanos * 10 + i128::from(digit - b'0');
    }
    let round_up = fraction
        .as_bytes()
        .get(9)
        .is_some_and(|digit| *digit >= b'5');
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
