//! Curves through end conditions.

use inhand_curves::{curves, velocity};
use inhand_model::{Configuration, EndConditions, SegmentLayout};
use proptest::prelude::*;

use crate::{number, numbers, reference};

fn layout(samples: usize, rate_hz: f64) -> SegmentLayout {
    SegmentLayout {
        samples,
        rate_hz,
        object: false,
    }
}

/// Largest difference between two lists.
fn difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let differences = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max)
}

#[test]
fn agree_with_scipy() {
    let reference = &reference()["curves"];
    let values = |name: &str| -> Configuration { numbers(&reference[name]).try_into().unwrap() };
    let ends = EndConditions {
        first_m: values("first"),
        last_m: values("last"),
        first_velocity_m_s: values("first_velocity"),
        last_velocity_m_s: values("last_velocity"),
        object: None,
    };
    let samples = reference["samples"].as_u64().unwrap() as usize;
    let layout = layout(samples, number(&reference["rate_hz"]));
    for (name, curve) in [
        ("line", curves::line(&ends, layout)),
        ("minimum_jerk", curves::minimum_jerk(&ends, layout)),
        ("hermite", curves::hermite(&ends, layout)),
    ] {
        let worst = difference(curve.values_m(), &numbers(&reference[name]));
        assert!(worst < 1e-14, "{name}: {worst:e}");
    }
}

#[test]
fn short_layouts_have_an_answer() {
    let ends = EndConditions {
        first_m: [1.0; 15],
        last_m: [2.0; 15],
        first_velocity_m_s: [3.0; 15],
        last_velocity_m_s: [4.0; 15],
        object: None,
    };
    for curve in [curves::line, curves::minimum_jerk, curves::hermite] {
        assert_eq!(curve(&ends, layout(0, 100.0)).values_m(), &[0.0; 0]);
        assert_eq!(curve(&ends, layout(1, 100.0)).values_m(), &[1.0; 15]);
        assert_eq!(
            curve(&ends, layout(2, 100.0)).values_m(),
            [[1.0; 15], [2.0; 15]].concat()
        );
    }
    assert_eq!(curves::hold(&ends, layout(0, 100.0)).values_m(), &[0.0; 0]);
    assert_eq!(curves::hold(&ends, layout(3, 100.0)).values_m(), &[2.0; 45]);
}

fn configuration() -> impl Strategy<Value = Configuration> {
    prop::array::uniform15(-0.5..0.5)
}

fn ends() -> impl Strategy<Value = EndConditions> {
    let four = (
        configuration(),
        configuration(),
        configuration(),
        configuration(),
    );
    four.prop_map(
        |(first_m, last_m, first_velocity_m_s, last_velocity_m_s)| EndConditions {
            first_m,
            last_m,
            first_velocity_m_s,
            last_velocity_m_s,
            object: None,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn start_and_end_where_they_should(ends in ends(), samples in 2_usize..200, rate in 30.0..400.0) {
        let layout = layout(samples, rate);
        for curve in [curves::line, curves::minimum_jerk, curves::hermite] {
            let curve = curve(&ends, layout);
            prop_assert_eq!(curve.configuration_m(0), ends.first_m);
            prop_assert_eq!(curve.configuration_m(samples - 1), ends.last_m);
        }
    }

    /// A cubic is the one curve of its kind through its end conditions, so a segment sampled from
    /// a cubic comes back from its ends and their derivatives.
    #[test]
    fn hermite_reproduces_cubics(c in prop::array::uniform4(-1.0..1.0), samples in 2_usize..120) {
        let rate = 100.0;
        let layout = layout(samples, rate);
        let end = layout.duration_s();
        let value = |t: f64| c[0] + t * (c[1] + t * (c[2] + t * c[3]));
        let derivative = |t: f64| c[1] + t * (2.0 * c[2] + t * 3.0 * c[3]);
        let ends = EndConditions {
            first_m: [value(0.0); 15],
            last_m: [value(end); 15],
            first_velocity_m_s: [derivative(0.0); 15],
            last_velocity_m_s: [derivative(end); 15], object: None };
        let curve = curves::hermite(&ends, layout);
        for t in 0..samples {
            let expected = value(t as f64 / rate);
            prop_assert!((curve.configuration_m(t)[7] - expected).abs() < 1e-13);
        }
    }

    #[test]
    fn lines_move_at_constant_speed(ends in ends()) {
        let layout = layout(50, 100.0);
        let steps = velocity::steps(&curves::line(&ends, layout));
        for (i, (last, first)) in ends.last_m.iter().zip(&ends.first_m).enumerate() {
            let speed = (last - first) / layout.duration_s();
            prop_assert!(steps.iter().all(|step| (step[i] - speed).abs() < 1e-12));
        }
    }
}

#[test]
#[should_panic(expected = "the end conditions are")]
fn ends_that_are_no_number_are_refused() {
    let ends = EndConditions {
        first_m: [f64::NAN; 15],
        last_m: [0.0; 15],
        first_velocity_m_s: [0.0; 15],
        last_velocity_m_s: [0.0; 15],
        object: None,
    };
    curves::line(&ends, layout(10, 100.0));
}
