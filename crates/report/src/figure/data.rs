//! The numbers behind a figure.

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
    pub name: &'static str,
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
    /// A column of numbers.
    pub fn numbers(name: &'static str, values: impl IntoIterator<Item = f64>) -> Self {
        let values = FigureValues::Numbers(values.into_iter().collect());
        Self { name, values }
    }

    /// A column of counts.
    pub fn counts(name: &'static str, values: impl IntoIterator<Item = usize>) -> Self {
        let values = FigureValues::Counts(values.into_iter().collect());
        Self { name, values }
    }

    /// A column of words.
    pub fn words<W: Into<String>>(name: &'static str, values: impl IntoIterator<Item = W>) -> Self {
        let values = FigureValues::Words(values.into_iter().map(Into::into).collect());
        Self { name, values }
    }

    /// How many cells it has.
    pub fn len(&self) -> usize {
        match &self.values {
            FigureValues::Numbers(values) => values.len(),
            FigureValues::Counts(values) => values.len(),
            FigureValues::Words(values) => values.len(),
        }
    }

    /// Whether it has no cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn cell(&self, row: usize) -> String {
        match &self.values {
            FigureValues::Numbers(values) => (values.get(row))
                .filter(|value| value.is_finite())
                .map_or_else(String::new, ToString::to_string),
            FigureValues::Counts(values) => values
                .get(row)
                .map_or_else(String::new, ToString::to_string),
            FigureValues::Words(values) => quoted(values.get(row).map_or("", String::as_str)),
        }
    }
}

impl FigureData {
    /// A table of these columns.
    pub fn new(columns: impl IntoIterator<Item = FigureColumn>) -> Self {
        let data = Self {
            columns: columns.into_iter().collect(),
        };
        debug_assert!(
            data.columns
                .iter()
                .all(|column| column.len() == data.rows()),
            "columns of a figure's table are equally long"
        );
        data
    }

    /// How many rows it has.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, FigureColumn::len)
    }

    /// The column of that name.
    pub fn column(&self, name: &str) -> Option<&FigureColumn> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The table as CSV (RFC 4180, lines end in a newline): a line of names, then a line a row. Numbers in the fewest digits
    /// that give the same number back; a number that is not known is an empty cell.
    pub fn csv(&self) -> String {
        let line = |cells: Vec<String>| cells.join(",") + "\n";
        let mut text = line(self.columns.iter().map(|c| c.name.to_owned()).collect());
        for row in 0..self.rows() {
            text.push_str(&line(self.columns.iter().map(|c| c.cell(row)).collect()));
        }
        text
    }
}

/// A cell with words, in quotes where its letters could be taken for structure.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_become_csv() {
        let data = FigureData::new([
            FigureColumn::words("take", ["a,b", "say \"hi\"", "plain"]),
            FigureColumn::numbers("error_mm", [0.1, f64::NAN, 1.5e-7]),
            FigureColumn::counts("n", [3, 0, 12_000]),
        ]);
        assert_eq!(
            data.csv(),
            "take,error_mm,n\n\"a,b\",0.1,3\n\"say \"\"hi\"\"\",,0\nplain,0.00000015,12000\n"
        );
        assert_eq!(FigureData::default().csv(), "\n");
        assert!(data.column("n").is_some() && data.column("m").is_none());
    }
}
