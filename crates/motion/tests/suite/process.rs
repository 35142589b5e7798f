//! Gaps, the hand frame and the object's offset in closed form, and what is refused.

use inhand_model::{Finger, Recording, Status};
use inhand_motion::{Filter, GapFill, MotionError, ProcessSettings, Templates, process};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use proptest::prelude::*;

use crate::{
    PLAIN, assert_near, body, cluster, marker, recording, resting_hand, rigid_body, roles, tip_m,
};

fn processed(take: &Recording, settings: &ProcessSettings) -> inhand_model::Motion {
    let roles = roles(rigid_body("Hand"), None);
    process(take, &roles, &Templates::default(), settings).unwrap()
}

fn filling(max_gap_s: f64, fill: GapFill) -> ProcessSettings {
    ProcessSettings {
        max_gap_s,
        fill,
        ..PLAIN
    }
}

/// Statuses of the index finger as letters: measured, filled, `.` for missing.
fn letters(take: &Recording, settings: &ProcessSettings) -> String {
    let motion = processed(take, settings);
    let letter = |status: &Status| match status {
        Status::Measured => 'm',
        Status::Filled => 'f',
        Status::Missing => '.',
    };
    (motion.fingertips[Finger::Index].statuses().iter())
        .map(letter)
        .collect()
}

fn take_seen(pattern: &str) -> Recording {
    let pattern = pattern.as_bytes();
    resting_hand(pattern.len(), |finger, k| {
        finger != Finger::Index || pattern[k] == b'm'
    })
}

#[test]
fn gaps_up_to_the_limit_are_filled_and_marked() {
    for (max_gap_s, seen, expected) in [
        (0.03, "mm...mm", "mmfffmm"),
        (0.03, "mm....mm", "mm....mm"),
        (0.029, "mm...mm", "mm...mm"),
        (0.0, "mm.mm", "mm.mm"),
        // Nothing is extrapolated.
        (0.03, ".mm..", ".mm.."),
        (0.03, ".....", "....."),
        // One present sample between two gaps does not make them one.
        (0.03, "m...m...m", "mfffmfffm"),
    ] {
        let take = take_seen(seen);
        for fill in [GapFill::Cubic, GapFill::Linear] {
            assert_eq!(
                letters(&take, &filling(max_gap_s, fill)),
                expected,
                "{seen}"
            );
        }
        assert_eq!(letters(&take, &filling(max_gap_s, GapFill::None)), seen);
    }
}

#[test]
fn a_limit_of_whole_samples_is_not_lost_to_rounding() {
    // 0.29 * 100 is 28.999999999999996.
    let seen = format!("mm{}mm", ".".repeat(29));
    let filled = letters(&take_seen(&seen), &filling(0.29, GapFill::Cubic));
    assert!(!filled.contains('.'));
}

#[test]
fn the_cubic_follows_the_curve_and_the_line_cuts_it() {
    // Tips go along a parabola, which four, and three, samples determine.
    for seen in ["mmmm...mmmm", ".mm...m.mm"] {
        let motion = processed(&take_seen(seen), &filling(0.1, GapFill::Cubic));
        let index = &motion.fingertips[Finger::Index];
        for k in 3..6 {
            assert_near(index.get(k).unwrap(), tip_m(Finger::Index, k as f64), 1e-15);
        }
    }
    let motion = processed(&take_seen("mmm...mmm"), &filling(0.1, GapFill::Linear));
    let index = &motion.fingertips[Finger::Index];
    // Half-way from k = 2 (y = 4 mm) to k = 6 (36 mm).
    assert_near(index.get(4).unwrap(), [0.004, 0.020, 0.001], 1e-15);
}

/// A hand that turns evenly about z at 2 rad/s and moves, with tips that rest in its frame.
fn turning_hand(hand_seen: impl Fn(usize) -> bool, tip_seen: impl Fn(usize) -> bool) -> Recording {
    let pose = |k: usize| {
        Isometry3::new(
            Vector3::x() * 0.01 * k as f64,
            Vector3::z() * 0.02 * k as f64,
        )
    };
    let tips = Finger::ALL.map(|finger| {
        let (tip_seen, pose) = (&tip_seen, &pose);
        marker(
            finger.name(),
            (0..40).map(move |k| {
                let in_hand = Vector3::new(0.1, 0.0, 0.01 * finger.index() as f64);
                let tip = pose(k).rotation * in_hand + pose(k).translation.vector;
                tip_seen(k).then(|| tip.into())
            }),
        )
    });
    let hand = body("Hand", (0..40).map(|k| hand_seen(k).then(|| pose(k))));
    recording(100.0, tips.into(), vec![hand])
}

#[test]
fn tips_are_filled_within_the_moving_hand() {
    // Filled in the world by a line, the tips would miss by 0.1 m * (1 - cos 0.1 rad) = 0.5 mm.
    let take = turning_hand(|_| true, |k| !(10..19).contains(&k));
    let motion = processed(&take, &filling(0.1, GapFill::Linear));
    for k in 10..19 {
        let tip = motion.fingertips[Finger::Ring].get(k).unwrap();
        assert_near(tip, [0.1, 0.0, 0.03], 1e-15);
    }
}

#[test]
fn a_turning_hand_is_filled_along_its_turn() {
    let take = turning_hand(|k| !(10..19).contains(&k), |_| true);
    for fill in [GapFill::Linear, GapFill::Cubic] {
        let motion = processed(&take, &filling(0.1, fill));
        for k in 10..19 {
            let rotation = motion.hand.get(k).unwrap().isometry().rotation;
            let expected = UnitQuaternion::from_scaled_axis(Vector3::z() * 0.02 * k as f64);
            assert!(rotation.angle_to(&expected) < 1e-14);
            // And the tips with it, known as well as the hand.
            let tip = &motion.fingertips[Finger::Little];
            assert_eq!(tip.status(k), Status::Filled);
            assert_near(tip.get(k).unwrap(), [0.1, 0.0, 0.04], 1e-15);
        }
    }
}

#[test]
fn without_the_hand_there_is_no_hand_frame() {
    let take = turning_hand(|k| !(10..30).contains(&k), |_| true);
    let motion = processed(&take, &filling(0.1, GapFill::Cubic));
    for finger in Finger::ALL {
        let gaps = motion.fingertips[finger].gaps();
        assert_eq!((gaps.len(), gaps[0].clone()), (1, 10..30));
    }
}

#[test]
fn the_object_is_moved_to_its_centre_in_its_own_axes() {
    let quarter = Isometry3::new(
        Vector3::new(0.3, 0.0, 0.0),
        Vector3::z() * 0.5 * std::f64::consts::PI,
    );
    let tips = Finger::ALL.map(|finger| marker(finger.name(), [Some([0.0; 3])]));
    let hand = Isometry3::translation(0.1, 0.0, 0.0);
    let bodies = vec![body("Hand", [Some(hand)]), body("Box", [Some(quarter)])];
    let take = recording(100.0, tips.into(), bodies);
    let settings = ProcessSettings {
        object_offset_m: [0.02, 0.0, 0.0],
        ..PLAIN
    };
    let roles = roles(rigid_body("Hand"), Some(rigid_body("Box")));
    let motion = process(&take, &roles, &Templates::default(), &settings).unwrap();
    // The body's x is the world's y, and the hand stands 0.1 m along x.
    let object = motion.object.unwrap().get(0).unwrap();
    assert_near(object.origin(), [0.2, 0.02, 0.0], 1e-15);
    assert!(object.isometry().rotation.angle_to(&quarter.rotation) < 1e-15);
}

#[test]
fn filters_do_not_reach_across_gaps() {
    let seen = |_: Finger, k: usize| !(20..40).contains(&k);
    let whole = resting_hand(60, seen);
    let settings = ProcessSettings {
        filter: Filter::Median { window: 15 },
        ..PLAIN
    };
    let motion = processed(&whole, &settings);
    let after = processed(&whole.slice(40..60), &settings);
    for k in 0..20 {
        assert_eq!(
            motion.fingertips[Finger::Thumb].get(40 + k),
            after.fingertips[Finger::Thumb].get(k)
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Where the cameras' origin is makes no difference to motion in the hand's frame.
    #[test]
    fn motion_does_not_depend_on_the_world(
        p in prop::array::uniform3(-2.0..2.0), r in prop::array::uniform3(-3.0..3.0),
    ) {
        let moved = Isometry3::new(Vector3::from(p), Vector3::from(r));
        let take = turning_hand(|k| !(10..19).contains(&k), |k| !(15..22).contains(&k));
        let mut elsewhere = take.clone();
        for marker in &mut elsewhere.markers {
            marker.track = marker.track.map(|p| {
                inhand_model::Position::from_point(moved * p.point())
            });
        }
        elsewhere.bodies[0].track = (elsewhere.bodies[0].track)
            .map(|pose| inhand_model::Pose::new(moved * pose.isometry()));
        let settings = ProcessSettings { filter: Filter::Median { window: 6 }, ..filling(0.2, GapFill::Cubic) };
        let (here, there) = (processed(&take, &settings), processed(&elsewhere, &settings));
        for finger in Finger::ALL {
            prop_assert_eq!(here.fingertips[finger].statuses(), there.fingertips[finger].statuses());
            for (a, b) in here.fingertips[finger].iter().zip(there.fingertips[finger].iter()) {
                if let Some((a, b)) = a.zip(b) {
                    prop_assert!(a.distance_m(b) < 1e-12);
                }
            }
        }
    }
}

#[test]
fn settings_out_of_range_are_refused() {
    let take = take_seen("mmmm");
    let refused = |settings: &ProcessSettings, expected: &str| {
        let roles = roles(rigid_body("Hand"), None);
        match process(&take, &roles, &Templates::default(), settings) {
            Err(MotionError::Setting { setting, .. }) => assert_eq!(setting, expected),
            other => panic!("{expected}: {other:?}"),
        }
    };
    for max_gap_s in [-0.1, f64::NAN, f64::INFINITY] {
        refused(&ProcessSettings { max_gap_s, ..PLAIN }, "max_gap_s");
    }
    let filter = |filter| ProcessSettings { filter, ..PLAIN };
    refused(&filter(Filter::Median { window: 0 }), "filter.window");
    refused(
        &filter(Filter::SavitzkyGolay {
            window: 8,
            order: 2,
        }),
        "filter.window",
    );
    refused(
        &filter(Filter::SavitzkyGolay {
            window: 5,
            order: 5,
        }),
        "filter.order",
    );
    refused(
        &filter(Filter::Butterworth {
            cutoff_hz: 50.0,
            order: 2,
        }),
        "filter.cutoff_hz",
    );
    refused(
        &filter(Filter::Butterworth {
            cutoff_hz: 6.0,
            order: 0,
        }),
        "filter.order",
    );
    let object_offset_m = [0.0, f64::NAN, 0.0];
    refused(
        &ProcessSettings {
            object_offset_m,
            ..PLAIN
        },
        "object_offset_m",
    );
}

#[test]
fn names_that_the_take_lacks_are_refused_with_those_it_has() {
    let take = take_seen("mm");
    let message = |roles| {
        let error = process(&take, &roles, &Templates::default(), &PLAIN).unwrap_err();
        assert!(matches!(error, MotionError::NotInTake { .. }));
        error.to_string()
    };
    assert_eq!(
        message(roles(rigid_body("hand"), None)),
        "take \"take\" has no rigid body \"hand\", wanted as hand: it has \"Hand\"; map the role to one of these"
    );
    let mut pinky = roles(rigid_body("Hand"), None);
    pinky.fingers[Finger::Little] = "pinky".into();
    assert!(
        message(pinky)
            .contains("no marker \"pinky\", wanted as little: it has \"thumb\", \"index\"")
    );
    assert!(
        message(roles(rigid_body("Hand"), Some(rigid_body("Cube")))).contains("wanted as object")
    );

    let unfitted = roles(cluster(&["thumb", "index", "ring"]), None);
    let found = process(&take, &unfitted, &Templates::default(), &PLAIN);
    let message = found.expect_err("no template was fitted").to_string();
    assert!(message.contains("there is no template for it"), "{message}");
}

#[test]
fn an_empty_take_is_an_empty_motion() {
    let take = take_seen("mm").slice(0..0);
    let settings = ProcessSettings {
        filter: Filter::Median { window: 50 },
        ..filling(0.1, GapFill::Cubic)
    };
    assert!(processed(&take, &settings).is_empty());
}
