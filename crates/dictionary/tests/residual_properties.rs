//! Deviations from the cubic Hermite baseline: what holds for any segments.

use inhand_model::{Bandwidths, Residual, SegmentLayout, SegmentOrigin, Segments};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use proptest::prelude::*;

use crate::residual_data::{
    around_smooth, bump, conditions, deviations, displacement, ends, expected_m, layout, learn,
    mean_error_m, normal, numbers, uniform,
};

/// Deviations without relation to the boundary conditions, of five smooth shapes, metres.
fn noise(layout: SegmentLayout, seed: usize, count: usize, size_m: f64) -> DMatrix<f64> {
    deviations(layout, count, |i, c, s| {
        let shape = |k: usize| (std::f64::consts::PI * (k as f64 + 1.0) * s).sin();
        let each = |k: usize| normal(&[seed, i, c, k]) / (1.0 + k as f64);
        size_m * (0..5).map(|k| shape(k) * each(k)).sum::<f64>()
    })
}

/// Deviations with a relation to the boundary conditions, and some noise, metres.
fn related(layout: SegmentLayout, x: &DMatrix<f64>, seed: usize) -> DMatrix<f64> {
    let noise = noise(layout, seed, x.ncols(), 3e-4);
    let known = deviations(layout, x.ncols(), |i, c, s| {
        let moved = displacement(x, i, c);
        bump(s) * (0.2 * moved + 0.003 * (80.0 * displacement(x, i, c / 3 * 3)).sin())
    });
    known + noise
}

/// Share of points of deviations (rows x n) within each of the stated corridors.
fn coverage(residual: &Residual, x: &DMatrix<f64>, deviations_m: &DMatrix<f64>) -> [f64; 2] {
    let inverses: Vec<Matrix3<f64>> = (0..residual.layout.finger_rows() / 3)
        .map(|i| {
            let rows = residual.primitives.rows(3 * i, 3).into_owned();
            let spread = &rows * &residual.covariance_m2 * rows.transpose();
            let spread = Matrix3::from_fn(|a, b| spread[(a, b)]);
            (spread + Matrix3::identity() * residual.unexplained_m2)
                .try_inverse()
                .unwrap()
        })
        .collect();
    let (mut inside, mut all) = ([0, 0], 0);
    for (x, wanted) in x.column_iter().zip(deviations_m.column_iter()) {
        let error: DVector<f64> = wanted - expected_m(residual, &x.into_owned());
        for (i, inverse) in inverses.iter().enumerate() {
            let error = Vector3::new(error[3 * i], error[3 * i + 1], error[3 * i + 2]);
            let distance = error.dot(&(inverse * error)).sqrt();
            for (inside, corridor) in inside.iter_mut().zip(&residual.calibration) {
                *inside += usize::from(distance <= corridor.mahalanobis);
            }
            all += 1;
        }
    }
    inside.map(|inside| f64::from(inside as u32) / f64::from(all))
}

#[test]
fn corridors_hold_what_they_say_for_fresh_draws() {
    let layout = layout(20, false);
    for (seed, count) in [(1, 120), (2, 600)] {
        let x = conditions(layout, 0, count);
        let known = noise(layout, seed, count, 1e-3);
        let residual = learn(&around_smooth(layout, &x, &known, count / 6));
        let fresh = noise(layout, seed + 100, 300, 1e-3);
        let [half, most] = coverage(&residual, &conditions(layout, 5000, 300), &fresh);
        assert!((half - 0.5).abs() < 0.05, "{count}: {half}");
        assert!((most - 0.95).abs() < 0.03, "{count}: {most}");
    }
}

#[test]
fn weights_go_to_nothing_as_noise_is_told_from_motion() {
    let layout = layout(20, false);
    let weights = |related_share: f64| {
        let x = conditions(layout, 0, 180);
        let known = related(layout, &x, 3) * related_share
            + noise(layout, 4, 180, 2e-3) * (1.0 - related_share);
        let residual = learn(&around_smooth(layout, &x, &known, 30));
        let w = residual.expectation.weights();
        w.profile + w.hand + w.finger
    };
    assert!(weights(1.0) > 1.0, "{}", weights(1.0));
    assert!(weights(0.0) < 0.2, "{}", weights(0.0));
}

fn bits(residual: &Residual) -> Vec<u64> {
    let w = residual.expectation.weights();
    (residual.primitives.iter())
        .chain(residual.covariance_m2.iter())
        .chain(residual.ends_covariance.iter())
        .chain(residual.expectation.profile().iter())
        .chain(residual.expectation.answers_m().iter())
        .chain([&w.profile, &w.hand, &w.finger, &residual.unexplained_m2])
        .chain(residual.calibration.iter().map(|c| &c.mahalanobis))
        .map(|v| v.to_bits())
        .collect()
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for object in [false, true] {
        let layout = layout(20, object);
        let x = conditions(layout, 0, 240);
        let segments = around_smooth(layout, &x, &related(layout, &x, 5), 30);
        let of_threads = |threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap()
                .install(|| learn(&segments))
        };
        let one = of_threads(1);
        for threads in [2, 4] {
            let other = of_threads(threads);
            assert!(one == other && bits(&one) == bits(&other), "{threads}");
        }
    }
}

/// Like [`around_smooth`], with takes in another order and under other numbers.
fn permuted(
    layout: SegmentLayout,
    x: &DMatrix<f64>,
    known: &DMatrix<f64>,
    per_take: usize,
    order: &[usize],
) -> Segments {
    let plain = around_smooth(layout, x, known, per_take);
    let segments: Vec<usize> = (order.iter())
        .flat_map(|take| take * per_take..(take + 1) * per_take)
        .collect();
    let origins = (segments.iter().enumerate())
        .map(|(place, &segment)| SegmentOrigin {
            take: place / per_take,
            start: plain.origins()[segment].start,
        })
        .collect();
    let ends = segments.iter().map(|&i| plain.ends()[i]).collect();
    let columns = plain.columns_m().select_columns(&segments);
    Segments::new(layout, columns, origins, ends, 0).unwrap()
}

fn close(a: &DVector<f64>, b: &DVector<f64>, tolerance: f64) -> bool {
    (a - b).amax() <= tolerance * b.amax().max(1e-12)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, ..ProptestConfig::default() })]

    #[test]
    fn noise_makes_no_plan_worse(
        seed in 0_usize..1_000_000,
        takes in 1_usize..6,
        per_take in 5_usize..30,
        object in any::<bool>(),
    ) {
        let layout = layout(12, object);
        let count = takes * per_take;
        let x = conditions(layout, seed, count);
        let known = noise(layout, seed, count, 1e-3);
        let residual = learn(&around_smooth(layout, &x, &known, per_take));
        let validation = residual.validation;
        prop_assert!(validation.error_m <= validation.smooth_error_m * (1.0 + 1e-12));
        // On segments that were not there: what the cubic Hermite baseline does. What chance can do harm falls
        // with the segments (worst of 2700 draws: half of this).
        let x = conditions(layout, seed + 10_000, 60);
        let fresh = noise(layout, seed + 1, 60, 1e-3);
        let smooth = mean_error_m(&residual, &x, &fresh, 0.0);
        let expected = mean_error_m(&residual, &x, &fresh, 1.0);
        prop_assert!(
            expected <= (1.0 + 1.0 / count as f64) * smooth,
            "{expected} {smooth} of {count}"
        );
    }

    #[test]
    fn lengths_scale(seed in 0_usize..1_000_000, power in -1_i32..3) {
        // A power of two: no rounding, so what differs is what has a length of its own (noise of a
        // micrometre, distances of a hundredth of a millimetre).
        let layout = layout(12, true);
        let factor = 2.0_f64.powi(power);
        let x = conditions(layout, seed, 80);
        let known = related(layout, &x, seed);
        let plain = learn(&around_smooth(layout, &x, &known, 20));
        let scaled = learn(&around_smooth(layout, &(&x * factor), &(&known * factor), 20));
        for q in 0..5 {
            let query = numbers(seed + 5000 + q, layout);
            let expected = expected_m(&plain, &query) * factor;
            let found = expected_m(&scaled, &(query * factor));
            prop_assert!(close(&found, &expected, 1e-2));
        }
        let widths = [&plain, &scaled].map(|r| r.expectation.bandwidths());
        prop_assert_eq!(widths[0], widths[1]);
    }

    #[test]
    fn a_finger_does_the_same_elsewhere(
        seed in 0_usize..1_000_000,
        shift in prop::array::uniform3(-0.1_f64..0.1),
        object in any::<bool>(),
    ) {
        let layout = layout(12, object);
        let x = conditions(layout, seed, 80);
        let residual = learn(&around_smooth(layout, &x, &related(layout, &x, seed), 20));
        let query = numbers(seed + 5000, layout);
        let mut moved = query.clone();
        for c in (0..30).chain(if object { 60..66 } else { 0..0 }) {
            moved[c] += shift[c % 3];
        }
        let parts = [&query, &moved].map(|x| {
            let widths = Bandwidths { hand: 2.0, finger: 0.7 };
            let distances = residual.expectation.distances(x);
            residual.expectation.parts_m(x, &distances, widths)
        });
        // The object goes with the whole hand, which is somewhere else.
        let fingers: usize = residual.expectation.blocks()[..5].iter().sum();
        for part in [0, 2] {
            let [here, there] = parts.each_ref().map(|p| p.view((0, part), (fingers, 1)));
            prop_assert!((here - there).amax() <= 1e-9 * here.amax());
        }
        prop_assert!((parts[0].column(1) - parts[1].column(1)).amax() > 0.0);
    }

    #[test]
    fn the_order_of_takes_does_not_matter(
        seed in 0_usize..1_000_000,
        order in Just((0..5).collect::<Vec<usize>>()).prop_shuffle(),
    ) {
        let layout = layout(12, true);
        let x = conditions(layout, seed, 75);
        let known = related(layout, &x, seed);
        let plain = learn(&permuted(layout, &x, &known, 15, &[0, 1, 2, 3, 4]));
        let other = learn(&permuted(layout, &x, &known, 15, &order));
        let query = numbers(seed + 5000, layout);
        prop_assert!(close(&expected_m(&other, &query), &expected_m(&plain, &query), 1e-9));
        for (a, b) in plain.calibration.iter().zip(&other.calibration) {
            prop_assert!((a.mahalanobis - b.mahalanobis).abs() <= 1e-9 * a.mahalanobis);
        }
        let b = [&plain, &other].map(|r| &r.primitives * &r.covariance_m2 * r.primitives.transpose());
        prop_assert!((&b[0] - &b[1]).amax() <= 1e-9 * b[0].amax());
    }

    #[test]
    fn a_finger_knows_nothing_of_the_others(seed in 0_usize..1_000_000) {
        let layout = layout(12, false);
        let x = conditions(layout, seed, 60);
        let residual = learn(&around_smooth(layout, &x, &related(layout, &x, seed), 20));
        let query = numbers(seed + 5000, layout);
        let mut other = query.clone();
        for c in 3..60 {
            if c % 15 >= 3 {
                other[c] += 0.01 * uniform(&[seed, c]);
            }
        }
        let parts = [&query, &other].map(|x| {
            let distances = residual.expectation.distances(x);
            residual.expectation.parts_m(x, &distances, residual.expectation.bandwidths())
        });
        let thumb = residual.expectation.blocks()[0];
        for part in [0, 2] {
            let [a, b] = parts.each_ref().map(|p| p.view((0, part), (thumb, 1)));
            prop_assert!((a - b).amax() <= 1e-12 * a.amax());
        }
    }
}

#[test]
fn end_conditions_survive_as_numbers() {
    for object in [false, true] {
        let layout = layout(12, object);
        let x = numbers(5, layout);
        let back = ends(&x).to_vector(layout).unwrap();
        assert!((back - &x).amax() < 1e-15);
    }
}
