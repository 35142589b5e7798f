//! Tables: columns and rows, described once for the page, for Markdown and for a terminal.

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

/// The statistics in the tables of errors.
pub(crate) const SPREAD: [Statistic; 8] = [
    ("mean", |s| s.mean),
    ("RMSE", |s| s.rmse),
    ("5 %", |s| s.p5),
    ("25 %", |s| s.p25),
    ("median", |s| s.p50),
    ("75 %", |s| s.p75),
    ("95 %", |s| s.p95),
    ("max", |s| s.max),
];

/// The upper half of them.
pub(crate) const UPPER: [Statistic; 4] = [SPREAD[4], SPREAD[5], SPREAD[6], SPREAD[7]];

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

struct Column<'a, R> {
    name: String,
    unit: String,
    /// Whether its cells are words, set to the left.
    words: bool,
    /// Whether the smallest of a group is marked.
    marked: bool,
    cell: Box<dyn Fn(&R) -> Cell + 'a>,
}

/// A table: a caption, groups of rows, and what each column says of a row.
pub(crate) struct Table<'a, R> {
    caption: String,
    groups: Vec<(Option<Head>, Vec<R>)>,
    name: &'a str,
    head: Box<dyn Fn(&R) -> Head + 'a>,
    stressed: Box<dyn Fn(&R) -> bool + 'a>,
    columns: Vec<Column<'a, R>>,
}

impl<'a, R> Table<'a, R> {
    /// A table whose first column is `name`, made of `head`.
    pub(crate) fn new<H: Into<Head>>(
        caption: impl Into<String>,
        rows: impl IntoIterator<Item = R>,
        name: &'a str,
        head: impl Fn(&R) -> H + 'a,
    ) -> Self {
        let groups = vec![(None, rows.into_iter().collect())];
        Self::with_groups(caption, groups, name, head)
    }

    /// A table of groups of rows, each under its head.
    pub(crate) fn grouped<G: Into<Head>, H: Into<Head>>(
        caption: impl Into<String>,
        groups: impl IntoIterator<Item = (G, Vec<R>)>,
        name: &'a str,
        head: impl Fn(&R) -> H + 'a,
    ) -> Self {
        let groups = groups.into_iter().filter(|(_, rows)| !rows.is_empty());
        let groups = groups.map(|(head, rows)| (Some(head.into()), rows));
        Self::with_groups(caption, groups.collect(), name, head)
    }

    fn with_groups<H: Into<Head>>(
        caption: impl Into<String>,
        groups: Vec<(Option<Head>, Vec<R>)>,
        name: &'a str,
        head: impl Fn(&R) -> H + 'a,
    ) -> Self {
        Self {
            caption: caption.into(),
            groups,
            name,
            head: Box::new(move |row| head(row).into()),
            stressed: Box::new(|_| false),
            columns: Vec::new(),
        }
    }

    /// Stresses rows.
    pub(crate) fn stressed(mut self, stressed: impl Fn(&R) -> bool + 'a) -> Self {
        self.stressed = Box::new(stressed);
        self
    }

    fn column(
        mut self,
        name: impl Into<String>,
        unit: impl Into<String>,
        words: bool,
        cell: impl Fn(&R) -> Cell + 'a,
    ) -> Self {
        self.columns.push(Column {
            name: name.into(),
            unit: unit.into(),
            words,
            marked: false,
            cell: Box::new(cell),
        });
        self
    }

    /// Adds a column of words.
    pub(crate) fn words(self, name: impl Into<String>, words: impl Fn(&R) -> String + 'a) -> Self {
        self.column(name, "", true, move |row| (words(row), f64::NAN))
    }

    /// Adds a column of numbers as they are printed.
    pub(crate) fn numbers(
        self,
        name: impl Into<String>,
        unit: impl Into<String>,
        number: impl Fn(&R) -> String + 'a,
    ) -> Self {
        self.column(name, unit, false, move |row| (number(row), f64::NAN))
    }

    /// Adds a column of counts.
    pub(crate) fn counts(
        self,
        name: impl Into<String>,
        unit: impl Into<String>,
        n: impl Fn(&R) -> usize + 'a,
    ) -> Self {
        self.numbers(name, unit, move |row| count(n(row)))
    }

    /// Adds a column of numbers with so many decimals.
    pub(crate) fn decimals(
        self,
        name: &str,
        unit: &str,
        digits: usize,
        value: impl Fn(&R) -> f64 + 'a,
    ) -> Self {
        self.numbers(name, unit, move |row| decimals(value(row), digits))
    }

    /// Adds a column of lengths in millimetres, of metres.
    pub(crate) fn lengths(self, name: &str, metres: impl Fn(&R) -> f64 + 'a) -> Self {
        self.numbers(name, "mm", move |row| millimetres(metres(row)))
    }

    /// Adds a column of percentages, of shares; NaN is a dash.
    pub(crate) fn percents(self, name: &str, unit: &str, share: impl Fn(&R) -> f64 + 'a) -> Self {
        self.numbers(name, unit, move |row| percent(share(row)))
    }

    /// Adds a column for each finger.
    pub(crate) fn fingers(
        self,
        unit: &str,
        cell: impl Fn(&R, Finger) -> String + Copy + 'a,
    ) -> Self {
        Finger::ALL.into_iter().fold(self, |table, finger| {
            table.numbers(finger.name(), unit, move |row| cell(row, finger))
        })
    }

    /// Adds the sizes of a sample: `n`, filled and left out.
    pub(crate) fn sizes(self, sizes: impl Fn(&R) -> [usize; 3] + Copy + 'a) -> Self {
        self.counts("n", "", move |row| sizes(row)[0])
            .counts("filled", "", move |row| sizes(row)[1])
            .counts("left out", "", move |row| sizes(row)[2])
    }

    /// Adds statistics of a distribution in a unit; a dash where nothing was evaluated.
    pub(crate) fn statistics(
        self,
        which: &[Statistic],
        unit: &str,
        print: fn(f64) -> String,
        of: impl Fn(&R) -> Statistics + Copy + 'a,
    ) -> Self {
        which.iter().fold(self, |table, &(name, place)| {
            table.column(name, unit, false, move |row| {
                let value = statistic(&of(row), place);
                (print(value), value)
            })
        })
    }

    /// Marks the smallest of each column so far that has values to compare.
    pub(crate) fn smallest_marked(mut self) -> Self {
        self.columns
            .iter_mut()
            .for_each(|column| column.marked = true);
        self
    }

    /// Whether there is no row.
    pub(crate) fn is_empty(&self) -> bool {
        self.groups.iter().all(|(_, rows)| rows.is_empty())
    }

    /// The smallest of a column as printed. Equal as printed is equal: no one is shown ahead by digits that nobody
    /// sees. A single row is ahead of no one.
    fn smallest(column: &Column<'a, R>, rows: &[R]) -> Option<String> {
        let cells = rows.iter().map(|row| (column.cell)(row));
        let values = cells.filter(|(_, value)| column.marked && value.is_finite());
        let smallest = values.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (rows.len() > 1).then_some(smallest.0)
    }

    /// Headings with their units, then the cells of each row.
    fn lines(&self) -> Vec<Vec<String>> {
        let headings = self.columns.iter().map(|column| match &*column.unit {
            "" => column.name.clone(),
            unit => format!("{} ({unit})", column.name),
        });
        let mut lines = vec![
            std::iter::once(self.name.to_owned())
                .chain(headings)
                .collect(),
        ];
        lines.extend(self.rows().map(|row| {
            let cells = self.columns.iter().map(|column| (column.cell)(row).0);
            std::iter::once((self.head)(row).text)
                .chain(cells)
                .collect()
        }));
        lines
    }

    fn rows(&self) -> impl Iterator<Item = &R> {
        self.groups.iter().flat_map(|(_, rows)| rows)
    }

    /// Whether cells are words; the first are.
    fn words_at(&self, place: usize) -> bool {
        place == 0 || self.columns[place - 1].words
    }

    /// The rows as a Markdown table.
    pub(crate) fn markdown(&self) -> String {
        let mut lines = self.lines();
        for (cells, row) in lines[1..].iter_mut().zip(self.rows()) {
            // Numbers are ours and need no escaping.
            for (place, cell) in cells.iter_mut().enumerate() {
                if self.words_at(place) {
                    *cell = escaped(cell);
                }
            }
            if (self.stressed)(row) {
                cells[0] = format!("**{}**", cells[0]);
            }
        }
        let rule = |place| if self.words_at(place) { "---" } else { "---:" }.to_owned();
        lines.insert(1, (0..=self.columns.len()).map(rule).collect());
        (lines.iter())
            .map(|cells| format!("| {} |\n", cells.join(" | ")))
            .collect()
    }

    /// The rows in columns as wide as their widest cell, words to the left and numbers to the right.
    pub(crate) fn aligned(&self) -> String {
        let lines = self.lines();
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
        lines.iter().map(line).collect()
    }
}

/// The table on the page; it scrolls in itself where a page is narrower.
impl<R> Render for Table<'_, R> {
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
                        @let smallest = self.columns.iter().map(|c| Self::smallest(c, rows)).collect::<Vec<_>>();
                        tbody {
                            @if let Some(head) = head {
                                tr.group { th colspan=(1 + self.columns.len()) scope="rowgroup" { span { (head) } } }
                            }
                            @for row in rows {
                                tr class=[(self.stressed)(row).then_some("stressed")] {
                                    th scope="row" { ((self.head)(row)) }
                                    @for (column, smallest) in self.columns.iter().zip(&smallest) {
                                        @let (text, _) = (column.cell)(row);
                                        @let best = smallest.as_ref() == Some(&text);
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
