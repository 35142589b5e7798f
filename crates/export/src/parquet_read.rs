//! Columns of a Parquet table of ours, read one at a time.

use std::collections::BTreeMap;
use std::fs::File;
use std::ops::Range;
use std::path::Path;

use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};

use crate::error::TableError;

/// Rows that room is made for before any is read.
const MOST_AT_ONCE: usize = 1 << 16;

const AGAIN: &str = "it may be cut or damaged: make it again";

/// A Parquet file whose columns are read as they are asked for, so that a file far larger than memory can be
/// looked at.
pub struct ParquetTable {
    file: String,
    reader: SerializedFileReader<File>,
    columns: BTreeMap<String, usize>,
    /// Rows of each group.
    groups: Vec<Range<usize>>,
}

impl std::fmt::Debug for ParquetTable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "ParquetTable({}, {} rows)", self.file, self.rows())
    }
}

impl ParquetTable {
    /// Opens a file and reads what it says of itself.
    ///
    /// # Errors
    ///
    /// [`TableError::File`] for a file that cannot be read or is no whole Parquet file.
    pub fn open(path: &Path) -> Result<Self, TableError> {
        let file = path.display().to_string();
        let refused = |found: String| TableError::File {
            file: file.clone(),
            expected: "a whole Parquet file".to_owned(),
            found,
            hint: AGAIN.to_owned(),
        };
        let handle = File::open(path).map_err(|error| refused(error.to_string()))?;
        let reader = SerializedFileReader::new(handle).map_err(|e| refused(e.to_string()))?;
        let schema = reader.metadata().file_metadata().schema_descr();
        let columns = (schema.columns().iter().enumerate())
            .map(|(place, column)| (column.name().to_owned(), place))
            .collect();
        let mut end = 0;
        let groups = (reader.metadata().row_groups().iter())
            .map(|group| {
                let start = end;
                end = usize::try_from(group.num_rows())
                    .unwrap_or(0)
                    .saturating_add(end);
                start..end
            })
            .collect();
        Ok(Self {
            file,
            reader,
            columns,
            groups,
        })
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.groups.last().map_or(0, |group| group.end)
    }

    /// Whether there is a column of this name.
    pub fn has(&self, column: &str) -> bool {
        self.columns.contains_key(column)
    }

    /// What the file says of itself under a key.
    pub fn fact(&self, key: &str) -> Option<&str> {
        let facts = self.reader.metadata().file_metadata();
        let facts = facts.key_value_metadata()?;
        facts.iter().find(|fact| fact.key == key)?.value.as_deref()
    }

    /// Numbers of some rows, NaN where a cell is blank.
    ///
    /// # Errors
    ///
    /// [`TableError::File`] for a column that is not there or holds no numbers, and damaged bytes.
    pub fn numbers(&self, column: &str, rows: Range<usize>) -> Result<Vec<f64>, TableError> {
        self.cells(column, rows, "numbers", |reader, count, out| match reader {
            ColumnReader::DoubleColumnReader(reader) => Some(cells(reader, count, &f64::NAN, out)),
            _ => None,
        })
    }

    /// Whole numbers of some rows.
    ///
    /// # Errors
    ///
    /// As for [`numbers`](Self::numbers).
    pub fn counts(&self, column: &str, rows: Range<usize>) -> Result<Vec<i64>, TableError> {
        self.cells(
            column,
            rows,
            "whole numbers",
            |reader, count, out| match reader {
                ColumnReader::Int64ColumnReader(reader) => Some(cells(reader, count, &0, out)),
                _ => None,
            },
        )
    }

    /// Words of some rows.
    ///
    /// # Errors
    ///
    /// As for [`numbers`](Self::numbers).
    pub fn words(&self, column: &str, rows: Range<usize>) -> Result<Vec<String>, TableError> {
        let nothing = ByteArray::new();
        let words = self.cells(column, rows, "words", |reader, count, out| match reader {
            ColumnReader::ByteArrayColumnReader(reader) => {
                Some(cells(reader, count, &nothing, out))
            }
            _ => None,
        })?;
        let text = |word: &ByteArray| {
            (word.as_utf8().map(str::to_owned)).map_err(|error| self.damaged(column, &error))
        };
        words.iter().map(text).collect()
    }

    /// Cells of some rows, from every group that has any of them; `read` is `None` for a column of other cells.
    fn cells<T>(
        &self,
        column: &str,
        rows: Range<usize>,
        what: &str,
        read: impl Fn(ColumnReader, usize, &mut Vec<T>) -> Option<Result<(), ParquetError>>,
    ) -> Result<Vec<T>, TableError> {
        let Some(&place) = self.columns.get(column) else {
            return Err(self.refused(
                format!("a column \"{column}\""),
                format!("{} others", self.columns.len()),
            ));
        };
        if rows.end > self.rows() {
            let expected = format!("{} rows", rows.end);
            return Err(self.refused(expected, self.rows().to_string()));
        }
        // The file may lie about its size: no room is made on its word.
        let mut found = Vec::with_capacity(rows.len().min(MOST_AT_ONCE));
        for (k, group) in self.groups.iter().enumerate() {
            let part = rows.start.max(group.start)..rows.end.min(group.end);
            if part.is_empty() {
                continue;
            }
            let before = found.len();
            let reader = (self.reader.get_row_group(k))
                .and_then(|group| group.get_column_reader(place))
                .map_err(|error| self.damaged(column, &error))?;
            let read = read(reader, group.len(), &mut found).ok_or_else(|| {
                self.refused(
                    format!("{what} in column \"{column}\""),
                    "others".to_owned(),
                )
            })?;
            read.map_err(|error| self.damaged(column, &error))?;
            if found.len() - before != group.len() {
                let missing = format!("{} cells in column \"{column}\"", group.len());
                return Err(self.refused(missing, (found.len() - before).to_string()));
            }
            found.truncate(before + part.end - group.start);
            found.drain(before..before + part.start - group.start);
        }
        Ok(found)
    }

    fn damaged(&self, column: &str, error: &ParquetError) -> TableError {
        let expected = format!("sound bytes in column \"{column}\"");
        self.refused(expected, error.to_string())
    }

    fn refused(&self, expected: String, found: String) -> TableError {
        TableError::File {
            file: self.file.clone(),
            expected,
            found,
            hint: AGAIN.to_owned(),
        }
    }
}

/// All cells of a column in one group; a blank one becomes `blank`.
fn cells<D: DataType>(
    mut reader: ColumnReaderImpl<D>,
    count: usize,
    blank: &D::T,
    out: &mut Vec<D::T>,
) -> Result<(), ParquetError> {
    let (mut values, mut present) = (Vec::with_capacity(count.min(MOST_AT_ONCE)), Vec::new());
    let mut read = 0;
    while read < count {
        let (rows, ..) = reader.read_records(
            (count - read).min(MOST_AT_ONCE),
            Some(&mut present),
            None,
            &mut values,
        )?;
        if rows == 0 {
            break;
        }
        read += rows;
    }
    if present.is_empty() {
        out.append(&mut values);
        return Ok(());
    }
    let mut values = values.into_iter();
    for present in present {
        let value = if present == 0 { None } else { values.next() };
        out.push(value.unwrap_or_else(|| blank.clone()));
    }
    Ok(())
}
