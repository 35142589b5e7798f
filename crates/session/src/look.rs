//! Inspection of a session before anything is learned.

use inhand_inspection::{SessionLimits, SessionMotion, inspect};
use inhand_model::{Inspection, Level, Motion};

use crate::check::check_settings;
use crate::error::{Located, SessionError};
use crate::session::Session;
use crate::settings::{Role, Settings};
use crate::take::Take;

/// Looks at every take, and at the settings; motions are in the hand's frame, not filtered.
pub(crate) fn look(
    session: &Session,
    takes: &[Take],
    motions: &[Motion],
    settings: &Settings,
) -> Result<Inspection, SessionError> {
    let takes = (takes.iter().zip(motions).zip(&session.takes)).map(|((take, motion), entry)| {
        Ok(SessionMotion {
            name: &take.name,
            recording: &take.recording,
            roles: take.roles()?,
            motion,
            train: entry.role == Role::Train,
        })
    });
    let takes: Vec<_> = takes.collect::<Result<_, SessionError>>()?;
    inspect(&takes, &limits(settings)?).during("looking at the takes")
}

pub(crate) fn limits(settings: &Settings) -> Result<SessionLimits<'_>, SessionError> {
    Ok(SessionLimits {
        check: check_settings(settings)?,
        shape: settings.shape()?,
        tau_m: settings.evaluate.tau_mm / 1000.0,
        accept: &settings.look.accept,
    })
}

/// Refuses a session with findings that make its results wrong, all of them at once.
pub(crate) fn refuse(session: &Session, inspection: &Inspection) -> Result<(), SessionError> {
    let fails: Vec<_> = inspection.counted(Level::Fail).collect();
    if fails.is_empty() {
        return Ok(());
    }
    let mut ids: Vec<_> = fails.iter().map(|finding| finding.id.as_str()).collect();
    ids.dedup();
    let lines: String = fails.iter().map(|finding| format!("\n{finding}")).collect();
    let accept = ids.join(" --accept ");
    let message = format!(
        "results would be wrong; nothing was learned or written{lines}\nwhere it is right all the same: --accept {accept}"
    );
    Err(SessionError::Refused {
        session: session.name.clone(),
        message,
        findings: fails.into_iter().cloned().collect(),
    })
}
