//! Checking takes, one at a time in memory.

use std::path::Path;

use inhand_inspection::detect::{Suspects, all, flips, spikes};
use inhand_inspection::{CheckSettings, Checked, Suspicion, SuspicionKind, check};

use crate::containers::name_of;
use crate::error::SessionError;
use crate::settings::Settings;
use crate::take::{Take, read};

/// Reads a take, whatever its format, and looks at everything that it tells of itself. A file that
/// cannot be read is a result with its reason, so that it does not end the check of others.
///
/// # Errors
///
/// [`SessionError::Settings`]: what would be wrong for every take.
pub fn check_take(path: &Path, settings: &Settings) -> Result<Checked, SessionError> {
    let limits = check_settings(settings)?;
    let outcome = match read(path, settings) {
        Ok(take) => {
            let roles = take.roles.as_ref().map_err(String::as_str);
            let suspicions = suspicions(&take);
            Ok(check(&take.recording, roles, &suspicions, &limits))
        }
        Err(error) if error.is_usage() => return Err(error),
        Err(error) => Err(reason(&error, path)),
    };
    Ok(Checked {
        file: path.display().to_string(),
        outcome,
    })
}

/// Limits of a check: the take is looked at as these settings would process and cut it.
fn check_settings(settings: &Settings) -> Result<CheckSettings, SessionError> {
    Ok(CheckSettings {
        process: settings.process_settings()?,
        margin_s: settings.segments.margin_s,
        missing_s: settings.segments.missing_s,
        ..CheckSettings::default()
    })
}

/// What detectors suspect. Without roles, what needs none.
fn suspicions(take: &Take) -> Vec<Suspicion> {
    let without_roles = || Suspects {
        flips: flips(&take.recording),
        spikes: spikes(&take.recording),
        ..Suspects::default()
    };
    let found = match &take.roles {
        // Roles whose hand has no pose are said by the check itself.
        Ok(roles) => all(&take.recording, roles).unwrap_or_else(|_| without_roles()),
        Err(_) => without_roles(),
    };
    let flips = found.flips.iter().map(|flip| Suspicion {
        kind: SuspicionKind::Flip,
        entity: flip.name.clone(),
        samples: flip.samples.clone(),
        score: flip.score,
        message: flip.to_string(),
    });
    let swaps = found.swaps.iter().map(|swap| Suspicion {
        kind: SuspicionKind::Swap,
        entity: (swap.fingers.iter())
            .map(|finger| finger.name())
            .collect::<Vec<_>>()
            .join(" and "),
        samples: swap.samples.clone(),
        score: swap.score,
        message: swap.to_string(),
    });
    let spikes = found.spikes.iter().map(|spike| Suspicion {
        kind: SuspicionKind::Spike,
        entity: spike.name.clone(),
        samples: spike.samples.clone(),
        score: spike.score,
        message: spike.to_string(),
    });
    let unlabelled = found.unlabelled.iter().map(|piece| Suspicion {
        kind: SuspicionKind::Unlabelled,
        entity: piece.finger.name().to_owned(),
        samples: piece.samples.clone(),
        score: piece.score,
        message: piece.to_string(),
    });
    (flips.chain(swaps).chain(spikes).chain(unlabelled)).collect()
}

/// An error and its causes without the file's name, which stands beside them.
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
