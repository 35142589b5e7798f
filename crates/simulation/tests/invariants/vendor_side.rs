//! Additions of the recording to the truth: noise, fits, signs, gaps, names.

use inhand_model::{
    BodyKind, Finger, Frame, MarkerKind, Pose, Position, RotationOrder, Status, TrackedBody,
    UpAxis, World,
};
use inhand_simulation::{GapSettings, SimulatedTake, TakeSettings, simulate};

const NAMES: [&str; 5] = ["Thumb", "Index", "Middle", "Ring", "Little"];

fn cube(change: impl FnOnce(&mut TakeSettings)) -> SimulatedTake {
    let mut settings = TakeSettings::cube("take");
    change(&mut settings);
    simulate(&settings, 21).expect("the settings are valid")
}

#[test]
fn a_take_without_noise_is_the_truth() {
    let take = cube(|s| (s.noise_m, s.duration_s) = (0.0, 10.0));
    for (finger, name) in Finger::ALL.into_iter().zip(NAMES) {
        let marker = take.recording.marker(name).unwrap();
        assert_eq!(marker.kind, MarkerKind::Labelled);
        assert_eq!(
            marker.track.values().collect::<Vec<_>>(),
            take.truth.fingertips[finger]
        );
    }
    let hand = take.recording.body("Hand").unwrap();
    for (pose, truth) in hand.track.iter().zip(&take.truth.world_from_hand) {
        let (pose, truth) = (pose.unwrap().isometry(), truth.isometry());
        assert!((pose.translation.vector - truth.translation.vector).norm() < 1e-12);
        assert!(pose.rotation.angle_to(&truth.rotation) < 1e-7);
    }
    assert!(hand.marker_error_m.iter().flatten().all(|&e| e < 1e-12));
}

#[test]
fn noise_has_the_deviation_asked_for() {
    for noise_m in [1e-4, 5e-4] {
        let take = cube(|s| s.noise_m = noise_m);
        for (finger, name) in Finger::ALL.into_iter().zip(NAMES) {
            let track = &take.recording.marker(name).unwrap().track;
            let truth = &take.truth.fingertips[finger];
            for axis in 0..3 {
                let noise: Vec<f64> = (track.values().zip(truth))
                    .map(|(seen, truth)| seen.to_array()[axis] - truth.to_array()[axis])
                    .collect();
                let n = noise.len() as f64;
                let mean = noise.iter().sum::<f64>() / n;
                let deviation = (noise.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
                // Five standard errors: of the mean 1 / sqrt(n), of the deviation 1 / sqrt(2 n).
                assert!(mean.abs() < 5.0 * noise_m / n.sqrt());
                assert!((deviation / noise_m - 1.0).abs() < 5.0 / (2.0 * n).sqrt());
                // White: neighbours are not correlated.
                let product: f64 = noise.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
                assert!(product.abs() < 5.0 * noise_m * noise_m / n.sqrt());
            }
        }
    }
}

#[test]
fn bodies_are_fitted_to_noisy_markers() {
    let take = cube(|_| ());
    let noise_m = 1e-4;
    fn check<F: Frame>(body: &TrackedBody, truth: &[Pose<World, F>], noise_m: f64) {
        assert_eq!(body.kind, BodyKind::RigidBody);
        let n = truth.len() as f64;
        let error = (body.marker_error_m.as_ref().unwrap().iter()).sum::<f64>() / n;
        // Nine coordinates less the six of a pose leave 3 noise² for three markers' squared
        // distances; their mean length is somewhat below the root.
        assert!((0.6 * noise_m..noise_m).contains(&error), "{error}");
        let turn_rad = (body.track.iter().zip(truth))
            .map(|(pose, truth)| {
                let rotation = pose.unwrap().isometry().rotation;
                rotation.angle_to(&truth.isometry().rotation).powi(2)
            })
            .sum::<f64>();
        // Noise over the arms of three markers some centimetres away.
        let turn_rad = (turn_rad / n).sqrt();
        assert!((1.5e-3..1e-2).contains(&turn_rad), "{turn_rad}");
    }
    let truth = &take.truth;
    let body = |name| take.recording.body(name).unwrap();
    check(body("Hand"), &truth.world_from_hand, noise_m);
    check(body("Object"), &truth.world_from_object, noise_m);
    for body in &take.recording.bodies {
        // The body's markers move with its reported pose: constant in its frame.
        for number in 1..=3 {
            let name = format!("{}:Marker{number}", body.name);
            let marker = take.recording.marker(&name).unwrap();
            assert_eq!(marker.kind, MarkerKind::RigidBodyMarker);
            let place = |k: usize| {
                let pose = body.track.get(k).unwrap();
                (pose.inverse() * marker.track.get(k).unwrap()).coords_m()
            };
            let first = place(0);
            assert!((1..truth.world_from_hand.len()).all(|k| (place(k) - first).norm() < 1e-12));
        }
    }
}

#[test]
fn quaternions_change_sign_now_and_then_and_stay_unit() {
    let take = cube(|_| ());
    for body in &take.recording.bodies {
        let quaternions: Vec<_> = (body.track.values())
            .map(|pose| nalgebra::Vector4::from(pose.quaternion_xyzw()))
            .collect();
        assert!(quaternions.iter().all(|q| (q.norm() - 1.0).abs() < 1e-12));
        let changes = quaternions.windows(2).filter(|w| w[0].dot(&w[1]) < 0.0);
        // 30 expected in two minutes.
        assert!((10..60).contains(&changes.count()));
    }
    let truth = &take.truth.world_from_object;
    assert!(truth.windows(2).all(|w| {
        let [a, b] = [w[0], w[1]].map(|p| nalgebra::Vector4::from(p.quaternion_xyzw()));
        a.dot(&b) > 0.0
    }));
}

#[test]
fn gaps_are_as_asked_for_and_known() {
    let take = cube(|s| s.gaps = Some(GapSettings::with_share(0.02)));
    for (finger, name) in Finger::ALL.into_iter().zip(NAMES) {
        let track = &take.recording.marker(name).unwrap().track;
        let gaps = track.gaps();
        assert_eq!(gaps, take.truth.gaps[finger]);
        assert!(gaps.iter().all(|gap| (2..=23).contains(&gap.len())));
        // Within a shortest gap of 2 % of 12 000.
        assert!((240..=241).contains(&track.counts().missing));
        assert!(gaps[0] != take.truth.gaps[Finger::ALL[(finger.index() + 1) % 5]][0]);
    }
    for body in &take.recording.bodies {
        assert!(body.track.statuses().iter().all(|&s| s == Status::Measured));
    }
}

#[test]
fn the_recording_names_things_as_motive_does() {
    let take = cube(|s| s.duration_s = 2.0);
    let recording = &take.recording;
    assert_eq!((recording.name.as_str(), recording.len()), ("take", 200));
    assert_eq!(recording.clock.rate_hz(), 100.0);
    assert_eq!(recording.source.format, "inhand simulation");
    assert_eq!(recording.source.up_axis, UpAxis::Y);
    assert_eq!(recording.source.rotation, Some(RotationOrder::Quaternion));
    assert_eq!(recording.source.header["Object Shape"], "cube:0.05");
    let bodies: Vec<_> = recording.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(bodies, ["Hand", "Object"]);
    let markers: Vec<_> = recording.markers.iter().map(|m| m.name.as_str()).collect();
    let body_markers = [
        "Hand:Marker1",
        "Hand:Marker2",
        "Hand:Marker3",
        "Object:Marker1",
        "Object:Marker2",
        "Object:Marker3",
    ];
    assert_eq!(markers, [&body_markers[..], &NAMES].concat());
}

#[test]
fn an_object_that_is_not_tracked_is_left_out() {
    let take = cube(|s| (s.track_object, s.duration_s) = (false, 2.0));
    assert!(take.recording.body("Object").is_none());
    assert!(take.recording.marker("Object:Marker1").is_none());
    assert_eq!(take.truth.world_from_object.len(), 200);
}

#[test]
fn files_hold_lengths_to_a_micrometre() {
    let take = cube(|s| (s.duration_s, s.gaps) = (10.0, Some(GapSettings::with_share(0.02))));
    let rounded = take.rounded_recording();
    let is_rounded = |exact_m: f64, found_m: f64| {
        (found_m * f64::from(1 << 20)).fract() == 0.0 && (found_m - exact_m).abs() < 0.48e-6
    };
    for (exact, found) in take.recording.markers.iter().zip(&rounded.markers) {
        assert_eq!(exact.track.statuses(), found.track.statuses());
        for (exact, found) in exact.track.iter().zip(found.track.iter()) {
            let exact = exact.map(Position::to_array).into_iter().flatten();
            let found = found.map(Position::to_array).into_iter().flatten();
            assert!(
                exact
                    .zip(found)
                    .all(|(exact, found)| is_rounded(exact, found))
            );
        }
    }
    for (exact, found) in take.recording.bodies.iter().zip(&rounded.bodies) {
        for (exact, found) in exact.track.iter().zip(found.track.iter()) {
            let (exact, found) = (exact.unwrap(), found.unwrap());
            assert_eq!(exact.quaternion_xyzw(), found.quaternion_xyzw());
            let places = (exact.origin().to_array().into_iter()).zip(found.origin().to_array());
            assert!(
                places
                    .into_iter()
                    .all(|(exact, found)| is_rounded(exact, found))
            );
        }
        let errors = exact
            .marker_error_m
            .iter()
            .flatten()
            .zip(found.marker_error_m.iter().flatten());
        assert!(
            errors
                .into_iter()
                .all(|(&exact, &found)| is_rounded(exact, found))
        );
    }
}
