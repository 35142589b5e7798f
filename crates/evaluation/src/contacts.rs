//! Contacts of the fingertips with the object.
//!
//! P1 measures from a fingertip to a cloud of points on the object's surface: how far away it is, not
//! on which side. Contacts and differences of distances follow it and use the size of the signed
//! distance. So a finger deeper inside the object than tau is not in contact, as it is not when it is
//! farther outside: a method that puts fingers deep into the object does not score by it.

use std::ops::Range;

use inhand_contact::FingerOffsets;
use inhand_model::{
    ContactShare, Finger, MethodRows, Motion, PerFinger, Pose, Shape, Statistics, TauShare,
    in_contact,
};

use crate::constraints::is_known;
use crate::input::EvaluationSettings;
use crate::known::{Counts, finger_statistics};
use crate::recorded::Recorded;

/// Contacts that a stable grasp needs (P1).
pub(crate) const STABLE: usize = 3;

/// Share of contacts over the instants at which planned and recorded distances are known.
pub(crate) fn contact_share(
    rows: &MethodRows,
    recorded: &Recorded,
    settings: &EvaluationSettings,
    counts: Counts,
) -> Option<ContactShare> {
    let (planned, of_recording) = (
        rows.distance_m.as_ref()?,
        recorded.rows.recorded_distance_m.as_ref()?,
    );
    let judged: Vec<usize> = (0..planned.len().min(of_recording.len()))
        .filter(|&k| is_known(&planned[k]) && is_known(&of_recording[k]))
        .collect();
    let n = judged.len();
    let is_filled = |k: &&usize| recorded.any_filled(**k).as_array().contains(&true);

    // At least three are in contact at tau where the third nearest to the surface is.
    let third = |distance_m: &[PerFinger<f64>]| -> Vec<f64> {
        (judged.iter())
            .map(|&k| {
                let mut sorted = distance_m[k].as_array().map(f64::abs);
                sorted.sort_unstable_by(f64::total_cmp);
                sorted[STABLE - 1]
            })
            .collect()
    };
    let (planned_third, recorded_third) = (third(planned), third(of_recording));
    let share_at = |third: &[f64], tau_m: f64| {
        third.iter().filter(|&&d| in_contact(d, tau_m)).count() as f64 / n as f64
    };
    let by_finger = |distance_m: &[PerFinger<f64>]| {
        PerFinger::from_fn(|finger: Finger| {
            let contacts = judged
                .iter()
                .filter(|&&k| in_contact(distance_m[k][finger], settings.tau_m));
            contacts.count() as f64 / n as f64
        })
    };
    Some(ContactShare {
        n,
        n_filled: judged.iter().filter(is_filled).count(),
        n_left_out: counts.left_out(n),
        tau_m: settings.tau_m,
        three_or_more: share_at(&planned_third, settings.tau_m),
        recorded_three_or_more: share_at(&recorded_third, settings.tau_m),
        by_finger: by_finger(planned),
        recorded_by_finger: by_finger(of_recording),
        by_tau: (settings.tau_sweep_m.iter())
            .map(|&tau_m| TauShare {
                tau_m,
                three_or_more: share_at(&planned_third, tau_m),
                recorded_three_or_more: share_at(&recorded_third, tau_m),
            })
            .collect(),
    })
}

/// Absolute difference between planned and recorded distance to the object's surface, each finger:
/// 0 for a pad planned as deep inside as it was recorded outside.
pub(crate) fn distance_difference(
    rows: &MethodRows,
    recorded: &Recorded,
    counts: Counts,
) -> Option<PerFinger<Statistics>> {
    let (planned, of_recording) = (
        rows.distance_m.as_ref()?,
        recorded.rows.recorded_distance_m.as_ref()?,
    );
    let difference: Vec<PerFinger<f64>> = (planned.iter().zip(of_recording))
        .map(|(planned, recorded)| {
            PerFinger::from_fn(|finger| (planned[finger].abs() - recorded[finger].abs()).abs())
        })
        .collect();
    let filled: Vec<PerFinger<bool>> = (0..recorded.rows.filled.len())
        .map(|k| recorded.any_filled(k))
        .collect();
    Some(finger_statistics(&difference, &filled, counts))
}

/// Signed distance of each pad to the object's surface at these samples of a motion, metres, negative inside, as
/// [`recorded`](crate::recorded) measures it inside segments; NaN where the fingertip is missing. `None` at samples without the object, or without any fingertip. No sample at all where the motion has
/// no object.
pub fn motion_contacts(
    motion: &Motion,
    samples: Range<usize>,
    shape: &Shape,
    settings: &EvaluationSettings,
) -> Vec<Option<PerFinger<f64>>> {
    if motion.object.is_none() {
        return Vec::new();
    }
    let contact = contact_at(motion, shape, settings);
    samples.map(contact).collect()
}

/// The same of one sample.
pub(crate) fn contact_at(
    motion: &Motion,
    shape: &Shape,
    settings: &EvaluationSettings,
) -> impl Fn(usize) -> Option<PerFinger<f64>> {
    let offsets = FingerOffsets(settings.finger_offsets_m);
    move |k| {
        let object_from_hand = motion.object.as_ref()?.get(k).map(Pose::inverse)?;
        let distance_m = PerFinger::from_fn(|finger| {
            let tip = motion.fingertips[finger].get(k);
            tip.map_or(f64::NAN, |tip| {
                offsets.pad_distance_m(shape, finger, object_from_hand * tip)
            })
        });
        let known = distance_m.as_array().iter().any(|d| !d.is_nan());
        known.then_some(distance_m)
    }
}
