//! Rows of numbers: the part of a vendor file below its header.
//!
//! The lines are parsed in pieces of a fixed size, several at a time, and handed on in order, so
//! that the result does not depend on the number of threads.

use memchr::{memchr, memchr_iter};
use rayon::prelude::*;

use crate::error::CaptureError;
use crate::lines::Run;
use crate::text::{count_lines, excerpt};

/// Bytes of a block: a few hundred rows, large against the cost of handing it to a thread, small
/// against its cache.
const BLOCK_BYTES: usize = 128 * 1024;

/// Largest frame number; every integer up to it is exact as f64.
const MAX_FRAME: f64 = 9_007_199_254_740_992.0;

/// Content of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Column {
    /// The frame number.
    Frame,
    /// Seconds since the first frame.
    Time,
    /// A number to keep.
    Value,
    /// Nothing to keep; any text.
    Skip,
}

/// Length of a text file, or of the part below its header.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Extent {
    /// Bytes.
    pub bytes: u64,
    /// Line ends.
    pub line_ends: u64,
}

impl Extent {
    /// Adds the next bytes of the file.
    pub fn add(&mut self, bytes: &[u8]) {
        self.bytes += bytes.len() as u64;
        self.line_ends += count_lines(bytes) as u64;
    }

    /// The rest below a header of so many bytes and lines.
    pub(crate) fn below(self, bytes: usize, line_ends: usize) -> Self {
        Self {
            bytes: self.bytes.saturating_sub(bytes as u64),
            line_ends: self.line_ends.saturating_sub(line_ends as u64),
        }
    }
}

/// Meaning of the columns of text rows.
pub(crate) struct Table {
    /// Name of the file, for messages.
    file: String,
    /// Byte between cells.
    delimiter: u8,
    columns: Vec<Column>,
    /// Name of each column in messages.
    labels: Vec<String>,
    /// Number of [`Column::Value`] columns.
    values: usize,
    /// A row may end behind this many cells: all values behind them are then blank.
    pub(crate) may_end_after: Option<usize>,
}

/// Consecutive rows as numbers.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    /// Frame number of each row; empty where the table has no such column.
    pub(crate) frames: Vec<i64>,
    /// Time of each row, NaN where blank; empty where the table has no such column.
    pub(crate) times_s: Vec<f64>,
    /// The [`Column::Value`] cells, row by row; NaN where blank.
    pub(crate) values: Vec<f64>,
    /// Line of the file of each row, from 1.
    pub(crate) lines: Vec<usize>,
    /// Line of the last row, where the file ends within it.
    pub(crate) cut: Option<usize>,
}

impl Table {
    pub(crate) fn new(file: &str, delimiter: u8) -> Self {
        Self {
            file: file.to_owned(),
            delimiter,
            columns: Vec::new(),
            labels: Vec::new(),
            values: 0,
            may_end_after: None,
        }
    }

    /// Adds a column of which no value is kept.
    pub(crate) fn push(&mut self, column: Column, label: String) {
        self.columns.push(column);
        self.labels.push(label);
    }

    /// Adds a column of numbers; returns its place among the values of a row.
    pub(crate) fn push_value(&mut self, label: String) -> usize {
        self.push(Column::Value, label);
        self.values += 1;
        self.values - 1
    }

    /// Adds the X, Y and Z of a marker; returns their places among the values of a row.
    pub(crate) fn push_marker(&mut self, name: &str) -> [usize; 3] {
        ["X", "Y", "Z"].map(|axis| self.push_value(format!("\"{name}\" {axis}")))
    }

    /// Number of [`Column::Value`] columns.
    pub(crate) fn values(&self) -> usize {
        self.values
    }

    /// An upper bound for the number of rows in so much text: no row is shorter than its
    /// delimiters, so this stays in proportion to the text even where that is all line ends.
    pub(crate) fn rows_at_most(&self, extent: Extent) -> u64 {
        (extent.line_ends + 1).min(extent.bytes / self.required_cells().max(1) as u64 + 1)
    }

    /// Cells that every row must have: up to the last column that is read.
    fn required_cells(&self) -> usize {
        let last = (self.columns.iter()).rposition(|&column| column != Column::Skip);
        last.map_or(0, |last| last + 1)
    }

    /// Parses whole lines: pieces in order, each of them rows or the error of one that is damaged.
    pub(crate) fn parse(&self, run: &Run<'_>) -> Vec<Result<Rows, CaptureError>> {
        let mut line = run.first_line;
        let pieces: Vec<(&[u8], usize)> = blocks(run.bytes)
            .map(|block| {
                let first_line = line;
                line += count_lines(block);
                (block, first_line)
            })
            .collect();
        let parse = |&(block, first_line): &(&[u8], usize)| self.parse_block(block, first_line);
        pieces.par_iter().map(parse).collect()
    }

    fn parse_block(&self, block: &[u8], first_line: usize) -> Result<Rows, CaptureError> {
        let mut rows = Rows::default();
        let required = self.required_cells();
        let estimate = block.len() / required.max(1) / 4 + 1;
        rows.values.reserve(estimate * self.values);
        let has_frames = self.columns.contains(&Column::Frame);
        let mut rest = block;
        for number in first_line.. {
            if rest.is_empty() {
                break;
            }
            let line_end = memchr(b'\n', rest);
            let end = line_end.unwrap_or(rest.len());
            let line = &rest[..end];
            rest = rest.get(end + 1..).unwrap_or_default();
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            if line_end.is_none() && self.is_cut(line) {
                // Only the end of the file has no end of line: copies break off anywhere.
                rows.cut = Some(number);
            } else if !self.is_no_row(line, has_frames) {
                self.parse_row(line, number, required, &mut rows)?;
                rows.lines.push(number);
            }
        }
        debug_assert!(!has_frames || rows.frames.len() == rows.lines.len());
        Ok(rows)
    }

    /// Whether a line holds nothing at all. With a frame column a line of delimiters alone, as
    /// spreadsheets leave them, is none either; without one it is a sample with all markers
    /// missing.
    fn is_no_row(&self, line: &[u8], has_frames: bool) -> bool {
        let nothing = |&byte: &u8| byte == b' ' || (has_frames && byte == self.delimiter);
        line.first().is_none_or(nothing) && line.iter().all(nothing)
    }

    /// Whether a line has fewer cells than a row.
    fn is_cut(&self, line: &[u8]) -> bool {
        let cells = memchr_iter(self.delimiter, line).count() + 1;
        !line.is_empty() && cells < self.required_cells() && self.may_end_after != Some(cells)
    }

    fn parse_row(
        &self,
        line: &[u8],
        line_number: usize,
        required: usize,
        rows: &mut Rows,
    ) -> Result<(), CaptureError> {
        let mut at = 0;
        for (index, &column) in self.columns.iter().enumerate() {
            let error = |expected: &str, end: usize| {
                let place = format_args!("{} ({})", index + 1, self.labels[index]);
                let found = excerpt(&line[at..end]);
                let problem = format_args!("expected {expected}, found {found:?}");
                CaptureError::in_cell(&self.file, line_number, place, problem)
            };
            let end = if column == Column::Skip {
                cell_end(line, at, self.delimiter)
            } else {
                let (number, end) = number(line, at, self.delimiter)
                    .ok_or_else(|| error("a number", cell_end(line, at, self.delimiter)))?;
                match column {
                    Column::Value => rows.values.push(number),
                    Column::Time => rows.times_s.push(number),
                    _ => (rows.frames)
                        .push(frame(number).ok_or_else(|| error("a frame number", end))?),
                }
                end
            };
            if end == line.len() {
                let found = index + 1;
                if found < required {
                    if self.may_end_after != Some(found) {
                        let file = &self.file;
                        return Err(CaptureError::too_few_cells(
                            file,
                            line_number,
                            required,
                            found,
                        ));
                    }
                    let rest = self.columns[found..].iter();
                    let blank = rest.filter(|&&column| column == Column::Value).count();
                    rows.values.extend(std::iter::repeat_n(f64::NAN, blank));
                }
                return Ok(());
            }
            at = end + 1;
        }
        let rest = &line[at.min(line.len())..];
        let blank = |&byte: &u8| byte == self.delimiter || byte == b' ' || byte == b'\t';
        if rest.iter().all(blank) {
            return Ok(());
        }
        let (columns, found) = (self.columns.len(), excerpt(rest));
        Err(CaptureError::too_many_cells(
            &self.file,
            line_number,
            columns,
            &found,
        ))
    }
}

/// Pieces of about [`BLOCK_BYTES`] that end with a line.
fn blocks(mut data: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        if data.is_empty() {
            return None;
        }
        let at_least = data.len().min(BLOCK_BYTES);
        let end = memchr(b'\n', &data[at_least..]).map_or(data.len(), |more| at_least + more + 1);
        let (block, rest) = data.split_at(end);
        data = rest;
        Some(block)
    })
}

fn cell_end(line: &[u8], at: usize, delimiter: u8) -> usize {
    memchr(delimiter, &line[at..]).map_or(line.len(), |length| at + length)
}

/// The number that a cell holds, NaN where it is blank or says that it is none; `None` for any
/// other text, and for infinity.
pub(crate) fn cell_number(cell: &[u8]) -> Option<f64> {
    // No cell holds a line end.
    number(cell, 0, b'\n').map(|(number, _)| number)
}

/// The number in the cell that starts at `at`, NaN where it is blank or says that it is none, and
/// where the cell ends. `None` for any other text, and for infinity.
#[inline]
fn number(line: &[u8], at: usize, delimiter: u8) -> Option<(f64, usize)> {
    let cell = &line[at..];
    if cell.first().is_none_or(|&byte| byte == delimiter) {
        return Some((f64::NAN, at));
    }
    if let Some((number, length)) = plain_decimal(cell)
        && cell.get(length).is_none_or(|&byte| byte == delimiter)
    {
        return Some((number, at + length));
    }
    if let Ok((number, length)) = fast_float2::parse_partial::<f64, _>(cell)
        && number.is_finite()
        && cell.get(length).is_none_or(|&byte| byte == delimiter)
    {
        return Some((number, at + length));
    }
    unusual_number(line, at, delimiter)
}

/// Most digits of a plain decimal: their number is below 2^53, and so exact as f64.
const PLAIN_DIGITS: usize = 15;

/// Powers of ten that are exact as f64.
const POWERS_OF_TEN: [f64; PLAIN_DIGITS + 1] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
];

/// A number of a few digits without exponent, as nearly all cells are, and its length. The
/// quotient of two exact numbers is the f64 nearest to the decimal, as any parser has to give it.
#[inline]
fn plain_decimal(cell: &[u8]) -> Option<(f64, usize)> {
    let negative = cell.first() == Some(&b'-');
    let mut at = usize::from(negative);
    let mut digits = 0_u64;
    let mut take_digits = |from: usize| {
        let mut end = from;
        while let Some(digit) = cell.get(end).map(|byte| byte.wrapping_sub(b'0'))
            && digit < 10
        {
            // What wraps has too many digits.
            digits = digits.wrapping_mul(10).wrapping_add(u64::from(digit));
            end += 1;
        }
        end - from
    };
    let whole = take_digits(at);
    at += whole;
    let mut decimals = 0;
    if cell.get(at) == Some(&b'.') {
        decimals = take_digits(at + 1);
        at += 1 + decimals;
    }
    if !(1..=PLAIN_DIGITS).contains(&(whole + decimals)) {
        return None;
    }
    let number = digits as f64 / POWERS_OF_TEN[decimals];
    Some((if negative { -number } else { number }, at))
}

/// Cells with spaces or quotes around them, with a decimal comma, and the spellings of "not a number".
#[cold]
fn unusual_number(line: &[u8], at: usize, delimiter: u8) -> Option<(f64, usize)> {
    let end = cell_end(line, at, delimiter);
    let mut text = line[at..end].trim_ascii();
    if let [b'"', inner @ .., b'"'] = text {
        text = inner.trim_ascii();
    }
    // Spreadsheets of many countries write a decimal comma, where it separates nothing else.
    let commas = memchr::memchr_iter(b',', text).count();
    let with_point: Vec<u8>;
    if delimiter != b',' && commas == 1 && memchr(b'.', text).is_none() {
        let point = |&byte: &u8| if byte == b',' { b'.' } else { byte };
        with_point = text.iter().map(point).collect();
        text = &with_point;
    }
    let number = if text.is_empty() {
        f64::NAN
    } else if let Ok(number) = fast_float2::parse::<f64, _>(text) {
        if number.is_infinite() {
            return None;
        }
        number
    } else {
        // What C runtimes print for NaN.
        let unsigned = text.strip_prefix(b"-").unwrap_or(text).to_ascii_lowercase();
        let nan = unsigned.starts_with(b"nan(")
            || unsigned.starts_with(b"1.#ind")
            || unsigned.starts_with(b"1.#qnan");
        if !nan {
            return None;
        }
        f64::NAN
    };
    Some((number, end))
}

/// A frame number, where it is a whole one.
pub(crate) fn frame(number: f64) -> Option<i64> {
    (number.fract() == 0.0 && number.abs() <= MAX_FRAME).then_some(number as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(columns: &[Column]) -> Table {
        let mut table = Table::new("a.csv", b',');
        for (k, &column) in columns.iter().enumerate() {
            match column {
                Column::Value => drop(table.push_value(format!("c{k}"))),
                _ => table.push(column, format!("c{k}")),
            }
        }
        table
    }

    const COLUMNS: [Column; 5] = [
        Column::Frame,
        Column::Time,
        Column::Skip,
        Column::Value,
        Column::Value,
    ];

    fn parse(data: &[u8]) -> Result<(Vec<i64>, Vec<f64>), String> {
        let mut frames = Vec::new();
        let mut values = Vec::new();
        let run = Run {
            bytes: data,
            first_line: 8,
        };
        for rows in table(&COLUMNS).parse(&run) {
            let rows = rows.map_err(|e| e.to_string())?;
            frames.extend_from_slice(&rows.frames);
            values.extend_from_slice(&rows.values);
        }
        Ok((frames, values))
    }

    #[test]
    fn cells_that_are_numbers() {
        for (cell, expected) in [
            ("1.5", 1.5),
            ("-0.000001", -1e-6),
            ("+2", 2.0),
            ("1E-3", 1e-3),
            (" 7 ", 7.0),
            ("\"7\"", 7.0),
            (".5", 0.5),
        ] {
            let row = format!("0,0,x,{cell},1\n");
            assert_eq!(parse(row.as_bytes()).unwrap().1[0], expected, "{cell}");
        }
        for cell in [
            "",
            " ",
            "\"\"",
            "nan",
            "NAN",
            "-nan",
            "-nan(ind)",
            "-1.#IND00",
            "1.#QNAN",
        ] {
            let row = format!("0,0,x,{cell},1\n");
            assert!(parse(row.as_bytes()).unwrap().1[0].is_nan(), "{cell}");
        }
    }

    #[test]
    fn a_decimal_comma_is_one_where_commas_separate_no_cells() {
        for (cell, expected) in [("-1,25", -1.25), ("\"0,5\"", 0.5), ("1,5E-3", 1.5e-3)] {
            assert_eq!(cell_number(cell.as_bytes()), Some(expected), "{cell}");
        }
        assert_eq!(number(b"1,5\t2", 0, b'\t'), Some((1.5, 3)));
        for cell in ["1,2,3", "1.234,5", ",", "1,x"] {
            assert_eq!(cell_number(cell.as_bytes()), None, "{cell}");
        }
    }

    #[test]
    fn plain_decimals_are_the_nearest_numbers() {
        let mut x = 1_u64;
        for k in 0..20_000 {
            x = x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let digits = (x >> 11) % 10_u64.pow(1 + k % 17);
            let decimals = (k % 13) as usize;
            let text = format!("{digits:0width$}", width = decimals + 1);
            let (whole, fraction) = text.split_at(text.len() - decimals);
            for sign in ["", "-"] {
                let text = format!("{sign}{whole}.{fraction}");
                let expected: f64 = text.parse().unwrap();
                let (found, end) = number(text.as_bytes(), 0, b',').unwrap();
                assert_eq!(
                    (found.to_bits(), end),
                    (expected.to_bits(), text.len()),
                    "{text}"
                );
            }
        }
        for none in ["", "-", ".", "-.", "+1", "e5", "1234567890123456"] {
            assert_eq!(plain_decimal(none.as_bytes()), None, "{none}");
        }
    }

    #[test]
    fn cells_that_are_not() {
        for cell in [
            "1.0.24",
            "x",
            "inf",
            "-Infinity",
            "1e999",
            "1 2",
            "0x10",
            "\"1",
            "\0",
            "--1",
        ] {
            let row = format!("0,0,x,1,{cell}\n");
            let message = parse(row.as_bytes()).unwrap_err();
            assert!(
                message.starts_with("a.csv, line 8, column 5 (c4): expected a number, found"),
                "{message}"
            );
        }
        for frame in ["", "1.5", "x", "1e300"] {
            assert!(
                parse(format!("{frame},0,x,1,1\n").as_bytes()).is_err(),
                "{frame}"
            );
        }
    }

    #[test]
    fn rows_of_every_shape() {
        let (frames, values) = parse(b"0,0,x,1,2\r\n\r\n,,,,\n1,0,,3,4,,\n2,0,\"a\",5,6").unwrap();
        assert_eq!(frames, [0, 1, 2]);
        assert_eq!(values, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(
            parse(b"0,0,x,1,2\n1,0,x,1\n").unwrap_err(),
            "a.csv, line 9: expected 5 cells, found 4: the row is cut off"
        );
        assert_eq!(
            parse(b"0,0,x,1,2\n\n1,0,x,1,2,3\n").unwrap_err(),
            "a.csv, line 10, column 6: expected no more than the header's 5 columns, found \"3\": \
             is a comma used as decimal point?"
        );
        assert_eq!(parse(b"").unwrap(), (vec![], vec![]));
    }

    #[test]
    fn many_blocks_keep_order_and_line_numbers() {
        let rows = 40_000;
        let mut text: String = (0..rows).map(|k| format!("{k},0,x,{k}.25,-1\n")).collect();
        assert!(text.len() > 3 * BLOCK_BYTES);
        let (frames, values) = parse(text.as_bytes()).unwrap();
        assert_eq!(frames.len(), rows);
        assert!((0..rows).all(|k| values[2 * k] == k as f64 + 0.25));
        // Two errors in different blocks: the earlier one counts.
        text.push_str("39,0,x,oops,1\n");
        let text = text.replacen("31000,0,x,31000.25", "31000,0,x,3x", 1);
        let message = parse(text.as_bytes()).unwrap_err();
        assert!(message.contains("line 31008, column 4"), "{message}");
        assert!(message.contains("found \"3x\""), "{message}");
    }

    #[test]
    fn the_bound_on_rows_holds_and_stays_small() {
        let bound = |bytes: &[u8]| {
            let mut extent = Extent::default();
            extent.add(bytes);
            table(&COLUMNS).rows_at_most(extent)
        };
        assert_eq!(bound(&[b'\n'; 1000]), 201);
        assert_eq!(bound(b"0,0,,1,2\n1,0,,1,2"), 2);
    }
}
