//! Intervals over clusters, against plain resampling and NumPy.

use inhand_model::{Bootstrap, Cluster, Estimate, Measure};
use inhand_statistics::BootstrapError;
use inhand_statistics::bootstrap::{
    ClusteredRows, SortedRows, differences, draw_clusters, intervals,
};
use inhand_statistics::quantiles::quantile;
use proptest::prelude::*;
use serde_json::Value;

use crate::{number, numbers};

const MEASURES: [Measure; 5] = Measure::ALL;

fn bootstrap(draws: usize, seed: u64, confidence: f64) -> Bootstrap {
    Bootstrap {
        cluster: Cluster::Segment,
        draws,
        seed,
        confidence,
    }
}

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
    let expected = numbers(&expected["percentile"]);
    for (found, expected) in found.interval.unwrap().into_iter().zip(expected) {
        close(found, expected, &format!("interval of {what}"));
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
        draw_clusters(seed, expected["draw"].as_u64().unwrap(), &mut times);
        let expected: Vec<u32> = (expected["times"].as_array().unwrap().iter())
            .map(|n| n.as_u64().unwrap() as u32)
            .collect();
        assert_eq!(times, expected);
    }
}

#[test]
fn intervals_agree_with_numpy() {
    let recorded = recorded();
    let cases = recorded["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        let resampling = bootstrap(
            case["draws"].as_u64().unwrap() as usize,
            case["seed"].as_str().unwrap().parse().unwrap(),
            number(&case["confidence"]),
        );
        let first = ClusteredRows::new(&clusters(&case["first"])).unwrap();
        let second = ClusteredRows::new(&clusters(&case["second"])).unwrap();
        let found = intervals(&first, &MEASURES, &resampling).unwrap();
        let paired = differences(&first, &second, true, &MEASURES, &resampling).unwrap();
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
    let resampling = bootstrap(50, 1, 0.9);
    let none: [&[f64]; 3] = [&[], &[], &[]];
    let rows = ClusteredRows::new(&none).unwrap();
    assert_eq!(intervals(&rows, &MEASURES, &resampling).unwrap(), [None; 5]);
    assert!(ClusteredRows::new(&none[..0]).unwrap().sorted().is_empty());

    // Of four clusters there is a value alone.
    for few in [[vec![], vec![1.0, 2.0, 6.0]].to_vec(), vec![vec![3.0]; 4]] {
        let rows = ClusteredRows::new(&few).unwrap();
        let mean = intervals(&rows, &[Measure::Mean], &resampling).unwrap()[0].unwrap();
        assert_eq!(
            (mean.value, mean.interval, mean.standard_error),
            (3.0, None, None)
        );
    }

    // Of 5 clusters with rows and 40 without, a draw in 200 has no row at all: it is left out.
    let mut sparse = vec![vec![]; 45];
    for (cluster, value) in [1.0, 3.0, 1.0, 3.0, 1.0].into_iter().enumerate() {
        sparse[9 * cluster] = vec![value];
    }
    let rows = ClusteredRows::new(&sparse).unwrap();
    let many = bootstrap(2700, 1, 0.999);
    let mean = intervals(&rows, &[Measure::Mean], &many).unwrap()[0].unwrap();
    assert_eq!(mean.interval, Some([1.0, 3.0]));
}

#[test]
fn a_method_does_not_differ_from_itself() {
    let rows =
        ClusteredRows::new(&[[1.0, 2.0], [2.0, 5.0], [0.5, 0.25], [3.0, 3.5], [0.0, 1.0]]).unwrap();
    let resampling = bootstrap(200, 3, 0.95);
    for found in differences(&rows, &rows, true, &MEASURES, &resampling).unwrap() {
        let found = found.unwrap();
        for estimate in [found.absolute, found.relative.unwrap()] {
            assert_eq!(estimate.value, 0.0);
            // No draw differs from another: an interval of no width would pass for certainty.
            assert_eq!(estimate.interval, None);
        }
    }
    let zero = ClusteredRows::new(&[[0.0]; 5]).unwrap();
    let found = differences(&rows, &zero, true, &[Measure::Mean], &resampling).unwrap()[0].unwrap();
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
    let resampling = bootstrap(20_000, 5, 0.95);
    let rows = ClusteredRows::new(&clusters).unwrap();
    let found = intervals(&rows, &[Measure::Mean], &resampling).unwrap()[0].unwrap();
    // The spread of a spread over 20 000 draws is half a per cent.
    assert!((found.standard_error.unwrap() / expected - 1.0).abs() < 0.02);
    let [low, high] = found.interval.unwrap();
    assert!(((high - low) / (2.0 * 1.96 * expected) - 1.0).abs() < 0.05);
}

#[test]
fn settings_and_rows_that_make_no_sense_are_refused() {
    let rows = ClusteredRows::new(&[[1.0], [2.0]]).unwrap();
    let good = bootstrap(10, 0, 0.95);
    for confidence in [0.0, 1.0, -0.5, 95.0, f64::NAN] {
        let bad = Bootstrap { confidence, ..good };
        let error = intervals(&rows, &MEASURES, &bad).unwrap_err();
        assert!(matches!(error, BootstrapError::Confidence { .. }));
    }
    let error = intervals(&rows, &MEASURES, &Bootstrap { draws: 0, ..good }).unwrap_err();
    assert_eq!(error, BootstrapError::NoDraws);
    let other = ClusteredRows::new(&[[1.0]]).unwrap();
    let error = differences(&rows, &other, true, &MEASURES, &good).unwrap_err();
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
}

/// The statistics of each draw, rows put together, ascending by measure; draws without rows left out.
fn drawn(clusters: &[Vec<f64>], resampling: &Bootstrap) -> [Vec<f64>; 5] {
    let mut drawn: [Vec<f64>; 5] = Default::default();
    for draw in 0..resampling.draws as u64 {
        let mut times = vec![0; clusters.len()];
        draw_clusters(resampling.seed, draw, &mut times);
        let rows =
            (clusters.iter().zip(times)).flat_map(|(rows, times)| rows.repeat(times as usize));
        let found = plain(&rows.collect::<Vec<f64>>());
        for (drawn, found) in drawn.iter_mut().zip(found) {
            drawn.extend(Some(found).filter(|found| found.is_finite()));
        }
    }
    drawn
        .iter_mut()
        .for_each(|drawn| drawn.sort_by(f64::total_cmp));
    drawn
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
        let resampling = bootstrap(40, seed, 0.9);
        let rows = ClusteredRows::new(&clusters).unwrap();
        let quick = intervals(&rows, &MEASURES, &resampling).unwrap();
        let (values, drawn) = (plain(&clusters.concat()), drawn(&clusters, &resampling));
        for (k, (quick, drawn)) in quick.iter().zip(&drawn).enumerate() {
            prop_assert_eq!(quick.is_some(), values[k].is_finite());
            let Some(quick) = quick else { continue };
            let tail = (1.0 - resampling.confidence) / 2.0;
            let ends = quick.interval.map(|_| [tail, 1.0 - tail].map(|q| quantile(drawn, q).unwrap()));
            if k >= 2 {
                prop_assert_eq!((quick.value, quick.interval), (values[k], ends));
            } else {
                prop_assert!((quick.value - values[k]).abs() < 1e-14);
                for (quick, slow) in quick.interval.iter().flatten().zip(ends.iter().flatten()) {
                    prop_assert!((quick - slow).abs() < 1e-13);
                }
            }
        }
    }
}

#[test]
fn samples_of_one_cluster_each_have_a_difference_and_no_interval() {
    let first = ClusteredRows::new(&[vec![1.0, 2.0], vec![]]).unwrap();
    let second = ClusteredRows::new(&[vec![], vec![5.0, 6.0]]).unwrap();
    let few = bootstrap(200, 1, 0.95);
    let found = differences(&first, &second, true, &[Measure::Mean], &few).unwrap();
    let difference = found[0].unwrap();
    assert_eq!(difference.absolute.value, -4.0);
    assert_eq!(difference.absolute.interval, None);
}

#[test]
fn relative_differences_have_the_sign_of_the_difference() {
    let first = ClusteredRows::new(&[vec![-1.4], vec![-1.4]]).unwrap();
    let second = ClusteredRows::new(&[vec![-1.6], vec![-1.6]]).unwrap();
    let few = bootstrap(200, 1, 0.95);
    let found = differences(&first, &second, true, &[Measure::Mean], &few).unwrap();
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
        let sorted: Vec<SortedRows> =
            parts.iter().map(|part| SortedRows::new(part).unwrap()).collect();
        let merged = ClusteredRows::from(SortedRows::merged(&sorted).unwrap());
        let expected = ClusteredRows::new(&together).unwrap();
        prop_assert_eq!(merged.sorted(), expected.sorted());
        prop_assert_eq!(merged.by_cluster(), expected.by_cluster());
        let all: Vec<usize> = (0..together.len()).collect();
        prop_assert_eq!(&*merged.of_clusters(&all), merged.sorted());
        let mut rest: Vec<f64> = together[1..].concat();
        rest.sort_by(f64::total_cmp);
        prop_assert_eq!(&*merged.of_clusters(&all[1..]), rest);
        let resampling = bootstrap(20, 3, 0.9);
        // Small whole numbers add up exactly in any order.
        prop_assert_eq!(
            intervals(&merged, &MEASURES, &resampling).unwrap(),
            intervals(&expected, &MEASURES, &resampling).unwrap()
        );
    }
}

#[test]
fn samples_of_other_clusters_are_drawn_apart() {
    let first = vec![
        vec![1.0, 2.0],
        vec![4.0],
        vec![3.0, 8.0],
        vec![2.5],
        vec![7.0, 0.5],
    ];
    let second = vec![vec![2.0], vec![5.0, 1.0]];
    let resampling = bootstrap(200, 11, 0.9);
    let rows = |clusters: &[Vec<f64>]| ClusteredRows::new(clusters).unwrap();
    let apart = |second: &[Vec<f64>]| {
        differences(&rows(&first), &rows(second), false, &MEASURES, &resampling).unwrap()
    };
    let statistics = |clusters: &[Vec<f64>], seed: u64, draw: u64| {
        let mut times = vec![0; clusters.len()];
        draw_clusters(seed, draw, &mut times);
        let rows = clusters.iter().zip(times);
        plain(
            &rows
                .flat_map(|(rows, times)| rows.repeat(times as usize))
                .collect::<Vec<f64>>(),
        )
    };
    for (k, found) in apart(&second).iter().enumerate() {
        let mut values: Vec<f64> = (0..resampling.draws as u64)
            .map(|draw| statistics(&first, 11, draw)[k] - statistics(&second, 12, draw)[k])
            .collect();
        values.sort_by(f64::total_cmp);
        let found = found.unwrap().absolute;
        let [low, high] = found.interval.unwrap();
        close(
            found.value,
            plain(&first.concat())[k] - plain(&second.concat())[k],
            "value",
        );
        close(low, quantile(&values, 0.05).unwrap(), "low");
        close(high, quantile(&values, 0.95).unwrap(), "high");
    }
    // One cluster shows no spread.
    assert!(apart(&second[..1])[0].unwrap().absolute.interval.is_none());
}
