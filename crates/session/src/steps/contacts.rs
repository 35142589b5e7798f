//! Contact rule, and the contacts of a recorded motion.

use inhand_evaluation::{EvaluationSettings, motion_contacts};
use inhand_model::{Motion, PerFinger};

use crate::error::SessionError;
use crate::settings::Settings;

/// The limits that motion is judged by.
pub(super) fn evaluation_settings(settings: &Settings) -> Result<EvaluationSettings, SessionError> {
    Ok(EvaluationSettings {
        tau_m: settings.evaluate.tau_mm / 1000.0,
        collision_limit_m: settings.evaluate.collision_mm / 1000.0,
        finger_offsets_m: settings.pad_offsets_m()?,
        ..EvaluationSettings::paper()
    })
}

/// Signed distance of each pad to the object at each sample of a motion, metres; no sample where the object's shape or pose is not known.
///
/// # Errors
///
/// [`SessionError::Settings`].
pub fn contacts(
    motion: &Motion,
    settings: &Settings,
) -> Result<Vec<Option<PerFinger<f64>>>, SessionError> {
    Ok(match settings.shape()? {
        Some(shape) => motion_contacts(motion, &shape, &evaluation_settings(settings)?),
        None => Vec::new(),
    })
}
