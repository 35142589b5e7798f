#![no_main]

use std::io::Cursor;

use inhand_container::Source;
use inhand_fuzz::documents;
use inhand_import::{ImportSettings, read_take, views_for};
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    inhand_fuzz::mutate::mutate(data, size, max_size, seed)
});

fuzz_target!(init: inhand_fuzz::start(), |bytes: &[u8]| {
    let read = read_take(bytes, "bag.mcap", &ImportSettings::default());
    if let Ok(mut source) = Source::open("bag.mcap", Cursor::new(bytes)) {
        let _ = views_for(&mut source, &ImportSettings::default());
    }
    if let Ok(read) = read
        && inhand_fuzz::turn(bytes, 4) == 0
    {
        documents::check_recording(&read.recording);
    }
});
