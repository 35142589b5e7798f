//! Contacts of a whole recorded motion, with or without gaps.

use inhand_contact::FingerOffsets;
use inhand_model::{Motion, PerFinger, Pose, Shape};

use crate::input::EvaluationSettings;

/// Signed distance of each pad to the object's surface at each sample of a motion, metres, negative inside, as
/// [`recorded`](crate::recorded) measures it inside segments; NaN where the fingertip is missing. `None` at samples without the object, or without any fingertip. No sample at all where the motion has
/// no object.
pub fn motion_contacts(
    motion: &Motion,
    shape: &Shape,
    settings: &EvaluationSettings,
) -> Vec<Option<PerFinger<f64>>> {
    let Some(object) = &motion.object else {
        return Vec::new();
    };
    let offsets = FingerOffsets(settings.finger_offsets_m);
    (0..motion.len())
        .map(|k| {
            let object_from_hand = object.get(k).map(Pose::inverse)?;
            let distance_m = PerFinger::from_fn(|finger| {
                let tip = motion.fingertips[finger].get(k);
                tip.map_or(f64::NAN, |tip| {
                    offsets.pad_distance_m(shape, finger, object_from_hand * tip)
                })
            });
            let known = distance_m.as_array().iter().any(|d| !d.is_nan());
            known.then_some(distance_m)
        })
        .collect()
}
