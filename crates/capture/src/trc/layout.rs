//! The two rows of column labels of a TRC file.

use super::header::{Lines, describe};
use crate::error::CaptureError;
use crate::table::Column;
use crate::text;

/// Columns of `Frame#` and `Time`.
pub(super) const LEADING_COLUMNS: usize = 2;

/// What the columns hold, what messages call them, and the markers in their order.
pub(super) struct Layout {
    pub(super) columns: Vec<Column>,
    pub(super) labels: Vec<String>,
    pub(super) marker_names: Vec<String>,
}

impl Layout {
    pub(super) fn parse(lines: &mut Lines<'_>) -> Result<Self, CaptureError> {
        const LABELS: &str = "a row of labels (Frame#, Time, then marker names)";
        let names = lines.cells(LABELS)?;
        for (column, label) in ["frame", "time"].into_iter().enumerate() {
            let fits = names
                .get(column)
                .is_some_and(|name| name.to_ascii_lowercase().starts_with(label));
            if !fits {
                return Err(lines.error(
                    format!(
                        "{LABELS} with {} in column {}",
                        ["Frame#", "Time"][column],
                        column + 1
                    ),
                    describe(&names, column),
                ));
            }
        }
        let axes = lines.cells("a row of axes (X1, Y1, Z1, X2, ...)")?;
        let first = first_marker_column(&axes, lines)?;
        let marker_names = marker_names(&names, first, axes.len(), lines)?;

        let mut columns = vec![Column::Frame, Column::Time];
        let mut labels = vec!["Frame#".to_owned(), "Time".to_owned()];
        for column in LEADING_COLUMNS..first {
            columns.push(Column::Skip);
            labels.push(names.get(column).copied().unwrap_or_default().to_owned());
        }
        for name in &marker_names {
            for axis in ["X", "Y", "Z"] {
                columns.push(Column::Value);
                labels.push(format!("\"{name}\" {axis}"));
            }
        }
        Ok(Self {
            columns,
            labels,
            marker_names,
        })
    }
}

/// Index of the first column of the first marker, after a check that from there on every three
/// columns are an X, a Y and a Z.
fn first_marker_column(axes: &[&str], lines: &Lines<'_>) -> Result<usize, CaptureError> {
    let first = axes.iter().position(|cell| !cell.is_empty());
    let first = first.unwrap_or(LEADING_COLUMNS);
    let error = |index: usize, axis: &str| {
        lines.error(
            format!("{axis} of a marker in column {}", index + 1),
            describe(axes, index),
        )
    };
    if first < LEADING_COLUMNS {
        return Err(lines.error(
            "a row of axes (X1, Y1, Z1, X2, ...) from column 3 on".to_owned(),
            format!("{} in column {}", describe(axes, first), first + 1),
        ));
    }
    let coordinates = axes.len().saturating_sub(first).next_multiple_of(3);
    for index in first..first + coordinates {
        let axis = ["X", "Y", "Z"][(index - first) % 3];
        let fits = axes.get(index).is_some_and(|cell| {
            cell.get(..1).is_some_and(|c| c.eq_ignore_ascii_case(axis))
                && cell[1..].bytes().all(|byte| byte.is_ascii_digit())
        });
        if !fits {
            return Err(error(index, axis));
        }
    }
    Ok(first)
}

/// A name for each three columns from `first` to `end`: the one above its X, or, where a program
/// did not leave the two blank cells behind each name, one after the other.
fn marker_names(
    names: &[&str],
    first: usize,
    end: usize,
    lines: &Lines<'_>,
) -> Result<Vec<String>, CaptureError> {
    let markers = end.saturating_sub(first) / 3;
    let named = || (names.iter().enumerate().skip(first)).filter(|(_, name)| !name.is_empty());
    let misplaced = named().find(|&(index, _)| index >= end || !(index - first).is_multiple_of(3));
    let Some((index, name)) = misplaced else {
        let above_x = |m: usize| names.get(first + 3 * m).copied().unwrap_or_default();
        return Ok((0..markers).map(|m| above_x(m).to_owned()).collect());
    };
    if named().count() == markers {
        return Ok(named().map(|(_, name)| (*name).to_owned()).collect());
    }
    Err(lines.error(
        format!(
            "an X, a Y and a Z below the name \"{}\" of line {}, column {}",
            text::excerpt(name.as_bytes()),
            lines.number - 1,
            index + 1
        ),
        format!("axes of {markers} markers, up to column {end}"),
    ))
}
