//! Dictionaries on disk.

use std::path::Path;

use inhand_channels::{dictionary_of_source, read_dictionary};
use inhand_model::{Dictionary, InputHash, Provenance};

use crate::error::{Located, SessionError};
use crate::files::{hash_file, hex_sha256, name_of, open};
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
    let name = name_of(path);
    // A stream can be read only once.
    let stream = (!path.is_file()).then(|| std::fs::read(path));
    let stream = (stream.transpose()).map_err(SessionError::io("read", path))?;
    let (read, sha256) = match &stream {
        None => (
            dictionary_of_source(&mut open(path)?),
            hash_file(path)?.sha256,
        ),
        Some(bytes) => (read_dictionary(bytes, &name), hex_sha256(bytes)),
    };
    let (dictionary, provenance) = read.in_file(path)?;
    Ok(DictionaryFile {
        dictionary,
        provenance,
        hash: InputHash { name, sha256 },
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
