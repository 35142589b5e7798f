//! Settings that make no take.

use inhand_simulation::{
    GapSettings, SessionSettings, SimulationError, TakeSettings, session, simulate,
};
use proptest::prelude::*;

fn refusal(change: impl FnOnce(&mut TakeSettings)) -> SimulationError {
    let mut settings = TakeSettings::cube("take");
    change(&mut settings);
    simulate(&settings, 1).expect_err("the settings are not valid")
}

#[track_caller]
fn check_setting(name: &str, change: impl FnOnce(&mut TakeSettings)) {
    match refusal(change) {
        SimulationError::Setting(text) if text.starts_with(&format!("setting {name} is ")) => {}
        other => panic!("expected a refusal of {name}, got {other}"),
    }
}

#[test]
fn numbers_out_of_range_are_refused_by_name() {
    for rate_hz in [0.0, -100.0, 19.0, 1e4, f64::NAN, f64::INFINITY] {
        check_setting("rate_hz", |s| s.rate_hz = rate_hz);
    }
    for duration_s in [0.0, 0.01, -1.0, 1e9, f64::NAN, f64::INFINITY] {
        check_setting("duration_s", |s| s.duration_s = duration_s);
    }
    check_setting("duration_s * rate_hz", |s| {
        (s.duration_s, s.rate_hz) = (3600.0, 1000.0);
    });
    for noise_m in [-1e-4, 0.1, f64::NAN] {
        check_setting("noise_m", |s| s.noise_m = noise_m);
    }
    let gaps = |share, min_samples, max_samples| {
        Some(GapSettings {
            share,
            min_samples,
            max_samples,
        })
    };
    for share in [-0.1, 0.9, f64::NAN] {
        check_setting("gaps.share", |s| s.gaps = gaps(share, 2, 23));
    }
    check_setting("gaps.min_samples", |s| s.gaps = gaps(0.1, 0, 23));
    check_setting("gaps.min_samples", |s| s.gaps = gaps(0.1, 24, 23));
    check_setting("gaps.max_samples", |s| s.gaps = gaps(0.1, 2, 12_000));
    let message = refusal(|s| s.rate_hz = 0.0).to_string();
    assert_eq!(message, "setting rate_hz is 0: expected 20 to 1000");
}

#[test]
fn objects_that_the_hand_does_not_hold_are_refused() {
    let check = |text: &str, named: &str| {
        let refused = refusal(|s| s.shape = text.parse().unwrap());
        let text = refused.to_string();
        assert!(matches!(refused, SimulationError::Object(_)), "{text}");
        assert!(text.contains(&format!("{named} is")), "{text}");
    };
    check("cube:0.2", "edge along x");
    check("cube:0.01", "edge along x");
    check("box:0.05x0.3x0.05", "edge along y");
    check("box:0.05x0.05x0.5", "height along z");
    check("cylinder:0.3x0.05", "diameter");
    check("cylinder:0.05x0.01", "height along z");
    let nan = inhand_model::Shape::Cuboid {
        edges_m: [0.05, f64::NAN, 0.05],
    };
    assert!(matches!(
        refusal(|s| s.shape = nan),
        SimulationError::Object(_)
    ));
}

#[test]
fn a_session_refuses_what_its_takes_refuse() {
    let settings = |change: fn(&mut SessionSettings)| {
        let mut settings = SessionSettings::new(TakeSettings::cube("").shape);
        change(&mut settings);
        session(&settings, 1).map(|_| ())
    };
    assert!(settings(|s| s.take.rate_hz = f64::NAN).is_err());
    assert!(settings(|s| s.train_takes = 1000).is_err());
    let empty = settings(|s| (s.train_takes, s.test_takes) = (0, 0));
    assert_eq!(empty, Ok(()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever lies within the limits is grasped, and held to the end.
    #[test]
    fn every_object_within_the_limits_is_held(
        x in 0.035..=0.08,
        y in 0.035..=0.08,
        z in 0.03..=0.1,
        round: bool,
        seed: u64,
    ) {
        let shape = if round {
            inhand_model::Shape::Cylinder { diameter_m: x, height_m: z }
        } else {
            inhand_model::Shape::Cuboid { edges_m: [x, y, z] }
        };
        let settings = TakeSettings { duration_s: 5.0, ..TakeSettings::new(shape, "take") };
        prop_assert_eq!(simulate(&settings, seed).map(|take| take.recording.len()), Ok(500));
    }
}
