//! Paths, speeds, spectral arc length, jerk.

use std::f64::consts::PI;

use inhand_curves::smoothness::{
    PathMeasures, log_dimensionless_jerk, path_measures, spectral_arc_length, speeds_m_s,
};
use inhand_model::{Hand, Position};
use proptest::prelude::*;

use crate::{motion_reference, number, numbers};

fn path(flat: &[f64]) -> Vec<Position<Hand>> {
    flat.chunks_exact(3)
        .map(|p| Position::new(p[0], p[1], p[2]))
        .collect()
}

#[test]
fn agree_with_numpy_and_scipy() {
    let reference = motion_reference();
    let paths = reference["paths"].as_array().unwrap();
    assert_eq!(paths.len(), 5);
    for expected in paths {
        let path = path(&numbers(&expected["path"]));
        let rate_hz = number(&expected["rate_hz"]);
        let found = path_measures(&path, rate_hz, number(&expected["static_speed_m_s"])).unwrap();
        for (name, found) in [
            ("length_m", found.length_m),
            ("peak_speed_m_s", found.peak_speed_m_s),
            ("static_share", found.static_share),
            ("sparc", found.sparc),
            ("ldlj_v", found.ldlj),
        ] {
            let expected = number(&expected[name]);
            assert!(
                (found - expected).abs() <= 1e-9 * expected.abs().max(1.0),
                "{name}: {found}, expected {expected}"
            );
        }
    }
}

/// A fingertip that goes to and fro on a line as a cosine: its speed is known.
#[test]
fn a_cosine_has_the_speed_of_its_derivative() {
    let (amplitude_m, frequency_hz, rate_hz) = (0.02, 1.0, 1000.0);
    let omega = 2.0 * PI * frequency_hz;
    let path: Vec<Position<Hand>> = (0..=1000)
        .map(|k| {
            Position::new(
                0.0,
                amplitude_m * (omega * f64::from(k) / rate_hz).cos(),
                0.0,
            )
        })
        .collect();
    let found = path_measures(&path, rate_hz, 1e-9).unwrap();
    assert!((found.length_m - 4.0 * amplitude_m).abs() < 1e-6);
    assert!((found.peak_speed_m_s / (amplitude_m * omega) - 1.0).abs() < 1e-4);
}

/// Minimum jerk has the bell shape 30 (s² - 2 s³ + s⁴), whose integral of squared second derivative is
/// 720 and whose peak is 1.875: ln(720 / 1.875²) = 5.3234 for any distance and duration.
#[test]
fn minimum_jerk_has_its_known_log_dimensionless_jerk() {
    for (count, rate_hz) in [(4000, 100.0), (9000, 7.0)] {
        let bell: Vec<f64> = (0..=count)
            .map(|k| f64::from(k) / f64::from(count))
            .map(|s| 30.0 * (s * (1.0 - s)).powi(2))
            .collect();
        let found = log_dimensionless_jerk(&bell, rate_hz).unwrap();
        let expected = -(720.0_f64 / 1.875_f64.powi(2)).ln();
        assert!((found - expected).abs() < 5e-3, "{found}, {expected}");
    }
}

#[test]
fn more_ripples_are_less_smooth() {
    let speed = |ripples: f64| -> Vec<f64> {
        (0..100)
            .map(|k| f64::from(k) / 99.0)
            .map(|s| (PI * s).sin().powi(2) * (1.0 + 0.4 * (2.0 * PI * ripples * s).cos()))
            .collect()
    };
    let arcs = [0.0, 3.0, 5.0].map(|n| spectral_arc_length(&speed(n), 100.0).unwrap());
    let jerks = [0.0, 3.0, 5.0].map(|n| log_dimensionless_jerk(&speed(n), 100.0).unwrap());
    for [plain, some, more] in [arcs, jerks] {
        assert!(
            0.0 > plain && plain > some && some > more,
            "{plain} {some} {more}"
        );
    }
}

#[test]
fn paths_together_measure_as_each_alone() {
    let path = |step: f64| -> Vec<Position<Hand>> {
        (0..80)
            .map(|k| Position::new(0.05 * (f64::from(k) * step).sin(), 0.01 * step, 0.0))
            .collect()
    };
    let (slow, fast, mut gap) = (path(0.03), path(0.2), path(0.1));
    gap[20] = Position::new(f64::NAN, 0.0, 0.0);
    let measures = PathMeasures::new(80, 100.0, 0.005).unwrap();
    let alone = |path| path_measures(path, 100.0, 0.005);
    let found = measures.of([&slow, &gap, &fast, &slow[1..]]);
    assert!(alone(&slow).is_some_and(|facts| facts.sparc < -1.0));
    assert_eq!(found, [alone(&slow), None, alone(&fast), None]);
}

#[test]
fn what_cannot_be_measured_has_no_number() {
    let still = vec![Position::<Hand>::new(0.1, 0.0, 0.0); 50];
    let found = path_measures(&still, 100.0, 0.005).unwrap();
    assert_eq!((found.length_m, found.static_share), (0.0, 1.0));
    assert!(found.sparc.is_nan() && found.ldlj.is_nan());

    assert_eq!(path_measures(&still[..1], 100.0, 0.005), None);
    assert_eq!(path_measures(&still[..0], 100.0, 0.005), None);
    let short = path_measures(&still[..3], 100.0, 0.005).unwrap();
    assert!(short.ldlj.is_nan());

    let mut gap = still.clone();
    gap[20] = Position::new(f64::NAN, 0.0, 0.0);
    assert_eq!(path_measures(&gap, 100.0, 0.005), None);
    assert_eq!(speeds_m_s(&gap, 100.0), None);
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(path_measures(&still, bad, 0.005), None);
        assert_eq!(path_measures(&still, 100.0, bad), None);
        assert_eq!(spectral_arc_length(&[0.1, 0.2, 0.1], bad), None);
        assert_eq!(log_dimensionless_jerk(&[0.1, 0.2, 0.1], bad), None);
    }
    for speeds in [
        &[][..],
        &[1.0],
        &[1.0, -0.5, 1.0],
        &[1.0, f64::NAN, 1.0],
        &[0.0; 5],
    ] {
        assert_eq!(spectral_arc_length(speeds, 100.0), None, "{speeds:?}");
        assert_eq!(log_dimensionless_jerk(speeds, 100.0), None, "{speeds:?}");
    }
    // At 20 Hz the spectrum ends at 10 Hz: a cut-off there is not below it.
    assert_eq!(spectral_arc_length(&[0.1, 0.2, 0.1], 20.0), None);
    assert!(spectral_arc_length(&[0.1, 0.2, 0.1], 20.5).is_some());
    // A constant speed has no jerk.
    assert_eq!(log_dimensionless_jerk(&[0.5; 20], 100.0), None);
    // Nor has a straight line at constant speed, as rounding leaves it.
    let line: Vec<Position<Hand>> = (0..100)
        .map(|k| Position::new(0.1, 0.2 + 0.0038 * f64::from(k) / 99.0, -0.3))
        .collect();
    let speeds = speeds_m_s(&line, 100.0).unwrap();
    assert!(speeds.windows(2).any(|pair| pair[0] != pair[1]));
    assert_eq!(log_dimensionless_jerk(&speeds, 100.0), None);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Neither measure of smoothness knows the unit of length; the arc does not know where in the window
    /// the motion is (as long as the padded length stays), the jerk not at what rate it was sampled.
    #[test]
    fn smoothness_has_no_unit(
        speeds in prop::collection::vec(0.01..1.0, 40..60), scale in 0.01..100.0, shift in 0..4_usize
    ) {
        let rest = |before: usize| [vec![0.0; before], speeds.clone(), vec![0.0; 4 - before]].concat();
        let (plain, shifted) = (rest(0), rest(shift));
        let scaled: Vec<f64> = plain.iter().map(|v| v * scale).collect();
        let of = |v: &[f64]| spectral_arc_length(v, 100.0).unwrap();
        prop_assert!((of(&scaled) - of(&plain)).abs() < 1e-9);
        prop_assert!((of(&shifted) - of(&plain)).abs() < 1e-9);
        let of = |v: &[f64], rate| log_dimensionless_jerk(v, rate).unwrap();
        prop_assert!((of(&scaled, 100.0) - of(&plain, 100.0)).abs() < 1e-9);
        prop_assert!((of(&plain, 240.0) - of(&plain, 100.0)).abs() < 1e-9);
    }

    /// Where the path lies does not matter; backwards it is as long, as fast and as smooth.
    #[test]
    fn a_path_backwards_measures_the_same(
        steps in prop::collection::vec((-0.01..0.01, -0.01..0.01, -0.01..0.01), 8..40), move_m in -1.0..1.0
    ) {
        let path: Vec<Position<Hand>> = steps.iter().map(|&(x, y, z)| Position::new(x, y, z)).collect();
        let other: Vec<Position<Hand>> = (steps.iter().rev())
            .map(|&(x, y, z)| Position::new(x + move_m, y - move_m, z))
            .collect();
        let [a, b] = [path, other].map(|path| path_measures(&path, 100.0, 0.5).unwrap());
        prop_assert!((a.length_m - b.length_m).abs() < 1e-12);
        prop_assert!((a.peak_speed_m_s - b.peak_speed_m_s).abs() < 1e-9);
        prop_assert!((a.sparc - b.sparc).abs() < 1e-9);
        prop_assert!((a.ldlj - b.ldlj).abs() < 1e-9);
    }
}
