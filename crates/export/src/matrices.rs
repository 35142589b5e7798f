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
//! All variables of a file together take at most the [`memory_limit`], however small it is packed.
//!
//! # Writing
//!
//! 64-bit floats, column by column. The same matrices give the same bytes: no time of day is written.

mod dictionary;
mod given;
mod mat;
mod npz;
mod number;

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::Path;

use inhand_container::memory_limit;
use nalgebra::{DMatrix, DVector};

use crate::error::ExportError;
pub use dictionary::{Matrices, export_dictionary};
pub use given::{Given, import_primitives};

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
    if ZIP_MARKS.iter().any(|mark| bytes.starts_with(mark)) {
        npz::read(bytes, file)
    } else if mat::is_mat(bytes) {
        mat::read(bytes, file)
    } else {
        Err(unknown(bytes, file))
    }
}

/// Writes matrices as a file of this format, in the given order. `file` is its name in errors.
///
/// # Errors
///
/// [`ExportError::Content`] for a name that MATLAB does not take or that comes twice, for
/// [`Variable::Other`] and for matrices too large for the format.
pub fn write<N: AsRef<str>>(
    form: MatrixFormat,
    file: &str,
    variables: &[(N, Variable)],
) -> Result<Vec<u8>, ExportError> {
    let mut matrices: Vec<(&str, &DMatrix<f64>)> = Vec::with_capacity(variables.len());
    for (name, variable) in variables {
        let name = name.as_ref();
        let again = matrices.iter().any(|&(earlier, _)| earlier == name);
        if again || !is_name(name) {
            return Err(ExportError::Content(format!(
                "{file}: variable \"{name}\": expected names of letters, digits and _ that start with a \
                 letter, have at most 63 characters and come once"
            )));
        }
        match variable {
            Variable::Numbers(matrix) => matrices.push((name, matrix)),
            Variable::Other(what) => return Err(not_written(file, name, what)),
        }
    }
    match form {
        MatrixFormat::Npz => npz::write(file, &matrices),
        MatrixFormat::Mat => mat::write(file, &matrices),
    }
}

/// How archives of files start; an empty one has the second mark.
const ZIP_MARKS: [&[u8]; 2] = [b"PK\x03\x04", b"PK\x05\x06"];

/// Longest name that MATLAB takes.
const NAME_CHARACTERS: usize = 63;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixFormat {
    /// NumPy's archive of arrays, as of `numpy.savez`.
    Npz,
    /// MATLAB's MAT file of level 5, as of `save -v7`.
    Mat,
}

impl MatrixFormat {
    /// Every format.
    pub const ALL: [MatrixFormat; 2] = [MatrixFormat::Npz, MatrixFormat::Mat];

    /// Extension of its files, without the dot.
    pub const fn extension(self) -> &'static str {
        match self {
            MatrixFormat::Npz => "npz",
            MatrixFormat::Mat => "mat",
        }
    }

    /// The format that a file name asks for, whatever the case of its letters.
    ///
    /// ```
    /// use inhand_export::matrices::MatrixFormat;
    /// assert_eq!(MatrixFormat::from_path("a/W.MAT"), Some(MatrixFormat::Mat));
    /// assert_eq!(MatrixFormat::from_path("npz"), None);
    /// ```
    pub fn from_path(path: impl AsRef<Path>) -> Option<Self> {
        let extension = path.as_ref().extension()?;
        (MatrixFormat::ALL.into_iter())
            .find(|form| extension.eq_ignore_ascii_case(form.extension()))
    }
}

/// Whether MATLAB takes it as a name of a variable.
fn is_name(name: &str) -> bool {
    name.len() <= NAME_CHARACTERS
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// The error for bytes of none of the formats.
fn unknown(bytes: &[u8], file: &str) -> ExportError {
    // HDF5's own mark, without MATLAB's text in front or after it.
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    let matrices = "no file of matrices: expected .npz (numpy.savez) or .mat (MATLAB's save -v7)";
    let level_5 = "expected a MAT file of level 5";
    let message =
        if bytes.starts_with(HDF5) || bytes.get(512..).is_some_and(|rest| rest.starts_with(HDF5)) {
            format!("{level_5}, found one of MATLAB 7.3 (HDF5): save it again with `save -v7`")
        } else if mat::looks_like_level_4(bytes) {
            let remedy = "save it again with `save -v7` (scipy.io.savemat: format='5')";
            format!("{level_5}, found what looks like one of level 4: {remedy}")
        } else if bytes.starts_with(b"\x93NUMPY") {
            let remedy = "save it with numpy.savez(file, primitives=array)";
            format!("{matrices}, found a single array (.npy): {remedy}")
        } else if bytes.is_empty() {
            format!("{matrices}, found nothing")
        } else {
            let start = bytes[..bytes.len().min(12)].escape_ascii();
            format!("{matrices}, found \"{start}\" ({} bytes)", bytes.len())
        };
    ExportError::Content(format!("{file}: {message}"))
}

/// A variable that cannot be written.
fn not_written(file: &str, name: &str, found: impl Display) -> ExportError {
    ExportError::Content(format!(
        "{file}: variable {name}: expected a matrix that fits into the file, found {found}"
    ))
}

/// Content that contradicts the format, before its place is known.
#[derive(Debug)]
pub(crate) struct Fault {
    fault: String,
    remedy: &'static str,
}

impl Fault {
    fn new(expected: impl Display, found: impl Display) -> Self {
        Self {
            fault: format!("expected {expected}, found {found}"),
            remedy: "save or copy the file again",
        }
    }

    /// With the file and the place in it.
    fn at(self, file: &str, place: impl Display) -> ExportError {
        let Self { fault, remedy } = self;
        ExportError::Content(format!("{file}: {place}: {fault}; {remedy}"))
    }
}

/// Memory that the variables of a file may still take: a few hostile bytes may unpack to gigabytes.
struct Budget {
    limit: u64,
    left: u64,
}

impl Budget {
    fn new() -> Self {
        let limit = memory_limit();
        Self { limit, left: limit }
    }

    /// Takes this many bytes, before they are allocated.
    fn take(&mut self, bytes: u64) -> Result<(), Fault> {
        self.left = self.left.checked_sub(bytes).ok_or_else(|| self.spent())?;
        Ok(())
    }

    /// The fault of a file that needs more than is left.
    fn spent(&self) -> Fault {
        let expected = format!("variables of at most {} bytes of memory", self.limit);
        Fault {
            remedy: "raise the limit with --memory-limit if the file is to be trusted",
            ..Fault::new(expected, "more")
        }
    }
}
