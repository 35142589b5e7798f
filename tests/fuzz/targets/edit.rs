#![no_main]

use std::io::Cursor;

use inhand_container::{
    Interval, Merge, MetadataRecord, Packing, Selection, Source, Written, merge, select, verify,
};
use inhand_fuzz::files;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    inhand_fuzz::mutate::mutate(data, size, max_size, seed)
});

fuzz_target!(init: inhand_fuzz::start(), |bytes: &[u8]| {
    let (messages, fault) = files::messages(bytes);
    let turn = inhand_fuzz::turn(bytes, 4);
    // Where others read the file, they read what is made of it.
    let readable = fault.is_ok() && files::is_orderly(bytes);
    let everything = Selection::default();
    if let Some((out, _)) = selected(bytes, &everything)
        && readable
    {
        assert_eq!(files::messages(&out).0, messages, "everything");
        if let Ok(records) = files::records(bytes) {
            let copied = files::records(&out).expect("readable");
            // Definitions of the summary alone are written where they are needed, too.
            let mut rest = copied.iter();
            let lost: Vec<_> = records.iter().filter(|record| !rest.any(|copy| copy == *record)).collect();
            assert!(lost.is_empty(), "not copied: {lost:?}");
            let more = copied.len() - records.len();
            let defined = copied.iter().filter(|record| record.starts_with("Schema") || record.starts_with("Channel"));
            assert!(more <= defined.count(), "{more} more records");
        }
        if turn == 0 {
            let again = selected(&out, &everything).expect("own output");
            assert_eq!(again.0, out, "everything of everything");
        }
    }
    let middle = messages.get(messages.len() / 2).map_or(5, |message| message.2);
    let part = Selection {
        keep: vec![Interval::new(middle, None)],
        channels: Some(&|channel| channel.id != 1),
        append: Some(bytes),
        packing: Some(Packing::Lz4),
        add: vec![MetadataRecord { name: "note".to_owned(), facts: Default::default() }],
        ..Selection::default()
    };
    if turn == 1
        && let Some((out, _)) = selected(bytes, &part)
        && readable
    {
        files::messages(&out).1.expect("part");
    }
    let until = Interval::new(0, Some(middle));
    let early = Selection { keep: vec![until], packing: Some(Packing::None), ..Selection::default() };
    if turn == 2
        && let Some((out, written)) = selected(bytes, &early)
        && readable
    {
        let kept: Vec<_> = messages.iter().filter(|message| message.2 < middle).cloned().collect();
        assert_eq!(files::messages(&out).0, kept, "up to {middle}");
        let mut kept = kept;
        kept.sort();
        assert_eq!(files::indexed(&out).expect("indexed"), kept, "up to {middle}");
        assert_eq!(kept.len() as u64, written.messages);
    }
    if turn == 3 {
        merged(bytes, readable.then_some(&messages));
    }
});

fn check(out: &[u8], written: &Written) {
    let mut source = Source::open("out.mcap", Cursor::new(out)).expect("own output opens");
    verify(&mut source, written).expect("own output verifies");
}

fn selected(bytes: &[u8], selection: &Selection<'_>) -> Option<(Vec<u8>, Written)> {
    let mut out = Vec::new();
    let mut source = Source::open("in.mcap", Cursor::new(bytes)).ok()?;
    let selected = select(&mut source, &mut out, selection).ok()?;
    check(&out, &selected.written);
    Some((out, selected.written))
}

/// Merges a file with itself.
fn merged(bytes: &[u8], messages: Option<&Vec<files::Message>>) {
    let settings = Merge {
        library: "",
        keep_both: true,
        metadata: &|_, record| record,
        packing: Packing::Zstd,
    };
    let open = |name| Source::open(name, Cursor::new(bytes));
    let mut out = Vec::new();
    let (Ok(a), Ok(b)) = (open("a.mcap"), open("b.mcap")) else {
        return;
    };
    let Ok(merged) = merge(vec![a, b], &mut out, &settings) else {
        return;
    };
    check(&out, &merged.written);
    let Some(messages) = messages else { return };
    let (mut both, fault) = files::messages(&out);
    fault.expect("merged");
    let mut twice: Vec<_> = messages.iter().chain(messages).cloned().collect();
    twice.sort();
    both.sort();
    assert_eq!(both, twice, "merged with itself");
    assert_eq!(
        files::indexed(&out).expect("indexed"),
        twice,
        "merged, by indexes"
    );
}
