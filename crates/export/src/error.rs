//! Errors of reading and writing tables.

use std::io;

use thiserror::Error;

/// Why a table cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TableError {
    /// A cell that is not what its column holds.
    #[error(
        "{file}, line {line}, column {column} (\"{title}\"): expected {expected}, found {found}"
    )]
    Cell {
        /// The file.
        file: String,
        /// Line, from 1.
        line: u64,
        /// Column, from 1.
        column: usize,
        /// Heading of the column.
        title: String,
        /// What belongs there.
        expected: String,
        /// What is there.
        found: String,
    },
    /// The file as a whole, or its first line.
    #[error("{file}: expected {expected}, found {found}; {hint}")]
    File {
        /// The file.
        file: String,
        /// What was expected.
        expected: String,
        /// What was found.
        found: String,
        /// What to do.
        hint: String,
    },
    /// Text that is no CSV.
    #[error("{file}, line {line}: {message}")]
    Csv {
        /// The file.
        file: String,
        /// Line, from 1; 0 where it cannot be told.
        line: u64,
        /// What is wrong.
        message: String,
    },
    /// A name that cannot be part of another name.
    #[error("{what} is \"{found}\": expected {expected}")]
    Name {
        /// What is named.
        what: &'static str,
        /// The name.
        found: String,
        /// What a name has to be like.
        expected: &'static str,
    },
    /// Writing failed.
    #[error("cannot write the table: {source}")]
    Write {
        /// Why.
        #[from]
        source: io::Error,
    },
    /// The Parquet writer refused something.
    #[error("cannot write the Parquet file: {source}")]
    Parquet {
        /// Why.
        #[from]
        source: parquet::errors::ParquetError,
    },
}

impl TableError {
    /// An error of the csv crate while reading.
    pub(crate) fn csv(file: &str, bytes: &[u8], error: &csv::Error) -> Self {
        let line = error.position().map_or(0, |place| line_of(bytes, place));
        TableError::Csv {
            file: file.to_owned(),
            line,
            message: match error.kind() {
                csv::ErrorKind::Utf8 { .. } => {
                    "expected text in UTF-8, found other bytes".to_owned()
                }
                csv::ErrorKind::UnequalLengths {
                    expected_len, len, ..
                } => format!("expected {expected_len} cells as in the first line, found {len}"),
                _ => error.to_string(),
            },
        }
    }
}

/// The line of a record, from 1. The csv crate counts one too few where lines end in CR LF.
pub(crate) fn line_of(bytes: &[u8], place: &csv::Position) -> u64 {
    let at = usize::try_from(place.byte())
        .unwrap_or(usize::MAX)
        .min(bytes.len());
    // A record may be said to begin at the end of the line before.
    let ends = bytes[at..]
        .iter()
        .take_while(|byte| matches!(byte, b'\r' | b'\n'));
    let at = at + ends.count();
    1 + bytes[..at].iter().filter(|&&byte| byte == b'\n').count() as u64
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
