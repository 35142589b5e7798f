//! The header of a Motive CSV file: facts and label rows.

use std::collections::BTreeMap;

use csv::ByteRecord;

use crate::error::CaptureError;
use crate::text;

/// Most bytes looked at for the header; a take of a thousand markers needs a few hundred thousand.
const MAX_HEADER_BYTES: usize = 16 << 20;

/// Most rows looked at for the axis labels; Motive writes six or seven.
const MAX_HEADER_ROWS: usize = 16;

/// What stands above the rows of data.
#[derive(Debug, Default)]
pub(super) struct Header {
    /// Keys and values of the first line.
    pub(super) facts: BTreeMap<String, String>,
    /// `Rigid Body`, `Marker`, ... for each column.
    pub(super) types: Vec<String>,
    /// Name of the entity of each column.
    pub(super) names: Vec<String>,
    /// ID of the entity of each column.
    pub(super) ids: Vec<String>,
    /// `Rotation`, `Position`, a quality, for each column.
    pub(super) kinds: Vec<String>,
    /// `Frame`, `Time (Seconds)`, then `X`, ... for each column.
    pub(super) axes: Vec<String>,
    /// Line of the axis labels, from 1.
    pub(super) axes_line: usize,
    /// Where the rows start in the bytes.
    pub(super) data_start: usize,
    /// Line of the first row, from 1.
    pub(super) first_data_line: usize,
}

impl Header {
    pub(super) fn fact(&self, key: &str) -> Option<&str> {
        self.facts.get(key).map(|value| value.trim())
    }

    pub(super) fn is_fact(&self, key: &str, value: &str) -> bool {
        self.fact(key)
            .is_some_and(|found| found.eq_ignore_ascii_case(value))
    }

    /// The export rate, which is that of the rows; the capture rate may be higher.
    pub(super) fn rate_hz(&self, file: &str) -> Result<f64, CaptureError> {
        const KEY: &str = "Export Frame Rate";
        self.fact(KEY)
            .and_then(|rate| rate.parse().ok())
            .filter(|rate: &f64| rate.is_finite() && *rate > 0.0)
            .ok_or_else(|| CaptureError::HeaderValue {
                file: file.to_owned(),
                line: 1,
                key: KEY,
                expected: "the rate of the rows in Hz, such as 100.000000",
                found: self
                    .fact(KEY)
                    .map_or("missing".to_owned(), |value| format!("\"{value}\"")),
            })
    }
}

/// Whether the layout of this version has been seen: 1.21 to 1.25.
pub(super) fn is_known_version(version: &str) -> bool {
    ["1.21", "1.22", "1.23", "1.24", "1.25"].contains(&version)
}

/// Reads the header from the start of a file without byte-order mark.
pub(super) fn parse(bytes: &[u8], file: &str) -> Result<Header, CaptureError> {
    refuse_other_formats(bytes, file)?;
    let window = &bytes[..bytes.len().min(MAX_HEADER_BYTES)];
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .from_reader(window);
    let mut record = ByteRecord::new();
    let mut rows: Vec<(usize, Vec<String>)> = Vec::new();
    // Start of the record about to be read, as the CSV reader counts bytes.
    let mut start = 0;
    loop {
        // Reading from memory, with rows of any length: there is nothing left that can fail.
        let more = reader.read_byte_record(&mut record).unwrap_or(false);
        let end = usize::try_from(reader.position().byte()).map_or(window.len(), |end| end);
        let end = end.min(window.len());
        let line = 1 + text::count_lines(&bytes[..start]);
        text::header_text(&bytes[start..end], line, file)?;
        if !more || rows.len() >= MAX_HEADER_ROWS {
            return Err(no_axes(file, bytes, end));
        }
        // Blank lines before the record belong to it for the CSV reader.
        let blank = bytes[start..end]
            .iter()
            .take_while(|byte| matches!(byte, b'\r' | b'\n'))
            .filter(|&&byte| byte == b'\n')
            .count();
        let cells = cells(&record);
        start = end;
        if cells
            .first()
            .is_some_and(|cell| cell.trim().eq_ignore_ascii_case("Frame"))
        {
            // After a CR the reader leaves the LF for the next record.
            let data_start = if bytes[..end].ends_with(b"\r") && bytes[end..].starts_with(b"\n") {
                end + 1
            } else {
                end
            };
            let header = Header {
                axes: cells,
                axes_line: line + blank,
                data_start,
                first_data_line: 1 + text::count_lines(&bytes[..data_start]),
                ..Header::default()
            };
            return with_labels(header, rows, file);
        }
        rows.push((line + blank, cells));
    }
}

pub(super) fn looks_like(bytes: &[u8]) -> bool {
    bytes.starts_with(b"Format Version,") || bytes.starts_with(b"\"Format Version\",")
}

fn refuse_other_formats(bytes: &[u8], file: &str) -> Result<(), CaptureError> {
    if looks_like(bytes) {
        return Ok(());
    }
    Err(CaptureError::UnknownFormat {
        file: file.to_owned(),
        found: text::beginning(bytes),
    })
}

fn no_axes(file: &str, bytes: &[u8], end: usize) -> CaptureError {
    let at_end = end >= bytes.trim_ascii_end().len();
    CaptureError::Header {
        file: file.to_owned(),
        line: 1 + text::count_lines(&bytes[..end]),
        expected: "the row of axis labels that starts with \"Frame\"".to_owned(),
        found: if at_end {
            "the end of the file".to_owned()
        } else {
            "other rows only".to_owned()
        },
        hint: "the header is cut; export the take again",
    }
}

/// Cells as they stand. The bytes were found to be UTF-8 before.
fn cells(record: &ByteRecord) -> Vec<String> {
    record
        .iter()
        .map(|cell| String::from_utf8_lossy(cell).into_owned())
        .collect()
}

fn is_blank(cell: &str) -> bool {
    cell.trim().is_empty()
}

fn with_labels(
    mut header: Header,
    rows: Vec<(usize, Vec<String>)>,
    file: &str,
) -> Result<Header, CaptureError> {
    let mut rows = rows.into_iter();
    let facts = rows.next().map(|(_, cells)| cells).unwrap_or_default();
    for pair in facts.chunks(2) {
        if let [key, value] = pair
            && !is_blank(key)
        {
            header
                .facts
                .entry(key.trim().to_owned())
                .or_insert_with(|| value.clone());
        }
    }

    // 1.23 and later label the rows; 1.21 and 1.22 leave the labels blank and keep the order. A
    // take without any entity has label rows without any content.
    let mut unlabelled = Vec::new();
    let mut labelled = false;
    for (_, cells) in rows {
        let label = cells.iter().take(2).find(|cell| !is_blank(cell));
        match label
            .map(|label| label.trim().to_ascii_lowercase())
            .as_deref()
        {
            Some("type") => (header.types, labelled) = (cells, true),
            Some("name") => header.names = cells,
            Some("id") => header.ids = cells,
            Some("parent") => {}
            _ if cells.iter().any(|cell| !is_blank(cell)) => unlabelled.push(cells),
            _ => {}
        }
    }
    if labelled {
        header.kinds = unlabelled.pop().unwrap_or_default();
    } else if !unlabelled.is_empty() {
        let found = unlabelled.len();
        let Ok([types, names, ids, kinds]) = <[Vec<String>; 4]>::try_from(unlabelled) else {
            return Err(CaptureError::Header {
                file: file.to_owned(),
                line: header.axes_line,
                expected: "rows of type, name, ID and Rotation/Position above the axis labels"
                    .to_owned(),
                found: format!("{found} rows"),
                hint: "the header is cut; export the take again",
            });
        };
        (header.types, header.names) = (types, names);
        (header.ids, header.kinds) = (ids, kinds);
    }
    Ok(header)
}
