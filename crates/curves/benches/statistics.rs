//! Summaries of as many errors as a session has, smoothness, and the nearest of many demonstrations.

use inhand_curves::smoothness::{ArcSettings, spectral_arc_length};
use inhand_curves::warping::nearest;
use inhand_model::Configuration;
use inhand_statistics::quantiles::statistics;

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

/// Speeds of one fingertip in a segment of 100 samples.
#[divan::bench]
fn spectral_arc_of_a_segment(bencher: divan::Bencher<'_, '_>) {
    let speeds: Vec<f64> = (0..99)
        .map(|k| (f64::from(k) * 0.05).sin().powi(2) * 0.2)
        .collect();
    bencher.bench(|| spectral_arc_length(&speeds, 100.0, ArcSettings::PUBLISHED));
}

/// 595 demonstrations of 100 configurations; a query beside one of them.
#[divan::bench(args = [None, Some(10)])]
fn nearest_of_595(bencher: divan::Bencher<'_, '_>, band: Option<usize>) {
    let motion = |from: f64| -> Vec<Configuration> {
        (0..100)
            .map(|t| {
                std::array::from_fn(|c| {
                    let phase = f64::from(t) * 0.03 + from * (1.0 + c as f64);
                    0.08 * (from * 3.0 + c as f64).sin() + 0.02 * phase.sin()
                })
            })
            .collect()
    };
    let demonstrations: Vec<_> = (0..595).map(|k| motion(f64::from(k) * 0.618)).collect();
    let query = motion(100.4 * 0.618);
    bencher.bench(|| nearest(&query, demonstrations.iter().map(Vec::as_slice), band));
}
