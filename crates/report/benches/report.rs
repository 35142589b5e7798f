//! Time from an evaluation to the bytes of its report.

#[path = "../tests/suite/sample.rs"]
mod sample;

use divan::Bencher;

fn main() {
    divan::main();
}

#[divan::bench]
fn html(bencher: Bencher<'_, '_>) {
    let (evaluation, provenance) = (sample::evaluation(true), sample::provenance());
    bencher.bench(|| inhand_report::html(&inhand_report::Report::new(&evaluation, &provenance)));
}

#[divan::bench]
fn evaluation_json(bencher: Bencher<'_, '_>) {
    let (evaluation, provenance) = (sample::evaluation(true), sample::provenance());
    bencher.bench(|| inhand_report::evaluation_json(&evaluation, &provenance));
}
