//! Deviations from the cubic Hermite baseline against plain NumPy and SciPy
//! (`reference/make_residual_reference.py`).

use inhand_dictionary::learn_residual;
use inhand_model::{Residual, SegmentLayout, SmoothCurve};
use nalgebra::{DMatrix, DVector};
use serde_json::Value;

use crate::pca::numbers as of_json;
use crate::residual_data::{
    around_smooth, bump, conditions, deviations, displacement, layout, numbers, uniform,
};

/// The deviations of the reference: a shared profile, something of each finger, and noise.
fn made_up(layout: SegmentLayout, x: &DMatrix<f64>) -> DMatrix<f64> {
    deviations(layout, x.ncols(), |i, c, s| {
        let moved = |c| displacement(x, i, c);
        if c >= 15 {
            return bump(s) * (0.2 * moved(c) + 0.001 * uniform(&[9, i, c - 15]));
        }
        let way = layout.duration_s() * x[(30 + c, i)];
        let own = 0.3 * moved(c) + 0.1 * way * (1.0 - 2.0 * s);
        let local = 0.004 * (60.0 * moved(c / 3 * 3) + c as f64).sin();
        let noise = 0.002 * uniform(&[7, i, c]) + 0.001 * s * uniform(&[8, i, c]);
        bump(s) * (own + local + noise)
    })
}

fn learned(layout: SegmentLayout) -> Residual {
    let x = conditions(layout, 0, 48);
    let segments = around_smooth(layout, &x, &made_up(layout, &x), 16);
    learn_residual(&segments, 5).unwrap()
}

fn reference(object: bool) -> Value {
    let all: Value = serde_json::from_str(include_str!("reference/residual.json")).unwrap();
    all[if object { "object" } else { "hand" }].clone()
}

/// Agreement of numbers, relative to the largest of them.
fn close(found: &[f64], expected: &Value, tolerance: f64, what: &str) {
    let expected = of_json(expected);
    assert_eq!(found.len(), expected.len(), "{what}");
    let size = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert!(
            (found - expected).abs() <= tolerance * size,
            "{what} {i}: {found} instead of {expected}"
        );
    }
}

/// What follows from the segments without any choice.
const EXACT: f64 = 1e-9;
/// What depends on the weights: a general minimiser of the sum of distances stops where this
/// changes by less, and so does ours.
const CHOSEN: f64 = 1e-3;

#[test]
fn choices_and_spread_agree() {
    for object in [false, true] {
        let residual = learned(layout(8, object));
        let r = reference(object);
        close(
            &[residual.unexplained_m2],
            &r["unexplained_m2"],
            EXACT,
            "unexplained",
        );
        close(
            residual.ends_mean.as_slice(),
            &r["ends_mean"],
            EXACT,
            "mean",
        );
        let variances: Vec<f64> = residual
            .ends_covariance
            .diagonal()
            .iter()
            .copied()
            .collect();
        close(&variances, &r["ends_variances"], EXACT, "ends");

        let bandwidths = residual.expectation.bandwidths();
        assert_eq!(r["hand_width"], bandwidths.hand);
        assert_eq!(r["finger_width"], bandwidths.finger);
        let weights = residual.expectation.weights();
        close(
            &[weights.profile, weights.hand, weights.finger],
            &r["weights"],
            CHOSEN,
            "weights",
        );
        let validation = residual.validation;
        assert_eq!((validation.folds, validation.segments), (3, 48));
        for (found, part, tolerance) in [
            (validation.smooth_error_m, "smooth_error_m", EXACT),
            (validation.error_m, "error_m", CHOSEN),
            (validation.standard_error_m, "standard_error_m", CHOSEN),
        ] {
            close(&[found], &r[part], tolerance, part);
        }
        let widths: Vec<f64> = residual.calibration.iter().map(|c| c.mahalanobis).collect();
        close(&widths, &r["widths"], CHOSEN, "corridors");
        let b = &residual.primitives;
        let spread = b * &residual.covariance_m2 * b.transpose();
        let variances: Vec<f64> = spread.diagonal().iter().copied().collect();
        close(&variances, &r["variances_m2"], CHOSEN, "variances");
    }
}

#[test]
fn profile_and_kernel_regression_agree() {
    for object in [false, true] {
        let layout = layout(8, object);
        let residual = learned(layout);
        let expectation = &residual.expectation;
        for (q, r) in reference(object)["queries"]
            .as_array()
            .unwrap()
            .iter()
            .enumerate()
        {
            let x = numbers(1000 + q, layout);
            let distances = expectation.distances(&x);
            let parts = expectation.parts_m(&x, &distances, expectation.bandwidths());
            for (k, name) in ["profile", "hand", "finger"].into_iter().enumerate() {
                let part: DVector<f64> = &residual.primitives * parts.column(k);
                close(part.as_slice(), &r["parts"][k], EXACT, name);
            }
            let expected: DVector<f64> = &residual.primitives * residual.expected_m(&x);
            close(expected.as_slice(), &r["expected"], CHOSEN, "expected");
            let smooth: DVector<f64> = SmoothCurve::Hermite.basis(layout) * &x;
            close(smooth.as_slice(), &r["smooth"], EXACT, "smooth");
        }
    }
}
