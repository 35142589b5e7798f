//! Boundary conditions from least-squares lines.

use inhand_model::{Finger, Motion, Pose, PoseTrack, Position, Protocol, SegmentLayout, Status};
use inhand_motion::{
    EndsRule, MotionError, SegmentSettings, Templates, cut_segments, cut_some, process,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::{PLAIN, resting_hand, rigid_body, roles};

const N: usize = 8;

fn motion(samples: usize) -> Motion {
    let take = resting_hand(samples, |_, _| true);
    let roles = roles(rigid_body("Hand"), None);
    process(&take, &roles, &Templates::default(), &PLAIN).unwrap()
}

/// Segments of 20 samples at 100 Hz, lines over 8 of them.
fn settings() -> SegmentSettings {
    SegmentSettings {
        layout: SegmentLayout {
            samples: 20,
            rate_hz: 100.0,
            object: false,
        },
        stride: 7,
        ends: EndsRule::Lines { ends_s: 0.08 },
        missing_s: 0.0,
    }
}

#[test]
fn ends_are_values_and_slopes_of_lines() {
    let take = motion(60);
    let segments = cut_segments(&[&take], &settings()).unwrap();
    assert_eq!(segments.protocol(), Protocol::HeldOut);
    let starts: Vec<usize> = segments.origins().iter().map(|o| o.start).collect();
    assert_eq!(starts, [8, 15, 22, 29]);
    // Of k² over the n samples up to k = a: the slope is that of the middle, and the line's value at a is
    // (n - 1)(n - 2) / 6 below the parabola.
    let n = N as f64;
    let below = (n - 1.0) * (n - 2.0) / 6.0;
    for (ends, &start) in segments.ends().iter().zip(&starts) {
        let (first, last) = (start as f64, start as f64 + 19.0);
        for finger in Finger::ALL {
            let i = 3 * finger.index();
            for (found, expected) in [
                (ends.first_m[i], 1e-3 * first),
                (ends.first_m[i + 1], 1e-3 * (first * first - below)),
                (ends.first_m[i + 2], 1e-3 * finger.index() as f64),
                (ends.last_m[i], 1e-3 * last),
                (ends.last_m[i + 1], 1e-3 * (last * last - below)),
                (ends.first_velocity_m_s[i], 0.1),
                (
                    ends.first_velocity_m_s[i + 1],
                    0.1 * (2.0 * first - (n - 1.0)),
                ),
                (ends.last_velocity_m_s[i], 0.1),
                (
                    ends.last_velocity_m_s[i + 1],
                    0.1 * (2.0 * last + (n - 1.0)),
                ),
                (ends.last_velocity_m_s[i + 2], 0.0),
            ] {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        }
    }
}

#[test]
fn a_line_has_whole_samples_and_three_at_least() {
    let samples = |ends_s, rate_hz| EndsRule::Lines { ends_s }.samples(rate_hz).unwrap();
    for (rate_hz, expected) in [(30.0, 3), (60.0, 5), (100.0, 8), (120.0, 10), (360.0, 29)] {
        assert_eq!(samples(0.08, rate_hz), expected);
    }
    for ends_s in [0.0, -0.08, f64::NAN, f64::INFINITY] {
        let refused = EndsRule::Lines { ends_s }.samples(100.0).unwrap_err();
        assert!(matches!(
            refused,
            MotionError::Setting {
                setting: "ends_s",
                ..
            }
        ));
    }
}

#[test]
fn nothing_between_the_ends_and_nothing_filled_counts() {
    let take = motion(60);
    let expected = cut_segments(&[&take], &settings()).unwrap();
    let bits = |segments: &inhand_model::Segments, segment: usize| {
        format!("{:?}", segments.ends()[segment])
    };
    let mut other = take.clone();
    // The first segment covers samples 8 to 27.
    for k in 9..27 {
        let at = Position::new(0.1, -0.2, 0.3 + k as f64);
        other.fingertips[Finger::Thumb].set(k, Some(at), Status::Measured);
    }
    let changed = cut_segments(&[&other], &settings()).unwrap();
    assert_eq!(bits(&changed, 0), bits(&expected, 0));
    assert_ne!(bits(&changed, 1), bits(&expected, 1));

    // Four measured samples of eight are enough, three are not; filled ones have no say.
    for (filled, kept) in [(4, true), (5, false)] {
        let mut other = take.clone();
        let tip = &mut other.fingertips[Finger::Ring];
        for k in 2..2 + filled {
            tip.set(k, Some(Position::new(9.0, 9.0, 9.0)), Status::Filled);
        }
        let segments = cut_segments(&[&other], &settings()).unwrap();
        assert_eq!(segments.origins()[0].start == 8, kept);
        assert_eq!(
            (segments.len(), segments.left_out),
            (3 + usize::from(kept), usize::from(!kept))
        );
        let velocity = segments.ends()[0].first_velocity_m_s[3 * Finger::Ring.index()];
        assert!((velocity - 0.1).abs() < 1e-12);
    }
}

#[test]
fn an_object_that_turns_evenly_is_where_it_was() {
    let pose = |k: usize| {
        let turned = Vector3::new(0.02, -0.01, 0.03) * (k as f64 - 30.0);
        let rotation = UnitQuaternion::from_scaled_axis(turned);
        Isometry3::from_parts(Translation3::new(0.001 * k as f64, 0.0, 0.05), rotation)
    };
    let mut take = motion(60);
    let mut object = PoseTrack::from_measured((0..60).map(|k| Some(Pose::new(pose(k)))));
    object.set(14, Some(Pose::new(Isometry3::identity())), Status::Filled);
    take.object = Some(object);
    let segments = cut_segments(&[&take], &settings()).unwrap();
    for (origin, ends) in segments.origins().iter().zip(segments.ends()) {
        let found = ends.object.unwrap();
        for (found, k) in [(found.first, origin.start), (found.last, origin.start + 19)] {
            let apart = found.isometry().inv_mul(&pose(k));
            assert!(apart.translation.vector.norm() < 1e-12);
            assert!(apart.rotation.angle() < 1e-7);
        }
    }
    // Without half of its samples the object is not given, and the fingers are.
    let object = take.object.as_mut().unwrap();
    for k in 1..6 {
        object.set(k, None, Status::Missing);
    }
    let segments = cut_segments(&[&take], &settings()).unwrap();
    assert_eq!(segments.len(), 4);
    assert!(segments.ends()[0].object.is_none() && segments.ends()[1].object.is_some());
}

#[test]
fn some_segments_are_those_of_all() {
    let take = motion(60);
    let all = cut_segments(&[&take, &take], &settings()).unwrap();
    let some = cut_some(&[&take, &take], &settings(), |count| vec![1, count - 1]).unwrap();
    let selected = all.select(&[1, 7]);
    assert_eq!(some.columns_m(), selected.columns_m());
    assert_eq!(some.origins(), selected.origins());
    assert_eq!(some.ends(), selected.ends());
}
