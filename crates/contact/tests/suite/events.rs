//! Makes, breaks and states of contact; `../reference/make_events.py` made the numbers.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::collections::BTreeMap;

use inhand_contact::{Contact, ContactError, ContactSeries};
use inhand_model::{Finger, FingerSet, Object, PerFinger, Position};
use proptest::prelude::*;
use serde_json::{Value, json};

pub(crate) fn recorded() -> Vec<Value> {
    serde_json::from_str(include_str!("../reference/events.json")).expect("written by the script")
}

/// Contacts from one string a finger: `1` in contact, `0` not, `?` not known.
pub(crate) fn series(fingers: [&str; 5], rate_hz: f64) -> ContactSeries {
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

pub(crate) fn of_reference(take: &Value) -> ContactSeries {
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

pub(crate) fn pads(take: &Value) -> Vec<PerFinger<Option<Position<Object>>>> {
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
            let listed: Vec<Value> = (series.contacts(finger).iter())
                .map(|c| json!([c.samples.start, c.samples.end, c.made, c.broken]))
                .collect();
            assert_eq!(json!(listed), take["contacts"][k], "{finger}");
            assert_eq!(
                text(&steady, finger),
                take["debounced"][k].as_str().unwrap()
            );
        }
        let runs = series.state_runs();
        let (mut samples, mut transitions) = (BTreeMap::new(), BTreeMap::new());
        for run in &runs {
            *samples.entry(run.fingers.bits()).or_insert(0) += run.samples.len();
        }
        for pair in runs.windows(2) {
            if pair[0].samples.end == pair[1].samples.start {
                let change = (pair[0].fingers.bits(), pair[1].fingers.bits());
                *transitions.entry(change).or_insert(0) += 1;
            }
        }
        let samples: Vec<Value> = samples.iter().map(|(s, n)| json!([s, n])).collect();
        assert_eq!(json!(samples), take["state_samples"]);
        let transitions: Vec<Value> = (transitions.iter())
            .map(|((from, to), n)| json!([from, to, n]))
            .collect();
        assert_eq!(json!(transitions), take["transitions"]);
    }
}

#[test]
fn missing_samples_end_contacts_but_break_none() {
    let found = series(["11?1001?0110"; 5], 10.0).contacts(Finger::Ring);
    let contact = |samples, made, broken| Contact {
        samples,
        made,
        broken,
    };
    assert_eq!(
        found,
        [
            contact(0..2, false, false),
            contact(3..4, false, true),
            contact(6..7, true, false),
            contact(9..11, true, true),
        ]
    );
    let nothing = series(["???"; 5], 10.0);
    assert!(nothing.contacts(Finger::Thumb).is_empty() && nothing.state_runs().is_empty());
    let empty = ContactSeries::new(Vec::new(), 10.0).unwrap();
    assert!(empty.contacts(Finger::Thumb).is_empty() && empty.states().is_empty());
}

/// The duration of a state is known where both its ends were seen.
#[test]
fn states_at_ends_and_gaps_are_not_complete() {
    let runs = series(["0011?0101"; 5], 100.0).state_runs();
    let found: Vec<_> = (runs.iter())
        .map(|run| (run.samples.clone(), run.fingers.len(), run.complete))
        .collect();
    assert_eq!(
        found,
        [
            (0..2, 0, false),
            (2..4, 5, false),
            (5..6, 0, false),
            (6..7, 5, true),
            (7..8, 0, true),
            (8..9, 5, false),
        ]
    );
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
    pub(crate) fn any_series()(
        runs in prop::collection::vec((prop::array::uniform5(prop::option::weighted(0.9, prop::bool::weighted(0.75))), 1..6_usize), 0..30)
    ) -> Vec<PerFinger<Option<bool>>> {
        (runs.into_iter())
            .flat_map(|(fingers, n)| std::iter::repeat_n(PerFinger::new(fingers), n))
            .collect()
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = ContactSeries::new(Vec::new(), rate_hz).unwrap_err();
        assert!(matches!(error, ContactError::Rate { .. }));
    }
    for bad in [-0.1, f64::NAN, f64::INFINITY] {
        let error = series(["0110"; 5], 100.0).debounced(bad).unwrap_err();
        assert!(matches!(error, ContactError::Duration { .. }));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn sums_hold(samples in any_series(), least in 0..5_u32) {
        let series = ContactSeries::new(samples.clone(), 100.0).unwrap();
        for finger in Finger::ALL {
            let touching: usize = series.contacts(finger).iter().map(|c| c.samples.len()).sum();
            prop_assert_eq!(touching, samples.iter().filter(|s| s[finger] == Some(true)).count());
        }
        let runs = series.state_runs();
        let known = series.states().iter().flatten().count();
        prop_assert_eq!(runs.iter().map(|run| run.samples.len()).sum::<usize>(), known);
        let mut pairs = runs.windows(2);
        prop_assert!(pairs.all(|p| p[0].samples.end < p[1].samples.start || p[0].fingers != p[1].fingers));

        // Debouncing once is enough, and what is known stays known.
        let least_s = f64::from(least) / 100.0;
        let once = series.debounced(least_s).unwrap();
        prop_assert_eq!(&once.debounced(least_s).unwrap(), &once);
        for (a, b) in samples.iter().zip(once.samples()) {
            prop_assert!(Finger::ALL.iter().all(|&f| a[f].is_some() == b[f].is_some()));
        }
        prop_assert_eq!(series.debounced(0.0).unwrap(), series);
    }
}
