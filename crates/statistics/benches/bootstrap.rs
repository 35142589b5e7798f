//! Intervals over as many errors as a session has.

use inhand_statistics::bootstrap::{
    ClusteredRows, Measure, Resampling, differences, intervals, intervals_of,
};
use inhand_statistics::quantiles::quantile;

fn main() {
    divan::main();
}

const RESAMPLING: Resampling = Resampling {
    draws: 2000,
    seed: 7,
    confidence: 0.95,
};

const MEASURES: [Measure; 5] = [
    Measure::Mean,
    Measure::Quantile(0.25),
    Measure::Quantile(0.5),
    Measure::Quantile(0.75),
    Measure::Quantile(0.95),
];

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
        intervals(&rows, &MEASURES, &RESAMPLING)
    });
}

/// The same, less another method.
#[divan::bench]
fn differences_of_a_session(bencher: divan::Bencher<'_, '_>) {
    let [first, second] =
        [500, 499].map(|n| ClusteredRows::new(&clusters(119, n)).expect("rows are finite"));
    bencher.bench_local(|| differences(&first, &second, &MEASURES, &RESAMPLING));
}

/// 100 sessions of 119 segments.
#[divan::bench(sample_count = 3)]
fn a_hundred_sessions(bencher: divan::Bencher<'_, '_>) {
    let clusters = clusters(100, 59_500);
    bencher.bench_local(|| {
        let rows = ClusteredRows::new(&clusters).expect("rows are finite");
        intervals(&rows, &MEASURES, &RESAMPLING)
    });
}

/// What it would take to put the rows of every draw together: one statistic, 20 draws, 119 x 500 rows.
#[divan::bench(sample_count = 3)]
fn plain_median_twenty_draws(bencher: divan::Bencher<'_, '_>) {
    let clusters = clusters(119, 500);
    let few = Resampling {
        draws: 20,
        ..RESAMPLING
    };
    bencher.bench_local(|| {
        intervals_of(&clusters, &few, |rows| {
            let mut sorted = rows.to_vec();
            sorted.sort_unstable_by(f64::total_cmp);
            [quantile(&sorted, 0.5).unwrap_or(f64::NAN)]
        })
    });
}
