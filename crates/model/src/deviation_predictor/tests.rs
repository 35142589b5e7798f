//! The regression against its formulas, computed pair by pair.

use nalgebra::{DMatrix, DVector};

use super::{Bandwidths, DeviationPredictor, PredictorWeights};
use crate::segments::{SegmentLayout, ends_len};

fn layout(object: bool) -> SegmentLayout {
    SegmentLayout {
        samples: 21,
        rate_hz: 10.0,
        object,
    }
}

/// A number from -1 to 1 for each pair.
fn number(i: usize, j: usize) -> f64 {
    ((12.9898 * i as f64 + 78.233 * j as f64).sin() * 437.585).sin()
}

fn table(rows: usize, columns: usize, seed: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |i, j| 0.1 * number(i + 1000 * seed, j))
}

/// Two activations a finger, three of the object.
fn blocks(object: bool) -> Vec<usize> {
    let mut blocks = vec![2; 5];
    blocks.extend(object.then_some(3));
    blocks
}

fn of_ends(ends: &DMatrix<f64>, object: bool) -> DeviationPredictor {
    let blocks = blocks(object);
    let rank = blocks.iter().sum();
    let profile = table(rank, ends_len(layout(object)), 7);
    let answers = table(rank, ends.ncols(), 8);
    DeviationPredictor::new(layout(object), blocks, profile, ends.clone(), answers)
}

fn made(count: usize, object: bool) -> DeviationPredictor {
    of_ends(&table(ends_len(layout(object)), count, 1), object)
}

fn query(object: bool) -> DVector<f64> {
    table(ends_len(layout(object)), 1, 2).column(0).into_owned()
}

const ALL: PredictorWeights = PredictorWeights {
    profile: 0.7,
    hand: 0.4,
    finger: 0.9,
};

const WIDTHS: Bandwidths = Bandwidths {
    hand: 5.0,
    finger: 2.0,
};

fn only(profile: f64, hand: f64, finger: f64) -> PredictorWeights {
    PredictorWeights {
        profile,
        hand,
        finger,
    }
}

/// Features of the fingers' motion (five times twelve), of their places (five times three), of the
/// object's motion (six) and of its place (three).
fn features(x: &DVector<f64>, object: bool) -> [Vec<f64>; 4] {
    let seconds = 2.0;
    let mut motion = Vec::new();
    for finger in 0..5 {
        let own = |part: usize, axis: usize| x[15 * part + 3 * finger + axis];
        for a in 0..3 {
            motion.extend([
                own(1, a) - own(0, a),
                own(1, a) - own(0, a) - seconds * (own(2, a) + own(3, a)) / 2.0,
                own(2, a),
                own(3, a),
            ]);
        }
    }
    let place = x.as_slice()[..15].to_vec();
    if !object {
        return [motion, place, Vec::new(), Vec::new()];
    }
    let object = &x.as_slice()[60..];
    let mut moved: Vec<f64> = (0..3).map(|a| object[3 + a] - object[a]).collect();
    moved.extend_from_slice(&object[6..9]);
    [motion, place, moved, object[..3].to_vec()]
}

/// Squared standardised differences of each group of features, by demonstration.
fn squares(ends: &DMatrix<f64>, x: &DVector<f64>, object: bool) -> Vec<[Vec<f64>; 4]> {
    let known: Vec<_> = ends
        .column_iter()
        .map(|c| features(&c.into_owned(), object))
        .collect();
    let asked = features(x, object);
    let count = known.len() as f64;
    let mut squares = vec![[const { Vec::new() }; 4]; known.len()];
    for group in 0..4 {
        for k in 0..asked[group].len() {
            let values: Vec<f64> = known.iter().map(|f| f[group][k]).collect();
            let mean = values.iter().sum::<f64>() / count;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
            for (squares, value) in squares.iter_mut().zip(values) {
                squares[group].push((value - asked[group][k]).powi(2) / variance);
            }
        }
    }
    squares
}

fn kernel_mean(squared: &[f64], width: f64, answers: &DMatrix<f64>, row: usize) -> f64 {
    let nearest = squared.iter().copied().fold(f64::INFINITY, f64::min);
    let kernels = squared
        .iter()
        .map(|d| (d - nearest) / (2.0 * width * width))
        .map(|e| if e < 16.0 { (-e).exp() } else { 0.0 });
    let (mut sum, mut total) = (0.0, 0.0);
    for (j, kernel) in kernels.enumerate() {
        sum += kernel * answers[(row, j)];
        total += kernel;
    }
    sum / total
}

#[test]
fn expectations_are_those_of_the_formulas() {
    for object in [false, true] {
        // A number of demonstrations that is no multiple of four as well.
        for count in [1, 2, 7, 40] {
            let expectation = made(count, object).weighted(WIDTHS, ALL);
            let x = query(object);
            let groups = squares(expectation.ends(), &x, object);
            let sum = |v: &[f64]| v.iter().sum::<f64>();
            let hand: Vec<f64> = groups
                .iter()
                .map(|g| g.iter().map(|v| sum(v)).sum())
                .collect();
            let expected = expectation.expected_m(&x);
            for row in 0..expected.len() {
                let answers = expectation.answers_m();
                let by_hand = kernel_mean(&hand, WIDTHS.hand, answers, row);
                let by_finger = if row < 10 {
                    let finger = row / 2;
                    let own: Vec<f64> = groups
                        .iter()
                        .map(|g| sum(&g[0][12 * finger..12 * finger + 12]) + sum(&g[2]))
                        .collect();
                    kernel_mean(&own, WIDTHS.finger, answers, row)
                } else {
                    by_hand
                };
                let by_profile = expectation.profile().row(row).transpose().dot(&x);
                let formula = 0.7 * by_profile + 0.4 * by_hand + 0.9 * by_finger;
                // One demonstration has no spread to standardise by: any distance is none.
                if count > 1 {
                    assert!((expected[row] - formula).abs() < 1e-12, "{object} {count}");
                } else {
                    let only = 0.7 * by_profile + 1.3 * answers[(row, 0)];
                    assert!((expected[row] - only).abs() < 1e-12, "{object}");
                }
            }
        }
    }
}

#[test]
fn parts_add_up() {
    for object in [false, true] {
        let expectation = made(9, object).weighted(WIDTHS, ALL);
        let x = query(object);
        let parts = expectation.parts_m(&x, &expectation.distances(&x), WIDTHS);
        let sum = parts * DVector::from_vec(vec![ALL.profile, ALL.hand, ALL.finger]);
        assert!((sum - expectation.expected_m(&x)).amax() < 1e-15);
    }
}

#[test]
fn a_narrow_kernel_gives_a_demonstration_its_own_answer() {
    let narrow = Bandwidths {
        hand: 1e-3,
        finger: 1e-3,
    };
    for object in [false, true] {
        for weights in [only(0.0, 1.0, 0.0), only(0.0, 0.0, 1.0)] {
            let expectation = made(12, object).weighted(narrow, weights);
            for j in 0..12 {
                let x = expectation.ends().column(j).into_owned();
                let error = expectation.expected_m(&x) - expectation.answers_m().column(j);
                assert!(error.amax() < 1e-15);
            }
        }
    }
}

#[test]
fn a_wide_kernel_gives_the_mean_of_all_answers() {
    let wide = Bandwidths {
        hand: 1e9,
        finger: 1e9,
    };
    for weights in [only(0.0, 1.0, 0.0), only(0.0, 0.0, 1.0)] {
        let expectation = made(13, true).weighted(wide, weights);
        let error = expectation.expected_m(&query(true)) - expectation.answers_m().column_mean();
        assert!(error.amax() < 1e-12);
    }
}

#[test]
fn without_weights_nothing_is_expected() {
    assert_eq!(made(5, true).expected_m(&query(true)).amax(), 0.0);
}

#[test]
fn without_demonstrations_there_is_the_profile() {
    for object in [false, true] {
        let expectation = made(0, object).weighted(WIDTHS, ALL);
        let x = query(object);
        let error = expectation.expected_m(&x) - expectation.profile() * &x * ALL.profile;
        assert_eq!(error.amax(), 0.0);
        let parts = expectation.parts_m(&x, &expectation.distances(&x), WIDTHS);
        assert_eq!(parts.columns(1, 2).amax(), 0.0);
    }
}

#[test]
fn what_no_demonstration_changed_does_not_count() {
    // Fingers two to five rest at zero in all demonstrations; the query may have them anywhere.
    let mut ends = table(60, 8, 1);
    for (i, mut row) in ends.row_iter_mut().enumerate() {
        if i % 15 >= 3 {
            row.fill(0.0);
        }
    }
    let expectation = of_ends(&ends, false).weighted(WIDTHS, only(0.0, 1.0, 1.0));
    let mut resting = query(false);
    for i in 0..60 {
        if i % 15 >= 3 {
            resting[i] = 0.0;
        }
    }
    assert_eq!(
        expectation.expected_m(&query(false)),
        expectation.expected_m(&resting)
    );
}

#[test]
fn far_from_everything_the_nearest_demonstration_is_left() {
    // Metres away no kernel has a value of its own, and none of them is lost to underflow.
    let mut ends = table(60, 2, 1);
    ends[(0, 1)] = ends[(0, 0)] + 0.5;
    let expectation = of_ends(&ends, false).weighted(WIDTHS, only(0.0, 1.0, 0.0));
    let mut x = ends.column(1).into_owned();
    for i in 0..30 {
        // All fingers elsewhere, along the way from one demonstration to the other.
        x[i] += 100.0 * (ends[(i % 15, 1)] - ends[(i % 15, 0)]);
    }
    let error = expectation.expected_m(&x) - expectation.answers_m().column(1);
    assert!(error.amax() < 1e-15);
}

#[test]
fn end_conditions_that_are_no_numbers_stay_visible() {
    let mut x = query(false);
    x[3] = f64::NAN;
    let expected = made(5, false).weighted(WIDTHS, ALL).expected_m(&x);
    assert!(expected.iter().all(|v| v.is_nan()));
}

#[test]
#[should_panic(expected = "another layout")]
fn end_conditions_of_another_layout_are_refused() {
    made(3, true).distances(&query(false));
}

#[test]
fn what_never_changed_does_not_count_wherever_it_stayed() {
    // A place of 0.1 m in every demonstration has a variance of nothing, not of what rounding
    // leaves of its square.
    let mut ends = table(60, 8, 1);
    for (i, mut row) in ends.row_iter_mut().enumerate() {
        if i % 15 >= 3 {
            row.fill(if i < 30 {
                0.1 + 0.013 * (i % 15) as f64
            } else {
                0.07
            });
        }
    }
    let expectation = of_ends(&ends, false).weighted(WIDTHS, only(0.0, 1.0, 1.0));
    let mut resting = query(false);
    for i in 0..60 {
        if i % 15 >= 3 {
            resting[i] = ends[(i, 0)];
        }
    }
    let mut moved = resting.clone();
    for i in 3..15 {
        moved[i] += 1e-4;
        moved[15 + i] += 2e-4;
    }
    let difference = expectation.expected_m(&resting) - expectation.expected_m(&moved);
    assert!(difference.amax() < 1e-12, "{}", difference.amax());
}

#[test]
fn the_narrowest_kernel_is_the_nearest_demonstration() {
    let narrow = Bandwidths {
        hand: 1e-10,
        finger: 1e-10,
    };
    for weights in [only(0.0, 1.0, 0.0), only(0.0, 0.0, 1.0)] {
        let expectation = made(1, false).weighted(narrow, weights);
        let error = expectation.expected_m(&query(false)) - expectation.answers_m().column(0);
        assert!(error.amax() < 1e-15);
        let expectation = made(6, false).weighted(narrow, weights);
        assert!(
            expectation
                .expected_m(&query(false))
                .iter()
                .all(|v| *v != 0.0)
        );
    }
}
