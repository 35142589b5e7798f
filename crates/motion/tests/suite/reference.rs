//! Gaps, hand frame and filters against NumPy and SciPy (`reference/make.py`).

use inhand_model::{BodySource, Finger, Motion, PointTrack, Status};
use inhand_motion::{Filter, GapFill, ProcessSettings, Templates, process};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde_json::Value;

use crate::{body, marker, recording, rigid_body, roles};

/// What the method promises against an independent computation, metres; quaternions the same.
const TOLERANCE: f64 = 1e-9;

fn rows<const N: usize>(value: &Value) -> Vec<Option<[f64; N]>> {
    let row = |row: &Value| {
        let numbers: Option<Vec<f64>> = row.as_array().unwrap().iter().map(Value::as_f64).collect();
        numbers.map(|numbers| numbers.try_into().unwrap())
    };
    value.as_array().unwrap().iter().map(row).collect()
}

fn poses(positions: &Value, quaternions: &Value) -> Vec<Option<Isometry3<f64>>> {
    (rows::<3>(positions).into_iter().zip(rows::<4>(quaternions)))
        .map(|(p, q)| {
            let ([x, y, z], [i, j, k, w]) = p.zip(q)?;
            let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
            Some(Isometry3::from_parts(Translation3::new(x, y, z), rotation))
        })
        .collect()
}

fn processed(filter: Filter) -> (Value, Motion) {
    let reference: Value = serde_json::from_str(include_str!("../reference/motion.json")).unwrap();
    let inputs = &reference["inputs"];
    // Two tracks for five fingers: each finger of the reference is tested where it is given.
    let tips = Finger::ALL.map(|finger| {
        let track = if finger == Finger::Thumb {
            "thumb"
        } else {
            "little"
        };
        marker(finger.name(), rows::<3>(&inputs[track]))
    });
    let bodies = vec![
        body("Hand", poses(&inputs["hand_p"], &inputs["hand_q"])),
        body("Object", poses(&inputs["object_p"], &inputs["object_q"])),
    ];
    let take = recording(reference["rate_hz"].as_f64().unwrap(), tips.into(), bodies);
    let object: Option<BodySource> = Some(rigid_body("Object"));
    let offset: Vec<f64> = serde_json::from_value(reference["offset"].clone()).unwrap();
    let settings = ProcessSettings {
        max_gap_s: 0.1,
        fill: GapFill::Cubic,
        filter,
        object_offset_m: offset.try_into().unwrap(),
    };
    let roles = roles(rigid_body("Hand"), object);
    let motion = process(&take, &roles, &Templates::default(), &settings).unwrap();
    (reference, motion)
}

fn check_points(found: &PointTrack<inhand_model::Hand>, expected: &Value, what: &str) {
    let expected = rows::<3>(expected);
    assert_eq!(found.len(), expected.len());
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        let found = found.map(inhand_model::Position::to_array);
        assert_eq!(found.is_some(), expected.is_some(), "{what} at {k}");
        if let Some((found, expected)) = found.zip(expected) {
            let distance = (Vector3::from(found) - Vector3::from(expected)).norm();
            assert!(distance < TOLERANCE, "{what} at {k}: {distance:e} m");
        }
    }
}

fn check(name: &str, filter: Filter) {
    let (reference, motion) = processed(filter);
    let expected = &reference["expected"][name];
    check_points(
        &motion.fingertips[Finger::Thumb],
        &expected["thumb"],
        "thumb",
    );
    check_points(
        &motion.fingertips[Finger::Little],
        &expected["little"],
        "little",
    );

    let object = motion.object.unwrap();
    let expected = poses(&expected["object_p"], &expected["object_q"]);
    let check_pose = |k: usize, found: Isometry3<f64>, expected: Isometry3<f64>| {
        let distance = (found.translation.vector - expected.translation.vector).norm();
        let turn = found.rotation.angle_to(&expected.rotation);
        assert!(
            distance < TOLERANCE && turn < 10.0 * TOLERANCE,
            "object at {k}: {distance:e}, {turn:e}"
        );
    };
    for (k, (found, expected)) in object.iter().zip(&expected).enumerate() {
        check_pose(k, found.unwrap().isometry(), expected.unwrap());
        // The sign too: it is continuous, starting on the side of w >= 0.
        let sign = found
            .unwrap()
            .isometry()
            .rotation
            .coords
            .dot(&expected.unwrap().rotation.coords);
        assert!(sign > 0.0, "the quaternion at {k} has the other sign");
    }

    // The hand is filled and nothing else, whatever the filter.
    let hand = poses(&reference["hand_p"], &reference["hand_q"]);
    for (k, (found, expected)) in motion.hand.iter().zip(hand).enumerate() {
        check_pose(k, found.unwrap().isometry(), expected.unwrap());
    }
}

#[test]
fn gaps_and_hand_frame() {
    check("none", Filter::None);
}

#[test]
fn median_of_an_even_window() {
    check("median_50", Filter::Median { window: 50 });
}

#[test]
fn median_of_an_odd_window() {
    check("median_7", Filter::Median { window: 7 });
}

#[test]
fn savitzky_golay() {
    let filter = Filter::SavitzkyGolay {
        window: 9,
        order: 3,
    };
    check("savitzky_golay_9_3", filter);
}

#[test]
fn butterworth_of_even_and_odd_order() {
    for (name, cutoff_hz, order) in [("butterworth_8_2", 8.0, 2), ("butterworth_5_3", 5.0, 3)] {
        check(name, Filter::Butterworth { cutoff_hz, order });
    }
}

#[test]
fn statuses_tell_what_was_filled_whatever_the_filter() {
    for filter in [Filter::None, Filter::Median { window: 50 }] {
        let (_, motion) = processed(filter);
        let hand_filled = 50..54;
        for k in 0..motion.len() {
            let at = |filled: bool| {
                if filled {
                    Status::Filled
                } else {
                    Status::Measured
                }
            };
            let by_hand = hand_filled.contains(&k);
            assert_eq!(motion.hand.status(k), at(by_hand));
            assert_eq!(motion.object.as_ref().unwrap().status(k), at(by_hand));
            let thumb_filled = (20..27).contains(&k) || (28..30).contains(&k);
            assert_eq!(
                motion.fingertips[Finger::Thumb].status(k),
                at(by_hand || thumb_filled)
            );
            let little = if k < 2 || (54..66).contains(&k) {
                Status::Missing
            } else {
                at(by_hand)
            };
            assert_eq!(motion.fingertips[Finger::Little].status(k), little);
        }
    }
}
