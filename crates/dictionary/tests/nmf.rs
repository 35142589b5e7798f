//! Non-negative factorisation through its public face.

use inhand_dictionary::{LearnError, NmfSettings, Penalty, Precision, Start, Update, learn_nmf};
use inhand_model::{Dictionary, DictionaryKind, StopReason};
use nalgebra::DMatrix;
use proptest::prelude::*;

use crate::segments::{demonstrated, motion, segments};

/// Relative rounding of an objective that is formed by subtracting numbers up to a million times
/// larger.
const OBJECTIVE_ROUNDING: f64 = 1e-9;

/// Rounding of the reconstruction relative to the data, as norms: near an exact fit it adds its
/// product with the error to the objective.
const RECONSTRUCTION_ROUNDING: f64 = 1e-14;

fn settings(rank: usize) -> NmfSettings {
    NmfSettings {
        rank,
        relative_change: 0.0,
        ..NmfSettings::default()
    }
}

fn learn(columns: DMatrix<f64>, settings: &NmfSettings) -> Dictionary {
    learn_nmf(&segments(columns), demonstrated(), settings).unwrap()
}

/// What holds for every dictionary, whatever the data.
fn check(dictionary: &Dictionary) {
    dictionary.validate().unwrap();
    assert_eq!(dictionary.kind, DictionaryKind::Nmf);
    for primitive in dictionary.primitives.column_iter() {
        assert!((primitive.norm() - 1.0).abs() < 1e-12);
    }
    let learning = &dictionary.learning;
    assert_eq!(learning.objective_history_m2.len(), learning.iterations + 1);
    let last = *learning.objective_history_m2.last().unwrap();
    let relative = learning.relative_error.max(f64::MIN_POSITIVE);
    let data_m2 = 2.0 * last / relative / relative;
    for pair in learning.objective_history_m2.windows(2) {
        let rounding =
            OBJECTIVE_ROUNDING * pair[0] + RECONSTRUCTION_ROUNDING * (pair[0] * data_m2).sqrt();
        assert!(
            pair[1] <= pair[0] + rounding,
            "the objective rose from {} to {}",
            pair[0],
            pair[1]
        );
    }
    let numbers = dictionary.primitives.nrows() * learning.segments;
    let rms = (2.0 * last / numbers as f64).sqrt();
    assert!(
        (learning.rms_m - rms).abs() <= 1e-8 * rms
            || learning.relative_error < RECONSTRUCTION_ROUNDING * 100.0
    );
    assert!(dictionary.activation_mean_m.iter().all(|h| *h >= 0.0));
    assert!(
        dictionary
            .activation_covariance_m2
            .clone()
            .cholesky()
            .is_some()
    );
}

#[test]
fn smooth_motion_is_learned_to_half_a_millimetre() {
    let limit = NmfSettings {
        max_iterations: 40,
        ..settings(30)
    };
    let dictionary = learn(motion(20, 60), &limit);
    check(&dictionary);
    assert!(
        dictionary.learning.rms_m < 5e-4,
        "{}",
        dictionary.learning.rms_m
    );
    assert_eq!(dictionary.learning.iterations, 40);
    assert_eq!(dictionary.learning.stop_reason, StopReason::IterationLimit);
    assert_eq!(dictionary.rank(), 30);
}

#[test]
fn the_offset_is_each_coordinates_minimum_minus_the_margin() {
    let columns = motion(10, 12);
    let dictionary = learn(columns.clone(), &settings(4));
    for coordinate in 0..15 {
        let min = (0..columns.nrows())
            .filter(|row| row % 15 == coordinate)
            .map(|row| columns.row(row).min())
            .fold(f64::INFINITY, f64::min);
        for t in 0..10 {
            let found = dictionary.offset_m[15 * t + coordinate];
            assert!((found - (min - 0.005)).abs() < 1e-15);
        }
    }
}

#[test]
fn data_of_low_rank_are_recovered() {
    // Three non-negative primitives, each active alone in some segments: the factorisation is
    // unique, and its error goes to zero.
    let w = DMatrix::from_fn(30, 3, |row, j| {
        if row % 3 == j {
            0.1 + 0.01 * row as f64
        } else {
            0.0
        }
    });
    let h = DMatrix::from_fn(3, 24, |j, i| {
        if i % 4 == 3 {
            0.5 + 0.1 * j as f64
        } else {
            f64::from(u8::from(i % 4 == j)) * (1.0 + i as f64)
        }
    });
    // With every coordinate reaching zero, no margin means no offset.
    let settings = NmfSettings {
        max_iterations: 300,
        offset_margin_m: 0.0,
        ..settings(3)
    };
    let dictionary = learn(&w * &h, &settings);
    check(&dictionary);
    assert!(
        dictionary.learning.relative_error < 1e-7,
        "{}",
        dictionary.learning.relative_error
    );
    for expected in w.column_iter() {
        let best = dictionary
            .primitives
            .column_iter()
            .map(|found| found.dot(&expected) / expected.norm())
            .fold(0.0, f64::max);
        assert!(best > 1.0 - 1e-6, "no primitive matches: {best}");
    }
}

#[test]
fn scaling_the_data_by_a_power_of_two_scales_the_activations_alone() {
    for (start, update) in [
        (Start::Random, Update::Hals),
        (Start::Segments, Update::Multiplicative),
    ] {
        let one = NmfSettings {
            start,
            update,
            ..settings(7)
        };
        let eight = NmfSettings {
            offset_margin_m: 8.0 * one.offset_margin_m,
            ..one.clone()
        };
        let (a, b) = (
            learn(motion(6, 20), &one),
            learn(motion(6, 20) * 8.0, &eight),
        );
        // To the bit for the random start, which does not look at the data.
        let tolerance = if start == Start::Random { 0.0 } else { 1e-12 };
        assert!((&a.primitives - &b.primitives).amax() <= tolerance);
        assert!((&a.activation_mean_m * 8.0 - &b.activation_mean_m).amax() <= tolerance);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    // Enough columns for two blocks, and for several chunks in each.
    for (samples, count, rank) in [(1, 2500, 6), (14, 210, 40)] {
        for update in [Update::Hals, Update::Multiplicative] {
            let settings = NmfSettings {
                max_iterations: 4,
                update,
                ..settings(rank)
            };
            let of_threads = |threads| {
                rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap()
                    .install(|| learn(motion(samples, count), &settings))
            };
            let one = of_threads(1);
            check(&one);
            for threads in [2, 3, 5] {
                assert!(
                    one == of_threads(threads),
                    "{threads} threads, {count} columns"
                );
            }
        }
    }
}

#[test]
fn a_seed_repeats_and_another_differs() {
    for start in [Start::Random, Start::Segments] {
        let with_seed = |seed| {
            learn(
                motion(5, 30),
                &NmfSettings {
                    seed,
                    start,
                    max_iterations: 3,
                    ..settings(8)
                },
            )
        };
        assert!(with_seed(1) == with_seed(1));
        assert!(with_seed(1).primitives != with_seed(2).primitives);
        assert_eq!(with_seed(2).learning.seed, 2);
    }
}

#[test]
fn singular_vectors_are_a_start_ahead_of_chance() {
    let objective = |start, seed| {
        let limit = NmfSettings {
            start,
            seed,
            max_iterations: 0,
            ..settings(8)
        };
        learn(motion(10, 60), &limit).learning.objective_history_m2[0]
    };
    assert!(objective(Start::Nndsvd, 0) < objective(Start::Random, 0));
    // Which directions the search begins with leaves next to no trace.
    let (one, other) = (objective(Start::Nndsvd, 1), objective(Start::Nndsvd, 2));
    assert!((one / other - 1.0).abs() < 0.1, "{one} {other}");
}

#[test]
fn learning_says_why_it_stopped() {
    let reached = NmfSettings {
        stop_rms_m: Some(1e-3),
        max_iterations: 40,
        ..settings(20)
    };
    let dictionary = learn(motion(10, 40), &reached);
    assert_eq!(dictionary.learning.stop_reason, StopReason::TargetReached);
    assert!(dictionary.learning.rms_m <= 1e-3 * (1.0 + 1e-12));
    // The iteration before had not reached it.
    let history = &dictionary.learning.objective_history_m2;
    assert!(history.len() < 2 || history[history.len() - 2] > 0.5 * 1e-6 * (150 * 40) as f64);

    let already = NmfSettings {
        stop_rms_m: Some(1.0),
        ..settings(20)
    };
    let dictionary = learn(motion(10, 40), &already);
    assert_eq!(dictionary.learning.stop_reason, StopReason::TargetReached);
    assert_eq!(dictionary.learning.iterations, 0);

    let converged = NmfSettings {
        relative_change: 0.05,
        max_iterations: 1000,
        ..settings(5)
    };
    let dictionary = learn(motion(10, 40), &converged);
    assert_eq!(dictionary.learning.stop_reason, StopReason::Converged);
    let history = &dictionary.learning.objective_history_m2;
    for (i, pair) in history.windows(2).enumerate() {
        let small = pair[0] - pair[1] < 0.05 * pair[0];
        assert_eq!(small, i + 2 == history.len(), "iteration {}", i + 1);
    }

    let none = NmfSettings {
        max_iterations: 0,
        ..settings(5)
    };
    let dictionary = learn(motion(10, 40), &none);
    check(&dictionary);
    assert_eq!(dictionary.learning.stop_reason, StopReason::IterationLimit);
}

#[test]
fn as_many_primitives_as_segments_are_possible() {
    let dictionary = learn(motion(4, 9), &settings(9));
    check(&dictionary);
    // The covariance of nine activations from nine segments is singular before shrinkage.
    assert!(dictionary.covariance_shrinkage > 1e-3);
}

#[test]
fn segments_that_are_all_the_same_can_be_learned() {
    let one = motion(4, 1);
    for rank in [1, 3] {
        let columns = DMatrix::from_fn(60, 5, |row, _| one[row]);
        let limit = NmfSettings {
            max_iterations: 80,
            ..settings(rank)
        };
        let dictionary = learn(columns, &limit);
        check(&dictionary);
        assert!(dictionary.learning.relative_error < 1e-6);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_objective_never_rises(
        samples in 1_usize..4,
        count in 1_usize..30,
        rank in 1_usize..12,
        seed in any::<u64>(),
        hals in any::<bool>(),
        random_start in any::<bool>(),
        exponent in -3_i32..3,
        numbers in prop::collection::vec(prop_oneof![4 => -1.0..1.0, 1 => Just(0.0)], 1400),
    ) {
        let scale = 10.0_f64.powi(exponent);
        let rows = 15 * samples;
        let mut columns = DMatrix::from_fn(rows, count, |r, c| scale * numbers[r + c * rows]);
        // No coordinate may be constant.
        for coordinate in 0..15 {
            columns[(coordinate, 0)] = scale * (1.5 + coordinate as f64);
            columns[(rows - 15 + coordinate, count - 1)] -= 3.0 * scale;
        }
        prop_assume!(samples * count > 1);
        let settings = NmfSettings {
            seed,
            max_iterations: 15,
            update: if hals { Update::Hals } else { Update::Multiplicative },
            start: if random_start { Start::Random } else { Start::Segments },
            ..settings(rank.min(count))
        };
        check(&learn(columns, &settings));
    }

    #[test]
    fn nor_does_it_with_penalties_in_either_precision(
        samples in 1_usize..4,
        count in 2_usize..30,
        rank in 1_usize..12,
        seed in any::<u64>(),
        hals in any::<bool>(),
        single in any::<bool>(),
        penalised in prop::bool::weighted(0.75),
        start in prop::sample::select(&[Start::Random, Start::Segments, Start::Online, Start::Nndsvd][..]),
        weights in prop::collection::vec(
            prop_oneof![2 => Just(0.0), 2 => 1e-6..1e-3, 1 => 1e-3..1.0], 4,
        ),
        numbers in prop::collection::vec(prop_oneof![4 => -1.0..1.0, 1 => Just(0.0)], 1400),
    ) {
        // Both factors have a penalty or neither.
        let penalty = |l1: f64, l2: f64| Penalty {
            l1: if l1 + l2 > 0.0 { l1 } else { 1e-5 },
            l2,
        };
        let (of_activations, of_primitives) = if penalised {
            (penalty(weights[0], weights[1]), penalty(weights[2], weights[3]))
        } else {
            Default::default()
        };
        let rows = 15 * samples;
        let mut columns = DMatrix::from_fn(rows, count, |r, c| 0.1 * numbers[r + c * rows]);
        for coordinate in 0..15 {
            columns[(coordinate, 0)] = 0.15 + 0.1 * coordinate as f64;
            columns[(rows - 15 + coordinate, count - 1)] -= 0.3;
        }
        let settings = NmfSettings {
            seed,
            max_iterations: 15,
            update: if hals { Update::Hals } else { Update::Multiplicative },
            precision: if single { Precision::F32 } else { Precision::F64 },
            start,
            activation_penalty: of_activations,
            primitive_penalty: of_primitives,
            ..settings(rank.min(count))
        };
        let dictionary = match learn_nmf(&segments(columns.clone()), demonstrated(), &settings) {
            Ok(dictionary) => dictionary,
            // The heaviest weights leave nothing, and that is said.
            Err(LearnError::PenaltyOfEverything) if penalised => return Ok(()),
            Err(error) => panic!("{error}"),
        };
        dictionary.validate().unwrap();
        let mut shifted = columns;
        for mut column in shifted.column_iter_mut() {
            column -= &dictionary.offset_m;
        }
        let data_m2 = shifted.norm_squared();
        // Of numbers with 24 bits each, and of their products with the error.
        let (of_objective, of_reconstruction) = if single {
            (1e-5, 1e-6)
        } else {
            (OBJECTIVE_ROUNDING, RECONSTRUCTION_ROUNDING)
        };
        for pair in dictionary.learning.objective_history_m2.windows(2) {
            let rounding =
                of_objective * pair[0] + of_reconstruction * (pair[0] * data_m2).sqrt();
            prop_assert!(
                pair[1] <= pair[0] + rounding,
                "the objective rose from {} to {}", pair[0], pair[1]
            );
        }
    }
}
