//! Repaired takes compared with the takes without faults.

use inhand_inspection::{CleanSettings, clean, detect, repair};
use inhand_model::{ChangeKind, Finger, Position, Recording, Status};
use inhand_simulation::{FaultKind, TakeSettings};

use crate::common::{faulty, label, repairs, roles};

/// Samples of a recording that are further from the truth than `limit_m`, and all that are there.
fn far_off(
    recording: &Recording,
    take: &inhand_simulation::FaultyTake,
    limit_m: f64,
) -> (usize, usize) {
    let (mut far, mut all) = (0, 0);
    for finger in Finger::ALL {
        let track = &recording
            .marker(&label(finger))
            .expect("it has all fingers")
            .track;
        for (k, &there) in take.clean.truth.fingertips[finger].iter().enumerate() {
            if let Some(at) = track.get(k) {
                all += 1;
                far += usize::from(at.distance_m(there) > limit_m);
            }
        }
    }
    (far, all)
}

#[test]
fn fingertips_and_bodies_are_back_where_they_were() {
    let take = faulty(&TakeSettings::cube("cube"), 341);
    let (wrong, before) = far_off(&take.recording, &take, 0.003);
    assert!(wrong > 1000, "the faults show: {wrong} of {before}");
    let cleaned = clean(&take.recording, &roles(true), &repairs()).expect("roles are in the take");
    let (far, after) = far_off(&cleaned.recording, &take, 0.003);
    assert!(
        after > before,
        "stitching gives samples back: {after} of {before}"
    );
    assert!(far * 2000 <= after, "{far} of {after} samples are off");

    for (body, truth_body) in cleaned
        .recording
        .bodies
        .iter()
        .zip(&take.clean.recording.bodies)
    {
        let mut far = 0;
        for k in 0..body.track.len() {
            let (Some(pose), Some(truth)) = (body.track.get(k), truth_body.track.get(k)) else {
                continue;
            };
            let (pose, truth) = (pose.isometry(), truth.isometry());
            let turned = pose.rotation.angle_to(&truth.rotation).to_degrees();
            far += usize::from(turned > 3.0);
            let moved = (pose.translation.vector - truth.translation.vector).norm();
            far += usize::from(moved > 0.002);
        }
        assert_eq!(far, 0, "{} is turned back", body.name);
    }
}

#[test]
fn every_changed_sample_is_in_a_change_and_no_other() {
    let take = faulty(
        &TakeSettings {
            duration_s: 30.0,
            ..TakeSettings::cube("cube")
        },
        342,
    );
    let raw = take.recording.clone();
    let cleaned = clean(&take.recording, &roles(true), &repairs()).expect("roles are in the take");
    let same = |a: Option<Position<_>>, b: Option<Position<_>>| a == b;
    for (before, after) in raw.markers.iter().zip(&cleaned.recording.markers) {
        for k in 0..before.track.len() {
            let told = cleaned.changes.iter().any(|change| {
                change.samples.contains(&k)
                    && (change.entity.split(", ").any(|name| name == before.name)
                        || change.message.contains(&before.name))
            });
            let kept = same(before.track.get(k), after.track.get(k));
            assert!(kept || told, "{} changed at {k} in silence", before.name);
        }
        // Repairs move measured samples about; they make none up.
        assert!(after.track.statuses().iter().all(|s| *s != Status::Filled));
    }
    let kinds: Vec<_> = cleaned.changes.iter().map(|change| change.kind).collect();
    for kind in [
        ChangeKind::TurnedBack,
        ChangeKind::Swapped,
        ChangeKind::Removed,
        ChangeKind::Stitched,
    ] {
        assert!(kinds.contains(&kind), "{kind:?} is told");
    }
}

#[test]
fn a_step_that_is_not_wished_for_changes_nothing() {
    let settings = TakeSettings {
        duration_s: 20.0,
        ..TakeSettings::cube("cube")
    };
    let take = faulty(&settings, 343);
    let cleaned = clean(&take.recording, &roles(true), &CleanSettings::default())
        .expect("roles are in the take");
    assert!(cleaned.changes.is_empty());
    for (before, after) in take
        .recording
        .markers
        .iter()
        .zip(&cleaned.recording.markers)
    {
        assert!(before.track.iter().eq(after.track.iter()));
    }
    let swaps_only = CleanSettings {
        swaps: true,
        ..CleanSettings::default()
    };
    let cleaned = clean(&take.recording, &roles(true), &swaps_only).expect("roles are in the take");
    assert!(!cleaned.changes.is_empty());
    assert!(
        cleaned
            .changes
            .iter()
            .all(|change| change.kind == ChangeKind::Swapped)
    );
}

#[test]
fn what_was_repaired_is_not_found_again() {
    let take = faulty(&TakeSettings::cylinder("cylinder"), 344);
    let cleaned = clean(&take.recording, &roles(true), &repairs()).expect("roles are in the take");
    let left = detect::all(&cleaned.recording, Some(&roles(true))).expect("roles are in the take");
    let count = |id: &str| {
        left.iter()
            .filter(|suspect| suspect.kind.id() == id)
            .count()
    };
    assert_eq!((count("flips"), count("swaps")), (0, 0), "{left:?}");
    assert!(count("spikes") <= 2, "{left:?}");
}

#[test]
fn holes_that_spikes_leave_are_no_reason_for_new_ones() {
    let (mut first, mut second) = (0, 0);
    for seed in 351..355 {
        let take = faulty(&TakeSettings::cube("cube"), seed);
        let mut recording = take.clean.recording.clone();
        // Spikes alone, where the faults have them, each to one side.
        for fault in &take.faults {
            if !matches!(fault.kind, FaultKind::Spike { .. }) {
                continue;
            }
            let marker = (recording
                .markers
                .iter_mut()
                .find(|m| m.name == fault.entities[0]))
            .expect("it is in the take");
            for k in fault.samples.clone() {
                let off_m = nalgebra::Vector3::new(0.01, -0.008, 0.0);
                let off = marker
                    .track
                    .get(k)
                    .map(|at| Position::from_coords(at.coords_m() + off_m));
                marker.track.set(k, off, Status::Measured);
            }
        }
        let found = detect::spikes(&recording);
        first += found.len();
        repair(&mut recording, &roles(true), &found).expect("roles are in the take");
        second += detect::spikes(&recording).len();
    }
    assert!(first > 100, "{first}");
    assert_eq!(second, 0, "of {first}");
}
