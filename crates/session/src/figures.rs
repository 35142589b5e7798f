//! Figures of a report as files: drawings for print, and the numbers behind them.

use std::path::{Path, PathBuf};

use inhand_export::{RESULTS_KEY, Table, TableBuilder, pdf_of_svg, write_parquet};
use inhand_report::{Figure, FigureData, FigureValues};

use crate::error::{Located, SessionError};
use crate::output::{write_atomic, write_text};

/// Writes figures into a folder: `ID.svg` and `ID.pdf` for print, the numbers that each draws as `ID.csv` and as
/// `ID.parquet`, which has the key of the results. Returns what was written, in the same order.
///
/// # Errors
///
/// [`SessionError::At`], [`SessionError::Io`]. Each file appears whole or not at all.
pub fn write_figures(
    folder: &Path,
    figures: &[Figure],
    key: Option<&str>,
) -> Result<Vec<PathBuf>, SessionError> {
    let written = inhand_parallel::try_map(figures, |figure| write_figure(folder, figure, key))?;
    Ok(written.into_iter().flatten().collect())
}

fn write_figure(
    folder: &Path,
    figure: &Figure,
    key: Option<&str>,
) -> Result<[PathBuf; 4], SessionError> {
    let file = |extension: &str| folder.join(format!("{}.{extension}", figure.id));
    let files @ [svg, pdf, csv, parquet] = &["svg", "pdf", "csv", "parquet"].map(file);
    let drawing = figure.print_svg();
    write_text(svg, &drawing)?;
    write_text(pdf, &pdf_of_svg(&drawing))?;
    write_text(csv, &figure.data.csv())?;
    let about = [
        ("inhand.figure", figure.title.clone()),
        (RESULTS_KEY, key.unwrap_or_default().to_owned()),
    ];
    let table = table(&figure.data);
    write_atomic(parquet, |out| {
        write_parquet(&table, table.rows, &about, out).in_file(parquet)
    })?;
    Ok(files.clone())
}

fn table(data: &FigureData) -> Table<'_> {
    let mut table = TableBuilder::new(data.rows(), |row| row);
    for column in &data.columns {
        let added = match &column.values {
            FigureValues::Numbers(values) => table.numbers(&column.name, "", |row| {
                values.get(row).copied().unwrap_or(f64::NAN)
            }),
            FigureValues::Counts(values) => {
                table.counts(&column.name, |row| values.get(row).copied().unwrap_or(0))
            }
            FigureValues::Words(values) => table.words(&column.name, |row| {
                values.get(row).map_or("", String::as_str)
            }),
        };
        added.unit = unit(&column.name);
    }
    table.finish()
}

/// The unit that a column's name ends in; none where it is no unit.
fn unit(name: &str) -> &'static str {
    const UNITS: [(&str, &str); 7] = [
        ("_mm2_hz", "mm²/Hz"),
        ("_mm2", "mm²"),
        ("_mm", "mm"),
        ("_percent", "%"),
        ("_ms", "ms"),
        ("_hz", "Hz"),
        ("_s", "s"),
    ];
    let known = UNITS.iter().find(|(ending, _)| name.ends_with(ending));
    known.map_or("", |(_, unit)| unit)
}
