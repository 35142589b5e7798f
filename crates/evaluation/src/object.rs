//! The planned object against the recorded one.

use inhand_model::{Hand, Object, ObjectError, Pose};
use inhand_trajectory::quantiles::statistics;

use crate::method::Counts;
use crate::recorded::Recorded;

/// Distance and angle between planned and recorded object, over all instants at which both are known.
/// `planned` has one entry for each segment of the recording, `None` where the plan failed.
pub(crate) fn object_error(
    planned: &[Option<&[Pose<Hand, Object>]>],
    recorded: &Recorded,
    counts: Counts,
) -> Option<ObjectError> {
    if recorded.object_from_hand.is_empty() {
        return None;
    }
    let (mut position_m, mut angle_rad, mut n_filled) = (Vec::new(), Vec::new(), 0);
    for (segment, planned) in planned.iter().enumerate() {
        let object_from_hand = recorded.object_from_hand(segment, counts.samples);
        let poses = planned.unwrap_or_default().iter().zip(object_from_hand);
        for (t, (planned, object_from_hand)) in poses.enumerate() {
            let Some(object_from_hand) = object_from_hand.filter(|_| planned.is_finite()) else {
                continue;
            };
            let hand_from_object = object_from_hand.inverse();
            position_m.push(planned.origin().distance_m(hand_from_object.origin()));
            let rotation = planned.isometry().rotation;
            angle_rad.push(rotation.angle_to(&hand_from_object.isometry().rotation));
            let k = segment * counts.samples + t;
            n_filled += usize::from(recorded.object_filled[k]);
        }
    }
    let n_left_out = counts.left_out(position_m.len());
    Some(ObjectError {
        position: statistics(position_m, n_filled, n_left_out),
        angle: statistics(angle_rad, n_filled, n_left_out),
    })
}
