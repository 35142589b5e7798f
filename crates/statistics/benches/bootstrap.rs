//! Summaries and intervals of as many errors as a session has.

use inhand_model::{Bootstrap, Cluster, Measure};
use inhand_statistics::bootstrap::{ClusteredRows, differences, intervals};
use inhand_statistics::quantiles::statistics;

fn main() {
    divan::main();
}

const BOOTSTRAP: Bootstrap = Bootstrap {
    cluster: Cluster::Segment,
    draws: 2000,
    seed: 7,
    confidence: 0.95,
};

/// One-sided rows in no order, of a level of its own for each cluster.
fn clusters(count: u32, rows: u32) -> Vec<Vec<f64>> {
    let fraction = |k: u32| (f64::from(k) * 0.618_033_988_749_895).fract();
    (0..count)
        .map(|c| {
            let level = 0.5 + fraction(c * 7 + 3);
            (0..rows)
                .map(|k| level * fraction(c * rows + k).powi(2) * 1e-3)
                .collect()
        })
        .collect()
}

/// 119 segments x 100 samples x 5 fingers, rows sorted first.
#[divan::bench]
fn five_statistics_of_a_session(bencher: divan::Bencher<'_, '_>) {
    let clusters = clusters(119, 500);
    bencher.bench_local(|| {
        let rows = ClusteredRows::new(&clusters).expect("rows are finite");
        intervals(&rows, &Measure::ALL, &BOOTSTRAP)
    });
}

/// The same, less another method.
#[divan::bench]
fn differences_of_a_session(bencher: divan::Bencher<'_, '_>) {
    let [first, second] =
        [500, 499].map(|n| ClusteredRows::new(&clusters(119, n)).expect("rows are finite"));
    bencher.bench_local(|| differences(&first, &second, true, &Measure::ALL, &BOOTSTRAP));
}

/// 100 sessions of 119 segments.
#[divan::bench(sample_count = 3)]
fn a_hundred_sessions(bencher: divan::Bencher<'_, '_>) {
    let clusters = clusters(100, 59_500);
    bencher.bench_local(|| {
        let rows = ClusteredRows::new(&clusters).expect("rows are finite");
        intervals(&rows, &Measure::ALL, &BOOTSTRAP)
    });
}

/// 119 segments x 100 samples x 5 fingers.
#[divan::bench]
fn statistics_of_a_session(bencher: divan::Bencher<'_, '_>) {
    // A low-discrepancy sequence, squared: one-sided and in no order, as errors are.
    let values: Vec<f64> = (0..59_500)
        .map(|i| (f64::from(i) * 0.618_033_988_749_895).fract().powi(2) * 1e-3)
        .collect();
    bencher
        .with_inputs(|| values.clone())
        .bench_values(|values| statistics(values, 0, 0));
}
