#![no_main]

use std::collections::BTreeSet;
use std::io::Cursor;

use inhand_container::{ContainerError, Recovered, Source, recover, verify};
use inhand_fuzz::files;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    inhand_fuzz::mutate::mutate(data, size, max_size, seed)
});

fuzz_target!(init: inhand_fuzz::start(), |bytes: &[u8]| {
    let (mut before, fault) = files::messages(bytes);
    if fault.is_err() {
        // Where damage follows a record, nothing says that it ends there.
        before.pop();
    }
    let (out, recovered) = match recovered(bytes, false) {
        Ok(done) => done,
        Err(ContainerError::NotMcap { .. }) if before.is_empty() => return,
        Err(error) => panic!("{error}"),
    };
    let (streamed, readable) = files::messages(&out);
    readable.expect("own output is read by others");
    let mut sorted = streamed.clone();
    sorted.sort();
    assert_eq!(files::indexed(&out).expect("indexed"), sorted, "by indexes and as a stream");
    assert_eq!(sorted.len() as u64, recovered.written.messages, "counted");
    // What others read before the first fault is intact. Of two definitions that contradict each other one counts.
    let plain = |m: &files::Message| (m.1, m.2, m.3, m.4.clone());
    let saved: BTreeSet<_> = streamed.iter().map(plain).collect();
    let lost: Vec<_> = before.iter().filter(|message| !saved.contains(&plain(message))).collect();
    assert!(lost.is_empty(), "not saved: {lost:?}");
    if fault.is_ok() && !recovered.is_lossy() {
        assert_eq!(streamed, before, "said to be all");
    }
    let turn = inhand_fuzz::turn(bytes, 4);
    if turn == 0 {
        let (again, second) = self::recovered(&out, false).expect("own output");
        assert!(!second.is_lossy(), "own output is lossy: {second:?}");
        assert_eq!(again, out, "recovered again");
    }
    if turn == 1
        && recovered.is_lossy()
        && let Ok((kept, with)) = self::recovered(bytes, true)
    {
        files::messages(&kept).1.expect("unverified ones too");
        assert!(with.written.messages >= recovered.written.messages, "more with unverified ones");
    }
});

fn recovered(bytes: &[u8], keep_unverified: bool) -> Result<(Vec<u8>, Recovered), ContainerError> {
    let mut out = Vec::new();
    let recovered = recover(
        "in.mcap",
        Cursor::new(bytes),
        &mut out,
        keep_unverified,
        |_| None,
    )?;
    let mut source = Source::open("out.mcap", Cursor::new(&out)).expect("own output opens");
    verify(&mut source, &recovered.written).expect("own output verifies");
    drop(source);
    Ok((out, recovered))
}
