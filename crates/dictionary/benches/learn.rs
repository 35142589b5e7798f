//! Time to learn a hand session: 200 primitives from 595 segments of 1500 numbers, beside the plain
//! version on a smaller problem; to learn deviations from the cubic Hermite baseline, and what to expect of one.
//!
//!     cargo bench -p inhand-dictionary

use inhand_dictionary::{
    DEVIATION_PRIMITIVES, NmfSettings, Update, activations, learn_nmf, learn_pca, learn_residual,
};
use inhand_model::{Bandwidths, PredictorWeights, SegmentLayout, Segments};
use nalgebra::DMatrix;

#[path = "../tests/plain.rs"]
mod plain;
#[expect(dead_code, reason = "the tests use all of it")]
#[path = "../tests/residual_data.rs"]
mod residual_data;
#[path = "../tests/segments.rs"]
mod segments;

use residual_data::{around_smooth, bump, conditions, deviations, displacement, numbers, uniform};
use segments::{demonstrated, motion, segments as segments_of};

fn main() {
    divan::main();
}

fn settings(rank: usize, max_iterations: usize, update: Update) -> NmfSettings {
    NmfSettings {
        rank,
        max_iterations,
        relative_change: 0.0,
        update,
        ..NmfSettings::default()
    }
}

/// A whole session, by iterations.
#[divan::bench(args = [1, 10, 40], sample_count = 5)]
fn nmf_session(bencher: divan::Bencher<'_, '_>, iterations: usize) {
    let data = segments_of(motion(100, 595));
    let settings = settings(200, iterations, Update::Hals);
    bencher.bench(|| learn_nmf(&data, demonstrated(), &settings));
}

/// The same with multiplicative updates.
#[divan::bench(sample_count = 5)]
fn nmf_session_multiplicative_10(bencher: divan::Bencher<'_, '_>) {
    let data = segments_of(motion(100, 595));
    let settings = settings(200, 10, Update::Multiplicative);
    bencher.bench(|| learn_nmf(&data, demonstrated(), &settings));
}

/// Ten iterations of a small problem, fast version.
#[divan::bench(sample_count = 10)]
fn nmf_small(bencher: divan::Bencher<'_, '_>) {
    let data = segments_of(motion(20, 120));
    let settings = settings(50, 10, Update::Hals);
    bencher.bench(|| learn_nmf(&data, demonstrated(), &settings));
}

/// Ten iterations of the same small problem, plain version with as many sweeps.
#[divan::bench(sample_count = 10)]
fn nmf_small_plain(bencher: divan::Bencher<'_, '_>) {
    let v = motion(20, 120).add_scalar(0.2);
    bencher.bench(|| {
        let mut w = DMatrix::from_fn(300, 50, |r, c| ((r * 50 + c) as f64).sin().abs());
        let mut h = DMatrix::from_element(50, 120, 0.01);
        for _ in 0..10 {
            plain::iterate(&v, &mut w, &mut h, 4);
        }
        plain::objective(&v, &w, &h)
    });
}

/// Principal components of a whole session.
#[divan::bench(sample_count = 3)]
fn pca_session(bencher: divan::Bencher<'_, '_>) {
    let data = segments_of(motion(100, 595));
    bencher.bench(|| learn_pca(&data, demonstrated(), 30));
}

/// One segment onto 200 primitives.
#[divan::bench(sample_count = 10)]
fn projection(bencher: divan::Bencher<'_, '_>) {
    let data = segments_of(motion(100, 595));
    let dictionary = learn_nmf(&data, demonstrated(), &settings(200, 5, Update::Hals))
        .expect("the bench's own data can be learned");
    bencher.bench(|| activations(&dictionary, data.column_m(7)));
}

/// Segments of 100 samples in five takes that deviate from the cubic Hermite baseline in sixty shapes.
fn deviating(count: usize) -> Segments {
    let layout = SegmentLayout::one_second(100.0);
    let x = conditions(layout, 0, count);
    let shapes = DMatrix::from_fn(layout.samples, 60, |t, k| {
        let s = t as f64 / (layout.samples - 1) as f64;
        (std::f64::consts::PI * (k as f64 + 1.0) * s).sin() / (k as f64 + 1.0).powf(1.5)
    });
    let deviations_m = deviations(layout, count, |i, c, s| {
        let t = (s * (layout.samples - 1) as f64).round() as usize;
        let shape = |k: usize| shapes[(t, k)] * uniform(&[11, i, c, k]);
        0.2 * bump(s) * displacement(&x, i, c) + 1e-3 * (0..60).map(shape).sum::<f64>()
    });
    around_smooth(layout, &x, &deviations_m, count.div_ceil(5))
}

/// Deviations of a whole session, with their cross-validation.
#[divan::bench(sample_count = 10)]
fn residual_session(bencher: divan::Bencher<'_, '_>) {
    let data = deviating(595);
    bencher.bench(|| learn_residual(&data, DEVIATION_PRIMITIVES));
}

/// What to expect of one segment, by demonstrations: a session cut at stride 100, and at stride 10.
#[divan::bench(args = [595, 5950], sample_count = 100)]
fn expected(bencher: divan::Bencher<'_, '_>, demonstrations: usize) {
    let data = deviating(demonstrations);
    let residual =
        learn_residual(&data, DEVIATION_PRIMITIVES).expect("the bench's own data can be learned");
    // As a session of a real hand has them.
    let widths = Bandwidths {
        hand: 2.0,
        finger: 0.5,
    };
    let weights = PredictorWeights {
        profile: 0.9,
        hand: 0.5,
        finger: 0.7,
    };
    let expectation = residual.expectation.weighted(widths, weights);
    let x = numbers(100_000, data.layout());
    bencher.bench(|| expectation.expected_m(&x));
}
