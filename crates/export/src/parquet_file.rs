//! Tables as Parquet.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use serde_json::{Value, json};

use crate::error::TableError;
use crate::table::{Column, Table, Values};

/// Rows of a group: what is held in memory of one column at a time.
const GROUP_ROWS: usize = 64 * 1024;

/// Writes a table as Parquet (version 2, zstd). Blank cells are null. The file's metadata has under
/// `inhand.columns` a JSON object with unit and frame of each column, and the pairs of `about`.
///
/// # Errors
///
/// [`TableError::Parquet`], [`TableError::Write`].
pub fn write_parquet(
    table: &Table<'_>,
    about: &[(&str, String)],
    out: impl Write + Send,
) -> Result<(), TableError> {
    write_parquet_parts(table, table.rows, about, out)
}

/// As [`write_parquet`]; every `part_rows` rows belong together, such as those of a method, and are stored so that
/// a reader finds them without their neighbours.
///
/// # Errors
///
/// [`TableError::Parquet`], [`TableError::Write`].
pub fn write_parquet_parts(
    table: &Table<'_>,
    part_rows: usize,
    about: &[(&str, String)],
    mut out: impl Write + Send,
) -> Result<(), TableError> {
    let fields = (table.columns.iter())
        .map(|column| Ok(Arc::new(field(column)?)))
        .collect::<Result<Vec<_>, TableError>>()?;
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
        // Coordinates hardly ever repeat: a dictionary of them only costs time.
        .set_dictionary_enabled(false)
        .set_encoding(Encoding::PLAIN)
        .build();
    let mut writer = SerializedFileWriter::new(&mut out, Arc::new(schema), Arc::new(properties))?;
    let mut start = 0;
    while start < table.rows {
        // No group holds rows of two parts.
        let part_rows = part_rows.max(1);
        let part_end = (start / part_rows + 1).saturating_mul(part_rows);
        let rows = start..(start + GROUP_ROWS).min(part_end).min(table.rows);
        let mut group = writer.next_row_group()?;
        for column in &table.columns {
            let mut cells = group.next_column()?.ok_or_else(|| {
                parquet::errors::ParquetError::General("fewer columns than the schema".to_owned())
            })?;
            write_cells(column, rows.clone(), &mut cells)?;
            cells.close()?;
        }
        group.close()?;
        start = rows.end;
    }
    writer.close()?;
    Ok(out.flush()?)
}

fn field(column: &Column<'_>) -> Result<Type, TableError> {
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
    rows: std::ops::Range<usize>,
    cells: &mut SerializedColumnWriter<'_>,
) -> Result<(), TableError> {
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
            let words: Vec<ByteArray> = rows.map(|row| ByteArray::from(word(row))).collect();
            (cells.typed::<ByteArrayType>()).write_batch(&words, None, None)?;
        }
    }
    Ok(())
}
