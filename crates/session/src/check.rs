//! Checking takes, one at a time in memory.

use std::path::Path;

use inhand_inspection::{CheckSettings, Checked, check, detect};

use crate::error::SessionError;
use crate::files::{folder_and_name, name_of};
use crate::session::SessionTake;
use crate::settings::Settings;
use crate::take::{Take, read, used};

/// Reads what a session uses of a take, whatever its format, and looks at everything that it tells of itself. A file
/// that cannot be read is a result with its reason, so that it does not end the check of others.
///
/// # Errors
///
/// [`SessionError::Settings`]: what would be wrong for every take.
pub fn check_take(entry: &SessionTake, settings: &Settings) -> Result<Checked, SessionError> {
    let limits = check_settings(settings)?;
    let path = entry.path.as_path();
    let mut range_s = None;
    let part = |take: Take| {
        let Some(samples) = used(&take, entry)? else {
            return Ok(take);
        };
        let clock = take.recording.clock;
        range_s = Some([samples.start, samples.end].map(|k| clock.time_s(k)));
        Ok(take.slice(samples))
    };
    let outcome = match read(path, settings).and_then(part) {
        Ok(take) => {
            let roles = take.roles.as_ref().map_err(String::as_str);
            // Roles whose hand has no pose are a result of the check itself.
            let suspects = (detect::all(&take.recording, roles.ok()))
                .or_else(|_| detect::all(&take.recording, None))
                .unwrap_or_default();
            Ok(check(&take.recording, roles, &suspects, &limits))
        }
        Err(error) if error.is_usage() => return Err(error),
        Err(error) => Err(reason(&error, path)),
    };
    Ok(Checked {
        file: folder_and_name(path),
        role: Some(entry.role.name()),
        range_s,
        outcome,
    })
}

/// Limits of a check: the take is looked at as these settings would process and cut it.
pub(crate) fn check_settings(settings: &Settings) -> Result<CheckSettings, SessionError> {
    Ok(CheckSettings {
        process: settings.process_settings()?,
        margin_s: settings.segments.margin_s,
        missing_s: settings.segments.missing_s,
        ..CheckSettings::default()
    })
}

/// An error and its causes without the file's name, which is shown beside them.
fn reason(error: &SessionError, path: &Path) -> String {
    let file = path.display().to_string();
    let name = name_of(path);
    let short = |text: &str| {
        let rest = [&file, &name]
            .into_iter()
            .find_map(|name| text.strip_prefix(name.as_str()));
        let rest = rest.unwrap_or(text);
        rest.strip_prefix(": ").unwrap_or(rest).to_owned()
    };
    let mut causes = Vec::new();
    let mut next: Option<&dyn std::error::Error> = Some(error);
    while let Some(cause) = next {
        causes.push(short(&cause.to_string()));
        next = cause.source();
    }
    causes.retain(|cause| !cause.is_empty());
    causes.join(": ")
}
