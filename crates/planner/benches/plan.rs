//! Planning with 200 primitives over one second at 100 Hz: both backends, and the same problem
//! handed to Clarabel with all 2970 velocity rows present.
//!
//! `cargo bench -p inhand-planner`; one thread throughout.

use divan::Bencher;
use inhand_model::{Dictionary, DictionaryKind};
use inhand_planner::{Backend, Method, Planner, PlannerSettings, Target};

#[expect(dead_code, reason = "the benches need a part of what the tests need")]
#[path = "../tests/suite/support.rs"]
mod support;

const SAMPLES: usize = 100;
const RANK: usize = 200;
/// Targets off the mean by so much that some forty activations end at zero, as on recordings.
const REACH_M: f64 = 0.01;

fn main() {
    divan::main();
}

fn problem() -> (Dictionary, PlannerSettings, Vec<Target>) {
    let dictionary = support::smooth(DictionaryKind::Nmf, SAMPLES, RANK);
    let targets = (0..32)
        .map(|case| support::target(&dictionary, case, REACH_M))
        .collect();
    (dictionary, support::settings(support::bounds(0.3)), targets)
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
    let (dictionary, settings, targets) = problem();
    let planner = Planner::new(&dictionary, method, &settings)
        .expect("the formula makes a sound dictionary")
        .with_backend(backend);
    let mut next = targets.iter().cycle();
    bencher
        .with_inputs(|| next.next().expect("a cycle has no end"))
        .bench_local_values(|target| planner.plan(target));
}

#[divan::bench(args = Method::ALL, sample_count = 2, sample_size = 1)]
fn plain_clarabel_with_every_row(bencher: Bencher, method: Method) {
    let (dictionary, settings, targets) = problem();
    let plain = support::Plain::new(&dictionary, method, &settings, &targets[0]);
    bencher.bench_local(|| plain.solve());
}
