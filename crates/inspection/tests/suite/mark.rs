//! Takes with 2 % gaps and, a minute, 10 swaps, 5 flips, 20 spikes and 3 lost labels. The seeds here
//! were not looked at when thresholds were chosen.

use inhand_inspection::{CleanSettings, FillMethod, FillSettings, clean, detect};
use inhand_model::{Finger, Status};
use inhand_simulation::{TakeSettings, simulate};

use crate::common::{Tallies, compare, faulty, label, minutes, repairs, roles};

fn takes() -> Vec<(TakeSettings, u64, bool)> {
    let hand_only = TakeSettings {
        track_object: false,
        duration_s: 60.0,
        ..TakeSettings::cube("hand")
    };
    vec![
        (TakeSettings::cube("cube"), 301, true),
        (TakeSettings::cylinder("cylinder"), 302, true),
        (TakeSettings::cylinder("cylinder"), 303, true),
        (hand_only, 304, false),
    ]
}

#[test]
fn planted_faults_are_found_and_little_else() {
    let mut sum = Tallies::default();
    let mut all_minutes = 0.0;
    for (settings, seed, object) in takes() {
        let take = faulty(&settings, seed);
        let suspects =
            detect::all(&take.recording, Some(&roles(object))).expect("roles are in the take");
        sum.add(&compare(&take, &suspects));
        all_minutes += minutes(&take.recording);
    }
    assert!(all_minutes > 6.9 && sum.swaps.planted > 60, "{sum:?}");
    for (kind, tally) in [
        ("swaps", sum.swaps),
        ("flips", sum.flips),
        ("spikes", sum.spikes),
        ("lost labels", sum.unlabelled),
    ] {
        assert!(tally.share() >= 0.95, "{kind}: {tally:?}");
    }
    let false_alarms = sum.false_alarms() as f64 / all_minutes;
    assert!(false_alarms < 1.0, "{false_alarms} a minute: {sum:?}");
}

#[test]
fn other_rates_and_noisier_markers_are_searched_as_well() {
    for (rate_hz, noise_m) in [(60.0, 1e-4), (240.0, 1e-4), (120.0, 4e-4)] {
        let settings = TakeSettings {
            rate_hz,
            noise_m,
            duration_s: 90.0,
            ..TakeSettings::cube("other")
        };
        let take = faulty(&settings, 311);
        let suspects =
            detect::all(&take.recording, Some(&roles(true))).expect("roles are in the take");
        let found = compare(&take, &suspects);
        for tally in [found.swaps, found.flips, found.spikes] {
            assert!(tally.share() >= 0.9, "{rate_hz} Hz, {noise_m} m: {found:?}");
        }
        let limit = 2.0 * minutes(&take.recording);
        assert!(
            (found.false_alarms() as f64) < limit,
            "{rate_hz} Hz, {noise_m} m: {found:?}"
        );
    }
}

#[test]
fn nothing_is_found_in_takes_without_faults() {
    for (shape, seed) in [
        (TakeSettings::cube("a"), 321),
        (TakeSettings::cylinder("b"), 322),
    ] {
        let settings = TakeSettings {
            gaps: Some(inhand_simulation::GapSettings::with_share(0.02)),
            ..shape
        };
        let take = simulate(&settings, seed).expect("the settings are valid");
        let suspects =
            detect::all(&take.recording, Some(&roles(true))).expect("roles are in the take");
        assert!(suspects.is_empty(), "{suspects:?}");
    }
}

#[test]
fn filled_fingertips_are_near_the_truth() {
    let take = faulty(&TakeSettings::cylinder("cylinder"), 331);
    for (method, limit_mm) in [
        (FillMethod::Linear, 1.0),
        (FillMethod::Cubic, 1.0),
        (FillMethod::Neighbours, 1.0),
    ] {
        let settings = CleanSettings {
            fill: Some(FillSettings {
                method,
                limit_s: 0.1,
            }),
            ..repairs()
        };
        let cleaned = clean(&take.recording, &roles(true), &settings).expect("roles are there");
        let mut errors_mm = Vec::new();
        for finger in Finger::ALL {
            let marker = cleaned
                .recording
                .marker(&label(finger))
                .expect("it has all fingers");
            let truth = &take.clean.truth.fingertips[finger];
            for (k, &there) in truth.iter().enumerate() {
                let filled = marker
                    .track
                    .get(k)
                    .filter(|_| marker.track.status(k) == Status::Filled);
                errors_mm.extend(filled.map(|filled| filled.distance_m(there) * 1e3));
            }
        }
        errors_mm.sort_by(f64::total_cmp);
        assert!(
            errors_mm.len() > 300,
            "{method:?} filled {}",
            errors_mm.len()
        );
        let at = |share: f64| errors_mm[(share * (errors_mm.len() - 1) as f64) as usize];
        assert!(at(0.5) < limit_mm, "{method:?}: median {} mm", at(0.5));
        assert!(at(0.95) < 3.0, "{method:?}: 95 % below {} mm", at(0.95));
    }
}
