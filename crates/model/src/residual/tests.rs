//! The smooth curve, and end conditions as numbers.

use nalgebra::{DVector, Isometry3, Translation3, UnitQuaternion, Vector3};

use super::{SmoothCurve, ends_len};
use crate::frame::Pose;
use crate::segments::{EndConditions, ObjectEnds, SegmentLayout};

fn layout(samples: usize, object: bool) -> SegmentLayout {
    SegmentLayout {
        samples,
        rate_hz: 50.0,
        object,
    }
}

fn ends(object: bool) -> EndConditions {
    let configuration = |first: f64| std::array::from_fn(|c| first + 0.01 * c as f64);
    let pose = |x: f64, turned: UnitQuaternion<f64>| {
        Pose::new(Isometry3::from_parts(
            Translation3::new(x, x + 0.1, x + 0.2),
            turned,
        ))
    };
    let start = UnitQuaternion::from_euler_angles(0.4, -0.2, 1.0);
    // A quarter of a turn about the hand's z.
    let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * std::f64::consts::FRAC_PI_2);
    EndConditions {
        first_m: configuration(1.0),
        last_m: configuration(2.0),
        first_velocity_m_s: configuration(3.0),
        last_velocity_m_s: configuration(4.0),
        object: object.then(|| ObjectEnds {
            first: pose(5.0, start),
            last: pose(6.0, turn * start),
        }),
    }
}

#[test]
fn end_conditions_have_their_order() {
    let without = ends(false).to_vector(layout(5, false)).unwrap();
    assert_eq!(without.len(), 60);
    assert_eq!(ends_len(layout(5, false)), 60);
    for (i, value) in without.iter().enumerate() {
        let expected = 1.0 + (i / 15) as f64 + 0.01 * (i % 15) as f64;
        assert!((value - expected).abs() < 1e-15);
    }
    let with = ends(true).to_vector(layout(5, true)).unwrap();
    assert_eq!(with.len(), 69);
    assert_eq!(with.rows(0, 60), without);
    let quarter_m = 0.025 * std::f64::consts::FRAC_PI_2;
    let expected = [5.0, 5.1, 5.2, 6.0, 6.1, 6.2, 0.0, 0.0, quarter_m];
    for (found, expected) in with.rows(60, 9).iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
    // The object is left away where the layout has none, and missed where it has.
    assert_eq!(ends(true).to_vector(layout(5, false)).unwrap(), without);
    assert!(ends(false).to_vector(layout(5, true)).is_none());
}

#[test]
fn the_smooth_curve_has_its_end_conditions() {
    for object in [false, true] {
        for samples in [2, 3, 50] {
            let layout = layout(samples, object);
            let x = ends(object).to_vector(layout).unwrap();
            let curve: DVector<f64> = SmoothCurve::Hermite.basis(layout) * &x;
            let last = samples - 1;
            for c in 0..15 {
                assert_eq!(curve[c], x[c]);
                assert_eq!(curve[15 * last + c], x[15 + c]);
            }
            if object {
                for a in 0..3 {
                    assert_eq!(curve[layout.object_row(0, a)], x[60 + a]);
                    assert_eq!(curve[layout.object_row(last, a)], x[63 + a]);
                    assert_eq!(curve[layout.object_row(0, 3 + a)], 0.0);
                    assert_eq!(curve[layout.object_row(last, 3 + a)], x[66 + a]);
                }
            }
        }
    }
}

#[test]
fn cubics_are_given_back_by_their_ends() {
    // p(t) = a + b t + c t² + d t³ for each coordinate, t in seconds.
    let layout = layout(26, false);
    let seconds = layout.duration_s();
    assert_eq!(seconds, 0.5);
    let coefficients = |i: usize| {
        let i = i as f64;
        [0.1 * i, 0.3 - 0.05 * i, 0.2 * i - 1.0, 1.5 - 0.3 * i]
    };
    let position = |i: usize, t: f64| {
        let [a, b, c, d] = coefficients(i);
        a + t * (b + t * (c + t * d))
    };
    let velocity = |i: usize, t: f64| {
        let [_, b, c, d] = coefficients(i);
        b + t * (2.0 * c + t * 3.0 * d)
    };
    let x = DVector::from_fn(60, |k, _| match (k / 15, k % 15) {
        (0, i) => position(i, 0.0),
        (1, i) => position(i, seconds),
        (2, i) => velocity(i, 0.0),
        (_, i) => velocity(i, seconds),
    });
    let curve = SmoothCurve::Hermite.basis(layout) * x;
    for t in 0..26 {
        for i in 0..15 {
            assert!((curve[15 * t + i] - position(i, t as f64 / 50.0)).abs() < 1e-14);
        }
    }
}

#[test]
fn motion_elsewhere_has_the_same_curve_there() {
    for object in [false, true] {
        let layout = layout(20, object);
        let basis = SmoothCurve::Hermite.basis(layout);
        let shift = DVector::from_fn(ends_len(layout), |k, _| match k {
            0..30 | 60..66 => 0.25,
            _ => 0.0,
        });
        for (row, value) in (basis * shift).iter().enumerate() {
            let position = row < layout.finger_rows() || (row - layout.finger_rows()) % 6 < 3;
            let expected = if position { 0.25 } else { 0.0 };
            assert!((value - expected).abs() < 1e-15);
        }
    }
}

#[test]
#[should_panic(expected = "a first and a last sample")]
fn a_single_sample_is_no_curve() {
    SmoothCurve::Hermite.basis(layout(1, false));
}
