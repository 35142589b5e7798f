//! Intervals over clusters, against plain resampling, NumPy and SciPy.

use inhand_statistics::BootstrapError;
use inhand_statistics::bootstrap::{
    ClusteredRows, Draws, Estimate, Interval, Measure, Resampling, differences, intervals,
    intervals_of, unpaired_differences,
};
use inhand_statistics::quantiles::quantile;
use proptest::prelude::*;
use serde_json::Value;

use crate::{number, numbers};

const MEASURES: [Measure; 5] = [
    Measure::Mean,
    Measure::Rmse,
    Measure::Quantile(0.5),
    Measure::Quantile(0.75),
    Measure::Quantile(0.95),
];

fn recorded() -> Value {
    serde_json::from_str(include_str!("../reference/bootstrap.json")).unwrap()
}

fn clusters(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

/// [`MEASURES`] of rows in any order.
fn plain(rows: &[f64]) -> [f64; 5] {
    let mut sorted = rows.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = rows.len() as f64;
    let at = |q| quantile(&sorted, q).unwrap_or(f64::NAN);
    [
        rows.iter().sum::<f64>() / n,
        (rows.iter().map(|v| v * v).sum::<f64>() / n).sqrt(),
        at(0.5),
        at(0.75),
        at(0.95),
    ]
}

fn close(found: f64, expected: f64, what: &str) {
    assert!(
        (found - expected).abs() <= 1e-9 * expected.abs().max(1e-3),
        "{what}: {found}, expected {expected}"
    );
}

fn check(found: &Estimate, expected: &Value, what: &str) {
    close(found.value, number(&expected["value"]), what);
    close(
        found.standard_error.unwrap(),
        number(&expected["standard_error"]),
        what,
    );
    let ends = |interval: Option<Interval>| interval.map(|i| vec![i.low, i.high]);
    for (kind, found) in [("percentile", found.percentile), ("bca", found.bca)] {
        let expected = numbers(&expected[kind]);
        for (found, expected) in ends(found).unwrap().into_iter().zip(expected) {
            close(found, expected, &format!("{kind} of {what}"));
        }
    }
}

#[test]
fn draws_can_be_repeated_by_others() {
    let recorded = recorded();
    let draws = recorded["draws"].as_array().unwrap();
    assert_eq!(draws.len(), 6);
    for expected in draws {
        let clusters = expected["clusters"].as_u64().unwrap() as usize;
        let seed = expected["seed"].as_str().unwrap().parse().unwrap();
        let mut times = vec![0; clusters];
        Draws { clusters, seed }.times(expected["draw"].as_u64().unwrap(), &mut times);
        let expected: Vec<u32> = (expected["times"].as_array().unwrap().iter())
            .map(|n| n.as_u64().unwrap() as u32)
            .collect();
        assert_eq!(times, expected);
    }
}

#[test]
fn intervals_agree_with_numpy_and_scipy() {
    let recorded = recorded();
    let cases = recorded["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        let resampling = Resampling {
            draws: case["draws"].as_u64().unwrap() as usize,
            seed: case["seed"].as_str().unwrap().parse().unwrap(),
            confidence: number(&case["confidence"]),
        };
        let first = ClusteredRows::new(&clusters(&case["first"])).unwrap();
        let second = ClusteredRows::new(&clusters(&case["second"])).unwrap();
        let found = intervals(&first, &MEASURES, &resampling).unwrap();
        let paired = differences(&first, &second, &MEASURES, &resampling).unwrap();
        for (k, measure) in MEASURES.iter().enumerate() {
            let name = format!("{measure:?}");
            check(&found[k].unwrap(), &case["intervals"][k], &name);
            let paired = paired[k].unwrap();
            check(&paired.absolute, &case["differences"][k], &name);
            check(&paired.relative.unwrap(), &case["relative"][k], &name);
        }
    }
}

#[test]
fn nothing_and_one_cluster_have_no_interval() {
    let resampling = Resampling {
        draws: 50,
        seed: 1,
        confidence: 0.9,
    };
    let none: [&[f64]; 3] = [&[], &[], &[]];
    let rows = ClusteredRows::new(&none).unwrap();
    assert_eq!(intervals(&rows, &MEASURES, &resampling).unwrap(), [None; 5]);
    assert!(ClusteredRows::new(&none[..0]).unwrap().sorted().is_empty());

    let one: [&[f64]; 3] = [&[], &[1.0, 2.0, 6.0], &[]];
    let rows = ClusteredRows::new(&one).unwrap();
    let mean = intervals(&rows, &[Measure::Mean], &resampling).unwrap()[0].unwrap();
    assert_eq!(
        (mean.value, mean.percentile, mean.bca, mean.standard_error),
        (3.0, None, None, None)
    );

    // Of two clusters with rows and one without, one draw in 27 has no row at all.
    let two: [&[f64]; 3] = [&[1.0], &[], &[3.0]];
    let rows = ClusteredRows::new(&two).unwrap();
    let many = Resampling {
        draws: 2700,
        ..resampling
    };
    let mean = intervals(&rows, &[Measure::Mean], &many).unwrap()[0].unwrap();
    assert!((60..160).contains(&mean.undefined_draws));
    let interval = mean.percentile.unwrap();
    assert_eq!((interval.low, interval.high), (1.0, 3.0));
}

#[test]
fn a_method_does_not_differ_from_itself() {
    let rows = ClusteredRows::new(&[[1.0, 2.0], [2.0, 5.0], [0.5, 0.25]]).unwrap();
    let resampling = Resampling {
        draws: 200,
        seed: 3,
        confidence: 0.95,
    };
    for found in differences(&rows, &rows, &MEASURES, &resampling).unwrap() {
        let found = found.unwrap();
        for estimate in [found.absolute, found.relative.unwrap()] {
            assert_eq!(estimate.value, 0.0);
            assert_eq!(
                estimate.percentile,
                Some(Interval {
                    low: 0.0,
                    high: 0.0
                })
            );
            assert_eq!(estimate.bca, None);
        }
    }
    let zero = ClusteredRows::new(&[[0.0], [0.0], [0.0]]).unwrap();
    let found = differences(&rows, &zero, &[Measure::Mean], &resampling).unwrap()[0].unwrap();
    assert_eq!(found.relative, None);
}

/// The spread of a mean over equally large clusters is known: that of the cluster means over the root of
/// their number, whatever goes on inside.
#[test]
fn standard_error_of_a_mean_is_that_of_cluster_means() {
    let clusters: Vec<Vec<f64>> = (0..40)
        .map(|c| {
            let mean = f64::from(c * c % 41);
            (0..25).map(|k| mean + f64::from(k - 12) * 10.0).collect()
        })
        .collect();
    let means: Vec<f64> = (0..40).map(|c| f64::from(c * c % 41)).collect();
    let mean = means.iter().sum::<f64>() / 40.0;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 40.0;
    let expected = (variance / 40.0).sqrt();
    let resampling = Resampling {
        draws: 20_000,
        seed: 5,
        confidence: 0.95,
    };
    let rows = ClusteredRows::new(&clusters).unwrap();
    let found = intervals(&rows, &[Measure::Mean], &resampling).unwrap()[0].unwrap();
    // The spread of a spread over 20 000 draws is half a per cent.
    assert!((found.standard_error.unwrap() / expected - 1.0).abs() < 0.02);
    let interval = found.percentile.unwrap();
    assert!(((interval.high - interval.low) / (2.0 * 1.96 * expected) - 1.0).abs() < 0.05);
}

#[test]
fn settings_and_rows_that_make_no_sense_are_refused() {
    let rows = ClusteredRows::new(&[[1.0], [2.0]]).unwrap();
    let good = Resampling {
        draws: 10,
        seed: 0,
        confidence: 0.95,
    };
    for confidence in [0.0, 1.0, -0.5, 95.0, f64::NAN] {
        let bad = Resampling { confidence, ..good };
        let error = intervals(&rows, &MEASURES, &bad).unwrap_err();
        assert!(matches!(error, BootstrapError::Confidence { .. }));
    }
    let error = intervals(&rows, &MEASURES, &Resampling { draws: 0, ..good }).unwrap_err();
    assert_eq!(error, BootstrapError::NoDraws);
    let error = intervals(&rows, &[Measure::Quantile(1.5)], &good).unwrap_err();
    assert_eq!(error, BootstrapError::Quantile { found: 1.5 });
    let other = ClusteredRows::new(&[[1.0]]).unwrap();
    let error = differences(&rows, &other, &MEASURES, &good).unwrap_err();
    assert_eq!(
        error,
        BootstrapError::Unpaired {
            first: 2,
            second: 1
        }
    );
    let error = ClusteredRows::new(&[vec![1.0], vec![2.0, f64::INFINITY]]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "row 1 of cluster 1 is inf: expected a finite number, leave missing rows out and count them"
    );
    assert!(intervals_of(&[[f64::NAN]], &good, |_| [0.0]).is_err());
}

fn bits(estimate: &Estimate) -> Vec<Option<u64>> {
    let ends = |i: Option<Interval>| [i.map(|i| i.low.to_bits()), i.map(|i| i.high.to_bits())];
    let mut all = vec![
        Some(estimate.value.to_bits()),
        estimate.standard_error.map(f64::to_bits),
        Some(estimate.undefined_draws as u64),
    ];
    all.extend(ends(estimate.percentile));
    all.extend(ends(estimate.bca));
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Nothing put together and everything put together give the same: quantiles to the last bit, ties,
    /// clusters without rows and several blocks included.
    #[test]
    fn sorted_once_agrees_with_rows_put_together(
        clusters in prop::collection::vec(
            prop::collection::vec(prop_oneof![3 => -1.0..1.0, 1 => Just(0.25)], 0..40), 1..20),
        seed in any::<u64>(),
    ) {
        let resampling = Resampling { draws: 40, seed, confidence: 0.9 };
        let rows = ClusteredRows::new(&clusters).unwrap();
        let quick = intervals(&rows, &MEASURES, &resampling).unwrap();
        let slow = intervals_of(&clusters, &resampling, plain).unwrap();
        for (k, (quick, slow)) in quick.iter().zip(&slow).enumerate() {
            prop_assert_eq!(quick.is_some(), slow.is_some());
            let (Some(quick), Some(slow)) = (quick, slow) else { continue };
            if k >= 2 {
                prop_assert_eq!(bits(quick), bits(slow));
            } else {
                prop_assert!((quick.value - slow.value).abs() < 1e-14);
                if let (Some(quick), Some(slow)) = (quick.percentile, slow.percentile) {
                    prop_assert!((quick.low - slow.low).abs() < 1e-13);
                    prop_assert!((quick.high - slow.high).abs() < 1e-13);
                }
            }
        }
    }
}

const FEW: Resampling = Resampling {
    draws: 200,
    seed: 1,
    confidence: 0.95,
};

#[test]
fn samples_of_one_cluster_each_have_a_difference_and_no_interval() {
    let first = ClusteredRows::new(&[vec![1.0, 2.0], vec![]]).unwrap();
    let second = ClusteredRows::new(&[vec![], vec![5.0, 6.0]]).unwrap();
    let found = differences(&first, &second, &[Measure::Mean], &FEW).unwrap();
    let difference = found[0].unwrap();
    assert_eq!(difference.absolute.value, -4.0);
    assert_eq!(difference.absolute.percentile, None);
}

#[test]
fn relative_differences_have_the_sign_of_the_difference() {
    let first = ClusteredRows::new(&[vec![-1.4], vec![-1.4]]).unwrap();
    let second = ClusteredRows::new(&[vec![-1.6], vec![-1.6]]).unwrap();
    let found = differences(&first, &second, &[Measure::Mean], &FEW).unwrap();
    let relative = found[0].unwrap().relative.unwrap().value;
    assert!((relative - 0.125).abs() < 1e-12, "{relative}");
}

proptest! {
    #[test]
    fn merged_samples_are_as_their_rows_sorted_together(
        parts in (1_usize..6).prop_flat_map(|clusters| {
            proptest::collection::vec(
                proptest::collection::vec(proptest::collection::vec(-3_i8..3, 0..9), clusters),
                1..4,
            )
        }),
    ) {
        let numbers = |rows: &Vec<i8>| rows.iter().map(|&v| f64::from(v)).collect::<Vec<f64>>();
        let parts: Vec<Vec<Vec<f64>>> =
            parts.iter().map(|part| part.iter().map(numbers).collect()).collect();
        let together: Vec<Vec<f64>> = (0..parts[0].len())
            .map(|cluster| parts.iter().flat_map(|part| part[cluster].clone()).collect())
            .collect();
        let sorted: Vec<ClusteredRows> =
            parts.iter().map(|part| ClusteredRows::new(part).unwrap()).collect();
        let merged = ClusteredRows::merged(&sorted.iter().collect::<Vec<_>>()).unwrap();
        let expected = ClusteredRows::new(&together).unwrap();
        prop_assert_eq!(merged.sorted(), expected.sorted());
        prop_assert_eq!(merged.by_cluster(), expected.by_cluster());
        let resampling = Resampling { draws: 20, seed: 3, confidence: 0.9 };
        // Small whole numbers add up exactly in any order.
        prop_assert_eq!(
            intervals(&merged, &MEASURES, &resampling).unwrap(),
            intervals(&expected, &MEASURES, &resampling).unwrap()
        );
    }
}

#[test]
fn samples_of_other_clusters_are_drawn_apart() {
    let first = vec![vec![1.0, 2.0], vec![4.0], vec![3.0, 8.0]];
    let second = vec![vec![2.0], vec![5.0, 1.0]];
    let resampling = Resampling {
        draws: 200,
        seed: 11,
        confidence: 0.9,
    };
    let rows = |clusters: &[Vec<f64>]| ClusteredRows::new(clusters).unwrap();
    let found =
        unpaired_differences(&rows(&first), &rows(&second), &MEASURES, &resampling).unwrap();
    let drawn = |clusters: &[Vec<f64>], seed: u64, draw: u64| {
        let mut times = vec![0; clusters.len()];
        let size = clusters.len();
        Draws {
            clusters: size,
            seed,
        }
        .times(draw, &mut times);
        let rows = clusters.iter().zip(times);
        plain(
            &rows
                .flat_map(|(rows, times)| rows.repeat(times as usize))
                .collect::<Vec<f64>>(),
        )
    };
    for (k, found) in found.iter().enumerate() {
        let mut values: Vec<f64> = (0..resampling.draws as u64)
            .map(|draw| drawn(&first, 11, draw)[k] - drawn(&second, 12, draw)[k])
            .collect();
        values.sort_by(f64::total_cmp);
        let found = found.unwrap().absolute;
        let interval = found.percentile.unwrap();
        close(
            found.value,
            plain(&first.concat())[k] - plain(&second.concat())[k],
            "value",
        );
        close(interval.low, quantile(&values, 0.05).unwrap(), "low");
        close(interval.high, quantile(&values, 0.95).unwrap(), "high");
    }
    // One cluster shows no spread.
    let lone = unpaired_differences(&rows(&first), &rows(&second[..1]), &MEASURES, &resampling);
    assert!(lone.unwrap()[0].unwrap().absolute.percentile.is_none());
}
