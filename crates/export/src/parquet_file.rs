//! Tables as Parquet, and columns of such a table, read one at a time.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs::File;
use std::io::Write;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::column::reader::ColumnReaderImpl;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};
use serde_json::{Value, json};

use crate::error::ExportError;
use crate::table::{Column, Table, Values};

/// Rows of a group: what is held in memory of one column at a time.
const GROUP_ROWS: usize = 1 << 20;

/// Most rows of a page: what a reader unpacks at a time.
const PAGE_ROWS: usize = 1 << 16;

/// Rows that room is made for before any is read.
const MOST_AT_ONCE: usize = 1 << 16;

/// Writes a table as Parquet (version 2, zstd). Blank cells are null. The file's metadata has under
/// `inhand.columns` a JSON object with unit and frame of each column, and the pairs of `about`. Every `part_rows`
/// rows belong together, such as those of a method: pages end with them, so that a reader unpacks no others.
/// Columns whose cells are the same in every part are one page of a group, where repetitions take no space.
///
/// # Errors
///
/// [`ExportError::Parquet`], [`ExportError::Write`].
pub fn write_parquet(
    table: &Table<'_>,
    part_rows: usize,
    about: &[(&str, String)],
    out: &mut (dyn Write + Send),
) -> Result<(), ExportError> {
    let fields = (table.columns.iter())
        .map(|column| Ok(Arc::new(field(column)?)))
        .collect::<Result<Vec<_>, ExportError>>()?;
    let schema = Type::group_type_builder("inhand")
        .with_fields(fields)
        .build()?;
    let columns = KeyValue::new("inhand.columns".to_owned(), columns_json(table).to_string());
    let about = (about.iter()).map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone()));
    let properties = WriterProperties::builder()
        // A fixed name: the same table gives the same bytes.
        .set_created_by(concat!("inhand ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_key_value_metadata(Some([columns].into_iter().chain(about).collect()))
        .set_statistics_enabled(EnabledStatistics::None)
        .set_data_page_size_limit(usize::MAX)
        .set_data_page_row_count_limit(part_rows.clamp(1, PAGE_ROWS));
    let properties = table.columns.iter().fold(properties, |properties, column| {
        let path = ColumnPath::from(column.name.as_str());
        let properties = match column.shared {
            true => properties.set_column_data_page_row_count_limit(path.clone(), usize::MAX),
            false => properties,
        };
        match column.values {
            // Measured numbers hardly ever repeat, but their high bytes do, and low ones of rounded numbers.
            Values::Numbers(_) => (properties.set_column_dictionary_enabled(path.clone(), false))
                .set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT),
            // Whole numbers stay the same or count up: their differences take no look into a dictionary.
            Values::Counts(_) => (properties.set_column_dictionary_enabled(path.clone(), false))
                .set_column_encoding(path, Encoding::DELTA_BINARY_PACKED),
            Values::Words(_) => properties,
        }
    });
    let properties = Arc::new(properties.build());
    let mut writer = SerializedFileWriter::new(&mut *out, Arc::new(schema), properties)?;
    let mut start = 0;
    while start < table.rows {
        let rows = start..(start + GROUP_ROWS).min(table.rows);
        let mut group = writer.next_row_group()?;
        for column in &table.columns {
            let mut cells = group
                .next_column()?
                .ok_or_else(|| ParquetError::General("fewer columns than the schema".to_owned()))?;
            for part in parts(rows.clone(), part_rows.max(1)) {
                write_cells(column, part, &mut cells)?;
            }
            cells.close()?;
        }
        group.close()?;
        start = rows.end;
    }
    writer.close()?;
    Ok(out.flush()?)
}

/// Ranges of rows that do not go beyond a part.
fn parts(rows: Range<usize>, part_rows: usize) -> impl Iterator<Item = Range<usize>> {
    let next = move |start: usize| {
        (start / part_rows + 1)
            .saturating_mul(part_rows)
            .min(rows.end)
    };
    let starts = std::iter::successors(Some(rows.start), move |&start| Some(next(start)));
    let ends = starts.clone().skip(1);
    starts
        .zip(ends)
        .take_while(|(start, end)| start < end)
        .map(|(start, end)| start..end)
}

fn field(column: &Column<'_>) -> Result<Type, ExportError> {
    let builder = |physical| Type::primitive_type_builder(&column.name, physical);
    let builder = match &column.values {
        Values::Numbers(_) => builder(Physical::DOUBLE).with_repetition(Repetition::OPTIONAL),
        Values::Counts(_) => builder(Physical::INT64).with_repetition(Repetition::REQUIRED),
        Values::Words(_) => builder(Physical::BYTE_ARRAY)
            .with_repetition(Repetition::REQUIRED)
            .with_logical_type(Some(LogicalType::String)),
    };
    Ok(builder.build()?)
}

fn columns_json(table: &Table<'_>) -> Value {
    let columns = table.columns.iter().map(|column| {
        let mut facts = json!({});
        for (key, fact) in [("unit", column.unit), ("frame", column.frame)] {
            if !fact.is_empty() {
                facts[key] = fact.into();
            }
        }
        (column.name.clone(), facts)
    });
    Value::Object(columns.collect())
}

fn write_cells(
    column: &Column<'_>,
    rows: Range<usize>,
    cells: &mut SerializedColumnWriter<'_>,
) -> Result<(), ExportError> {
    match &column.values {
        Values::Numbers(number) => {
            let numbers: Vec<f64> = rows.map(number).collect();
            // 1 where there is a value, 0 where it is null.
            let present: Vec<i16> = numbers.iter().map(|n| i16::from(!n.is_nan())).collect();
            let values: Vec<f64> = numbers.into_iter().filter(|n| !n.is_nan()).collect();
            (cells.typed::<DoubleType>()).write_batch(&values, Some(&present), None)?;
        }
        Values::Counts(count) => {
            let counts: Vec<i64> = rows.map(count).collect();
            (cells.typed::<Int64Type>()).write_batch(&counts, None, None)?;
        }
        Values::Words(word) => {
            let mut words = Vec::<ByteArray>::with_capacity(rows.len());
            for row in rows {
                let word = word(row);
                // Runs of one word share its bytes.
                let same = words.last().filter(|last| last.data() == word.as_bytes());
                words.push((same.cloned()).unwrap_or_else(|| ByteArray::from(&*word)));
            }
            (cells.typed::<ByteArrayType>()).write_batch(&words, None, None)?;
        }
    }
    Ok(())
}

const AGAIN: &str = "it may be cut or damaged: make it again";

/// A Parquet file whose columns are read one at a time, so that a file far larger than memory can be read.
pub struct ParquetTable {
    pub(crate) file: String,
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
    /// Opens a file and reads its metadata.
    ///
    /// # Errors
    ///
    /// [`ExportError::Content`] for a file that cannot be read or is no whole Parquet file.
    pub fn open(path: &Path) -> Result<Self, ExportError> {
        let file = path.display().to_string();
        let refused =
            |found: &dyn Display| ExportError::file(&file, "a whole Parquet file", found, AGAIN);
        let handle = File::open(path).map_err(|error| refused(&error))?;
        let reader = SerializedFileReader::new(handle).map_err(|error| refused(&error))?;
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

    /// Value of a key of the metadata.
    pub fn fact(&self, key: &str) -> Option<&str> {
        let facts = self.reader.metadata().file_metadata();
        let facts = facts.key_value_metadata()?;
        facts.iter().find(|fact| fact.key == key)?.value.as_deref()
    }

    /// Numbers of some rows, NaN where a cell is blank.
    ///
    /// # Errors
    ///
    /// [`ExportError::Content`] for a column that is not there or holds no numbers, and damaged bytes.
    pub fn numbers(&self, column: &str, rows: Range<usize>) -> Result<Vec<f64>, ExportError> {
        self.cells::<DoubleType>(column, rows, "numbers", &f64::NAN)
    }

    /// Whole numbers of some rows.
    ///
    /// # Errors
    ///
    /// As for [`numbers`](Self::numbers).
    pub fn counts(&self, column: &str, rows: Range<usize>) -> Result<Vec<i64>, ExportError> {
        self.cells::<Int64Type>(column, rows, "whole numbers", &0)
    }

    /// Words of some rows.
    ///
    /// # Errors
    ///
    /// As for [`numbers`](Self::numbers).
    pub fn words(&self, column: &str, rows: Range<usize>) -> Result<Vec<String>, ExportError> {
        let words = self.cells::<ByteArrayType>(column, rows, "words", &ByteArray::new())?;
        let text = |word: &ByteArray| {
            (word.as_utf8().map(str::to_owned)).map_err(|error| self.damaged(column, &error))
        };
        words.iter().map(text).collect()
    }

    /// Cells of some rows, from every group that has any of them; a blank one becomes `blank`.
    fn cells<D: DataType>(
        &self,
        column: &str,
        rows: Range<usize>,
        what: &str,
        blank: &D::T,
    ) -> Result<Vec<D::T>, ExportError> {
        let Some(&place) = self.columns.get(column) else {
            let others = format!("{} others", self.columns.len());
            return Err(self.refused(format!("a column \"{column}\""), others));
        };
        if rows.end > self.rows() {
            let expected = format!("{} rows", rows.end);
            return Err(self.refused(expected, self.rows()));
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
            let reader = D::get_column_reader(reader).ok_or_else(|| {
                let expected = format!("{what} in column \"{column}\"");
                self.refused(expected, "others")
            })?;
            let cells = cells(
                reader,
                part.start - group.start,
                part.len(),
                blank,
                &mut found,
            );
            cells.map_err(|error| self.damaged(column, &error))?;
            if found.len() - before != part.len() {
                let missing = format!("{} cells in column \"{column}\"", part.len());
                return Err(self.refused(missing, found.len() - before));
            }
        }
        Ok(found)
    }

    fn damaged(&self, column: &str, error: &ParquetError) -> ExportError {
        self.refused(format!("intact bytes in column \"{column}\""), error)
    }

    fn refused(&self, expected: impl Display, found: impl Display) -> ExportError {
        ExportError::file(&self.file, expected, found, AGAIN)
    }
}

/// Cells of a column in one group behind those that are skipped; a blank one becomes `blank`.
fn cells<D: DataType>(
    mut reader: ColumnReaderImpl<D>,
    skipped: usize,
    count: usize,
    blank: &D::T,
    out: &mut Vec<D::T>,
) -> Result<(), ParquetError> {
    let (mut values, mut present) = (Vec::with_capacity(count.min(MOST_AT_ONCE)), Vec::new());
    reader.skip_records(skipped)?;
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
