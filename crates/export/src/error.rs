//! Errors of reading and writing files of other tools.

use std::fmt::Display;
use std::io;

use thiserror::Error;

/// Why a file cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExportError {
    /// Content that cannot be used: where it is, what was expected, what was found, what to do.
    #[error("{0}")]
    Content(String),
    /// Writing failed.
    #[error("cannot write the table: {0}")]
    Write(#[from] io::Error),
    /// The Parquet writer refused something.
    #[error("cannot write the Parquet file: {0}")]
    Parquet(#[from] parquet::errors::ParquetError),
    /// Writing a bag failed.
    #[error("cannot write the bag: {0}")]
    Container(#[from] inhand_container::ContainerError),
}

/// The csv crate fails at writing only where the file does.
impl From<csv::Error> for ExportError {
    fn from(error: csv::Error) -> Self {
        ExportError::Write(error.into())
    }
}

impl ExportError {
    /// Content of a file as a whole.
    pub(crate) fn file(
        file: &str,
        expected: impl Display,
        found: impl Display,
        hint: &str,
    ) -> Self {
        ExportError::Content(format!(
            "{file}: expected {expected}, found {found}; {hint}"
        ))
    }
}

/// A CSV file in memory, for errors with their place in it.
#[derive(Clone, Copy)]
pub(crate) struct CsvFile<'a> {
    pub(crate) name: &'a str,
    pub(crate) bytes: &'a [u8],
}

impl<'a> CsvFile<'a> {
    /// A file without its byte order mark.
    pub(crate) fn new(name: &'a str, bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Self { name, bytes }
    }

    /// The line of a record, from 1. The csv crate counts one too few where lines end in CR LF.
    pub(crate) fn line(self, place: &csv::Position) -> u64 {
        let at = usize::try_from(place.byte())
            .unwrap_or(usize::MAX)
            .min(self.bytes.len());
        // A record may be said to begin at the end of the line before.
        let ends = self.bytes[at..]
            .iter()
            .take_while(|byte| matches!(byte, b'\r' | b'\n'));
        let before = &self.bytes[..at + ends.count()];
        1 + before.iter().filter(|&&byte| byte == b'\n').count() as u64
    }

    /// An error in a line; 0 where the line is not known.
    pub(crate) fn line_error(self, line: u64, message: impl Display) -> ExportError {
        ExportError::Content(format!("{}, line {line}: {message}", self.name))
    }

    /// An error of the csv crate while reading.
    pub(crate) fn csv_error(self, error: &csv::Error) -> ExportError {
        let line = error.position().map_or(0, |place| self.line(place));
        match error.kind() {
            csv::ErrorKind::Utf8 { .. } => {
                self.line_error(line, "expected text in UTF-8, found other bytes")
            }
            csv::ErrorKind::UnequalLengths {
                expected_len, len, ..
            } => {
                let expected = format!("{expected_len} cells as in the first line");
                self.line_error(line, format!("expected {expected}, found {len}"))
            }
            _ => self.line_error(line, error),
        }
    }

    /// A cell that is not what its column holds.
    pub(crate) fn cell_error(
        self,
        row: &csv::StringRecord,
        column: usize,
        title: &str,
        expected: &str,
    ) -> ExportError {
        ExportError::Content(format!(
            "{}, line {}, column {} (\"{title}\"): expected {expected}, found {}",
            self.name,
            row.position().map_or(0, |place| self.line(place)),
            column + 1,
            shown(row.get(column).unwrap_or_default().trim()),
        ))
    }
}

/// A cell as messages show it: not a whole line of it.
pub(crate) fn shown(cell: &str) -> String {
    const MOST: usize = 60;
    if cell.is_empty() {
        return "nothing".to_owned();
    }
    let short: String = cell.chars().take(MOST).collect();
    let dots = if short.len() < cell.len() { "..." } else { "" };
    format!("\"{short}{dots}\"")
}
