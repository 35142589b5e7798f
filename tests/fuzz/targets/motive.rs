#![no_main]

libfuzzer_sys::fuzz_target!(init: inhand_fuzz::start(), |bytes: &[u8]| inhand_fuzz::capture::check(bytes));
