//! Errors of reading and writing matrix files.

use std::fmt::Display;

use crate::error::ExportError;

/// A variable that cannot be written.
pub(crate) fn not_written(file: &str, name: &str, found: impl Display) -> ExportError {
    ExportError::Content(format!(
        "{file}: variable {name}: expected a matrix that fits into the file, found {found}"
    ))
}

/// Content that contradicts the format, before its place is known.
#[derive(Debug)]
pub(crate) struct Fault(String);

impl Fault {
    pub(crate) fn new(expected: impl Display, found: impl Display) -> Self {
        Self(format!("expected {expected}, found {found}"))
    }

    /// With the file and the place in it.
    pub(crate) fn at(self, file: &str, place: impl Display) -> ExportError {
        let Self(fault) = self;
        ExportError::Content(format!(
            "{file}: {place}: {fault}; save or copy the file again"
        ))
    }
}
