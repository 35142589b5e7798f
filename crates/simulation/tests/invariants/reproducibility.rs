//! Same settings and seed, same bits; what may change them and what may not.

use inhand_model::{Finger, Shape};
use inhand_simulation::{
    GapSettings, SessionSettings, SimulatedTake, TakeSettings, session, simulate,
};

/// Every number of a take, as bits.
fn bits(take: &SimulatedTake) -> Vec<u64> {
    let mut bits = Vec::new();
    let mut add = |values: &[f64]| bits.extend(values.iter().map(|v| v.to_bits()));
    for marker in &take.recording.markers {
        (marker.track.values()).for_each(|p| add(&p.to_array()));
    }
    for body in &take.recording.bodies {
        for pose in body.track.values() {
            add(&pose.quaternion_xyzw());
            add(&pose.origin().to_array());
        }
        body.marker_error_m.iter().for_each(|e| add(e));
    }
    for finger in Finger::ALL {
        (take.truth.fingertips[finger].iter()).for_each(|p| add(&p.to_array()));
    }
    bits
}

fn short(name: &str) -> TakeSettings {
    TakeSettings {
        duration_s: 20.0,
        ..TakeSettings::cube(name)
    }
}

fn short_session() -> SessionSettings {
    let mut settings = SessionSettings::new(Shape::Cylinder {
        diameter_m: 0.05,
        height_m: 0.05,
    });
    (settings.train_takes, settings.test_takes) = (3, 2);
    settings.take.duration_s = 10.0;
    settings
}

#[test]
fn the_seed_decides() {
    let take = |seed| simulate(&short("take"), seed).unwrap();
    assert!(bits(&take(5)) == bits(&take(5)));
    assert_eq!(take(5).truth, take(5).truth);
    let (one, other) = (take(5).truth, take(6).truth);
    assert_ne!(one.fingertips, other.fingertips);
    assert_ne!(one.world_from_hand, other.world_from_hand);
}

#[test]
fn noise_gaps_tracking_and_length_leave_the_motion_alone() {
    let plain = simulate(&short("plain"), 3).unwrap().truth;
    let settings = TakeSettings {
        noise_m: 1e-3,
        gaps: Some(GapSettings::with_share(0.05)),
        track_object: false,
        ..short("other")
    };
    let mut other = simulate(&settings, 3).unwrap().truth;
    assert_ne!(plain.gaps, other.gaps);
    other.gaps = plain.gaps.clone();
    assert_eq!(plain, other);
    let longer = TakeSettings {
        duration_s: 30.0,
        ..short("longer")
    };
    let longer = simulate(&longer, 3).unwrap().truth;
    assert_eq!(plain.world_from_object, longer.world_from_object[..2000]);
}

#[test]
fn a_session_is_the_same_for_any_number_of_threads() {
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let session = pool
            .build()
            .unwrap()
            .install(|| session(&short_session(), 8));
        let session = session.unwrap();
        let takes = session.train.iter().chain(&session.test);
        takes.map(bits).collect::<Vec<_>>()
    };
    assert!(with_threads(1) == with_threads(3));
}

#[test]
fn a_session_has_takes_of_their_own() {
    let simulated = session(&short_session(), 8).unwrap();
    let names: Vec<_> = (simulated.train.iter().chain(&simulated.test))
        .map(|take| take.recording.name.as_str())
        .collect();
    let expected = [
        "cylinder_train_01",
        "cylinder_train_02",
        "cylinder_train_03",
        "cylinder_test_01",
        "cylinder_test_02",
    ];
    assert_eq!(names, expected);
    for take in &simulated.train {
        assert!(take.recording.body("Object").is_none());
        for test in &simulated.test {
            assert_ne!(take.truth.fingertips, test.truth.fingertips);
        }
    }
    assert!((simulated.test.iter()).all(|take| take.recording.body("Object").is_some()));
    // More takes for learning change neither the others nor the test takes.
    let more = SessionSettings {
        train_takes: 4,
        ..short_session()
    };
    let more = session(&more, 8).unwrap();
    assert_eq!(more.train[1].truth, simulated.train[1].truth);
    assert_eq!(more.test[0].truth, simulated.test[0].truth);
}
