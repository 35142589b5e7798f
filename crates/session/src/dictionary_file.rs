//! Dictionaries on disk.

use std::path::Path;

use inhand_model::{Dictionary, InputHash, Provenance};

use crate::error::{Located, SessionError};
use crate::files::{hex_sha256, name_of};
use crate::output;

/// A dictionary read from a file.
#[derive(Clone, Debug)]
pub struct DictionaryFile {
    /// The dictionary.
    pub dictionary: Dictionary,
    /// Steps that made the file.
    pub provenance: Vec<Provenance>,
    /// Content of the file.
    pub hash: InputHash,
}

/// Reads a dictionary file.
///
/// # Errors
///
/// [`SessionError::At`] for a file that holds none, [`SessionError::Io`].
pub fn read(path: &Path) -> Result<DictionaryFile, SessionError> {
    let bytes = std::fs::read(path).map_err(SessionError::io("read", path))?;
    let name = name_of(path);
    let (dictionary, provenance) = inhand_channels::read_dictionary(&bytes, &name).in_file(path)?;
    let hash = InputHash {
        name,
        sha256: hex_sha256(&bytes),
    };
    Ok(DictionaryFile {
        dictionary,
        provenance,
        hash,
    })
}

/// The dictionary of an earlier run, if it was made by exactly this.
pub(crate) fn read_if(path: &Path, learned_by: &Provenance) -> Option<Dictionary> {
    let file = read(path).ok()?;
    (file.provenance.last() == Some(learned_by)).then_some(file.dictionary)
}

/// Writes a dictionary file.
///
/// # Errors
///
/// [`SessionError::At`], [`SessionError::Io`].
pub fn write(
    path: &Path,
    dictionary: &Dictionary,
    provenance: &[Provenance],
) -> Result<(), SessionError> {
    output::write_atomic(path, |out| {
        inhand_channels::write_dictionary(out, dictionary, provenance).in_file(path)
    })
}
