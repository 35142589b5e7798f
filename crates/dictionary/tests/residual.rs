//! Deviations from the cubic Hermite baseline: what must come out exactly.

use inhand_model::{
    EndConditions, PredictorWeights, Protocol, SegmentLayout, SmoothCurve, Trajectory,
};
use nalgebra::{DMatrix, DVector};

use crate::residual_data::{
    around_smooth, bump, conditions, deviations, displacement, ends, expected_m, layout, learn,
    mean_error_m, numbers, uniform,
};

#[test]
fn the_smooth_curve_itself_leaves_nothing_to_learn() {
    for object in [false, true] {
        let layout = layout(30, object);
        for x in [
            conditions(layout, 0, 40),
            // Numbers that no rounding touches.
            conditions(layout, 0, 40).map(|v| (v * 1024.0).round() / 1024.0),
        ] {
            let nothing = DMatrix::zeros(layout.rows(), 40);
            let residual = learn(&around_smooth(layout, &x, &nothing, 10));
            assert_eq!(residual.primitives.shape(), (layout.rows(), 0));
            assert_eq!(residual.expectation.weights(), PredictorWeights::default());
            assert!(residual.validation.smooth_error_m < 1e-12);
            assert_eq!(
                residual.validation.error_m,
                residual.validation.smooth_error_m
            );
            assert_eq!(residual.unexplained_m2, 1e-12);
            let deviation = expected_m(&residual, &numbers(99, layout));
            assert!(deviation.len() == layout.rows() && deviation.amax() < 1e-12);
        }
    }
}

#[test]
fn a_deviation_that_goes_with_the_displacement_is_found_again() {
    for object in [false, true] {
        let layout = layout(30, object);
        let made = |from: usize, count: usize| {
            let x = conditions(layout, from, count);
            let deviations_m = deviations(layout, count, |segment, coordinate, s| {
                0.2 * bump(s) * displacement(&x, segment, coordinate)
            });
            (x, deviations_m)
        };
        let (x, known) = made(0, 300);
        let residual = learn(&around_smooth(layout, &x, &known, 50));
        assert!(residual.validation.error_m < 0.01 * residual.validation.smooth_error_m);
        let (x, unseen) = made(1000, 20);
        for (x, unseen) in x.column_iter().zip(unseen.column_iter()) {
            let error = expected_m(&residual, &x.into_owned()) - unseen;
            // The object shares the weight of the fingers' profile, which makes up for their ridge:
            // their displacements are small beside what velocities could do, its are not.
            for (rows, tolerance) in [
                (0..layout.finger_rows(), 0.01),
                (layout.finger_rows()..layout.rows(), 0.02),
            ] {
                let size = unseen.rows_range(rows.clone()).norm();
                assert!(error.rows_range(rows).norm() <= tolerance * size);
            }
        }
    }
}

#[test]
fn velocities_have_profiles_of_their_own() {
    let layout = layout(30, false);
    let made = |from: usize, count: usize| {
        let x = conditions(layout, from, count);
        let deviations_m = deviations(layout, count, |segment, c, s| {
            let x = x.column(segment);
            let way = |velocity: f64| layout.duration_s() * velocity;
            bump(s) * (0.2 * (1.0 - s) * way(x[30 + c]) - 0.3 * s * way(x[45 + c]))
        });
        (x, deviations_m)
    };
    let (x, known) = made(0, 300);
    let residual = learn(&around_smooth(layout, &x, &known, 50));
    let (x, unseen) = made(1000, 20);
    let smooth = mean_error_m(&residual, &x, &unseen, 0.0);
    assert!(mean_error_m(&residual, &x, &unseen, 1.0) <= 0.01 * smooth);
}

#[test]
fn one_demonstration_over_and_over_is_expected_as_it_was() {
    let layout = layout(30, true);
    let one = numbers(3, layout);
    let x = DMatrix::from_columns(&vec![one.clone(); 24]);
    let known = deviations(layout, 24, |_, c, s| {
        1e-3 * bump(s) * (c as f64 + 3.0 * s).sin()
    });
    let residual = learn(&around_smooth(layout, &x, &known, 6));
    let error = expected_m(&residual, &one) - known.column(0);
    assert!(error.amax() < 1e-12, "{}", error.amax());
    // Known to a micrometre, no better.
    assert!(residual.covariance_m2.clone().cholesky().is_some());
    assert!((residual.covariance_m2.trace() / residual.covariance_m2.nrows() as f64) >= 0.99e-12);
}

#[test]
fn what_was_seen_once_is_no_expectation_but_a_spread() {
    // There is nothing to leave out: the cubic Hermite baseline is expected, and the one deviation says how
    // far motion strays from it.
    let layout = layout(30, false);
    let x = conditions(layout, 0, 1);
    let known = deviations(layout, 1, |_, c, s| 2e-3 * bump(s) * (c as f64).cos());
    let residual = learn(&around_smooth(layout, &x, &known, 1));
    assert_eq!(residual.validation.folds, 0);
    assert_eq!(residual.expectation.weights(), PredictorWeights::default());
    assert_eq!(expected_m(&residual, &numbers(0, layout)).amax(), 0.0);
    assert_eq!(residual.primitives.ncols(), 5);
    let trace_m2 = residual.covariance_m2.trace();
    let size_m2 = known.norm_squared();
    assert!((trace_m2 - size_m2).abs() < 1e-7 * size_m2);
    // Widths of a normal distribution where nothing was measured.
    let widths: Vec<_> = (residual.calibration.iter())
        .map(|c| c.mahalanobis)
        .collect();
    assert!((widths[0] - 1.538_172_254_455).abs() < 1e-9);
    assert!((widths[1] - 2.795_483_482_915).abs() < 1e-9);
}

#[test]
fn a_bias_that_is_not_expected_is_in_the_spread() {
    // One take of two segments: no stretch of it holds one, so nothing can be left out, and the
    // same deviation twice is no reason to be sure that there will be none.
    let layout = layout(30, false);
    let x = conditions(layout, 0, 2);
    let known = deviations(layout, 2, |_, c, s| 2e-3 * bump(s) * (c as f64).cos());
    let residual = learn(&around_smooth(layout, &x, &known, 2));
    assert_eq!(residual.validation.folds, 0);
    let trace_m2 = residual.covariance_m2.trace();
    let size_m2 = known.column(0).norm_squared();
    assert!((trace_m2 - size_m2).abs() < 1e-7 * size_m2);
}

#[test]
fn primitives_are_orthonormal_and_each_moves_one_part() {
    let layout = layout(30, true);
    let x = conditions(layout, 0, 200);
    let known = deviations(layout, 200, |i, c, s| {
        let wave = |k: usize| (std::f64::consts::PI * (k as f64 + 1.0) * s).sin();
        (0..4).map(|k| 1e-3 * wave(k) * uniform(&[i, c, k])).sum()
    });
    let residual = learn(&around_smooth(layout, &x, &known, 50));
    let b = &residual.primitives;
    let rank = b.ncols();
    assert!((b.transpose() * b - DMatrix::identity(rank, rank)).amax() < 1e-12);
    // Twelve dimensions a finger, 24 of the object: all of them, and nothing more.
    assert_eq!(residual.expectation.blocks(), [12, 12, 12, 12, 12, 24]);
    assert!(residual.unexplained_m2 <= 1e-12);
    let mut start = 0;
    for (part, size) in residual.expectation.blocks().iter().enumerate() {
        for j in start..start + size {
            for row in 0..layout.rows() {
                let of = if row < layout.finger_rows() {
                    row % 15 / 3
                } else {
                    5
                };
                assert!(of == part || b[(row, j)] == 0.0);
            }
        }
        start += size;
    }
    // The motion stays at its ends.
    for row in (0..15).chain(layout.finger_rows() - 15..layout.finger_rows() + 6) {
        assert!(b.row(row).amax() == 0.0);
    }
}

#[test]
fn smooth_curves_are_those_of_the_baselines() {
    type Baseline = fn(&EndConditions, SegmentLayout) -> Trajectory;
    let baselines: [(SmoothCurve, Baseline); 3] = [
        (SmoothCurve::Hermite, inhand_curves::curves::hermite),
        (
            SmoothCurve::MinimumJerk,
            inhand_curves::curves::minimum_jerk,
        ),
        (SmoothCurve::Line, inhand_curves::curves::line),
    ];
    for ((curve, baseline), object) in baselines.iter().flat_map(|b| [(b, false), (b, true)]) {
        let layout = layout(23, object);
        let basis = curve.basis(layout);
        for i in 0..5 {
            let x = numbers(i, layout);
            let expected = baseline(&ends(&x), layout);
            let smooth: DVector<f64> = &basis * &x;
            assert_eq!(expected.values_m().len(), layout.finger_rows());
            for (smooth, value) in smooth.iter().zip(expected.values_m()) {
                assert!((smooth - value).abs() < 1e-15, "{curve:?}");
            }
        }
    }
}

#[test]
fn with_little_to_learn_held_out_deviations_are_those_from_the_best_curve() {
    let layout = layout(30, false);
    let x = conditions(layout, 0, 8);
    let straight = (SmoothCurve::Line.basis(layout) - SmoothCurve::Hermite.basis(layout)) * &x;
    let segments = around_smooth(layout, &x, &straight, 4);
    assert_eq!(learn(&segments).curve, SmoothCurve::Hermite);
    let residual = learn(&segments.under(Protocol::HeldOut));
    assert_eq!(residual.curve, SmoothCurve::Line);
    assert!(residual.validation.error_m < 1e-12);
}

#[test]
fn an_object_may_turn_by_more_than_half_a_turn() {
    // The two poses alone would tell the shorter way back, the column goes on.
    let layout = layout(30, true);
    let mut x = conditions(layout, 0, 40);
    for i in 0..40 {
        // 216 degrees about z.
        x[(66, i)] = 0.0;
        x[(67, i)] = 0.0;
        x[(68, i)] = 0.025 * 1.2 * std::f64::consts::PI;
    }
    let nothing = DMatrix::zeros(layout.rows(), 40);
    let residual = learn(&around_smooth(layout, &x, &nothing, 10));
    assert_eq!(residual.primitives.ncols(), 0);
}
