//! Power spectral density against SciPy (`reference/make_spectrum.py`), closed forms, gaps.

use inhand_model::{Hand, PointTrack, Position, Status};
use inhand_motion::{MotionError, Welch};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    serde_json::from_value(value.clone()).unwrap()
}

#[test]
fn agrees_with_scipy() {
    let cases: Value = serde_json::from_str(include_str!("../reference/spectrum.json")).unwrap();
    for case in cases.as_array().unwrap() {
        let window = case["window"].as_u64().unwrap() as usize;
        let mut welch = Welch::new(window, case["rate_hz"].as_f64().unwrap()).unwrap();
        welch.add(&numbers(&case["signal"]));
        let (expected, found) = (numbers(&case["density"]), welch.density().unwrap());
        let frequencies = numbers(&case["frequency_hz"]);
        assert_eq!(found.len(), expected.len());
        assert_eq!(welch.frequencies(), frequencies.len());
        let largest = expected.iter().copied().fold(0.0, f64::max);
        for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!((welch.frequency_hz(k) - frequencies[k]).abs() < 1e-12);
            // The mean is taken off first, so that at 0 Hz there is rounding alone.
            let error = (found - expected).abs();
            assert!(
                error < 1e-9 * expected + 1e-16 * largest,
                "{window}, {k}: {found} {expected}"
            );
        }
    }
}

/// A wave that fits the window has all of its power, A² / 2, in three bins, the outer two with a quarter
/// of the middle one's.
#[test]
fn a_wave_keeps_its_power() {
    let (rate_hz, window, amplitude) = (100.0, 50, 0.003);
    let wave = |k: u32| amplitude * (std::f64::consts::TAU * 10.0 * f64::from(k) / rate_hz).cos();
    let mut welch = Welch::new(window, rate_hz).unwrap();
    welch.add(&(0..5000).map(wave).collect::<Vec<_>>());
    let density = welch.density().unwrap();
    let power = density.iter().sum::<f64>() * 2.0;
    assert!((power - 0.5 * amplitude * amplitude).abs() < 1e-15);
    for side in [4, 6] {
        assert!((density[side] / density[5] - 0.25).abs() < 1e-9);
    }
    // 199 windows of 50 samples, 25 apart.
    assert_eq!(welch.windows(), 199);
}

/// Stretches on both sides of a gap give their own windows, one too short gives none, and nothing comes of
/// missing samples.
#[test]
fn tracks_are_cut_at_gaps() {
    let at = |k: usize| [0.3, 0.7, 1.1].map(|f| 0.01 * (f * k as f64).sin());
    let mut track = PointTrack::<Hand>::from_measured((0..60).map(|k| Some(Position::from(at(k)))));
    for k in [20, 21, 29] {
        track.set(k, None, Status::Missing);
    }
    let mut of_track = Welch::new(10, 100.0).unwrap();
    of_track.add_points(&track);

    let mut of_parts = Welch::new(10, 100.0).unwrap();
    for axis in 0..3 {
        for part in [0..20, 30..60] {
            of_parts.add(&part.map(|k| at(k)[axis]).collect::<Vec<_>>());
        }
    }
    assert_eq!(of_track.windows(), 3 * (3 + 5));
    assert_eq!(of_track.windows(), of_parts.windows());
    let (found, expected) = (of_track.density().unwrap(), of_parts.density().unwrap());
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() < 1e-18);
    }
}

#[test]
fn what_has_no_spectrum_says_so() {
    let setting = |window, rate_hz| match Welch::new(window, rate_hz) {
        Err(MotionError::Setting { setting, .. }) => setting,
        other => panic!("{other:?}"),
    };
    assert_eq!(setting(1, 100.0), "window");
    assert_eq!(setting(256, 0.0), "rate_hz");
    assert_eq!(setting(256, f64::NAN), "rate_hz");
    let mut welch = Welch::new(256, 100.0).unwrap();
    welch.add(&[0.0; 255]);
    assert_eq!(welch.density(), None);
}
