//! Time to learn a hand session: 200 primitives from 595 segments of 1500 numbers, beside the plain
//! version on a smaller problem.
//!
//!     cargo bench -p inhand-dictionary

use inhand_dictionary::{NmfSettings, Projection, Update, learn_nmf, learn_pca};
use nalgebra::DMatrix;

#[path = "../tests/plain.rs"]
mod plain;
#[path = "../tests/segments.rs"]
mod segments;

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
            plain::iterate(&v, &mut w, &mut h, 3);
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
    let projection = Projection::new(&dictionary);
    bencher.bench(|| projection.activations(data.column_m(7)));
}
