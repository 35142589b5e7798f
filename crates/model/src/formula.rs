//! Cells of text tables that a spreadsheet would take for formulas.

use std::borrow::Cow;

/// A cell of a text table that no spreadsheet runs: a name that begins as a formula does (`=`, `+`, `-` or `@`, also in full
/// width, behind blanks or apostrophes) gets an apostrophe before it. Numbers stay as they are.
///
/// ```
/// use inhand_model::{guarded, unguarded};
///
/// assert_eq!(guarded("=HYPERLINK(A1)"), "'=HYPERLINK(A1)");
/// assert_eq!(guarded("-30"), "-30");
/// assert_eq!(unguarded("'=HYPERLINK(A1)"), "=HYPERLINK(A1)");
/// assert_eq!(unguarded("'90s"), "'90s");
/// ```
pub fn guarded(cell: &str) -> Cow<'_, str> {
    let begin = cell.trim_start_matches(|c: char| c == '\'' || c.is_whitespace());
    let is_number = begin.parse::<f64>().is_ok_and(f64::is_finite);
    match begin.starts_with(['=', '+', '-', '@', '＝', '＋', '－', '＠']) && !is_number {
        true => Cow::Owned(format!("'{cell}")),
        false => Cow::Borrowed(cell),
    }
}

/// The text of which [`guarded`] made a cell; any other cell is its own text.
pub fn unguarded(cell: &str) -> &str {
    match cell.strip_prefix('\'') {
        Some(text) if guarded(text) == cell => text,
        _ => cell,
    }
}
