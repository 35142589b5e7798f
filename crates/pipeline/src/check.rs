//! Checking takes, one at a time in memory.

use std::error::Error as _;
use std::path::Path;

use inhand_checking::{CheckSettings, Checked, Suspicion, check};

use crate::error::PipelineError;
use crate::settings::Settings;
use crate::take::{Take, read};

/// Reads a take, whatever its format, and looks at everything that it tells of itself. A file that
/// cannot be read is a result with its reason, so that it does not end the check of others.
///
/// # Errors
///
/// [`PipelineError::Settings`]: what would be wrong for every take.
pub fn check_take(path: &Path, settings: &Settings) -> Result<Checked, PipelineError> {
    let limits = check_settings(settings)?;
    let outcome = match read(path, settings) {
        Ok(take) => {
            let roles = take.roles.as_ref().map_err(String::as_str);
            let suspicions = suspicions(&take);
            Ok(check(&take.recording, roles, &suspicions, &limits))
        }
        Err(error) if error.is_usage() => return Err(error),
        Err(error) => Err(reason(&error)),
    };
    Ok(Checked {
        file: path.display().to_string(),
        outcome,
    })
}

/// Limits of a check: the take is looked at as these settings would process and cut it.
fn check_settings(settings: &Settings) -> Result<CheckSettings, PipelineError> {
    Ok(CheckSettings {
        process: settings.process_settings()?,
        margin_s: settings.segments.margin_s,
        missing_s: settings.segments.missing_s,
        ..CheckSettings::default()
    })
}

/// What detectors suspect.
fn suspicions(_take: &Take) -> Vec<Suspicion> {
    Vec::new()
}

/// The causes of an error without the file's name, which stands beside it.
fn reason(error: &PipelineError) -> String {
    let mut reason = match (error, error.source()) {
        // The outermost says no more than the file.
        (PipelineError::Capture { .. } | PipelineError::Channels { .. }, Some(source)) => {
            source.to_string()
        }
        _ => error.to_string(),
    };
    let mut cause = match error {
        PipelineError::Capture { .. } | PipelineError::Channels { .. } => {
            error.source().and_then(|source| source.source())
        }
        _ => error.source(),
    };
    while let Some(next) = cause {
        reason.push_str(": ");
        reason.push_str(&next.to_string());
        cause = next.source();
    }
    reason
}
