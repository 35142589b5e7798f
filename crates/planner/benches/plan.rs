//! Planning with 200 unknowns over one second at 100 Hz: both backends, the same problem handed to
//! Clarabel with all 2970 velocity rows present, and each further family of constraints.
//!
//! `cargo bench -p inhand-planner`; one thread throughout.

use divan::Bencher;
use inhand_model::{Dictionary, DictionaryKind, EndConditions};
use inhand_planner::{Backend, Method, Planner, PlannerSettings, Target};

#[expect(dead_code, reason = "the benches need a part of what the tests need")]
#[path = "../tests/suite/support.rs"]
mod support;

#[expect(dead_code, reason = "the benches need a part of what the tests need")]
#[path = "../tests/suite/plain.rs"]
mod plain;

#[path = "plan/constraints.rs"]
mod constraints;
#[path = "plan/residual.rs"]
mod residual;

const SAMPLES: usize = 100;
const RANK: usize = 200;
/// Targets that far off the mean motion.
const REACH_M: f64 = 0.01;
/// As on recordings, where the bounds are 1.1 times the training extremes: hardly ever active.
const VELOCITY_M_S: f64 = 2.0;

fn main() {
    divan::main();
}

/// Primitives as slow as those of a hand, up to 2 Hz, and activations that spread by as much as
/// their mean, so that a good part of them ends at zero.
fn problem() -> (Dictionary, PlannerSettings, Vec<EndConditions>) {
    let mut dictionary = support::smooth(DictionaryKind::Nmf, SAMPLES, RANK);
    for (k, mut column) in dictionary.primitives.column_iter_mut().enumerate() {
        for (row, w) in column.iter_mut().enumerate() {
            let (t, c) = ((row / 15) as f64 / SAMPLES as f64, (row % 15) as f64);
            let phase = std::f64::consts::TAU * 0.01 * k as f64 * t + 0.7 * k as f64 + c;
            *w = (1.0 + phase.sin()) * (1.1 + (0.9 * c * (k as f64 + 1.0)).cos());
        }
        let length = column.norm();
        column /= length;
    }
    dictionary.activation_mean_m *= 0.5;
    let targets = (0..32)
        .map(|case| support::ends(&dictionary, case, REACH_M))
        .collect();
    let settings = support::settings(support::bounds(VELOCITY_M_S));
    (dictionary, settings, targets)
}

/// Plans to one target after the other.
fn plan_in_turn(bencher: Bencher, planner: &Planner, targets: &[Target]) {
    let mut next = targets.iter().cycle();
    bencher
        .with_inputs(|| next.next().expect("a cycle has no end"))
        .bench_local_values(|target| planner.plan(target));
}

#[divan::bench(args = Method::ALL)]
fn prepare(bencher: Bencher, method: Method) {
    let (dictionary, settings, _) = problem();
    bencher.bench_local(|| Planner::new(&dictionary, method, &settings));
}

#[divan::bench(args = Method::ALL)]
fn plan_by_active_set(bencher: Bencher, method: Method) {
    plan(bencher, method, Backend::ActiveSet);
}

#[divan::bench(args = Method::ALL, sample_count = 20)]
fn plan_by_clarabel(bencher: Bencher, method: Method) {
    plan(bencher, method, Backend::Clarabel);
}

fn plan(bencher: Bencher, method: Method, backend: Backend) {
    let (dictionary, settings, ends) = problem();
    let targets: Vec<Target> = ends.iter().map(|ends| method.target(ends)).collect();
    let planner = Planner::new(&dictionary, method, &settings)
        .expect("the formula makes a sound dictionary")
        .with_backend(backend);
    plan_in_turn(bencher, &planner, &targets);
}

#[divan::bench(args = Method::ALL, sample_count = 1, sample_size = 1)]
fn plain_clarabel_with_every_row(bencher: Bencher, method: Method) {
    let (dictionary, settings, ends) = problem();
    let plain = support::plain(&dictionary, method, &settings, &ends[0]);
    bencher.bench_local(|| plain.solve());
}
