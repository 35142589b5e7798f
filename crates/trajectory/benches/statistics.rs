//! Summaries of as many errors as a session has.

use inhand_trajectory::quantiles::statistics;

fn main() {
    divan::main();
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
