//! The header of a Motive CSV file: facts and label rows.

use std::collections::BTreeMap;

use csv::ByteRecord;

use crate::error::CaptureError;
use crate::header::Facts;
use crate::text::{count_lines, header_text};

/// Most rows looked at for the axis labels; Motive writes six or seven.
const MAX_HEADER_ROWS: usize = 16;

// Places of the label rows in `Header::rows`.
const TYPES: usize = 0;
const NAMES: usize = 1;
const IDS: usize = 2;
const KINDS: usize = 3;
const AXES: usize = 4;

/// Everything above the rows of data.
pub(super) struct Header<'a> {
    /// Byte between cells.
    pub(super) delimiter: u8,
    /// Keys and values of the first line.
    pub(super) facts: Facts<'a>,
    /// For each column: `Rigid Body`, `Marker`, ...; name and ID of the entity; `Rotation`,
    /// `Position`, a quality; `Frame`, `Time (Seconds)`, then `X`, ...
    rows: [Vec<String>; 5],
    /// Line of the axis labels, from 1.
    pub(super) axes_line: usize,
    /// Bytes above the first row.
    pub(super) bytes: usize,
    /// Lines above the first row.
    pub(super) lines: usize,
}

/// Whether the bytes start as the format from 1.2 on does.
pub(crate) fn looks_like(bytes: &[u8]) -> bool {
    delimiter(bytes).is_some()
}

/// The byte between cells: a comma, or what spreadsheets put there where the comma is the decimal sign.
fn delimiter(bytes: &[u8]) -> Option<u8> {
    let keys = [&b"Format Version"[..], b"\"Format Version\""];
    let rest = keys.iter().find_map(|key| bytes.strip_prefix(*key))?;
    rest.first().copied().filter(|byte| b",;".contains(byte))
}

impl<'a> Header<'a> {
    /// Reads the header from the start of a file without byte-order mark.
    pub(super) fn parse(bytes: &[u8], file: &'a str) -> Result<Self, CaptureError> {
        let delimiter = delimiter(bytes).unwrap_or(b',');
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .has_headers(false)
            .flexible(true)
            .from_reader(bytes);
        let mut record = ByteRecord::new();
        let mut rows: Vec<Vec<String>> = Vec::new();
        // Start of the record about to be read, as the CSV reader counts bytes.
        let mut start = 0;
        loop {
            // Reading from memory, with rows of any length: there is nothing left that can fail.
            let more = reader.read_byte_record(&mut record).unwrap_or(false);
            let end = usize::try_from(reader.position().byte()).unwrap_or(bytes.len());
            let end = end.min(bytes.len());
            let line = 1 + count_lines(&bytes[..start]);
            header_text(&bytes[start..end], line, file)?;
            if !more || rows.len() >= MAX_HEADER_ROWS {
                let expected = "the row of axis labels that starts with \"Frame\"";
                let line = 1 + count_lines(&bytes[..end]);
                return Err(match end >= bytes.trim_ascii_end().len() {
                    true => CaptureError::header_end(file, line, expected),
                    false => CaptureError::header(file, line, expected, "other rows only"),
                });
            }
            // The bytes were found to be UTF-8.
            let text = |cell| String::from_utf8_lossy(cell).into_owned();
            let cells: Vec<String> = record.iter().map(text).collect();
            if !(cells.first()).is_some_and(|cell| cell.trim().eq_ignore_ascii_case("Frame")) {
                rows.push(cells);
                start = end;
                continue;
            }
            // Blank lines before the record belong to it for the CSV reader.
            let blank = bytes[start..end].iter();
            let blank = blank.take_while(|byte| matches!(byte, b'\r' | b'\n'));
            let blank = blank.filter(|&&byte| byte == b'\n').count();
            // After a CR the reader leaves the LF for the next record.
            let cut = bytes[..end].ends_with(b"\r") && bytes[end..].starts_with(b"\n");
            let end = end + usize::from(cut);
            return Ok(Self {
                delimiter,
                facts: Facts {
                    file,
                    line: 1,
                    by_key: facts(rows.first()),
                },
                rows: label_rows(rows, cells, line + blank, file)?,
                axes_line: line + blank,
                bytes: end,
                lines: count_lines(&bytes[..end]),
            });
        }
    }

    /// Type, name, ID, kind and axis of a column.
    pub(super) fn column(&self, c: usize) -> [&str; 5] {
        (self.rows.each_ref()).map(|row| row.get(c).map_or("", String::as_str))
    }

    /// Number of columns.
    pub(super) fn width(&self) -> usize {
        self.rows.iter().map(Vec::len).max().unwrap_or(0)
    }
}

fn facts(row: Option<&Vec<String>>) -> BTreeMap<String, String> {
    let mut facts = BTreeMap::new();
    for pair in row.map_or(&[][..], Vec::as_slice).chunks(2) {
        if let [key, value] = pair
            && !key.trim().is_empty()
        {
            let fact = facts.entry(key.trim().to_owned());
            fact.or_insert_with(|| value.clone());
        }
    }
    facts
}

/// The label rows among those above the axes. 1.23 and later label the rows; 1.21 and 1.22 leave the
/// labels blank and keep the order. A take without any entity has label rows without any content.
fn label_rows(
    above: Vec<Vec<String>>,
    axes: Vec<String>,
    axes_line: usize,
    file: &str,
) -> Result<[Vec<String>; 5], CaptureError> {
    let mut rows: [Vec<String>; 5] = Default::default();
    rows[AXES] = axes;
    let mut unlabelled = Vec::new();
    let mut labelled = false;
    for cells in above.into_iter().skip(1) {
        let label = cells.iter().take(2).find(|cell| !cell.trim().is_empty());
        let label = label.map(|label| label.trim().to_ascii_lowercase());
        match label.as_deref() {
            Some("type") => (rows[TYPES], labelled) = (cells, true),
            Some("name") => rows[NAMES] = cells,
            Some("id") => rows[IDS] = cells,
            Some("parent") => {}
            _ if cells.iter().any(|cell| !cell.trim().is_empty()) => unlabelled.push(cells),
            _ => {}
        }
    }
    if labelled {
        rows[KINDS] = unlabelled.pop().unwrap_or_default();
    } else if !unlabelled.is_empty() {
        if unlabelled.len() != AXES {
            let expected = "rows of type, name, ID and Rotation/Position above the axis labels";
            let found = format_args!("{} rows", unlabelled.len());
            return Err(CaptureError::header(file, axes_line, expected, found));
        }
        for (row, cells) in rows.iter_mut().zip(unlabelled) {
            *row = cells;
        }
    }
    Ok(rows)
}
