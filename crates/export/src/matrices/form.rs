//! Formats of files of matrices.

use std::path::Path;

use super::mat;
use crate::error::ExportError;

/// How archives of files start; an empty one has the second mark.
const ZIP_MARKS: [&[u8]; 2] = [b"PK\x03\x04", b"PK\x05\x06"];

/// Longest name that MATLAB takes.
const NAME_CHARACTERS: usize = 63;

/// A form of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatrixFormat {
    /// NumPy's archive of arrays, as of `numpy.savez`.
    Npz,
    /// MATLAB's MAT file of level 5, as of `save -v7`.
    Mat,
}

impl MatrixFormat {
    /// Every form.
    pub const ALL: [MatrixFormat; 2] = [MatrixFormat::Npz, MatrixFormat::Mat];

    /// Extension of its files, without the dot.
    pub const fn extension(self) -> &'static str {
        match self {
            MatrixFormat::Npz => "npz",
            MatrixFormat::Mat => "mat",
        }
    }

    /// The form that a file name asks for, whatever the case of its letters.
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

    /// The form that bytes start as.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        if ZIP_MARKS.iter().any(|mark| bytes.starts_with(mark)) {
            return Some(MatrixFormat::Npz);
        }
        mat::is_mat(bytes).then_some(MatrixFormat::Mat)
    }
}

/// Whether MATLAB takes it as a name of a variable.
pub(crate) fn is_name(name: &str) -> bool {
    name.len() <= NAME_CHARACTERS
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// The error for bytes of none of the forms.
pub(crate) fn unknown(bytes: &[u8], file: &str) -> ExportError {
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
