//! The planned object against the recorded one.

use inhand_model::{Hand, MethodRows, Object, ObjectError, Pose};

use crate::known::{Counts, known_statistics};
use crate::recorded::Recorded;

/// Distance between the origins (metres) and angle (radians) of planned and recorded object at every instant, NaN
/// where one of them is not known. `planned` has one entry for each segment of the recording, `None` where the plan
/// failed; the result is `None` where no take has an object.
pub(crate) fn pose_errors(
    planned: &[Option<&[Pose<Hand, Object>]>],
    recorded: &Recorded,
    samples: usize,
) -> Option<(Vec<f64>, Vec<f64>)> {
    if recorded.object_from_hand.is_empty() {
        return None;
    }
    let error = |(k, object_from_hand): (usize, &Option<Pose<Object, Hand>>)| {
        let planned = planned[k / samples]?[k % samples];
        let hand_from_object = object_from_hand.filter(|_| planned.is_finite())?.inverse();
        let rotation = hand_from_object.isometry().rotation;
        Some((
            planned.origin().distance_m(hand_from_object.origin()),
            planned.isometry().rotation.angle_to(&rotation),
        ))
    };
    let instants = recorded.object_from_hand.iter().enumerate();
    Some(
        instants
            .map(|k| error(k).unwrap_or((f64::NAN, f64::NAN)))
            .unzip(),
    )
}

/// Errors of the planned object over all instants at which they are known; `None` where there is none.
pub(crate) fn object_error(
    rows: &MethodRows,
    recorded: &Recorded,
    counts: Counts,
) -> Option<ObjectError> {
    let filled = &recorded.rows.object_filled;
    let over = |values: &[f64]| {
        let values = values.iter().copied().zip(filled.iter().copied());
        known_statistics(values, counts.instants())
    };
    Some(ObjectError {
        position: over(rows.object_position_error_m.as_ref()?),
        angle: over(rows.object_angle_error_rad.as_ref()?),
    })
}
