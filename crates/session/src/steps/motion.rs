//! Movement and contact dynamics of the recording and of each method.

use std::ops::Range;

use inhand_evaluation::{
    EvaluationSettings, JudgedMethod, MovementSettings, contact_dynamics, filled_segments,
    motion_contacts, movement,
};
use inhand_model::{
    ContactDynamics, ContactRows, ContactRules, MethodRows, Motion, MotionRows, MovementAnalysis,
    PerFinger, Segments,
};

use super::{Comparison, Generated};
use crate::error::SessionError;
use crate::settings::Settings;

/// What [`motion_analysis`] finds.
#[derive(Debug)]
pub struct MotionAnalysis {
    /// Lengths, speeds, smoothness.
    pub movement: MovementAnalysis,
    /// Contacts over time; `None` without an object of known shape.
    pub contacts: Option<ContactDynamics>,
    /// The single segments and contacts behind both.
    pub rows: MotionRows,
}

/// Measures motion and contacts. `rows` are those that [`evaluate`](super::evaluate) gave for `generated`, in
/// its order; `train` are the training segments, where they are at hand.
///
/// # Errors
///
/// [`SessionError::Settings`], [`SessionError::At`].
pub fn motion_analysis(
    comparison: &Comparison<'_>,
    generated: &[Generated],
    rows: &[MethodRows],
    train: Option<&Segments>,
    settings: &Settings,
) -> Result<MotionAnalysis, SessionError> {
    let (data, recorded) = (&comparison.data, &comparison.recorded);
    let methods: Vec<_> = (generated.iter().zip(rows))
        .map(|(generated, rows)| JudgedMethod {
            trajectories: &generated.trajectories,
            rows,
        })
        .collect();
    let rules = contact_rules(settings);
    let ((movement, movement_rows), contacts) = inhand_parallel::both(
        || movement(data, recorded, &methods, train, &MovementSettings::USUAL),
        || contact_dynamics(data, recorded, &methods, &comparison.settings, &rules),
    );
    let (contacts, contact_rows) = contacts?.unzip();
    let (take_contacts, segment_contacts) =
        contact_rows.map(|rows| (rows.takes, rows.segments)).unzip();
    let rows = MotionRows {
        layout: recorded.rows.layout,
        takes: recorded.rows.takes.clone(),
        segments: recorded.rows.segments.clone(),
        filled: filled_segments(recorded),
        movement: movement_rows,
        contacts: segment_contacts,
        take_contacts: take_contacts.unwrap_or_default(),
    };
    Ok(MotionAnalysis {
        movement,
        contacts,
        rows,
    })
}

/// What counts as a contact, a grasp and a step of a finger.
pub fn contact_rules(settings: &Settings) -> ContactRules {
    let evaluate = &settings.evaluate;
    ContactRules {
        tau_m: evaluate.tau_mm / 1000.0,
        min_duration_s: evaluate.min_contact_s,
        max_lift_s: evaluate.max_lift_s,
        min_fingers: evaluate.grasp_fingers,
    }
}

/// What touches over a whole motion, with phases and steps; `None` where the object's shape or pose is not known.
///
/// # Errors
///
/// [`SessionError::Settings`], [`SessionError::At`].
pub fn contact_rows(
    motion: &Motion,
    settings: &Settings,
) -> Result<Option<ContactRows>, SessionError> {
    let Some(shape) = settings.shape()? else {
        return Ok(None);
    };
    let rules = contact_rules(settings);
    let limits = evaluation_settings(settings)?;
    Ok(inhand_evaluation::contact_rows(
        motion, &shape, &limits, &rules,
    )?)
}

/// The limits that motion is judged by.
pub(super) fn evaluation_settings(settings: &Settings) -> Result<EvaluationSettings, SessionError> {
    Ok(EvaluationSettings {
        tau_m: settings.evaluate.tau_mm / 1000.0,
        collision_limit_m: settings.evaluate.collision_mm / 1000.0,
        finger_offsets_m: settings.pad_offsets_m()?,
        ..EvaluationSettings::paper()
    })
}

/// Signed distance of each pad to the object at these samples of a motion, metres; no sample where the object's shape or pose is not known.
///
/// # Errors
///
/// [`SessionError::Settings`].
pub fn contacts(
    motion: &Motion,
    samples: Range<usize>,
    settings: &Settings,
) -> Result<Vec<Option<PerFinger<f64>>>, SessionError> {
    Ok(match settings.shape()? {
        Some(shape) => motion_contacts(motion, samples, &shape, &evaluation_settings(settings)?),
        None => Vec::new(),
    })
}
