#![no_main]

use std::io::Cursor;

use inhand_container::{
    ContainerError, Depth, Record, Selection, Source, Timeline, channels, listed, metadata,
    profile, select, span, walk,
};
use inhand_fuzz::files;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    inhand_fuzz::mutate::mutate(data, size, max_size, seed)
});

/// Sequence, log time, publish time and data.
type Message = (u32, u64, u64, Vec<u8>);

fuzz_target!(init: inhand_fuzz::start(), |bytes: &[u8]| {
    let mut walked: Vec<Message> = Vec::new();
    let everything = walk("a.mcap", bytes, Depth::Everything, |record| {
        if let Record::Message { header, data } = record {
            walked.push((header.sequence, header.log_time, header.publish_time, data.into_owned()));
        }
        Ok::<_, ContainerError>(())
    });
    let outside = walk("a.mcap", bytes, Depth::Outside, |_| Ok::<_, ContainerError>(()));
    assert!(outside.is_ok() || everything.is_err(), "only the quick walk fails: {outside:?}");
    let Ok(mut source) = Source::open("a.mcap", Cursor::new(bytes)) else { return };
    let of_headers = (listed(&mut source).is_ok(), metadata(&mut source).is_ok(), profile(&mut source).is_ok());
    let _ = (channels(&mut source).is_ok(), span(&mut source).is_ok());
    let timed = in_time(bytes);
    if everything.is_err() {
        return;
    }
    assert_eq!((true, true, true), of_headers, "the file is sound");
    let (others, fault) = files::messages(bytes);
    if fault.is_ok() {
        let others: Vec<Message> = others.into_iter().map(|(_, a, b, c, d)| (a, b, c, d)).collect();
        assert_eq!(walked, others, "walked and read by the mcap crate");
    }
    walked.sort();
    // An index that holds its checksum is trusted; in a copy it tells the truth.
    let (listed, _) = files::split(bytes.get(8..).unwrap_or_default());
    if listed.iter().all(|(opcode, _)| *opcode != mcap::records::op::CHUNK_INDEX)
        && let Ok(timed) = timed
    {
        check(&walked, timed);
    }
    if inhand_fuzz::turn(bytes, 4) != 0 {
        return;
    }
    let (mut copy, everything) = (Vec::new(), Selection::default());
    let mut source = Source::open("a.mcap", Cursor::new(bytes)).expect("opened before");
    if select(&mut source, &mut copy, &everything).is_ok() {
        match in_time(&copy) {
            Ok(timed) => check(&walked, timed),
            // Copies of messages without a channel have none.
            Err(error) => assert!(fault.is_err(), "own output: {error}"),
        }
    }
});

/// Compares all messages, sorted, with those in the order of time and those from the middle on.
fn check(all: &[Message], (timed, middle, later): (Vec<Message>, u64, usize)) {
    assert!(timed.is_sorted_by_key(|message| message.1), "in order");
    assert_eq!(
        timed.iter().filter(|message| message.1 >= middle).count(),
        later,
        "from {middle}"
    );
    let mut timed = timed;
    timed.sort();
    assert_eq!(all, timed, "in the order of time");
}

/// The messages in the order of time, the middle of the file, and how many come from there on.
fn in_time(bytes: &[u8]) -> Result<(Vec<Message>, u64, usize), ContainerError> {
    let mut timeline = Timeline::open(Source::open("a.mcap", Cursor::new(bytes))?)?;
    let mut messages = Vec::new();
    while let Some(m) = timeline.next_message()? {
        messages.push((m.sequence, m.log_time, m.publish_time, m.data.to_vec()));
    }
    let middle = (timeline.span()).map_or(0, |(first, last)| first / 2 + last / 2);
    timeline.latest_before(middle)?;
    timeline.seek(middle);
    let mut later = 0;
    while timeline.next_message()?.is_some() {
        later += 1;
    }
    Ok((messages, middle, later))
}
