//! A take of two minutes at 100 Hz with eleven markers and two bodies: written and read.
//!
//! `cargo bench -p inhand-channels`

#![expect(clippy::unwrap_used, reason = "a bench may stop at what cannot fail")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::io::Cursor;

use divan::Bencher;
use inhand_channels::{
    TakeFile, Views, info, read_dictionary, read_take, write_dictionary, write_take,
};

const SAMPLES: usize = 12_000;

fn main() {
    divan::main();
}

/// What a training take's file holds.
fn train(take: &common::Take) -> TakeFile<'_> {
    common::take_file(take, &[], &[])
}

fn written(file: &TakeFile, view: bool) -> Vec<u8> {
    let mut out = Cursor::new(Vec::with_capacity(32 << 20));
    let views = if view { Views::All } else { Views::None };
    write_take(&mut out, file, views).unwrap();
    out.into_inner()
}

#[divan::bench(args = [false, true])]
fn write_training_take(bencher: Bencher, view: bool) {
    let take = common::take(SAMPLES, 100.0);
    let file = train(&take);
    bencher.bench_local(|| written(&file, view));
}

/// With six methods generated and evaluated.
#[divan::bench]
fn write_test_take(bencher: Bencher) {
    let names = ["prior", "paper", "hold", "line", "minimum_jerk", "hermite"];
    let take = common::take(SAMPLES, 100.0);
    let segments = common::segments(&take);
    let generated = common::generated(&names, &segments);
    let evaluated = common::evaluated(&names, &take);
    let file = common::take_file(&take, &generated, &evaluated);
    bencher.bench_local(|| written(&file, true));
}

#[divan::bench]
fn read_training_take(bencher: Bencher) {
    let take = common::take(SAMPLES, 100.0);
    let bytes = written(&train(&take), true);
    bencher.bench_local(|| read_take(&bytes, "take.mcap").unwrap());
}

#[divan::bench]
fn list_training_take(bencher: Bencher) {
    let take = common::take(SAMPLES, 100.0);
    let bytes = written(&train(&take), true);
    bencher.bench_local(|| info(&bytes, "take.mcap").unwrap());
}

/// With rank 200, and a learned deviation that keeps as many demonstrations as the argument says.
#[divan::bench(args = [595, 5950])]
fn read_a_dictionary(bencher: Bencher, demonstrations: usize) {
    let mut dictionary = common::dictionary(200, 100, 100.0);
    let layout = dictionary.layout;
    dictionary.residual = Some(common::residual_with(layout, 24, demonstrations));
    let mut out = Cursor::new(Vec::new());
    write_dictionary(&mut out, &dictionary, &[]).unwrap();
    bencher.bench_local(|| read_dictionary(out.get_ref(), "dictionary.mcap").unwrap());
}

#[divan::bench]
fn write_and_read_dictionary(bencher: Bencher) {
    let dictionary = common::dictionary(200, 100, 100.0);
    bencher.bench_local(|| {
        let mut out = Cursor::new(Vec::new());
        write_dictionary(&mut out, &dictionary, &[]).unwrap();
        read_dictionary(out.get_ref(), "dictionary.mcap").unwrap()
    });
}
