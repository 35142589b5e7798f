//! Cleaned takes: the measured recording stays beside the cleaned one.

use std::path::Path;

use inhand_channels::{TakeFile, Views};
use inhand_inspection::{CleanSettings, Cleaned};
use inhand_model::{Provenance, Shape};

use crate::error::{Located, SessionError};
use crate::take::{Cleaning, Take};
use crate::take_file;

/// Cleans a take. What was cleaned before is cleaned on, and its changes come first in the list.
///
/// # Errors
///
/// [`SessionError::At`], and [`SessionError::Data`] where roles are undetermined.
pub fn clean_take(take: &Take, steps: &CleanSettings) -> Result<Cleaned, SessionError> {
    let mut cleaned =
        inhand_inspection::clean(&take.recording, take.roles()?, steps).in_file(&take.path)?;
    if let Some(earlier) = &take.cleaning {
        // Changes count the samples of what was measured.
        let (from, to) = (take.recording.clock, earlier.measured.clock);
        let measured = |k: usize| {
            to.nearest_sample(from.time_s(k))
                .min(earlier.measured.len())
        };
        for change in &mut cleaned.changes {
            change.samples = measured(change.samples.start)..measured(change.samples.end);
        }
        cleaned
            .changes
            .splice(0..0, earlier.changes.iter().cloned());
    }
    Ok(cleaned)
}

/// The take with its cleaned recording in use. A motion that was stored belongs to another recording
/// and is left out.
pub(crate) fn cleaned(take: Take, steps: &CleanSettings) -> Result<Take, SessionError> {
    let Cleaned { recording, changes } = clean_take(&take, steps)?;
    let measured = (take.cleaning).map_or(take.recording, |earlier| earlier.measured);
    Ok(Take {
        recording,
        cleaning: Some(Cleaning { measured, changes }),
        stored_motion: None,
        ..take
    })
}

/// Writes a take with its cleaned recording beside the measured one.
///
/// # Errors
///
/// [`SessionError`]; then no file appears.
pub fn write_cleaned(
    path: &Path,
    take: &Take,
    cleaned: &Cleaned,
    made: &Provenance,
    shape: Option<Shape>,
    views: Views,
) -> Result<(), SessionError> {
    take.roles()?;
    let provenance = take.made_by(made);
    let file = TakeFile {
        cleaned: Some(inhand_channels::CleanedTake {
            recording: &cleaned.recording,
            changes: &cleaned.changes,
        }),
        object_shape: shape,
        ..take.file(&provenance)
    };
    take_file::write_parts(path, &file, views)
}
