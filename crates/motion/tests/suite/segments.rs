//! Segments, their ends, and what is left out.

use inhand_model::{Finger, Motion, SegmentLayout};
use inhand_motion::{
    Cut, EndsRule, MotionError, SegmentSettings, SegmentTable, Templates, cut_segments, process,
};
use proptest::prelude::*;

use crate::{PLAIN, resting_hand, rigid_body, roles, tip_m};

fn motion(samples: usize, seen: impl Fn(usize) -> bool) -> Motion {
    let take = resting_hand(samples, |finger, k| finger != Finger::Ring || seen(k));
    let roles = roles(rigid_body("Hand"), None);
    process(&take, &roles, &Templates::default(), &PLAIN).unwrap()
}

fn settings(samples: usize, stride: usize, margin_s: f64) -> SegmentSettings {
    let layout = SegmentLayout {
        samples,
        rate_hz: 100.0,
        object: false,
    };
    SegmentSettings {
        layout,
        stride,
        ends: EndsRule::Differences { margin_s },
        missing_s: 0.0,
    }
}

#[test]
fn a_paper_take_gives_119_segments() {
    let take = motion(12_000, |_| true);
    let test = cut_segments(&[&take], &settings(100, 100, 0.04)).unwrap();
    assert_eq!((test.len(), test.left_out), (119, 0));
    assert_eq!(test.origins()[0].start, 4);
    assert_eq!(test.origins()[118].start, 11_804);
    let train = cut_segments(&[&take; 5], &settings(100, 100, 0.04)).unwrap();
    assert_eq!((train.len(), train.left_out), (595, 0));
    assert_eq!(
        (train.origins()[119].take, train.origins()[119].start),
        (1, 4)
    );
}

#[test]
fn columns_are_the_samples_and_velocities_are_outside() {
    let take = motion(60, |_| true);
    let segments = cut_segments(&[&take], &settings(20, 7, 0.03)).unwrap();
    let starts: Vec<usize> = segments
        .origins()
        .iter()
        .map(|origin| origin.start)
        .collect();
    assert_eq!(starts, [3, 10, 17, 24, 31]);
    for (segment, &start) in starts.iter().enumerate() {
        for t in 0..20 {
            for finger in Finger::ALL {
                let position = segments.position(segment, t, finger).to_array();
                assert_eq!(position, tip_m(finger, (start + t) as f64));
            }
        }
        let ends = &segments.ends()[segment];
        let (first, last) = (start as f64, start as f64 + 19.0);
        let at = |k: f64| Finger::ALL.map(|finger| tip_m(finger, k)).concat();
        assert_eq!(ends.first_m.to_vec(), at(first));
        assert_eq!(ends.last_m.to_vec(), at(last));
        // Means of the parabola's slope over the three samples outside, 0.1 k m/s a sample.
        for finger in Finger::ALL {
            let i = 3 * finger.index();
            assert!((ends.first_velocity_m_s[i] - 0.1).abs() < 1e-12);
            assert!((ends.first_velocity_m_s[i + 1] - 0.1 * (2.0 * first - 3.0)).abs() < 1e-10);
            assert!((ends.last_velocity_m_s[i + 1] - 0.1 * (2.0 * last + 3.0)).abs() < 1e-10);
            assert_eq!(ends.last_velocity_m_s[i + 2], 0.0);
        }
    }
}

#[test]
fn what_gaps_cost_is_counted() {
    // 20 samples with margins of 2 need 24: 100 samples give (100 - 24) / 20 + 1 = 4.
    let cut = |seen: fn(usize) -> bool| {
        let segments = cut_segments(&[&motion(100, seen)], &settings(20, 20, 0.02)).unwrap();
        let starts = segments.origins().iter().map(|origin| origin.start);
        (starts.collect::<Vec<_>>(), segments.left_out)
    };
    assert_eq!(cut(|_| true), (vec![2, 22, 42, 62], 0));
    // The grid starts anew behind a gap.
    assert_eq!(cut(|k| k != 36), (vec![2, 39, 59], 1));
    assert_eq!(cut(|k| k % 23 != 22), (vec![], 4));
    assert_eq!(cut(|_| false), (vec![], 4));
    // A stretch one sample too short, and one just long enough.
    assert_eq!(cut(|k| k < 23), (vec![], 4));
    assert_eq!(cut(|k| k < 24), (vec![2], 3));
}

#[test]
fn what_is_missing_most_is_why_a_segment_is_left_out() {
    let cut = |missing_s: f64, seen: fn(usize) -> bool| {
        let settings = SegmentSettings {
            missing_s,
            ..settings(20, 20, 0.02)
        };
        let table = SegmentTable::from_motion(&motion(100, seen));
        let left_out_by = Cut::new(&settings).unwrap().left_out_by(&table);
        left_out_by.into_iter().collect::<Vec<_>>()
    };
    let ring = |n| vec![("ring".to_owned(), n)];
    assert_eq!(cut(0.0, |_| true), []);
    // In the margin of one segment and in the next one.
    assert_eq!(cut(0.0, |k| k != 22), ring(2));
    assert_eq!(cut(0.0, |_| false), ring(4));
    // Without a hand there is no fingertip either.
    let lost = resting_hand(100, |_, k| k != 22);
    let roles = roles(rigid_body("Hand"), None);
    let lost = process(&lost, &roles, &Templates::default(), &PLAIN).unwrap();
    let left_out = Cut::new(&settings(20, 20, 0.02))
        .unwrap()
        .left_out_by(&SegmentTable::from_motion(&lost));
    assert_eq!(
        left_out.into_iter().collect::<Vec<_>>(),
        [("hand".to_owned(), 2)]
    );
    // A gap that may be missing, and one that may not.
    assert_eq!(cut(0.03, |k| !(30..33).contains(&k)), []);
    assert_eq!(cut(0.02, |k| !(30..33).contains(&k)), ring(1));
}

#[test]
fn what_is_missing_between_the_ends_may_stay_missing() {
    let cut = |missing_s: f64, seen: fn(usize) -> bool| {
        let settings = SegmentSettings {
            missing_s,
            ..settings(20, 20, 0.02)
        };
        let segments = cut_segments(&[&motion(100, seen)], &settings).unwrap();
        let starts = segments.origins().iter().map(|origin| origin.start);
        let missing = (0..segments.len()).map(|i| {
            let column = segments.column_m(i);
            column.iter().filter(|v| v.is_nan()).count()
        });
        (starts.zip(missing).collect::<Vec<_>>(), segments.left_out)
    };
    // Three samples of the ring finger, one coordinate in three of five fingers each.
    let gap = |k: usize| !(30..33).contains(&k);
    assert_eq!(cut(0.03, gap), (vec![(2, 0), (22, 9), (42, 0), (62, 0)], 0));
    // One sample more than may be missing: as if there were no allowance.
    assert_eq!(cut(0.02, gap), (vec![(2, 0), (35, 0), (55, 0), (75, 0)], 0));
    assert_eq!(cut(0.0, gap), cut(0.02, gap));
    // Two gaps that are bridged, but too much for one segment together.
    let gaps = |k: usize| k != 25 && !(30..33).contains(&k);
    assert_eq!(cut(0.03, gaps), (vec![(2, 0), (42, 0), (62, 0)], 1));
    // The ends, and what velocities are taken from, have to be there.
    assert_eq!(cut(0.03, |k| k != 41), (vec![(2, 0), (42, 0), (62, 0)], 1));
    assert_eq!(cut(0.03, |k| k != 20), (vec![(2, 3), (42, 0), (62, 0)], 1));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn segments_hold_no_missing_sample(
        seen in prop::collection::vec(prop::bool::weighted(0.97), 1..400),
        samples in 2_usize..40, stride in 1_usize..60, margin in 1_usize..6,
    ) {
        let take = motion(seen.len(), |k| seen[k]);
        let settings = settings(samples, stride, margin as f64 / 100.0);
        let segments = cut_segments(&[&take], &settings).unwrap();
        prop_assert!(segments.columns_m().iter().all(|v| v.is_finite()));
        for (origin, ends) in segments.origins().iter().zip(segments.ends()) {
            prop_assert!((origin.start - margin..origin.start + samples + margin).all(|k| seen[k]));
            prop_assert!(ends.first_velocity_m_s.iter().chain(&ends.last_velocity_m_s).all(|v| v.is_finite()));
        }
        let needed = samples + 2 * margin;
        let whole = if seen.len() < needed { 0 } else { (seen.len() - needed) / stride + 1 };
        prop_assert!(segments.len() + segments.left_out >= whole);
        if stride <= needed {
            prop_assert_eq!(segments.len() + segments.left_out, whole);
        }
    }
}

#[test]
fn nothing_to_cut_gives_nothing() {
    let segments = cut_segments(&[], &settings(100, 100, 0.04)).unwrap();
    assert!(segments.is_empty());
    let short = motion(50, |_| true);
    assert!(
        cut_segments(&[&short], &settings(100, 100, 0.04))
            .unwrap()
            .is_empty()
    );
}

#[test]
fn takes_of_different_rates_are_refused_by_name() {
    let here = motion(20, |_| true);
    let mut there = here.clone();
    there.name = "other".into();
    there.clock = inhand_model::Clock::new(0, inhand_model::StartTime::Unknown, 120.0).unwrap();
    let cut = |motions: &[&Motion]| cut_segments(motions, &settings(10, 1, 0.04)).unwrap_err();
    assert_eq!(
        cut(&[&here, &there]).to_string(),
        "take \"other\" is sampled at 120 Hz, take \"take\" at 100 Hz: takes of one session need one rate"
    );
    assert_eq!(
        cut(&[&there]).to_string(),
        "take \"other\" is sampled at 120 Hz, but segments are laid out for 100 Hz"
    );
}

#[test]
fn settings_out_of_range_are_refused() {
    let take = motion(20, |_| true);
    for (settings, expected) in [
        (settings(0, 1, 0.04), "layout.samples"),
        (settings(1, 1, 0.04), "layout.samples"),
        (settings(10, 0, 0.04), "stride"),
        (settings(10, 1, 0.004), "margin_s"),
        (settings(10, 1, -0.04), "margin_s"),
        (settings(10, 1, f64::NAN), "margin_s"),
        (settings(10, 1, f64::INFINITY), "margin_s"),
    ] {
        match cut_segments(&[&take], &settings) {
            Err(MotionError::Setting { setting, .. }) => assert_eq!(setting, expected),
            other => panic!("{expected}: {other:?}"),
        }
    }
    // Far beyond any take: no segment, no overflow.
    for settings in [settings(10, usize::MAX, 0.04), settings(10, 1, 1e300)] {
        assert!(cut_segments(&[&take], &settings).unwrap().len() <= 1);
    }
}

#[test]
fn segments_lie_inside_what_is_selected() {
    let mut take = motion(400, |k| k != 150);
    let starts = |take: &Motion| {
        let segments = cut_segments(&[take], &settings(20, 10, 0.03)).unwrap();
        let starts: Vec<usize> = segments.origins().iter().map(|o| o.start).collect();
        (starts, segments.left_out)
    };
    // Margins may reach out of a stretch, at the take's own ends they need room inside.
    take.selected = Some(vec![0..45, 100..141]);
    assert_eq!(starts(&take), (vec![3, 13, 23, 100, 110, 120], 0));
    // A gap inside a stretch costs what would lie over it: the grid begins anew behind it.
    take.selected = Some(std::iter::once(130..191).collect());
    assert_eq!(starts(&take), (vec![154, 164], 3));
    take.selected = Some(vec![50..69, 300..320]);
    assert_eq!(starts(&take), (vec![300], 0));
    take.selected = Some(Vec::new());
    assert_eq!(starts(&take), (Vec::new(), 0));
}

proptest! {
    #[test]
    fn everything_selected_is_as_nothing_said(
        len in 30_usize..200,
        hole in 0_usize..200,
        stride in 1_usize..30,
    ) {
        let mut take = motion(len, |k| k != hole);
        let of = |take: &Motion| {
            let segments = cut_segments(&[take], &settings(20, stride, 0.03)).unwrap();
            (segments.origins().to_vec(), segments.left_out)
        };
        let all = of(&take);
        take.selected = Some(std::iter::once(0..len).collect());
        prop_assert_eq!(of(&take), all);
    }
}
