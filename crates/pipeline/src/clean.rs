//! Cleaned takes: the measured recording stays beside the cleaned one.

use std::path::Path;

use inhand_channels::TakeFile;
use inhand_cleaning::{CleanSettings, Cleaned};
use inhand_model::{Provenance, Shape};

use crate::error::PipelineError;
use crate::take::{Cleaning, Take};
use crate::take_file;

/// Cleans what was measured of a take; what an earlier cleaning made of it is not used.
///
/// # Errors
///
/// [`PipelineError::Cleaning`], and [`PipelineError::Take`] where roles cannot be told.
pub fn clean_take(take: &Take, steps: &CleanSettings) -> Result<Cleaned, PipelineError> {
    inhand_cleaning::clean(take.measured(), take.roles()?, steps).map_err(|source| {
        PipelineError::Cleaning {
            path: take.path.clone(),
            source: source.into(),
        }
    })
}

/// The take with its cleaned recording in use. A motion that was stored belongs to another recording
/// and is left out.
pub(crate) fn cleaned(take: &Take, steps: &CleanSettings) -> Result<Take, PipelineError> {
    let Cleaned { recording, changes } = clean_take(take, steps)?;
    Ok(Take {
        recording,
        cleaning: Some(Cleaning {
            measured: take.measured().clone(),
            changes,
        }),
        stored_motion: None,
        ..take.clone()
    })
}

/// Writes a take with its cleaned recording beside the measured one.
///
/// # Errors
///
/// [`PipelineError`]; then no file appears.
pub fn write_cleaned(
    path: &Path,
    take: &Take,
    cleaned: &Cleaned,
    made: &Provenance,
    shape: Option<Shape>,
    view: bool,
) -> Result<(), PipelineError> {
    let mut provenance = take.provenance.clone();
    provenance.push(made.clone());
    let file = TakeFile {
        cleaned: Some(inhand_channels::CleanedTake {
            recording: &cleaned.recording,
            changes: &cleaned.changes,
        }),
        roles: Some(take.roles()?),
        object_shape: shape,
        annotations: Some(&take.annotations),
        provenance: &provenance,
        ..TakeFile::new(take.measured())
    };
    take_file::write_parts(path, &file, view)
}
