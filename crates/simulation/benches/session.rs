//! Simulation of a take and of the demo's session.

use divan::Bencher;
use inhand_model::Shape;
use inhand_simulation::{SessionSettings, TakeSettings, session, simulate};

fn main() {
    divan::main();
}

/// One take of 120 s at 100 Hz, one thread.
#[divan::bench]
fn take(bencher: Bencher) {
    let settings = TakeSettings::cube("take");
    bencher.bench(|| simulate(divan::black_box(&settings), 1));
}

/// Six such takes, all threads.
#[divan::bench]
fn six_takes(bencher: Bencher) {
    let settings = SessionSettings::new(Shape::Cuboid { edges_m: [0.05; 3] });
    bencher.bench(|| session(divan::black_box(&settings), 1));
}
