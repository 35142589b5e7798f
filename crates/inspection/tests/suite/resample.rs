//! Closed forms of resampling.

use std::f64::consts::TAU;

use inhand_inspection::resample;
use inhand_model::{
    BodyKind, Clock, LengthUnit, Marker, MarkerKind, Pose, Recording, Source, StartTime, Status,
    Track, TrackedBody, UpAxis,
};
use nalgebra::{Isometry3, Vector3};

fn recording(
    rate_hz: f64,
    samples: usize,
    x_m: impl Fn(f64) -> f64,
    turn: impl Fn(f64) -> f64,
) -> Recording {
    let time = |k: usize| k as f64 / rate_hz;
    let marker = Marker {
        name: "m".into(),
        id: String::new(),
        kind: MarkerKind::Labelled,
        track: Track::from_measured((0..samples).map(|k| Some([x_m(time(k)), 0.5, 0.0].into()))),
        quality: Some((0..samples).map(time).collect()),
    };
    let pose = |k: usize| {
        let turned = Vector3::z() * turn(time(k));
        Some(Pose::new(Isometry3::new(
            Vector3::new(x_m(time(k)), 0.0, 0.0),
            turned,
        )))
    };
    let body = TrackedBody {
        name: "b".into(),
        id: String::new(),
        kind: BodyKind::RigidBody,
        track: Track::from_measured((0..samples).map(pose)),
        marker_error_m: None,
    };
    let source = Source {
        format: "test".into(),
        length_unit: LengthUnit::Metres,
        up_axis: UpAxis::Z,
        rotation: None,
        header: Default::default(),
    };
    let clock = Clock::new(77, StartTime::Stated, rate_hz).expect("the rate is positive");
    Recording::new("r".into(), clock, source, samples, vec![marker], vec![body])
        .expect("lengths agree")
}

fn x_at(recording: &Recording, k: usize) -> f64 {
    recording.markers[0]
        .track
        .get(k)
        .expect("it is there")
        .coords_m()
        .x
}

#[test]
fn steady_motion_stays_at_any_rate() {
    for to_hz in [30.0, 50.0, 99.0, 100.0, 120.0, 250.0] {
        let (out, change) = resample(
            &recording(100.0, 301, |t| 0.1 + 0.2 * t, |t| 1.1 * t),
            to_hz,
        )
        .expect("it resamples");
        assert_eq!(
            out.len(),
            (3.0_f64 * to_hz).floor() as usize + 1,
            "{to_hz} Hz"
        );
        assert_eq!(change.samples, 0..301);
        assert_eq!(
            (out.clock.rate_hz(), out.clock.start_unix_nanos()),
            (to_hz, 77)
        );
        for k in 0..out.len() {
            let t = k as f64 / to_hz;
            assert!(
                (x_at(&out, k) - (0.1 + 0.2 * t)).abs() < 1e-9,
                "{to_hz} Hz at {t} s"
            );
            let turned = out.bodies[0]
                .track
                .get(k)
                .expect("it is there")
                .isometry()
                .rotation;
            assert!((turned.scaled_axis().z - 1.1 * t).abs() < 1e-9 || 1.1 * t > 3.0);
            let quality = out.markers[0].quality.as_ref().expect("the source has one")[k];
            assert!((quality - t).abs() < 1e-9);
        }
    }
}

#[test]
fn the_same_rate_gives_the_same_bits() {
    let given = recording(100.0, 50, |t| (9.0 * t).sin(), |t| t);
    let (out, _) = resample(&given, 100.0).expect("it resamples");
    assert!(
        given.markers[0]
            .track
            .iter()
            .eq(out.markers[0].track.iter())
    );
    assert!(
        given.bodies[0]
            .track
            .iter()
            .zip(out.bodies[0].track.iter())
            .all(|(a, b)| {
                let angle = a
                    .zip(b)
                    .map(|(a, b)| a.isometry().rotation.angle_to(&b.isometry().rotation));
                angle.is_some_and(|angle| angle < 1e-7)
            })
    );
}

#[test]
fn down_keeps_what_the_new_rate_can_show_and_drops_the_rest() {
    let middle = |f_hz: f64| {
        let (out, _) = resample(
            &recording(200.0, 1001, |t| (TAU * f_hz * t).sin(), |_| 0.0),
            50.0,
        )
        .expect("it resamples");
        (20..230)
            .map(|k| (x_at(&out, k), (TAU * f_hz * k as f64 / 50.0).sin()))
            .fold((0.0_f64, 0.0_f64), |(most, off), (x, there)| {
                (most.max(x.abs()), off.max((x - there).abs()))
            })
    };
    // 6 Hz is human motion: kept to a percent. 44 Hz would come back as 6 Hz.
    assert!(middle(6.0).1 < 0.01, "{:?}", middle(6.0));
    assert!(middle(44.0).0 < 0.01, "{:?}", middle(44.0));
    assert!(middle(35.0).0 < 0.02, "{:?}", middle(35.0));
}

#[test]
fn up_follows_a_smooth_motion_and_slerps() {
    let (out, _) = resample(
        &recording(
            100.0,
            201,
            |t| (TAU * 3.0 * t).sin(),
            |t| 2.0 * (4.0 * t).sin(),
        ),
        240.0,
    )
    .expect("it resamples");
    for k in 5..out.len() - 5 {
        let t = k as f64 / 240.0;
        assert!(
            (x_at(&out, k) - (TAU * 3.0 * t).sin()).abs() < 1e-4,
            "{t} s"
        );
        let turned = out.bodies[0]
            .track
            .get(k)
            .expect("it is there")
            .isometry()
            .rotation;
        // A chord of the turn: half the second derivative, 32 rad/s², times a quarter of (10 ms)².
        assert!(
            (turned.scaled_axis().z - 2.0 * (4.0 * t).sin()).abs() < 5e-4,
            "{t} s"
        );
    }
}

#[test]
fn gaps_are_not_crossed_and_status_is_carried() {
    let mut given = recording(100.0, 200, |t| 0.2 * t, |_| 0.0);
    let track = &mut given.markers[0].track;
    (80..100).for_each(|k| track.set(k, None, Status::Missing));
    let filled = track.get(150);
    track.set(150, filled, Status::Filled);
    // Beyond the gap the marker is elsewhere: none of it may leak to this side.
    for k in 100..200 {
        let status = track.status(k);
        track.set(k, Some([5.0 + 0.002 * k as f64, 0.5, 0.0].into()), status);
    }
    for to_hz in [40.0, 130.0] {
        let (out, _) = resample(&given, to_hz).expect("it resamples");
        for k in 0..out.len() {
            let at = k as f64 / to_hz * 100.0;
            let (before, after) = ((at + 1e-7).floor() as usize, (at - 1e-7).ceil() as usize);
            let there = [before, after]
                .iter()
                .all(|&s| given.markers[0].track.get(s).is_some());
            let status = out.markers[0].track.status(k);
            assert_eq!(status.is_present(), there, "{to_hz} Hz, sample {k}");
            if there {
                let jump = if at > 90.0 { 5.0 } else { 0.0 };
                assert!(
                    (x_at(&out, k) - jump - 0.002 * at).abs() < 1e-9,
                    "{to_hz} Hz, sample {k}"
                );
                let beside_filled = before == 150 || after == 150;
                assert_eq!(status == Status::Filled, beside_filled);
            }
        }
    }
}

#[test]
fn rates_that_are_none_are_refused() {
    let given = recording(100.0, 10, |t| t, |t| t);
    for rate_hz in [0.0, -5.0, f64::NAN, f64::INFINITY, 1e9] {
        let error = resample(&given, rate_hz)
            .expect_err("no such rate")
            .to_string();
        assert!(error.contains("1 to 10000 Hz"), "{error}");
    }
}
