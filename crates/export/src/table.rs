//! Tables: named columns with units over rows, and their text forms.

use std::borrow::Cow;
use std::io::Write;
use std::sync::Arc;

use inhand_model::guarded;

use crate::error::ExportError;

/// A column of a table.
pub struct Column<'a> {
    /// Heading; has the unit in it where there is one.
    pub name: String,
    /// Unit: `m`, `s`, `1`, or nothing for words.
    pub unit: &'static str,
    /// Frame of a coordinate, else nothing.
    pub frame: &'static str,
    /// Whether every part of the table has the same cells, such as those of the recorded motion by each method.
    pub(crate) shared: bool,
    pub(crate) values: Values<'a>,
}

/// Cells of a column, by row.
pub(crate) enum Values<'a> {
    /// Numbers; NaN is a blank cell.
    Numbers(Box<dyn Fn(usize) -> f64 + Sync + 'a>),
    Counts(Box<dyn Fn(usize) -> i64 + Sync + 'a>),
    Words(Box<dyn Fn(usize) -> Cow<'a, str> + Sync + 'a>),
}

/// Columns of one length.
pub struct Table<'a> {
    pub(crate) columns: Vec<Column<'a>>,
    /// Rows of each.
    pub rows: usize,
}

/// Describes a table column by column; each cell is computed from the row's value `R` when it is written.
///
/// ```
/// use inhand_export::{TableBuilder, write_csv};
///
/// let samples = [0.5, f64::NAN];
/// let mut table = TableBuilder::new(samples.len(), |row| (row, samples[row]));
/// table.counts("sample", |(row, _)| row);
/// table.numbers("length_m", "m", |(_, length_m)| length_m);
/// let mut csv = Vec::new();
/// write_csv(&table.finish(), &mut csv)?;
/// assert_eq!(csv, b"sample,length_m\n0,0.5\n1,\n");
/// # Ok::<(), inhand_export::ExportError>(())
/// ```
pub struct TableBuilder<'a, F> {
    row: F,
    table: Table<'a>,
}

impl<'a, R, F: Fn(usize) -> R + Clone + Sync + 'a> TableBuilder<'a, F> {
    /// A table without columns whose rows are what `row` returns.
    pub fn new(rows: usize, row: F) -> Self {
        let columns = Vec::new();
        Self {
            row,
            table: Table { columns, rows },
        }
    }

    /// Adds a column of words.
    pub fn words<W: Into<Cow<'a, str>>>(
        &mut self,
        name: impl Into<String>,
        word: impl Fn(R) -> W + Sync + 'a,
    ) -> &mut Column<'a> {
        let row = self.row.clone();
        let values = Values::Words(Box::new(move |k| word(row(k)).into()));
        self.add(name.into(), "", values)
    }

    /// Adds a column of whole numbers.
    pub fn counts(
        &mut self,
        name: impl Into<String>,
        count: impl Fn(R) -> usize + Sync + 'a,
    ) -> &mut Column<'a> {
        let row = self.row.clone();
        // Lists in memory have far fewer places than 63 bits count.
        let values = Values::Counts(Box::new(move |k| count(row(k)) as i64));
        self.add(name.into(), "1", values)
    }

    /// Adds a column of numbers with their unit; NaN is a blank cell.
    pub fn numbers(
        &mut self,
        name: impl Into<String>,
        unit: &'static str,
        number: impl Fn(R) -> f64 + Sync + 'a,
    ) -> &mut Column<'a> {
        let row = self.row.clone();
        let values = Values::Numbers(Box::new(move |k| number(row(k))));
        self.add(name.into(), unit, values)
    }

    fn add(&mut self, name: String, unit: &'static str, values: Values<'a>) -> &mut Column<'a> {
        let columns = &mut self.table.columns;
        let place = columns.len();
        columns.push(Column {
            name,
            unit,
            frame: "",
            shared: false,
            values,
        });
        &mut columns[place]
    }

    /// The table.
    pub fn finish(self) -> Table<'a> {
        self.table
    }
}

/// A table of these rows, still without columns.
pub(crate) fn table_of<'a, R: Clone + Send + Sync + 'a>(
    rows: Vec<R>,
) -> TableBuilder<'a, impl Fn(usize) -> R + Clone + Sync + 'a> {
    let rows: Arc<[R]> = rows.into();
    TableBuilder::new(rows.len(), move |row| rows[row].clone())
}

/// Writes a table as CSV: a heading, then a line for each row, LF, quotes where they are needed, words and names
/// [`guarded`].
///
/// # Errors
///
/// [`ExportError::Write`].
pub fn write_csv(table: &Table<'_>, out: &mut dyn Write) -> Result<(), ExportError> {
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record((table.columns.iter()).map(|column| guarded(&column.name).into_owned()))?;
    write_rows(table, writer, |_| ())
}

/// Writes a table as tab-separated values as BIDS has them: no quotes, `n/a` for blank cells.
pub(crate) fn write_tsv(
    table: &Table<'_>,
    heading: bool,
    out: &mut dyn Write,
) -> Result<(), ExportError> {
    let mut writer = csv::WriterBuilder::new()
        .delimiter(b'\t')
        .quote_style(csv::QuoteStyle::Never)
        .from_writer(out);
    let fit = |cell: &mut Vec<u8>| {
        for byte in cell.iter_mut() {
            if matches!(byte, b'\t' | b'\n' | b'\r') {
                *byte = b' ';
            }
        }
        if cell.is_empty() {
            cell.extend(b"n/a");
        }
    };
    if heading {
        let names = table.columns.iter().map(|column| {
            let mut name = guarded(&column.name).into_owned().into_bytes();
            fit(&mut name);
            name
        });
        writer.write_record(names)?;
    }
    write_rows(table, writer, fit)
}

/// Writes all rows; `fit` changes cells to what the format can hold.
fn write_rows(
    table: &Table<'_>,
    mut writer: csv::Writer<&mut dyn Write>,
    fit: impl Fn(&mut Vec<u8>),
) -> Result<(), ExportError> {
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
                Values::Words(word) => cell.extend_from_slice(guarded(&word(row)).as_bytes()),
            }
            fit(&mut cell);
            writer.write_field(&cell)?;
        }
        writer.write_record(None::<&[u8]>)?;
    }
    Ok(writer.flush()?)
}
