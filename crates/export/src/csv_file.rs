//! Tables as CSV.

use std::io::Write;

use crate::error::TableError;
use crate::table::{Table, Values};

/// Writes a table as CSV: a heading, then a line for each row, LF, quotes where they are needed.
///
/// # Errors
///
/// [`TableError::Write`].
pub fn write_csv(table: &Table<'_>, out: impl Write) -> Result<(), TableError> {
    let mut writer = csv::Writer::from_writer(out);
    let headings = table.columns.iter().map(|column| column.name.as_str());
    writer.write_record(headings).map_err(csv_error)?;
    let mut cell = Vec::new();
    for row in 0..table.rows {
        for column in &table.columns {
            cell.clear();
            match &column.values {
                Values::Numbers(number) => {
                    let number = number(row);
                    if !number.is_nan() {
                        write!(cell, "{number}")?;
                    }
                }
                Values::Counts(count) => write!(cell, "{}", count(row))?,
                Values::Words(word) => cell.extend_from_slice(word(row).as_bytes()),
            }
            writer.write_field(&cell).map_err(csv_error)?;
        }
        writer.write_record(None::<&[u8]>).map_err(csv_error)?;
    }
    Ok(writer.flush()?)
}

pub(crate) fn csv_error(error: csv::Error) -> TableError {
    let source = match error.into_kind() {
        csv::ErrorKind::Io(source) => source,
        other => std::io::Error::other(format!("{other:?}")),
    };
    TableError::Write { source }
}
