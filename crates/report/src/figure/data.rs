//! The numbers behind a figure.

use inhand_model::{Statistics, guarded};

use crate::table::{Statistic, statistic};
use crate::words::to_mm;

/// The table behind a figure: named columns of the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FigureData {
    /// Columns from left to right.
    pub columns: Vec<FigureColumn>,
}

/// A column of a figure's table.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureColumn {
    /// Name, with the unit at its end where there is one: `error_mm`, `share_percent`.
    pub name: String,
    /// Its cells.
    pub values: FigureValues,
}

/// Cells of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum FigureValues {
    /// Numbers; NaN where one is not known.
    Numbers(Vec<f64>),
    /// Counts.
    Counts(Vec<usize>),
    /// Words.
    Words(Vec<String>),
}

impl FigureColumn {
    fn cells(&self) -> usize {
        match &self.values {
            FigureValues::Numbers(values) => values.len(),
            FigureValues::Counts(values) => values.len(),
            FigureValues::Words(values) => values.len(),
        }
    }

    fn cell(&self, row: usize) -> String {
        match &self.values {
            FigureValues::Numbers(values) => (values.get(row))
                .filter(|value| value.is_finite())
                .map_or_else(String::new, ToString::to_string),
            FigureValues::Counts(values) => values
                .get(row)
                .map_or_else(String::new, ToString::to_string),
            FigureValues::Words(values) => quoted(values.get(row)),
        }
    }
}

impl FigureData {
    /// Begins a table about these rows.
    pub(crate) fn about<R>(rows: &[R]) -> DataColumns<'_, R> {
        let columns = Vec::new();
        DataColumns { rows, columns }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, FigureColumn::cells)
    }

    /// The column of that name.
    pub fn column(&self, name: &str) -> Option<&FigureColumn> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The table as CSV (RFC 4180, lines end in a newline): a line of names, then a line a row. Numbers in the fewest digits
    /// that give the same number back; a number that is not known is an empty cell. Words are [`guarded`].
    pub fn csv(&self) -> String {
        let line = |cells: Vec<String>| cells.join(",") + "\n";
        let mut text = line(self.columns.iter().map(|c| c.name.clone()).collect());
        for row in 0..self.rows() {
            text.push_str(&line(self.columns.iter().map(|c| c.cell(row)).collect()));
        }
        text
    }
}

/// Columns of a table, each read off the same rows.
pub(crate) struct DataColumns<'a, R> {
    rows: &'a [R],
    columns: Vec<FigureColumn>,
}

impl<'a, R> DataColumns<'a, R> {
    fn column<V>(
        mut self,
        name: &str,
        kind: fn(Vec<V>) -> FigureValues,
        cell: &dyn Fn(&'a R) -> V,
    ) -> Self {
        let values = kind(cells(self.rows.len(), &|row| cell(&self.rows[row])));
        let name = name.to_owned();
        self.columns.push(FigureColumn { name, values });
        self
    }

    /// Adds a column of words.
    pub(crate) fn words<W: Into<String>>(self, name: &str, words: impl Fn(&'a R) -> W) -> Self {
        self.column(name, FigureValues::Words, &|row| words(row).into())
    }

    /// Adds a column of counts.
    pub(crate) fn counts(self, name: &str, count: impl Fn(&'a R) -> usize) -> Self {
        self.column(name, FigureValues::Counts, &count)
    }

    /// Adds a column of numbers.
    pub(crate) fn numbers(self, name: &str, number: impl Fn(&'a R) -> f64) -> Self {
        self.column(name, FigureValues::Numbers, &number)
    }

    /// Adds a column for each coordinate of a point, millimetres.
    pub(crate) fn points(self, point_mm: impl Fn(&'a R) -> [f64; 3]) -> Self {
        (["x_mm", "y_mm", "z_mm"].into_iter().enumerate()).fold(self, |columns, (axis, name)| {
            columns.numbers(name, |row| point_mm(row)[axis])
        })
    }

    /// Adds the sizes of a distribution of lengths and those of its statistics that are named.
    pub(crate) fn lengths(self, names: &[&str], of: impl Fn(&'a R) -> &'a Statistics) -> Self {
        let sizes = self
            .counts("n", |row| of(row).n)
            .counts("n_filled", |row| of(row).n_filled)
            .counts("n_left_out", |row| of(row).n_left_out);
        let named = STATISTICS.iter().filter(|(name, _)| names.contains(name));
        named.fold(sizes, |columns, &(name, place)| {
            columns.numbers(&format!("{name}_mm"), |row| {
                to_mm(statistic(of(row), place))
            })
        })
    }

    /// The table.
    pub(crate) fn done(self) -> FigureData {
        FigureData {
            columns: self.columns,
        }
    }
}

/// Cells of rows by their places, so that this is compiled once for each type of cell and not for each type of row.
fn cells<V>(rows: usize, cell: &dyn Fn(usize) -> V) -> Vec<V> {
    (0..rows).map(cell).collect()
}

/// Statistics by their names in tables.
pub(crate) const STATISTICS: [Statistic; 11] = [
    ("mean", |s| s.mean),
    ("rmse", |s| s.rmse),
    ("min", |s| s.min),
    ("whisker_low", |s| s.whisker_low),
    ("p5", |s| s.p5),
    ("p25", |s| s.p25),
    ("p50", |s| s.p50),
    ("p75", |s| s.p75),
    ("p95", |s| s.p95),
    ("whisker_high", |s| s.whisker_high),
    ("max", |s| s.max),
];

/// A cell with words, in quotes where its letters could be taken for structure.
fn quoted(word: Option<&String>) -> String {
    let text = guarded(word.map_or("", |word| word));
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.into_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_become_csv() {
        let rows = [
            ("a,b", 0.1, 3),
            ("say \"hi\"", f64::NAN, 0),
            ("plain", 1.5e-7, 12_000),
            ("=1+1", -1.0, 0),
        ];
        let data = FigureData::about(&rows)
            .words("take", |row| row.0)
            .numbers("error_mm", |row| row.1)
            .counts("n", |row| row.2)
            .done();
        assert_eq!(
            data.csv(),
            "take,error_mm,n\n\"a,b\",0.1,3\n\"say \"\"hi\"\"\",,0\nplain,0.00000015,12000\n'=1+1,-1,0\n"
        );
        assert_eq!(FigureData::default().csv(), "\n");
        assert!(data.column("n").is_some() && data.column("m").is_none());
    }
}
