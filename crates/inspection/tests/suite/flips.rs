//! Bodies that turn, and bodies that jump.

use inhand_inspection::detect::flips;
use inhand_inspection::{FlipRepair, Suspect, SuspectKind, repair};
use inhand_model::{
    BodyKind, Clock, LengthUnit, Pose, Recording, Source, StartTime, Status, Track, TrackedBody,
    UpAxis,
};
use nalgebra::{Isometry3, Vector3};

use crate::common::roles;

/// A body that turns about one axis by so many degrees at each time in seconds.
fn turning(rate_hz: f64, duration_s: f64, degrees: impl Fn(f64) -> f64) -> Recording {
    let samples = (duration_s * rate_hz).round() as usize;
    let pose = |k: usize| {
        let turned = Vector3::new(0.6, 0.0, 0.8) * degrees(k as f64 / rate_hz).to_radians();
        Some(Pose::new(Isometry3::new(
            Vector3::new(0.1, 0.2, 0.3),
            turned,
        )))
    };
    let body = TrackedBody {
        name: "Object".into(),
        id: String::new(),
        kind: BodyKind::RigidBody,
        track: Track::from_measured((0..samples).map(pose)),
        marker_error_m: Some(vec![2e-4; samples]),
    };
    let source = Source {
        format: "test".into(),
        length_unit: LengthUnit::Metres,
        up_axis: UpAxis::Y,
        rotation: None,
        header: Default::default(),
    };
    let clock = Clock::new(0, StartTime::Unknown, rate_hz).expect("the rate is positive");
    Recording::new("test".into(), clock, source, samples, vec![], vec![body])
        .expect("lengths agree")
}

fn hide(take: &mut Recording, from_s: f64, to_s: f64) {
    let at = |s: f64| (s * take.clock.rate_hz()).round() as usize;
    (at(from_s)..at(to_s)).for_each(|k| take.bodies[0].track.set(k, None, Status::Missing));
}

fn repair_of(flip: &Suspect) -> FlipRepair {
    let SuspectKind::Flip { repair, .. } = flip.kind else {
        panic!("{flip:?} is no flip");
    };
    repair
}

fn assert_left_alone(take: &Recording, what: &str) {
    let found = flips(take);
    assert!(found.is_empty(), "{what}: {found:?}");
}

/// Degrees after a step at a time.
fn step(s: f64, at_s: f64, degrees: f64) -> f64 {
    if s < at_s { 0.0 } else { degrees }
}

#[test]
fn turns_while_a_body_is_hidden_are_left_alone() {
    // Long and short stretches on either side of the gap: none is wrong.
    for (gap_s, turn, rest_s) in [(1.0, 90.0, 20.0), (1.0, 90.0, 0.5), (0.5, 180.0, 3.0)] {
        let mut take = turning(100.0, 5.0 + gap_s + rest_s, |s| {
            step(s, 5.0 + gap_s / 2.0, turn)
        });
        hide(&mut take, 5.0, 5.0 + gap_s);
        assert_left_alone(&take, &format!("{turn} degrees in {gap_s} s"));
    }
    let mut still = turning(100.0, 6.0, |_| 30.0);
    hide(&mut still, 3.0, 3.5);
    assert_left_alone(&still, "at rest");
    // Turned, and turned back 7 s later, both while hidden.
    let mut there_and_back = turning(100.0, 20.0, |s| step(s, 5.2, 90.0) - step(s, 12.2, 90.0));
    hide(&mut there_and_back, 5.0, 5.4);
    hide(&mut there_and_back, 12.0, 12.4);
    assert_left_alone(&there_and_back, "there and back");
}

#[test]
fn a_quick_turn_in_a_short_gap_is_left_alone() {
    // 500 degrees a second while 80 ms are hidden.
    let mut take = turning(100.0, 8.0, |s| 500.0 * (s - 4.0).clamp(0.0, 0.09));
    hide(&mut take, 4.01, 4.09);
    assert_left_alone(&take, "45 degrees in 80 ms");
}

#[test]
fn fast_motion_is_no_flip_at_any_rate() {
    let swing = |s: f64| 69.0 * (std::f64::consts::TAU * 2.0 * s).sin();
    for rate_hz in [15.0, 30.0, 60.0, 100.0, 240.0] {
        assert_left_alone(&turning(rate_hz, 20.0, swing), &format!("{rate_hz} Hz"));
    }
}

#[test]
fn a_flip_is_turned_back_in_motion_and_across_a_short_gap() {
    let truth = |s: f64| 40.0 * (3.0 * s).sin();
    for (rate_hz, lost_s) in [(30.0, 0.0), (100.0, 0.0), (100.0, 0.05)] {
        let flipped = |s: f64| truth(s) + step(s, 4.0, 180.0) - step(s, 5.0, 180.0);
        let mut take = turning(rate_hz, 20.0, flipped);
        if lost_s > 0.0 {
            hide(&mut take, 4.0 - lost_s / 2.0, 4.0 + lost_s / 2.0);
        }
        let found = flips(&take);
        assert_eq!(found.len(), 1, "{rate_hz} Hz: {found:?}");
        assert!(matches!(repair_of(&found[0]), FlipRepair::TurnBack(_)));
        repair(&mut take, &roles(true), &found).expect("flips need no roles");
        let right = turning(rate_hz, 20.0, truth);
        for (k, pose) in take.bodies[0].track.iter().enumerate() {
            let (Some(pose), Some(there)) = (pose, right.bodies[0].track.get(k)) else {
                continue;
            };
            let off = pose
                .isometry()
                .rotation
                .angle_to(&there.isometry().rotation);
            assert!(off.to_degrees() < 10.0, "{rate_hz} Hz, sample {k}: {off}");
        }
    }
}

#[test]
fn a_jump_alone_takes_only_what_is_short_or_has_a_large_error() {
    let jump = |to_end_s: f64| turning(100.0, 10.0 + to_end_s, |s| step(s, 10.0, 120.0));
    let found = flips(&jump(0.8));
    assert_eq!(found.len(), 1);
    assert_eq!(
        (found[0].samples.clone(), repair_of(&found[0])),
        (1000..1080, FlipRepair::Remove)
    );
    assert_left_alone(&jump(5.0), "either side of the jump may be right");
    let mut told = jump(5.0);
    let errors = (told.bodies[0].marker_error_m.as_mut()).expect("it has errors");
    errors[1000..].fill(2e-3);
    let found = flips(&told);
    assert_eq!(found.len(), 1);
    assert_eq!(
        (found[0].samples.clone(), repair_of(&found[0])),
        (1000..1500, FlipRepair::Remove)
    );
    // The other side is the one whose error is large: the short one is good.
    let mut other = turning(100.0, 8.0, |s| step(s, 7.5, 120.0));
    hide(&mut other, 4.0, 4.5);
    let errors = (other.bodies[0].marker_error_m.as_mut()).expect("it has errors");
    errors[450..750].fill(2e-3);
    let found = flips(&other);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].samples, 450..750);
}
