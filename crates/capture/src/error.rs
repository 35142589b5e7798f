//! Errors of reading and writing vendor files.

use std::fmt::Display;
use std::io;

use inhand_model::Setting;
use thiserror::Error;

/// Reasons why a vendor file cannot be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CaptureError {
    /// The content of a file cannot be used.
    #[error("{file}{place}: {problem}")]
    Content {
        /// The file.
        file: String,
        /// Line and column, counted from 1 as a spreadsheet shows them; empty for the whole file.
        place: String,
        /// What was expected, what was found and what to do.
        problem: String,
    },
    /// The file ends within its header: its name, the line that is missing (from 1) and what belongs there.
    #[error(
        "{0}, line {1}: expected {2}, found the end of the file: the header is cut or edited; export the take again"
    )]
    HeaderEnd(String, usize, String),
    /// The input cannot be read.
    #[error("{file}: cannot read on: {source}")]
    Read {
        /// The file.
        file: String,
        /// Why.
        source: io::Error,
    },
    /// The output cannot be written.
    #[error("cannot write {format}: {source}")]
    Output {
        /// The format of the output.
        format: &'static str,
        /// Why.
        source: io::Error,
    },
}

impl CaptureError {
    /// A problem of a whole file.
    pub(crate) fn in_file(file: &str, problem: impl Display) -> Self {
        Self::at(file, "", problem)
    }

    /// A problem of a line.
    pub(crate) fn in_line(file: &str, line: usize, problem: impl Display) -> Self {
        Self::at(file, format_args!(", line {line}"), problem)
    }

    /// A problem of a cell; `column` counts from 1.
    pub(crate) fn in_cell(
        file: &str,
        line: usize,
        column: impl Display,
        problem: impl Display,
    ) -> Self {
        let place = format_args!(", line {line}, column {column}");
        Self::at(file, place, problem)
    }

    fn at(file: &str, place: impl Display, problem: impl Display) -> Self {
        Self::Content {
            file: file.to_owned(),
            place: place.to_string(),
            problem: problem.to_string(),
        }
    }

    /// A header that is cut or damaged.
    pub(crate) fn header(
        file: &str,
        line: usize,
        expected: impl Display,
        found: impl Display,
    ) -> Self {
        let problem = format_args!(
            "expected {expected}, found {found}: the header is cut or edited; export the take again"
        );
        Self::in_line(file, line, problem)
    }

    /// A file that ends within its header.
    pub(crate) fn header_end(file: &str, line: usize, expected: &str) -> Self {
        Self::HeaderEnd(file.to_owned(), line, expected.to_owned())
    }

    /// The error where the first `limit_bytes` of a longer file were searched for the header.
    pub(crate) fn of_header_within(self, limit_bytes: usize) -> Self {
        let Self::HeaderEnd(file, line, expected) = self else {
            return self;
        };
        let problem = format!(
            "expected {expected} within the first {limit_bytes} bytes of the file, found a longer \
             header: export fewer markers and bodies"
        );
        Self::in_line(&file, line, problem)
    }

    /// A row that ends early.
    pub(crate) fn too_few_cells(file: &str, line: usize, expected: usize, found: usize) -> Self {
        let problem = format!("expected {expected} cells, found {found}: the row is cut off");
        Self::in_line(file, line, problem)
    }

    /// A row that goes on behind its last column.
    pub(crate) fn too_many_cells(file: &str, line: usize, expected: usize, found: &str) -> Self {
        let problem = format!(
            "expected no more than the header's {expected} columns, found {found:?}: is a comma \
             used as decimal point?"
        );
        Self::in_cell(file, line, expected + 1, problem)
    }

    /// A line of which no end is in sight.
    pub(crate) fn line_too_long(file: &str, line: usize, limit_bytes: usize) -> Self {
        let problem = format!(
            "expected lines of at most {limit_bytes} bytes, found a longer one: is it a binary \
             file, or did it lose its line ends?"
        );
        Self::in_line(file, line, problem)
    }

    /// A header without any row of data.
    pub(crate) fn no_samples(file: &str) -> Self {
        let problem = "the header is followed by no samples: was the export interrupted?";
        Self::in_file(file, problem)
    }

    /// A format that is known, but not read.
    pub(crate) fn unsupported(file: &str, found: impl Display, hint: &str) -> Self {
        Self::in_file(file, format_args!("{found} is not read yet: {hint}"))
    }

    /// A file that leaves its unit of length open; `key` would state it.
    pub(crate) fn no_units(file: &str, key: &str) -> Self {
        let problem = format!(
            "the header has no \"{key}\": say it with {} (metres, centimetres, millimetres, \
             inches, feet)",
            Setting::Units
        );
        Self::in_file(file, problem)
    }

    /// A setting that says something else than the file.
    pub(crate) fn contradiction(
        file: &str,
        option: impl Display,
        given: impl Display,
        stated: impl Display,
    ) -> Self {
        let problem = format!(
            "{option} says {given}, but the file itself states {stated}: leave {option} out"
        );
        Self::in_file(file, problem)
    }
}
