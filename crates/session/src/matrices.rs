//! Dictionaries as plain matrices, for MATLAB, NumPy and whatever else reads `.npz` or `.mat`, and
//! primitives that were learned there.
//!
//! A segment `v` of N samples is a column of 15 N numbers, with the object 21 N
//! ([`SegmentLayout`]), and `v = offset_m + primitives * activations`. In Python:
//!
//! ```python
//! d = numpy.load("dictionary.npz")
//! v = d["offset_m"] + d["primitives"] @ d["activation_mean_m"]      # rows x 1
//! first_thumb = v[0:3, 0]                                           # metres, frame of the hand
//! ```
//!
//! The other way round, `numpy.savez("w.npz", primitives=W)` or, after scikit-learn's
//! `model.fit(segments)` with one segment a row, `numpy.savez("w.npz",
//! components_=model.components_)`; in MATLAB, `save("w.mat", "primitives", "-v7")`.

use std::io::Write as _;
use std::path::Path;

use inhand_export::matrices::{self, MatrixFormat, Variables};
use inhand_model::{DictionaryKind, SegmentLayout};

use crate::error::{Located, SessionError};
use crate::files::name_of;
use crate::output;

pub use inhand_export::matrices::{Given, Matrices, export_dictionary, import_primitives};

/// The form that a file name asks for by its extension.
///
/// # Errors
///
/// [`SessionError::Usage`] for another extension.
pub fn form_of(path: &Path) -> Result<MatrixFormat, SessionError> {
    let message = "expected a file name that ends in .npz or .mat";
    MatrixFormat::from_path(path).ok_or_else(|| SessionError::usage(path, message))
}

/// Writes matrices in the form that the extension says, whole or not at all.
///
/// # Errors
///
/// As for [`form_of`]; [`SessionError::At`] for matrices that cannot be written, [`SessionError::Io`].
pub fn write(path: &Path, matrices: &Matrices) -> Result<(), SessionError> {
    let bytes = matrices::write(form_of(path)?, &name_of(path), matrices).in_file(path)?;
    output::write_atomic(path, |out| {
        out.write_all(&bytes)
            .map_err(SessionError::io("write", path))
    })
}

/// Reads every variable of a file; its content says which form it has.
///
/// # Errors
///
/// [`SessionError::Io`], [`SessionError::At`] for content that is no matrices.
pub fn read(path: &Path) -> Result<Variables, SessionError> {
    let bytes = std::fs::read(path).map_err(SessionError::io("read", path))?;
    matrices::read(&bytes, &name_of(path)).in_file(path)
}

/// Reads a file by [`read`] and takes primitives from it by [`import_primitives`].
///
/// # Errors
///
/// As for both.
pub fn read_primitives(
    path: &Path,
    layout: SegmentLayout,
    kind: DictionaryKind,
) -> Result<Given, SessionError> {
    import_primitives(&read(path)?, layout, kind).in_file(path)
}
