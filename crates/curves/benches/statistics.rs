//! Smoothness, and the nearest of many demonstrations.

use inhand_curves::smoothness::spectral_arc_length;
use inhand_curves::warping::Candidates;
use inhand_model::Configuration;

fn main() {
    divan::main();
}

/// Speeds of one fingertip in a segment of 100 samples.
#[divan::bench]
fn spectral_arc_of_a_segment(bencher: divan::Bencher<'_, '_>) {
    let speeds: Vec<f64> = (0..99)
        .map(|k| (f64::from(k) * 0.05).sin().powi(2) * 0.2)
        .collect();
    bencher.bench(|| spectral_arc_length(&speeds, 100.0));
}

/// 595 demonstrations of 100 configurations; a query beside one of them.
#[divan::bench(args = [usize::MAX, 10])]
fn nearest_of_595(bencher: divan::Bencher<'_, '_>, band: usize) {
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
    bencher
        .bench(|| Candidates::new(demonstrations.iter().map(Vec::as_slice), band).nearest(&query));
}
