//! The planned object against the recorded one.

use inhand_model::{Hand, Object, ObjectError, Pose};
use inhand_statistics::quantiles::statistics;

use crate::method::Counts;
use crate::recorded::Recorded;

/// Distance and angle between planned and recorded object at every instant, NaN where one of them is not known.
#[derive(Clone, Debug)]
pub struct PoseErrors {
    /// Distance between the origins, metres.
    pub position_m: Vec<f64>,
    /// Angle of the rotation from one to the other, 0 to pi, radians.
    pub angle_rad: Vec<f64>,
}

/// Errors of the planned object. `planned` has one entry for each segment of the recording, `None` where the plan
/// failed; the result is `None` where no take has an object.
pub(crate) fn pose_errors(
    planned: &[Option<&[Pose<Hand, Object>]>],
    recorded: &Recorded,
    counts: Counts,
) -> Option<PoseErrors> {
    if recorded.object_from_hand.is_empty() {
        return None;
    }
    let count = planned.len() * counts.samples;
    let mut errors = PoseErrors {
        position_m: vec![f64::NAN; count],
        angle_rad: vec![f64::NAN; count],
    };
    for (segment, planned) in planned.iter().enumerate() {
        let object_from_hand = recorded.object_from_hand(segment, counts.samples);
        let poses = planned.unwrap_or_default().iter().zip(object_from_hand);
        for (t, (planned, object_from_hand)) in poses.enumerate() {
            let Some(object_from_hand) = object_from_hand.filter(|_| planned.is_finite()) else {
                continue;
            };
            let hand_from_object = object_from_hand.inverse();
            let k = segment * counts.samples + t;
            errors.position_m[k] = planned.origin().distance_m(hand_from_object.origin());
            let rotation = planned.isometry().rotation;
            errors.angle_rad[k] = rotation.angle_to(&hand_from_object.isometry().rotation);
        }
    }
    Some(errors)
}

/// Errors of the planned object over all instants at which they are known.
pub(crate) fn object_error(
    errors: &PoseErrors,
    recorded: &Recorded,
    counts: Counts,
) -> ObjectError {
    let known = |values: &[f64]| -> Vec<f64> {
        values
            .iter()
            .copied()
            .filter(|value| !value.is_nan())
            .collect()
    };
    let filled = errors.position_m.iter().zip(&recorded.object_filled);
    let n_filled = filled
        .filter(|(error, filled)| !error.is_nan() && **filled)
        .count();
    let (position_m, angle_rad) = (known(&errors.position_m), known(&errors.angle_rad));
    let n_left_out = counts.left_out(position_m.len());
    ObjectError {
        position: statistics(position_m, n_filled, n_left_out),
        angle: statistics(angle_rad, n_filled, n_left_out),
    }
}
