//! Contacts of a whole recorded motion, with or without gaps.

use inhand_contact::FingerOffsets;
use inhand_model::{Motion, PerFinger, Pose, Shape};

use crate::contacts::in_contact;
use crate::input::EvaluationSettings;

/// Fingertips and the object at one sample of a take.
#[derive(Clone, Copy, Debug)]
pub struct SampleContacts {
    /// Signed distance of each pad to the object's surface, metres, negative inside; NaN where the
    /// fingertip is missing.
    pub distance_m: PerFinger<f64>,
    /// Whether each finger is in contact, its distance between -tau and tau.
    pub in_contact: PerFinger<bool>,
}

/// What touches at each sample of a motion, as [`recorded`](crate::recorded) judges it inside segments;
/// `None` at samples without the object, or without any fingertip. No sample at all where the motion has
/// no object.
pub fn motion_contacts(
    motion: &Motion,
    shape: &Shape,
    settings: &EvaluationSettings,
) -> Vec<Option<SampleContacts>> {
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
            known.then(|| SampleContacts {
                distance_m,
                in_contact: distance_m.map(|d| in_contact(d, settings.tau_m)),
            })
        })
        .collect()
}
