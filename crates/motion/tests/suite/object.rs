//! Segments that carry the object.

use std::f64::consts::{PI, TAU};

use inhand_model::{
    Motion, OBJECT_COORDINATES, Pose, PoseTrack, ROTATION_LEVER_M, SegmentLayout, Segments,
};
use inhand_motion::{EndsRule, SegmentSettings, Templates, cut_segments, process};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use serde_json::Value;

use crate::{PLAIN, resting_hand, rigid_body, roles};

/// A take whose fingertips are seen throughout and whose object is where it is said to be.
fn motion(object: Vec<Option<Isometry3<f64>>>) -> Motion {
    let take = resting_hand(object.len(), |_, _| true);
    let roles = roles(rigid_body("Hand"), None);
    let mut motion = process(&take, &roles, &Templates::default(), &PLAIN).unwrap();
    motion.object = Some(PoseTrack::from_measured(
        object.into_iter().map(|pose| pose.map(Pose::new)),
    ));
    motion
}

/// Segments with a margin of one sample.
fn cut(motion: &Motion, samples: usize, stride: usize, object: bool) -> Segments {
    let layout = SegmentLayout {
        samples,
        rate_hz: 100.0,
        object,
    };
    let settings = SegmentSettings {
        layout,
        stride,
        ends: EndsRule::Differences { margin_s: 0.01 },
        missing_s: 0.0,
    };
    cut_segments(&[motion], &settings).unwrap()
}

/// The object's coordinates in a segment, position and rotation vector (radians).
fn rows(segments: &Segments, segment: usize) -> Vec<(Vector3<f64>, Vector3<f64>)> {
    let object = &segments.column_m(segment)[segments.layout().finger_rows()..];
    (object.as_chunks::<OBJECT_COORDINATES>().0.iter())
        .map(|&[x, y, z, a, b, c]| {
            (
                Vector3::new(x, y, z),
                Vector3::new(a, b, c) / ROTATION_LEVER_M,
            )
        })
        .collect()
}

/// Turned about an axis from an odd start, `angle` radians a sample, and moving.
fn turning(samples: usize, axis: Vector3<f64>, angle: f64) -> Vec<Option<Isometry3<f64>>> {
    let start = UnitQuaternion::from_scaled_axis(Vector3::new(0.9, -1.4, 0.3));
    (0..samples)
        .map(|k| {
            let turn = UnitQuaternion::from_scaled_axis(axis.normalize() * angle * k as f64);
            let place = Translation3::new(0.1, 1e-3 * k as f64, -0.02);
            Some(Isometry3::from_parts(place, turn * start))
        })
        .collect()
}

#[test]
fn a_steady_turn_is_a_straight_line() {
    let axis = Vector3::new(0.2, -0.5, 0.7);
    // From a fraction of a turn in a segment of 21 samples to twice around; the last goes through
    // whole turns exactly, where the rotation itself has no axis.
    for turns in [0.1, 0.49, 0.5, 0.51, 0.93, -0.7, 1.7, 2.0] {
        let step = turns * TAU / 20.0;
        let motion = motion(turning(45, axis, step));
        let segments = cut(&motion, 21, 7, true);
        assert_eq!((segments.len(), segments.left_out), (4, 0));
        for segment in 0..segments.len() {
            let start = segments.origins()[segment].start;
            for (t, (place, turned)) in rows(&segments, segment).into_iter().enumerate() {
                let expected = axis.normalize() * step * t as f64;
                assert!((turned - expected).norm() < 1e-12, "{turns} turns at {t}");
                let y_m = 1e-3 * (start + t) as f64;
                assert_eq!(place, Vector3::new(0.1, y_m, -0.02));
            }
        }
    }
}

#[test]
fn a_resting_object_does_not_turn() {
    let pose = Isometry3::new(Vector3::new(0.1, 0.0, 0.2), Vector3::new(1.0, 2.0, -2.0));
    let segments = cut(&motion(vec![Some(pose); 30]), 20, 1, true);
    for (_, turned) in rows(&segments, 0) {
        assert!(turned.norm() < 1e-15);
    }
}

#[test]
fn fingertips_stay_as_they_are_and_the_object_follows() {
    let motion = motion(turning(40, Vector3::z(), 0.05));
    let (with, without) = (cut(&motion, 20, 3, true), cut(&motion, 20, 3, false));
    assert_eq!(with.columns_m().nrows(), 21 * 20);
    assert_eq!(without.columns_m().nrows(), 15 * 20);
    assert_eq!(with.origins(), without.origins());
    // What is known of the object at the ends does not hang on whether it is in the columns.
    assert_eq!(with.ends(), without.ends());
    let track = motion.object.as_ref().unwrap();
    for (segment, origin) in with.origins().iter().enumerate() {
        assert_eq!(with.fingertips_m(segment), without.fingertips_m(segment));
        let ends = with.ends()[segment].object.unwrap();
        assert_eq!(Some(ends.first), track.get(origin.start));
        assert_eq!(Some(ends.last), track.get(origin.start + 19));
        // Within half a turn the column ends where the end conditions say.
        let object = &with.column_m(segment)[with.layout().finger_rows()..];
        for (row, expected) in [0, 19].into_iter().zip(ends.coordinates_m()) {
            for (found, expected) in object[6 * row..][..6].iter().zip(expected) {
                assert!((found - expected).abs() < 1e-15);
            }
        }
    }
}

#[test]
fn segments_without_the_object_are_left_out_and_counted() {
    let with_gaps = |gaps: &[usize]| {
        let mut object = turning(102, Vector3::x(), 0.01);
        for &k in gaps {
            object[k] = None;
        }
        motion(object)
    };
    let starts = |gaps: &[usize], object: bool| {
        let segments = cut(&with_gaps(gaps), 20, 20, object);
        let starts = segments.origins().iter().map(|origin| origin.start);
        let known = segments.ends().iter().map(|ends| ends.object.is_some());
        (
            starts.collect::<Vec<_>>(),
            segments.left_out,
            known.collect::<Vec<_>>(),
        )
    };
    assert_eq!(
        starts(&[], true),
        (vec![1, 21, 41, 61, 81], 0, vec![true; 5])
    );
    // The others stay where they were, as the fingertips were seen all the time.
    assert_eq!(starts(&[50], true), (vec![1, 21, 61, 81], 1, vec![true; 4]));
    assert_eq!(starts(&[40, 60], true), (vec![1, 61, 81], 2, vec![true; 3]));
    assert_eq!(
        starts(&[50, 60], false),
        (
            vec![1, 21, 41, 61, 81],
            0,
            vec![true, true, false, true, true]
        )
    );
    // The margins do not need it.
    assert_eq!(starts(&[0, 101], true).0.len(), 5);

    let mut never = with_gaps(&[]);
    never.object = None;
    let segments = cut(&never, 20, 20, true);
    assert_eq!((segments.len(), segments.left_out), (0, 5));
    assert!(
        cut(&never, 20, 20, false)
            .ends()
            .iter()
            .all(|ends| ends.object.is_none())
    );
    // A track shorter than the take is missing where it ends.
    never.object = with_gaps(&[]).object.map(|track| track.slice(0..45));
    assert_eq!(cut(&never, 20, 20, true).left_out, 3);
}

#[test]
fn agrees_with_scipy() {
    let reference: Value = serde_json::from_str(include_str!("../reference/object.json")).unwrap();
    let table =
        |key: &str| -> Vec<Vec<f64>> { serde_json::from_value(reference[key].clone()).unwrap() };
    let poses: Vec<_> = (table("position_m")
        .into_iter()
        .zip(table("quaternion_xyzw")))
    .map(|(p, q)| {
        Some(Isometry3::from_parts(
            Translation3::new(p[0], p[1], p[2]),
            UnitQuaternion::new_normalize(Quaternion::new(q[3], q[0], q[1], q[2])),
        ))
    })
    .collect();
    // One sample before and behind for the margins.
    let count = poses.len();
    let mut object = vec![poses[0]];
    object.extend(&poses);
    object.push(poses[count - 1]);
    let segments = cut(&motion(object), count, 1, true);
    assert_eq!(segments.len(), 1);
    let found = segments.column_m(0)[segments.layout().finger_rows()..].chunks_exact(6);
    let mut farthest_turn = 0.0_f64;
    for (t, (found, expected)) in found.zip(table("rows_m")).enumerate() {
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                (found - expected).abs() < 1e-14,
                "{found} {expected} at {t}"
            );
        }
        let turn_m = Vector3::new(expected[3], expected[4], expected[5]).norm();
        farthest_turn = farthest_turn.max(turn_m / ROTATION_LEVER_M);
    }
    assert!(farthest_turn > PI);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn rotation_vectors_are_those_of_the_poses_and_do_not_jump(
        steps in prop::collection::vec(prop::array::uniform3(-0.4_f64..0.4), 30..60),
        missing in prop::collection::vec(prop::bool::weighted(0.02), 60),
    ) {
        let mut turned = UnitQuaternion::from_scaled_axis(Vector3::new(-2.0, 1.0, 0.5));
        let object: Vec<_> = (steps.iter().zip(&missing))
            .map(|(&step, missing)| {
                turned = UnitQuaternion::from_scaled_axis(Vector3::from(step)) * turned;
                let place = Translation3::from(Vector3::from(step));
                (!missing).then(|| Isometry3::from_parts(place, turned))
            })
            .collect();
        let motion = motion(object.clone());
        let (with, without) = (cut(&motion, 12, 2, true), cut(&motion, 12, 2, false));
        prop_assert!(with.columns_m().iter().all(|v| v.is_finite()));
        // A subset of the segments without object, and the counts agree.
        prop_assert!(with.origins().iter().all(|origin| without.origins().contains(origin)));
        prop_assert_eq!(with.len() + with.left_out, without.len() + without.left_out);
        for segment in 0..with.len() {
            let start = with.origins()[segment].start;
            let first = object[start].unwrap().rotation;
            let rows = rows(&with, segment);
            for (t, (_, vector)) in rows.iter().enumerate() {
                let back = UnitQuaternion::from_scaled_axis(*vector) * first;
                prop_assert!(back.angle_to(&object[start + t].unwrap().rotation) < 1e-7);
            }
            // No other vector of the same rotation is nearer to the one before: half a turn at most
            // along its own axis.
            for pair in rows.windows(2) {
                let (previous, vector) = (pair[0].1, pair[1].1);
                let along = vector.norm() - vector.dot(&previous) / vector.norm().max(1e-12);
                prop_assert!(along.abs() <= PI + 1e-9);
            }
        }
    }
}
