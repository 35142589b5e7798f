//! Which file is which.

use std::path::Path;

use super::error::MatrixError;
use super::mat;

/// How archives of files start; an empty one has the second mark.
const ZIP_MARKS: [&[u8]; 2] = [b"PK\x03\x04", b"PK\x05\x06"];

/// Longest name that MATLAB takes.
const NAME_CHARACTERS: usize = 63;

/// A form of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// NumPy's archive of arrays, as of `numpy.savez`.
    Npz,
    /// MATLAB's MAT file of level 5, as of `save -v7`.
    Mat,
}

impl Form {
    /// Every form.
    pub const ALL: [Form; 2] = [Form::Npz, Form::Mat];

    /// Extension of its files, without the dot.
    pub const fn extension(self) -> &'static str {
        match self {
            Form::Npz => "npz",
            Form::Mat => "mat",
        }
    }

    /// The form that a file name asks for, whatever the case of its letters.
    ///
    /// ```
    /// use inhand_export::matrices::Form;
    /// assert_eq!(Form::of_path("a/W.MAT"), Some(Form::Mat));
    /// assert_eq!(Form::of_path("npz"), None);
    /// ```
    pub fn of_path(path: impl AsRef<Path>) -> Option<Self> {
        let extension = path.as_ref().extension()?;
        (Form::ALL.into_iter()).find(|form| extension.eq_ignore_ascii_case(form.extension()))
    }

    /// The form that bytes start as.
    pub fn of_bytes(bytes: &[u8]) -> Option<Self> {
        if ZIP_MARKS.iter().any(|mark| bytes.starts_with(mark)) {
            return Some(Form::Npz);
        }
        mat::is_mat(bytes).then_some(Form::Mat)
    }
}

/// Whether MATLAB takes it as a name of a variable.
pub(crate) fn is_name(name: &str) -> bool {
    name.len() <= NAME_CHARACTERS
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Why bytes have none of the forms.
pub(crate) fn unknown(bytes: &[u8], file: &str) -> MatrixError {
    let file = file.to_owned();
    // HDF5's own mark, where it stands without or behind MATLAB's text.
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    if bytes.starts_with(HDF5) || bytes.get(512..).is_some_and(|rest| rest.starts_with(HDF5)) {
        return MatrixError::TooNew { file };
    }
    if mat::looks_like_level_4(bytes) {
        return MatrixError::TooOld { file };
    }
    let found = if bytes.starts_with(b"\x93NUMPY") {
        "a single array (.npy): save it with numpy.savez(file, primitives=array)".to_owned()
    } else if bytes.is_empty() {
        "nothing".to_owned()
    } else {
        let start: String = (bytes.iter().take(12))
            .flat_map(|byte| byte.escape_ascii())
            .map(char::from)
            .collect();
        format!("\"{start}\" ({} bytes)", bytes.len())
    };
    MatrixError::Form { file, found }
}
