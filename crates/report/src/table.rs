//! Tables: columns and rows, described once for the page, for Markdown and for a terminal.

use std::ops::Range;

use inhand_model::{Finger, Statistics};
use maud::{Markup, Render, html};

use crate::figure::finger_class;
use crate::words::{NONE, count, decimals, millimetres, percent};

/// Head of a line or of a group of lines: a name with swatches of the colours it has in figures.
#[derive(Clone, Debug, Default)]
pub(crate) struct Head {
    classes: Vec<String>,
    text: String,
    hover: Option<String>,
}

impl Head {
    /// A name with one swatch.
    pub(crate) fn coloured(class: impl Into<String>, text: impl Into<String>) -> Self {
        Self::with_swatches(vec![class.into()], text)
    }

    /// A name with a swatch for each class.
    pub(crate) fn with_swatches(classes: Vec<String>, text: impl Into<String>) -> Self {
        Self {
            classes,
            text: text.into(),
            hover: None,
        }
    }

    /// A name that shows more under the pointer.
    pub(crate) fn hovering(text: &str, hover: &str) -> Self {
        Self {
            hover: Some(hover.to_owned()),
            ..text.into()
        }
    }
}

impl From<&str> for Head {
    fn from(text: &str) -> Self {
        Self::with_swatches(Vec::new(), text)
    }
}

impl From<String> for Head {
    fn from(text: String) -> Self {
        Self::with_swatches(Vec::new(), text)
    }
}

impl From<Finger> for Head {
    fn from(finger: Finger) -> Self {
        Self::coloured(finger_class(finger), finger.name())
    }
}

impl Render for Head {
    fn render(&self) -> Markup {
        html! {
            @for class in &self.classes { span.swatch.(class) {} }
            @match &self.hover {
                Some(hover) => span title=(hover) { (self.text) },
                None => (self.text),
            }
        }
    }
}

/// A statistic of a distribution with its name.
pub(crate) type Statistic = (&'static str, fn(&Statistics) -> f64);

/// The statistics in the tables of errors, those that matter most first: a phone shows the first columns.
pub(crate) const SPREAD: [Statistic; 8] = [
    ("median", |s| s.p50),
    ("75 %", |s| s.p75),
    ("95 %", |s| s.p95),
    ("max", |s| s.max),
    ("mean", |s| s.mean),
    ("RMSE", |s| s.rmse),
    ("5 %", |s| s.p5),
    ("25 %", |s| s.p25),
];

/// The upper half of them.
pub(crate) const UPPER: [Statistic; 4] = [SPREAD[0], SPREAD[1], SPREAD[2], SPREAD[3]];

/// A statistic of a distribution; NaN where nothing was evaluated.
pub(crate) fn statistic(s: &Statistics, of: fn(&Statistics) -> f64) -> f64 {
    if s.n == 0 { f64::NAN } else { of(s) }
}

/// Sizes of a sample: `n`, filled and left out.
pub(crate) fn sizes(s: &Statistics) -> [usize; 3] {
    [s.n, s.n_filled, s.n_left_out]
}

/// A cell as printed, and the number by which the smallest of a column is found.
type Cell = (String, f64);

struct Column {
    name: String,
    unit: String,
    /// Whether its cells are words, set to the left.
    words: bool,
    /// Whether the smallest of a group is marked.
    marked: bool,
    /// A cell for each row.
    cells: Vec<Cell>,
}

impl Column {
    /// The smallest of some rows as printed. Equal as printed is equal: no one is shown ahead by digits that nobody
    /// sees. A single row is ahead of no one.
    fn smallest(&self, rows: &Range<usize>) -> Option<&str> {
        let cells = self.cells[rows.clone()].iter();
        let values = cells.filter(|(_, value)| self.marked && value.is_finite());
        let smallest = values.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (rows.len() > 1).then_some(&*smallest.0)
    }
}

/// A table: a caption, groups of rows, and what each column says of a row.
pub(crate) struct Table<R> {
    rows: Vec<R>,
    printed: Printed,
}

impl<R> Table<R> {
    /// A table whose first column is `name`, made of `head`.
    pub(crate) fn new<H: Into<Head>>(
        caption: impl Into<String>,
        rows: impl IntoIterator<Item = R>,
        name: &str,
        head: impl Fn(&R) -> H,
    ) -> Self {
        let rows: Vec<R> = rows.into_iter().collect();
        let mut printed = Printed::new(caption.into(), name);
        printed.add_group(None, rows.len(), &|row| head(&rows[row]).into());
        Self { rows, printed }
    }

    /// A table of groups of rows, each under its head.
    pub(crate) fn grouped<G: Into<Head>, H: Into<Head>>(
        caption: impl Into<String>,
        groups: impl IntoIterator<Item = (G, Vec<R>)>,
        name: &str,
        head: impl Fn(&R) -> H,
    ) -> Self {
        let (mut all, mut printed) = (Vec::new(), Printed::new(caption.into(), name));
        for (group, mut rows) in groups {
            if !rows.is_empty() {
                let group = Some(group.into());
                printed.add_group(group, rows.len(), &|row| head(&rows[row]).into());
                all.append(&mut rows);
            }
        }
        Self { rows: all, printed }
    }

    /// Stresses rows.
    pub(crate) fn stressed(mut self, stressed: impl Fn(&R) -> bool) -> Self {
        (self.printed).stress(&|row| stressed(&self.rows[row]));
        self
    }

    fn column(mut self, name: &str, unit: &str, words: bool, cell: &dyn Fn(&R) -> Cell) -> Self {
        (self.printed).add_column(name, unit, words, &|row| cell(&self.rows[row]));
        self
    }

    /// Adds a column of words.
    pub(crate) fn words(self, name: &str, words: impl Fn(&R) -> String) -> Self {
        self.column(name, "", true, &|row| (words(row), f64::NAN))
    }

    /// Adds a column of numbers as they are printed.
    pub(crate) fn numbers(self, name: &str, unit: &str, number: impl Fn(&R) -> String) -> Self {
        self.column(name, unit, false, &|row| (number(row), f64::NAN))
    }

    /// Adds a column of counts.
    pub(crate) fn counts(self, name: &str, unit: &str, n: impl Fn(&R) -> usize) -> Self {
        self.numbers(name, unit, |row| count(n(row)))
    }

    /// Adds a column of numbers with so many decimals.
    pub(crate) fn decimals(
        self,
        name: &str,
        unit: &str,
        digits: usize,
        value: impl Fn(&R) -> f64,
    ) -> Self {
        self.numbers(name, unit, |row| decimals(value(row), digits))
    }

    /// Adds a column of lengths in millimetres, of metres.
    pub(crate) fn lengths(self, name: &str, metres: impl Fn(&R) -> f64) -> Self {
        self.numbers(name, "mm", |row| millimetres(metres(row)))
    }

    /// Adds a column of percentages, of shares; NaN is a dash.
    pub(crate) fn percents(self, name: &str, unit: &str, share: impl Fn(&R) -> f64) -> Self {
        self.numbers(name, unit, |row| percent(share(row)))
    }

    /// Adds a column for each finger.
    pub(crate) fn fingers(self, unit: &str, cell: impl Fn(&R, Finger) -> String) -> Self {
        Finger::ALL.into_iter().fold(self, |table, finger| {
            table.numbers(finger.name(), unit, |row| cell(row, finger))
        })
    }

    /// Adds the sizes of a sample: `n`, filled and left out.
    pub(crate) fn sizes(self, sizes: impl Fn(&R) -> [usize; 3]) -> Self {
        self.counts("n", "", |row| sizes(row)[0])
            .counts("filled", "", |row| sizes(row)[1])
            .counts("left out", "", |row| sizes(row)[2])
    }

    /// Adds statistics of a distribution in a unit; a dash where nothing was evaluated.
    pub(crate) fn statistics(
        self,
        which: &[Statistic],
        unit: &str,
        print: fn(f64) -> String,
        of: impl Fn(&R) -> Statistics,
    ) -> Self {
        which.iter().fold(self, |table, &(name, place)| {
            table.column(name, unit, false, &|row| {
                let value = statistic(&of(row), place);
                (print(value), value)
            })
        })
    }

    /// Marks the smallest of each column so far that has values to compare.
    pub(crate) fn smallest_marked(mut self) -> Self {
        for column in &mut self.printed.columns {
            column.marked = true;
        }
        self
    }

    /// Whether there is no row.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The rows as a Markdown table.
    pub(crate) fn markdown(&self) -> String {
        self.printed.markdown()
    }

    /// The rows in columns as wide as their widest cell, words to the left and numbers to the right.
    pub(crate) fn aligned(&self) -> String {
        self.printed.aligned()
    }
}

impl<R> Render for Table<R> {
    fn render(&self) -> Markup {
        self.printed.render()
    }
}

/// What is printed of a table. It knows rows by their places alone, so that it is compiled once and not for each
/// type of row.
#[derive(Default)]
struct Printed {
    caption: String,
    /// Groups of rows, each with its head.
    groups: Vec<(Option<Head>, Range<usize>)>,
    name: String,
    /// A head for each row.
    heads: Vec<Head>,
    /// Whether each row is stressed.
    stressed: Vec<bool>,
    columns: Vec<Column>,
}

impl Printed {
    fn new(caption: String, name: &str) -> Self {
        Self {
            caption,
            name: name.to_owned(),
            ..Self::default()
        }
    }

    fn add_group(&mut self, group: Option<Head>, rows: usize, head: &dyn Fn(usize) -> Head) {
        let first = self.heads.len();
        self.groups.push((group, first..first + rows));
        self.heads.extend((0..rows).map(head));
        self.stressed.resize(first + rows, false);
    }

    fn stress(&mut self, stressed: &dyn Fn(usize) -> bool) {
        self.stressed = (0..self.heads.len()).map(stressed).collect();
    }

    fn add_column(&mut self, name: &str, unit: &str, words: bool, cell: &dyn Fn(usize) -> Cell) {
        self.columns.push(Column {
            name: name.to_owned(),
            unit: unit.to_owned(),
            words,
            marked: false,
            cells: (0..self.heads.len()).map(cell).collect(),
        });
    }

    /// Headings with their units, then the cells of each row.
    fn lines(&self) -> Vec<Vec<String>> {
        let headings = self.columns.iter().map(|column| match &*column.unit {
            "" => column.name.clone(),
            unit => format!("{} ({unit})", column.name),
        });
        let mut lines = vec![std::iter::once(self.name.clone()).chain(headings).collect()];
        lines.extend(self.heads.iter().enumerate().map(|(row, head)| {
            let cells = self.columns.iter().map(|own| own.cells[row].0.clone());
            std::iter::once(head.text.clone()).chain(cells).collect()
        }));
        lines
    }

    /// Whether cells are words; the first are.
    fn words_at(&self, place: usize) -> bool {
        place == 0 || self.columns[place - 1].words
    }

    fn markdown(&self) -> String {
        let mut lines = self.lines();
        for (cells, stressed) in lines[1..].iter_mut().zip(&self.stressed) {
            // Numbers are ours and need no escaping.
            for (place, cell) in cells.iter_mut().enumerate() {
                if self.words_at(place) {
                    *cell = escaped(cell);
                }
            }
            if *stressed {
                cells[0] = format!("**{}**", cells[0]);
            }
        }
        let rule = |place| if self.words_at(place) { "---" } else { "---:" }.to_owned();
        lines.insert(1, (0..=self.columns.len()).map(rule).collect());
        (lines.iter())
            .map(|cells| format!("| {} |\n", cells.join(" | ")))
            .collect()
    }

    fn aligned(&self) -> String {
        let mut lines = self.lines();
        // What stands before a colon is the heading of all columns that follow one another with it.
        let headings: Vec<String> = lines[0]
            .iter_mut()
            .map(|heading| {
                let (group, own) = heading.split_once(": ").unwrap_or(("", heading));
                let (group, own) = (group.to_owned(), own.to_owned());
                *heading = own;
                group
            })
            .collect();
        let width = |column: usize| {
            let widths = lines.iter().map(|line| line[column].chars().count());
            widths.max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..=self.columns.len()).map(width).collect();
        let line = |line: &Vec<String>| {
            let cells = line.iter().zip(&widths).enumerate();
            let cells = cells.map(|(place, (cell, &width))| match self.words_at(place) {
                true => format!("{cell:<width$}"),
                false => format!("{cell:>width$}"),
            });
            let cells: Vec<String> = cells.collect();
            cells.join("  ").trim_end().to_owned() + "\n"
        };
        let mut text = String::new();
        if headings.iter().any(|heading| !heading.is_empty()) {
            let columns: Vec<_> = headings.iter().zip(&widths).collect();
            let groups = columns.chunk_by(|a, b| !a.0.is_empty() && a.0 == b.0);
            let groups = groups.map(|group| {
                let width = group.iter().map(|(_, width)| *width + 2).sum::<usize>() - 2;
                format!("{:^width$}", group[0].0)
            });
            text = groups.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n";
        }
        text.extend(lines.iter().map(line));
        text
    }
}

/// The table on the page; it scrolls in itself where a page is narrower.
impl Render for Printed {
    fn render(&self) -> Markup {
        let caption = &self.caption;
        html! {
            // Outside the part that scrolls, so that it is never cut.
            p.caption { (caption) }
            // Focusable, so that a keyboard can scroll it too.
            div.scroll tabindex="0" role="region" aria-label=(caption) {
                table aria-label=(caption) {
                    thead {
                        tr {
                            th.words scope="col" { (self.name) }
                            @for column in &self.columns {
                                th class=[column.words.then_some("words")] scope="col" {
                                    (column.name)
                                    @if !column.unit.is_empty() { span.unit { (column.unit) } }
                                }
                            }
                        }
                    }
                    @for (head, rows) in &self.groups {
                        @let smallest = self.columns.iter().map(|c| c.smallest(rows)).collect::<Vec<_>>();
                        tbody {
                            @if let Some(head) = head {
                                tr.group { th colspan=(1 + self.columns.len()) scope="rowgroup" { span { (head) } } }
                            }
                            @for row in rows.clone() {
                                tr class=[self.stressed[row].then_some("stressed")] {
                                    th scope="row" { (self.heads[row]) }
                                    @for (column, smallest) in self.columns.iter().zip(&smallest) {
                                        @let text = &*column.cells[row].0;
                                        @let best = *smallest == Some(text);
                                        // Most cells have no class, and there are many of them.
                                        td class=[if best { Some("best") } else { column.words.then_some("words") }] { (text) }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Text as text in Markdown: nothing in it is taken for a table, a tag, code, a link, stress or a mention.
pub(crate) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '&' => safe.push_str("&amp;"),
            // A backslash does not keep sites from mentioning people and issues; a character reference does.
            '@' => safe.push_str("&#64;"),
            '#' => safe.push_str("&#35;"),
            '|' | '`' | '*' | '_' | '[' | ']' | '\\' | '~' | '!' => {
                safe.push('\\');
                safe.push(letter);
            }
            '\n' | '\r' => safe.push(' '),
            _ => safe.push(letter),
        }
    }
    safe
}

/// A dash where nothing was evaluated.
pub(crate) fn evaluated(n: usize, text: String) -> String {
    if n == 0 { NONE.to_owned() } else { text }
}

/// Text that may not be known.
pub(crate) fn known(text: Option<String>) -> String {
    text.unwrap_or_else(|| NONE.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_as_printed_is_marked() {
        let marked = |values: &[f64]| {
            let of = |&value: &f64| Statistics {
                n: 1,
                max: value,
                ..Statistics::default()
            };
            let table = Table::new("", values.to_vec(), "", |_| "")
                .statistics(&UPPER[3..], "", |v| decimals(v, 1), of)
                .smallest_marked();
            let page = table.render().into_string();
            let cells = page.split("<td").skip(1);
            cells
                .map(|cell| cell.contains("best"))
                .collect::<Vec<bool>>()
        };
        assert_eq!(marked(&[0.31, 0.34, f64::NAN]), [true, true, false]);
        assert_eq!(marked(&[0.31, 0.36]), [true, false]);
        assert_eq!(marked(&[0.31, 0.29]), [true, true]);
        assert_eq!(marked(&[0.31]), [false]);
    }

    #[test]
    fn names_stay_text() {
        assert_eq!(
            escaped("a|b`c <script>@me #1 [x](y) *z*\n_w_"),
            "a\\|b\\`c &lt;script&gt;&#64;me &#35;1 \\[x\\](y) \\*z\\* \\_w\\_"
        );
        assert_eq!(escaped("0.44 mm (75 %)"), "0.44 mm (75 %)");
    }
}
