//! Contacts over time, phases and slip.

use inhand_contact::events::{Contact, ContactSeries};
use inhand_contact::phases::{PhaseKind, PhaseSettings, phases};
use inhand_contact::slip::slip;
use inhand_contact::{ContactError, FingerSet};
use inhand_model::{Finger, Object, PerFinger, Position, Shape};
use proptest::prelude::*;
use serde_json::{Value, json};

fn recorded() -> Vec<Value> {
    serde_json::from_str(include_str!("../reference/events.json")).expect("written by the script")
}

/// Contacts from one string a finger: `1` in contact, `0` not, `?` not known.
fn series(fingers: [&str; 5], rate_hz: f64) -> ContactSeries {
    let parse = |k: usize| {
        PerFinger::from_fn(|finger| match fingers[finger.index()].as_bytes()[k] {
            b'1' => Some(true),
            b'0' => Some(false),
            _ => None,
        })
    };
    ContactSeries::new((0..fingers[0].len()).map(parse).collect(), rate_hz).unwrap()
}

fn text(series: &ContactSeries, finger: Finger) -> String {
    let letter =
        |s: &PerFinger<Option<bool>>| s[finger].map_or('?', |on| if on { '1' } else { '0' });
    series.samples().iter().map(letter).collect()
}

fn of_reference(take: &Value) -> ContactSeries {
    let fingers: Vec<&str> = take["fingers"]
        .as_array()
        .unwrap()
        .iter()
        .map(|s| s.as_str().unwrap())
        .collect();
    series(
        fingers.try_into().unwrap(),
        take["rate_hz"].as_f64().unwrap(),
    )
}

fn pads(take: &Value) -> Vec<PerFinger<Option<Position<Object>>>> {
    let point = |p: &Value| {
        let p: Vec<f64> = p.as_array()?.iter().map(|x| x.as_f64().unwrap()).collect();
        Some(Position::new(p[0], p[1], p[2]))
    };
    (take["pads_m"].as_array().unwrap().iter())
        .map(|sample| PerFinger::from_fn(|finger| point(&sample[finger.index()])))
        .collect()
}

#[test]
fn contacts_and_states_agree_with_the_reference() {
    let takes = recorded();
    assert_eq!(takes.len(), 3);
    for take in &takes {
        let series = of_reference(take);
        let steady = series
            .debounced(take["min_duration_s"].as_f64().unwrap())
            .unwrap();
        for finger in Finger::ALL {
            let k = finger.index();
            let found = series.finger(finger);
            let listed: Vec<Value> = (found.contacts.iter())
                .map(|c| json!([c.samples.start, c.samples.end, c.made, c.broken]))
                .collect();
            assert_eq!(json!(listed), take["contacts"][k], "{finger}");
            assert_eq!(
                found.makes,
                found.contacts.iter().filter(|c| c.made).count()
            );
            assert_eq!(
                found.breaks,
                found.contacts.iter().filter(|c| c.broken).count()
            );
            assert_eq!(found.duty(), take["duty"][k].as_f64());
            assert_eq!(
                text(&steady, finger),
                take["debounced"][k].as_str().unwrap()
            );
        }
        let table = series.state_table();
        let samples: Vec<Value> = (table.samples.iter())
            .map(|(s, n)| json!([s.bits(), n]))
            .collect();
        assert_eq!(json!(samples), take["state_samples"]);
        let transitions: Vec<Value> = (table.transitions.iter())
            .map(|((from, to), n)| json!([from.bits(), to.bits(), n]))
            .collect();
        assert_eq!(json!(transitions), take["transitions"]);
        assert_eq!(json!(table.by_fingers), take["by_fingers"]);
    }
}

#[test]
fn phases_agree_with_the_reference() {
    for take in &recorded() {
        let settings = PhaseSettings {
            min_fingers: take["min_fingers"].as_u64().unwrap() as usize,
            min_duration_s: take["min_duration_s"].as_f64().unwrap(),
            max_lift_s: take["max_lift_s"].as_f64().unwrap(),
        };
        let found = phases(&of_reference(take), Some(&pads(take)), &settings).unwrap();
        let listed: Vec<Value> = (found.phases.iter())
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
        assert_eq!(found.gaits.len(), expected.len());
        for (gait, expected) in found.gaits.iter().zip(expected) {
            let (start, end) = (gait.samples.start, gait.samples.end);
            let whole = json!([start, gait.finger.index(), end, gait.holding.bits()]);
            assert_eq!(
                whole.as_array().unwrap()[..],
                expected.as_array().unwrap()[..4]
            );
            match (gait.displacement_m, expected[4].as_f64()) {
                (Some(found), Some(expected)) => assert!((found - expected).abs() < 1e-12),
                (found, expected) => assert_eq!(found, expected),
            }
        }
    }
}

#[test]
fn slip_agrees_with_the_reference() {
    for take in &recorded() {
        let edges: Vec<f64> = serde_json::from_value(take["edges_m"].clone()).unwrap();
        let shape = Shape::Cuboid {
            edges_m: edges.try_into().unwrap(),
        };
        let (series, pads) = (of_reference(take), pads(take));
        for finger in Finger::ALL {
            let pad: Vec<_> = pads.iter().map(|pads| pads[finger]).collect();
            let contacts = series.finger(finger).contacts;
            let expected = take["slip"][finger.index()].as_array().unwrap();
            assert_eq!(contacts.len(), expected.len());
            for (contact, expected) in contacts.iter().zip(expected) {
                let found = slip(&shape, &pad, contact, series.rate_hz());
                let Some(expected) = expected.as_array() else {
                    assert_eq!(found, None);
                    continue;
                };
                let s = found.unwrap();
                let found = [
                    s.displacement_m,
                    s.excursion_m,
                    s.path_m,
                    s.peak_speed_m_s,
                    s.mean_speed_m_s,
                    s.steps as f64,
                    s.missing as f64,
                ];
                for (found, expected) in found.iter().zip(expected) {
                    assert!((found - expected.as_f64().unwrap()).abs() < 1e-12, "{s:?}");
                }
            }
        }
    }
}

#[test]
fn missing_samples_end_contacts_but_break_none() {
    let found = series(["11?1001?0110"; 5], 10.0).finger(Finger::Ring);
    let contact = |samples, made, broken| Contact {
        samples,
        made,
        broken,
    };
    assert_eq!(
        found.contacts,
        [
            contact(0..2, false, false),
            contact(3..4, false, true),
            contact(6..7, true, false),
            contact(9..11, true, true),
        ]
    );
    assert_eq!(
        (found.makes, found.breaks, found.known, found.touching),
        (2, 2, 10, 6)
    );
    let nothing = series(["???"; 5], 10.0);
    assert_eq!(nothing.finger(Finger::Thumb).duty(), None);
    assert_eq!(nothing.state_table(), Default::default());
    let empty = ContactSeries::new(Vec::new(), 10.0).unwrap();
    assert!(empty.finger(Finger::Thumb).contacts.is_empty() && empty.states().is_empty());
}

/// A switch is debounced: what does not stay is not there, from the left.
#[test]
fn chatter_is_no_contact() {
    for (before, least_s, after) in [
        ("0001000", 0.02, "0000000"),
        ("0001000", 0.01, "0001000"),
        ("0001010111", 0.02, "0000000111"),
        ("1101101111", 0.02, "1111111111"),
        ("1000", 0.02, "1000"),
        ("0001", 0.02, "0001"),
        ("001?100", 0.03, "001?100"),
        // 0.03 s at 100 Hz are three samples, which is 2.9999... or 3.0000...1 by rounding.
        ("0011100", 0.03, "0011100"),
    ] {
        let steady = series([before; 5], 100.0).debounced(least_s).unwrap();
        assert_eq!(text(&steady, Finger::Middle), after, "{before}");
    }
}

#[test]
fn kinds_of_phases() {
    let settings = PhaseSettings {
        min_fingers: 3,
        min_duration_s: 0.0,
        max_lift_s: 0.03,
    };
    let of = |fingers| {
        let found = phases(&series(fingers, 100.0), None, &settings).unwrap();
        let phases: Vec<String> = (found.phases.iter())
            .map(|p| format!("{} {:?}", p.kind.name(), p.samples))
            .collect();
        let gaits: Vec<String> = (found.gaits.iter())
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

/// Around the side of a cylinder by a quarter: the chord and, in small steps, the arc; how deep the pad is
/// pressed in changes nothing.
#[test]
fn slip_around_a_cylinder_is_its_arc() {
    let cylinder: Shape = "cylinder:0.05x0.08".parse().unwrap();
    let pad: Vec<_> = (0..=90)
        .map(|k| {
            let (angle, depth_m) = (f64::from(k).to_radians(), 0.001 * f64::from(k % 5));
            let radius_m = 0.026 - depth_m;
            Some(Position::new(
                radius_m * angle.cos(),
                radius_m * angle.sin(),
                -0.01,
            ))
        })
        .collect();
    let contact = Contact {
        samples: 0..91,
        made: true,
        broken: true,
    };
    let found = slip(&cylinder, &pad, &contact, 90.0).unwrap();
    assert!((found.displacement_m - 0.025 * 2.0_f64.sqrt()).abs() < 1e-12);
    assert_eq!(found.excursion_m, found.displacement_m);
    let arc_m = 90.0 * 2.0 * 0.025 * 0.5_f64.to_radians().sin();
    assert!((found.path_m - arc_m).abs() < 1e-12);
    assert!((found.mean_speed_m_s - arc_m).abs() < 1e-12);
    assert!((found.peak_speed_m_s - arc_m).abs() < 1e-9);
}

#[test]
fn what_makes_no_sense_is_refused() {
    for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = ContactSeries::new(Vec::new(), rate_hz).unwrap_err();
        assert!(matches!(error, ContactError::Rate { .. }));
    }
    let some = series(["0110"; 5], 100.0);
    let good = PhaseSettings {
        min_fingers: 3,
        min_duration_s: 0.0,
        max_lift_s: 1.0,
    };
    for bad in [-0.1, f64::NAN, f64::INFINITY] {
        assert!(some.debounced(bad).is_err());
        assert!(
            phases(
                &some,
                None,
                &PhaseSettings {
                    min_duration_s: bad,
                    ..good
                }
            )
            .is_err()
        );
        assert!(
            phases(
                &some,
                None,
                &PhaseSettings {
                    max_lift_s: bad,
                    ..good
                }
            )
            .is_err()
        );
    }
    for min_fingers in [0, 6] {
        let error = phases(
            &some,
            None,
            &PhaseSettings {
                min_fingers,
                ..good
            },
        )
        .unwrap_err();
        assert_eq!(error, ContactError::MinFingers { found: min_fingers });
    }
    let cube: Shape = "cube:0.05".parse().unwrap();
    let pad = [Some(Position::new(0.0, 0.0, 0.03)); 3];
    let contact = |samples| Contact {
        samples,
        made: true,
        broken: true,
    };
    assert_eq!(slip(&cube, &pad, &contact(1..4), 100.0), None);
    assert_eq!(slip(&cube, &pad, &contact(1..2), 100.0), None);
    assert_eq!(slip(&cube, &pad, &contact(0..3), 0.0), None);
    let gaps = [
        pad[0],
        None,
        pad[0],
        Some(Position::new(f64::NAN, 0.0, 0.0)),
    ];
    assert_eq!(slip(&cube, &gaps, &contact(0..4), 100.0), None);
}

#[test]
fn sets_of_fingers() {
    let set = FingerSet::NONE
        .with(Finger::Thumb)
        .with(Finger::Ring)
        .with(Finger::Ring);
    assert_eq!(
        (set.len(), set.bits(), set.to_string().as_str()),
        (2, 0b1001, "thumb+ring")
    );
    assert_eq!(FingerSet::NONE.to_string(), "none");
    assert!(set.contains(Finger::Ring) && !set.contains(Finger::Index));
    assert_eq!(
        set.iter().collect::<Vec<_>>(),
        [Finger::Thumb, Finger::Ring]
    );
    assert_eq!(set.and(FingerSet::NONE.with(Finger::Ring)).bits(), 0b1000);
}

prop_compose! {
    fn any_series()(
        runs in prop::collection::vec((prop::array::uniform5(prop::option::weighted(0.9, prop::bool::weighted(0.75))), 1..6_usize), 0..30)
    ) -> Vec<PerFinger<Option<bool>>> {
        (runs.into_iter())
            .flat_map(|(fingers, n)| std::iter::repeat_n(PerFinger::new(fingers), n))
            .collect()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn sums_hold(samples in any_series(), least in 0..5_u32) {
        let series = ContactSeries::new(samples.clone(), 100.0).unwrap();
        for finger in Finger::ALL {
            let found = series.finger(finger);
            let touching: usize = found.contacts.iter().map(|c| c.samples.len()).sum();
            prop_assert_eq!(touching, found.touching);
            prop_assert!(found.touching <= found.known);
            let durations = series.durations_s(&found);
            let seconds: f64 = durations.complete.iter().chain(&durations.censored).sum();
            prop_assert!((seconds * 100.0 - touching as f64).abs() < 1e-9);
        }
        let table = series.state_table();
        let known = series.states().iter().flatten().count();
        prop_assert_eq!(table.by_fingers.iter().sum::<usize>(), known);
        prop_assert_eq!(table.samples.values().sum::<usize>(), known);
        prop_assert!(table.transitions.keys().all(|(from, to)| from != to));

        // Debouncing once is enough, and what is known stays known.
        let least_s = f64::from(least) / 100.0;
        let once = series.debounced(least_s).unwrap();
        prop_assert_eq!(&once.debounced(least_s).unwrap(), &once);
        for (a, b) in samples.iter().zip(once.samples()) {
            prop_assert!(Finger::ALL.iter().all(|&f| a[f].is_some() == b[f].is_some()));
        }
        prop_assert_eq!(series.debounced(0.0).unwrap(), series);
    }

    #[test]
    fn phases_tile_what_is_known(samples in any_series(), min_fingers in 1..6_usize, shift in 0..7_usize) {
        let settings = PhaseSettings { min_fingers, min_duration_s: 0.02, max_lift_s: 0.05 };
        let series = ContactSeries::new(samples.clone(), 100.0).unwrap();
        let found = phases(&series, None, &settings).unwrap();
        let states = series.debounced(0.02).unwrap().states();
        let mut covered = vec![0; states.len()];
        for phase in &found.phases {
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
        for gait in &found.gaits {
            prop_assert!(!gait.holding.contains(gait.finger) && gait.samples.len() <= 5);
        }

        // Later in the take it is the same, later.
        let nothing = std::iter::repeat_n(PerFinger::new([None; 5]), shift);
        let later = ContactSeries::new(nothing.chain(samples).collect(), 100.0).unwrap();
        let later = phases(&later, None, &settings).unwrap();
        let back = |range: &std::ops::Range<usize>| range.start - shift..range.end - shift;
        prop_assert_eq!(later.phases.len(), found.phases.len());
        for (later, found) in later.phases.iter().zip(&found.phases) {
            prop_assert_eq!((later.kind, back(&later.samples)), (found.kind, found.samples.clone()));
        }
        prop_assert_eq!(later.gaits.len(), found.gaits.len());
    }
}
