//! Contacts of the fingertips with the object.

use inhand_model::{ContactShare, Finger, PerFinger, Statistics, TauShare};

use crate::constraints::is_known;
use crate::input::EvaluationSettings;
use crate::method::{Counts, Rows, finger_statistics};
use crate::recorded::Recorded;

/// More than rounding can do to a distance between a finger and the object in its hand, metres, so
/// that a distance of exactly tau is a contact; far below what any camera can tell apart.
const CONTACT_ROUNDING_M: f64 = 1e-12;

/// Contacts that a stable grasp needs (P1).
const STABLE: usize = 3;

/// Whether a finger this far from the object is in contact; not where the distance is not known.
pub(crate) fn in_contact(distance_m: f64, tau_m: f64) -> bool {
    distance_m <= tau_m + CONTACT_ROUNDING_M
}

/// Share of contacts over the instants at which planned and recorded distances are known.
pub(crate) fn contact_share(
    rows: &Rows,
    recorded: &Recorded,
    settings: &EvaluationSettings,
    counts: Counts,
) -> Option<ContactShare> {
    let (planned, of_recording) = (rows.distance_m.as_ref()?, recorded.distance_m.as_ref()?);
    let judged: Vec<usize> = (0..planned.len().min(of_recording.len()))
        .filter(|&k| is_known(&planned[k]) && is_known(&of_recording[k]))
        .collect();
    let n = judged.len();
    let is_filled =
        |k: &&usize| recorded.object_filled[**k] || recorded.filled[**k].as_array().contains(&true);

    // At least three are in contact at tau where the third nearest is.
    let third = |distance_m: &[PerFinger<f64>]| -> Vec<f64> {
        (judged.iter())
            .map(|&k| {
                let mut sorted = *distance_m[k].as_array();
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

/// Absolute difference between planned and recorded distance to the object, each finger.
pub(crate) fn distance_difference(
    rows: &Rows,
    recorded: &Recorded,
    counts: Counts,
) -> Option<PerFinger<Statistics>> {
    let (planned, of_recording) = (rows.distance_m.as_ref()?, recorded.distance_m.as_ref()?);
    let difference: Vec<PerFinger<f64>> = (planned.iter().zip(of_recording))
        .map(|(planned, recorded)| {
            PerFinger::from_fn(|finger| (planned[finger] - recorded[finger]).abs())
        })
        .collect();
    let filled: Vec<PerFinger<bool>> = (recorded.filled.iter().zip(&recorded.object_filled))
        .map(|(fingers, &object)| fingers.map(|finger| finger || object))
        .collect();
    Some(finger_statistics(&difference, &filled, counts))
}
