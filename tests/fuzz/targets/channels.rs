#![no_main]

use std::io::Cursor;

use inhand_channels::{
    info, preview, read_annotations, read_dictionary, read_evaluated, read_file_events,
    read_generated, read_leading_metadata, read_metadata, read_take, write_dictionary,
};
use inhand_container::Source;
use inhand_fuzz::documents;
use inhand_model::Protocol;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    inhand_fuzz::mutate::mutate(data, size, max_size, seed)
});

fuzz_target!(init: inhand_fuzz::start(), |bytes: &[u8]| {
    let turn = inhand_fuzz::turn(bytes, 4) as usize;
    if turn == 0 {
        let _ = info(bytes, "take.mcap");
    }
    if let Ok(mut source) = Source::open("take.mcap", Cursor::new(bytes)) {
        let _ = preview(&mut source);
    }
    let _ = read_leading_metadata(bytes);
    let _ = read_annotations(bytes, "take.mcap");
    if let Ok(mut source) = Source::open("take.mcap", Cursor::new(bytes)) {
        let _ = read_file_events(&mut source);
    }
    if let Ok(metadata) = read_metadata(bytes, "take.mcap") {
        let _ = metadata.provenance("take.mcap");
    }
    if let Ok(take) = read_take(bytes, "take.mcap") {
        documents::check_recording(&take.recording);
    }
    let _ = read_evaluated(bytes, "take.mcap");
    let _ = read_generated(bytes, "take.mcap", Protocol::ALL[turn % Protocol::ALL.len()]);
    if let Ok((dictionary, provenance)) = read_dictionary(bytes, "dictionary.mcap") {
        let mut out = Vec::new();
        write_dictionary(&mut out, &dictionary, &provenance).expect("a dictionary that was read is written");
        let (again, _) = read_dictionary(&out, "again.mcap").expect("own output");
        assert_eq!(format!("{dictionary:?}"), format!("{again:?}"), "read again");
    }
});
