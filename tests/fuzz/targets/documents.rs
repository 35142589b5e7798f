#![no_main]

use inhand_export::events::{parse_instant, parse_seconds};
use inhand_import::{TopicUse, bag_files, unpack_file};
use inhand_report::{evaluation_json, read_evaluation_json};

libfuzzer_sys::fuzz_target!(init: inhand_fuzz::start(), |bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    if *kind == 0 {
        let _ = unpack_file(bytes);
        return;
    }
    let text = &*String::from_utf8_lossy(bytes);
    match kind {
        1 => evaluation(text),
        2 => drop(bag_files(text)),
        3 => drop(text.parse::<TopicUse>()),
        _ => {
            parse_seconds(text);
            parse_instant(text, 1_700_000_000_000_000_000);
        }
    }
});

/// Reads an evaluation; what was read is written and read again.
fn evaluation(text: &str) {
    let Ok((evaluation, provenance)) = read_evaluation_json(text) else {
        return;
    };
    let written =
        evaluation_json(&evaluation, &provenance).expect("an evaluation that was read is written");
    let (_, again) = read_evaluation_json(&written).expect("own output");
    assert_eq!(
        format!("{provenance:?}"),
        format!("{again:?}"),
        "read again"
    );
}
