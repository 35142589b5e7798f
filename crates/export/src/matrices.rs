//! Named matrices as NumPy (`.npz`) and MATLAB (`.mat`, level 5) files and back.
//!
//! With them Python and MATLAB use dictionaries learned here, and the other way round. The module does
//! not know the meaning of the matrices.
//!
//! ```
//! use inhand_export::matrices::{MatrixFormat, Variable, read, write};
//! use nalgebra::DMatrix;
//!
//! let primitives = DMatrix::from_row_slice(2, 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
//! for form in [MatrixFormat::Npz, MatrixFormat::Mat] {
//!     let bytes = write(form, "w", &[("primitives", Variable::from(primitives.clone()))])?;
//!     assert_eq!(read(&bytes, "w")?["primitives"], Variable::Numbers(primitives.clone()));
//! }
//! # Ok::<(), inhand_export::ExportError>(())
//! ```
//!
//! # Reading
//!
//! Real numbers of any type that the tools write (floats of 2 to 8 bytes, integers, truth values), in
//! either byte order, with one or two dimensions, packed or not; they become 64-bit floats. A vector of
//! NumPy becomes one column. Integers beyond 2^53 are refused rather than rounded. Variables that are
//! no such matrix (text, complex and sparse numbers, cells, structures, more dimensions) do not prevent
//! reading the others: they are listed with their kind ([`Variable::Other`]).
//!
//! # Writing
//!
//! 64-bit floats, column by column. The same matrices give the same bytes: no time of day is written.

mod error;
mod form;
mod mat;
mod npz;
mod number;

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use crate::error::ExportError;
pub use form::MatrixFormat;

/// A variable of a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Variable {
    /// A matrix; a vector of NumPy is one column, a number 1 x 1.
    Numbers(DMatrix<f64>),
    /// Something else, in words, such as `a cell array`. Never written.
    Other(String),
}

/// Variables by name, as a file has them.
pub type Variables = BTreeMap<String, Variable>;

impl Variable {
    /// The matrix, if it is one.
    pub const fn numbers(&self) -> Option<&DMatrix<f64>> {
        match self {
            Variable::Numbers(matrix) => Some(matrix),
            Variable::Other(_) => None,
        }
    }
}

impl From<DMatrix<f64>> for Variable {
    fn from(matrix: DMatrix<f64>) -> Self {
        Variable::Numbers(matrix)
    }
}

impl From<&DVector<f64>> for Variable {
    fn from(vector: &DVector<f64>) -> Self {
        Variable::Numbers(DMatrix::from_column_slice(
            vector.len(),
            1,
            vector.as_slice(),
        ))
    }
}

impl From<f64> for Variable {
    fn from(number: f64) -> Self {
        Variable::Numbers(DMatrix::from_element(1, 1, number))
    }
}

/// Reads the variables of a file; its content determines the format. `file` is its name in errors.
///
/// # Errors
///
/// [`ExportError::Content`] for other files, among them those of MATLAB's `-v7.3`, and where the bytes
/// contradict themselves.
pub fn read(bytes: &[u8], file: &str) -> Result<Variables, ExportError> {
    match MatrixFormat::from_bytes(bytes) {
        Some(MatrixFormat::Npz) => npz::read(bytes, file),
        Some(MatrixFormat::Mat) => mat::read(bytes, file),
        None => Err(form::unknown(bytes, file)),
    }
}

/// Writes matrices as a file of this form, in the given order. `file` is its name in errors.
///
/// # Errors
///
/// [`ExportError::Content`] for a name that MATLAB does not take or that comes twice, for
/// [`Variable::Other`] and for matrices too large for the form.
pub fn write<N: AsRef<str>>(
    form: MatrixFormat,
    file: &str,
    variables: &[(N, Variable)],
) -> Result<Vec<u8>, ExportError> {
    let mut matrices: Vec<(&str, &DMatrix<f64>)> = Vec::with_capacity(variables.len());
    for (name, variable) in variables {
        let name = name.as_ref();
        let again = matrices.iter().any(|&(earlier, _)| earlier == name);
        if again || !form::is_name(name) {
            return Err(ExportError::Content(format!(
                "{file}: variable \"{name}\": expected names of letters, digits and _ that start with a \
                 letter, have at most 63 characters and come once"
            )));
        }
        match variable {
            Variable::Numbers(matrix) => matrices.push((name, matrix)),
            Variable::Other(what) => return Err(error::not_written(file, name, what)),
        }
    }
    match form {
        MatrixFormat::Npz => npz::write(file, &matrices),
        MatrixFormat::Mat => mat::write(file, &matrices),
    }
}
