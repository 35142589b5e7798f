//! Tables that scroll in themselves where a page is narrower than they are.

use maud::{Markup, html};

/// A column: its heading, and the unit in a second line.
pub(super) struct Column<'a> {
    pub(super) name: &'a str,
    pub(super) unit: &'a str,
    /// Whether its cells are words, set to the left.
    pub(super) words: bool,
}

/// A column of numbers.
pub(super) const fn numbers<'a>(name: &'a str, unit: &'a str) -> Column<'a> {
    Column {
        name,
        unit,
        words: false,
    }
}

/// A column of words.
pub(super) const fn words<'a>(name: &'a str) -> Column<'a> {
    Column {
        name,
        unit: "",
        words: true,
    }
}

/// A line of a table. The first column is its heading.
pub(super) struct Line {
    pub(super) head: Markup,
    pub(super) cells: Vec<String>,
    /// Places of the cells that are the best of their column.
    pub(super) best: Vec<usize>,
    /// Whether it is the one to look at first.
    pub(super) stressed: bool,
}

/// Lines under a common heading.
pub(super) struct Group {
    /// Heading; `None` for a table of one group.
    pub(super) head: Option<Markup>,
    pub(super) lines: Vec<Line>,
}

/// For each line the places of the values that are the smallest of their column. Equal as printed is
/// equal: no one is shown ahead by digits that nobody sees. A single line is ahead of no one.
pub(super) fn smallest<const N: usize>(
    lines: &[[f64; N]],
    printed: impl Fn(usize, f64) -> String,
) -> Vec<Vec<usize>> {
    let best: Vec<Option<String>> = (0..N)
        .map(|column| {
            let values = lines.iter().map(|line| line[column]);
            let best = values.filter(|v| v.is_finite()).min_by(f64::total_cmp)?;
            (lines.len() > 1).then(|| printed(column, best))
        })
        .collect();
    lines
        .iter()
        .map(|line| {
            (0..N)
                .filter(|&column| best[column].as_ref() == Some(&printed(column, line[column])))
                .collect()
        })
        .collect()
}

/// A table of one group.
pub(super) fn table(caption: &str, columns: &[Column<'_>], lines: Vec<Line>) -> Markup {
    grouped(caption, columns, &[Group { head: None, lines }])
}

/// A table. The first of `columns` heads the lines.
pub(super) fn grouped(caption: &str, columns: &[Column<'_>], groups: &[Group]) -> Markup {
    debug_assert!(
        groups
            .iter()
            .flat_map(|group| &group.lines)
            .all(|line| line.cells.len() + 1 == columns.len()),
        "table \"{caption}\": each line has as many cells as there are columns"
    );
    html! {
        // Outside the part that scrolls, so that it is never cut.
        p.caption { (caption) }
        // Focusable, so that a keyboard can scroll it too.
        div.scroll tabindex="0" role="region" aria-label=(caption) {
            table aria-label=(caption) {
                thead {
                    tr {
                        @for column in columns {
                            th class=[column.words.then_some("words")] scope="col" {
                                (column.name)
                                @if !column.unit.is_empty() { span.unit { (column.unit) } }
                            }
                        }
                    }
                }
                @for group in groups {
                    tbody {
                        @if let Some(head) = &group.head {
                            tr.group { th colspan=(columns.len()) scope="rowgroup" { span { (head) } } }
                        }
                        @for line in &group.lines {
                            tr class=[line.stressed.then_some("stressed")] {
                                th scope="row" { (line.head) }
                                @for (place, (cell, column)) in line.cells.iter().zip(columns.iter().skip(1)).enumerate() {
                                    td class=[cell_class(column, line.best.contains(&place))] { (cell) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Most cells have no class, and there are many of them.
fn cell_class(column: &Column<'_>, best: bool) -> Option<&'static str> {
    if best {
        Some("best")
    } else {
        column.words.then_some("words")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_as_printed_is_marked() {
        let printed = |_: usize, value: f64| format!("{value:.1}");
        let lines = [[0.31, 2.0], [0.34, 1.0], [f64::NAN, f64::NAN]];
        assert_eq!(smallest(&lines, printed), [vec![0], vec![0, 1], vec![]]);
        let lines = [[0.31, 2.0], [0.29, 2.0]];
        assert_eq!(smallest(&lines, printed), [vec![0, 1], vec![0, 1]]);
        assert_eq!(smallest(&lines[..1], printed), [Vec::<usize>::new()]);
    }
}
