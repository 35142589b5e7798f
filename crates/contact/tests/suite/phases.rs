//! Phases of manipulation and steps of fingers; `../reference/make_events.py` made the numbers.

use inhand_contact::{ContactError, ContactSeries, phases};
use inhand_model::{ContactRules, PerFinger, PhaseKind};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::events::{any_series, of_reference, pads, recorded, series};

#[test]
fn phases_agree_with_the_reference() {
    for take in &recorded() {
        let rules = ContactRules {
            tau_m: 0.005,
            min_fingers: take["min_fingers"].as_u64().unwrap() as usize,
            min_duration_s: take["min_duration_s"].as_f64().unwrap(),
            max_lift_s: take["max_lift_s"].as_f64().unwrap(),
        };
        let pads = pads(take);
        let pad = |k: usize, finger| pads[k][finger];
        let (phases, gaits) = phases(&of_reference(take), &pad, &rules).unwrap();
        let listed: Vec<Value> = (phases.iter())
            .map(|p| {
                json!([
                    p.kind.name(),
                    p.samples.start,
                    p.samples.end,
                    p.holding.bits()
                ])
            })
            .collect();
        assert_eq!(json!(listed), take["phases"]);
        let expected = take["gaits"].as_array().unwrap();
        assert_eq!(gaits.len(), expected.len());
        for (gait, expected) in gaits.iter().zip(expected) {
            let (start, end) = (gait.samples.start, gait.samples.end);
            let whole = json!([start, gait.finger.index(), end, gait.holding.bits()]);
            assert_eq!(
                whole.as_array().unwrap()[..],
                expected.as_array().unwrap()[..4]
            );
            match expected[4].as_f64() {
                Some(expected) => assert!((gait.step_m - expected).abs() < 1e-12),
                None => assert!(gait.step_m.is_nan()),
            }
        }
    }
}

#[test]
fn kinds_of_phases() {
    let rules = ContactRules {
        tau_m: 0.005,
        min_fingers: 3,
        min_duration_s: 0.0,
        max_lift_s: 0.03,
    };
    let of = |fingers| {
        let (phases, gaits) = phases(&series(fingers, 100.0), &|_, _| None, &rules).unwrap();
        let phases: Vec<String> = (phases.iter())
            .map(|p| format!("{} {:?}", p.kind.name(), p.samples))
            .collect();
        let gaits: Vec<String> = (gaits.iter())
            .map(|g| format!("{} {:?} {}", g.finger, g.samples, g.holding))
            .collect();
        (phases.join(", "), gaits.join(", "))
    };
    // Taken up, held, given up, taken again.
    let take = "0111001110";
    assert_eq!(
        of([take; 5]).0,
        "no_grasp 0..1, in_grasp 1..4, regrasp 4..6, in_grasp 6..9, no_grasp 9..10"
    );
    // Two fingers one after the other, their steps overlapping.
    let full = "1111111111";
    let (found, gaits) = of([full, "1100111111", "1110001111", full, full]);
    assert_eq!(found, "in_grasp 0..2, finger_gaiting 2..6, in_grasp 6..10");
    assert_eq!(
        gaits,
        "index 2..4 thumb+ring+little, middle 3..6 thumb+ring+little"
    );
    // Off for too long, and off for good: the grasp changes, no finger gaits.
    let (found, gaits) = of([full, "1100001111", full, full, "1111111000"]);
    assert_eq!(
        found,
        "in_grasp 0..2, in_grasp 2..6, in_grasp 6..7, in_grasp 7..10"
    );
    assert_eq!(gaits, "");
    // Nobody saw whether the finger touched in between.
    let (found, gaits) = of([full, "110?011111", full, full, full]);
    assert_eq!(
        found,
        "in_grasp 0..2, in_grasp 2..3, in_grasp 4..5, in_grasp 5..10"
    );
    assert_eq!(gaits, "");
    // Others did not hold.
    let (found, gaits) = of([full, "1110111111", "0000000000", "0000000000", full]);
    assert_eq!(found, "in_grasp 0..3, regrasp 3..4, in_grasp 4..10");
    assert_eq!(gaits, "");
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    let some = series(["0110"; 5], 100.0);
    let good = ContactRules {
        tau_m: 0.005,
        min_fingers: 3,
        min_duration_s: 0.0,
        max_lift_s: 1.0,
    };
    let refused = |rules| phases(&some, &|_, _| None, &rules).unwrap_err();
    for bad in [-0.1, f64::NAN, f64::INFINITY] {
        let (min_duration_s, max_lift_s) = (bad, bad);
        for rules in [
            ContactRules {
                min_duration_s,
                ..good
            },
            ContactRules { max_lift_s, ..good },
        ] {
            assert!(matches!(refused(rules), ContactError::Duration { .. }));
        }
    }
    for min_fingers in [0, 6] {
        let error = refused(ContactRules {
            min_fingers,
            ..good
        });
        assert_eq!(error, ContactError::MinFingers { found: min_fingers });
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn phases_tile_what_is_known(samples in any_series(), min_fingers in 1..6_usize, shift in 0..7_usize) {
        let rules = ContactRules { tau_m: 0.005, min_fingers, min_duration_s: 0.02, max_lift_s: 0.05 };
        let series = ContactSeries::new(samples.clone(), 100.0).unwrap();
        let (found, gaits) = phases(&series, &|_, _| None, &rules).unwrap();
        let states = series.debounced(0.02).unwrap().states();
        let mut covered = vec![0; states.len()];
        for phase in &found {
            covered[phase.samples.clone()].iter_mut().for_each(|n| *n += 1);
            for state in &states[phase.samples.clone()] {
                let state = state.unwrap();
                prop_assert_eq!(state.and(phase.holding), phase.holding);
                let grasped = !matches!(phase.kind, PhaseKind::Regrasp | PhaseKind::NoGrasp);
                prop_assert_eq!(grasped, state.len() >= min_fingers);
                if phase.kind == PhaseKind::InGrasp {
                    prop_assert_eq!(state, phase.holding);
                }
            }
        }
        for (covered, state) in covered.iter().zip(&states) {
            prop_assert_eq!(*covered, u8::from(state.is_some()));
        }
        for gait in &gaits {
            prop_assert!(!gait.holding.contains(gait.finger) && gait.samples.len() <= 5);
        }

        // Later in the take it is the same, later.
        let nothing = std::iter::repeat_n(PerFinger::new([None; 5]), shift);
        let later = ContactSeries::new(nothing.chain(samples).collect(), 100.0).unwrap();
        let (later, later_gaits) = phases(&later, &|_, _| None, &rules).unwrap();
        let back = |range: &std::ops::Range<usize>| range.start - shift..range.end - shift;
        prop_assert_eq!(later.len(), found.len());
        for (later, found) in later.iter().zip(&found) {
            prop_assert_eq!((later.kind, back(&later.samples)), (found.kind, found.samples.clone()));
        }
        prop_assert_eq!(later_gaits.len(), gaits.len());
    }
}
