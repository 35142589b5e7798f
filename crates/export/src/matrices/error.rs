//! Errors of reading and writing matrix files.

use std::fmt::Display;

use thiserror::Error;

/// Why matrices cannot be read or written.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MatrixError {
    /// The bytes are something else.
    #[error(
        "{file}: no file of matrices: expected .npz (numpy.savez) or .mat (MATLAB's save -v7), found {found}"
    )]
    Form {
        /// File that was read.
        file: String,
        /// Its first bytes, in words.
        found: String,
    },
    /// A MATLAB file in the form of its version 7.3, which is HDF5.
    #[error(
        "{file}: expected a MAT file of level 5, found one of MATLAB 7.3 (HDF5): save it again with `save -v7`"
    )]
    TooNew {
        /// File that was read.
        file: String,
    },
    /// A MATLAB file from before version 5.
    #[error(
        "{file}: expected a MAT file of level 5, found what looks like one of level 4: save it again with `save -v7` (scipy.io.savemat: format='5')"
    )]
    TooOld {
        /// File that was read.
        file: String,
    },
    /// Bytes that contradict the form.
    #[error("{file}: {place}: expected {expected}, found {found}; save or copy the file again")]
    Damaged {
        /// File that was read.
        file: String,
        /// The variable, or the byte at which it starts.
        place: String,
        /// What should be there.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A name under which nothing can be written.
    #[error(
        "{file}: variable \"{name}\": expected names of letters, digits and _ that start with a letter, have at most 63 characters and come once"
    )]
    Name {
        /// File to be written.
        file: String,
        /// The name.
        name: String,
    },
    /// A variable that cannot be written.
    #[error("{file}: variable {name}: expected a matrix that fits into the file, found {found}")]
    NotWritten {
        /// File to be written.
        file: String,
        /// Name of the variable.
        name: String,
        /// What it is.
        found: String,
    },
}

/// A variable that cannot be written.
pub(crate) fn not_written(file: &str, name: &str, found: impl Display) -> MatrixError {
    MatrixError::NotWritten {
        file: file.to_owned(),
        name: name.to_owned(),
        found: found.to_string(),
    }
}

/// What does not fit, before it is known where that is.
#[derive(Debug)]
pub(crate) struct Fault {
    pub(crate) expected: String,
    pub(crate) found: String,
}

impl Fault {
    pub(crate) fn new(expected: impl Display, found: impl Display) -> Self {
        Self {
            expected: expected.to_string(),
            found: found.to_string(),
        }
    }

    /// With the file and the place in it.
    pub(crate) fn at(self, file: &str, place: impl Display) -> MatrixError {
        MatrixError::Damaged {
            file: file.to_owned(),
            place: place.to_string(),
            expected: self.expected,
            found: self.found,
        }
    }
}
