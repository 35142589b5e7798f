//! Inspection of takes before anything is learned from them.

use std::path::PathBuf;

use inhand_inspection::{SessionLimits, SessionMotion, TakeLook, inspect};
use inhand_model::{BodySource, Inspection, Level, Motion};

use crate::check::check_settings;
use crate::error::{Located, SessionError};
use crate::session::Session;
use crate::settings::{Role, Settings};
use crate::steps;
use crate::take::{Take, read_clean};

/// Looks at every take, and at the settings; motions are in the hand's frame, not filtered.
pub(crate) fn look(
    session: &Session,
    takes: &[Take],
    motions: &[Motion],
    settings: &Settings,
) -> Result<Inspection, SessionError> {
    let looks = inhand_parallel::try_up_to(takes.len(), |n| {
        let train = session.takes[n].role == Role::Train;
        take_look(&takes[n], &motions[n], train, settings)
    })?;
    Ok(inspect(&looks, &limits(settings)?))
}

/// Looks at training takes, as many in memory as there are threads; all of them where the hand is fitted to
/// markers, by one template. A take that has its motion alone is passed over.
///
/// # Errors
///
/// [`SessionError`]: a take that cannot be read, and findings that make results wrong.
pub fn look_at_training(
    paths: &[PathBuf],
    settings: &Settings,
) -> Result<Inspection, SessionError> {
    let (mut looks, mut done) = (Vec::new(), 0);
    let mut together = rayon::current_num_threads();
    while done < paths.len() {
        let rest = &paths[done..];
        let mut takes = inhand_parallel::try_map(&rest[..together.min(rest.len())], |path| {
            read_clean(path, settings)
        })?;
        let is_cluster = |take: &Take| {
            (take.roles.as_ref()).is_ok_and(|roles| matches!(roles.hand, BodySource::Markers(_)))
        };
        if together < paths.len() && takes.iter().any(is_cluster) {
            (together, looks, done) = (paths.len(), Vec::new(), 0);
            continue;
        }
        done += takes.len();
        takes.retain(|take| take.roles.is_ok() || take.stored_motion.is_none());
        let motions = steps::motions_in_hand(&takes, &|_| true, settings)?;
        looks.extend(inhand_parallel::try_up_to(takes.len(), |n| {
            take_look(&takes[n], &motions[n], true, settings)
        })?);
    }
    let inspection = inspect(&looks, &limits(settings)?);
    refuse("training takes", &inspection)?;
    Ok(inspection)
}

fn take_look(
    take: &Take,
    motion: &Motion,
    train: bool,
    settings: &Settings,
) -> Result<TakeLook, SessionError> {
    let seen = SessionMotion {
        name: &take.name,
        recording: &take.recording,
        roles: take.roles()?,
        motion,
        distances_m: &steps::contacts(motion, 0..motion.len(), settings)?,
        train,
    };
    TakeLook::new(&seen, &limits(settings)?).during(format_args!("looking at {}", take.name))
}

pub(crate) fn limits(settings: &Settings) -> Result<SessionLimits<'_>, SessionError> {
    Ok(SessionLimits {
        check: check_settings(settings)?,
        shape: settings.shape()?,
        tau_m: settings.evaluate.tau_mm / 1000.0,
        accept: &settings.look.accept,
        resampled: settings.clean.resample_hz.is_some(),
        ends_s: settings.segments.ends_s,
    })
}

/// Refuses takes with findings that make results wrong, all of them at once.
pub(crate) fn refuse(name: &str, inspection: &Inspection) -> Result<(), SessionError> {
    let fails: Vec<_> = inspection.counted(Level::Fail).collect();
    if fails.is_empty() {
        return Ok(());
    }
    let mut ids: Vec<_> = fails.iter().map(|finding| finding.id.as_str()).collect();
    ids.sort_unstable();
    ids.dedup();
    let lines: String = fails.iter().map(|finding| format!("\n{finding}")).collect();
    let accept = ids.join(" --accept ");
    let message = format!(
        "results would be wrong; nothing was learned or written{lines}\nwhere it is right all the same: --accept {accept}"
    );
    Err(SessionError::Refused {
        session: name.to_owned(),
        message,
        findings: fails.into_iter().cloned().collect(),
    })
}
