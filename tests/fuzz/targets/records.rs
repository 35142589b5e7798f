#![no_main]

use std::io::Cursor;

use inhand_container::{
    ContainerError, Depth, Record, Source, Timeline, channels, listed, metadata, profile, span,
    walk,
};
use inhand_fuzz::files;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    inhand_fuzz::mutate::mutate(data, size, max_size, seed)
});

fuzz_target!(init: inhand_fuzz::start(), |bytes: &[u8]| {
    let mut walked = Vec::new();
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
    let _ = channels(&mut source);
    let _ = span(&mut source);
    let timed = in_time(source);
    let (others, fault) = files::messages(bytes);
    if fault.is_ok() && everything.is_ok() {
        let others: Vec<_> = others.into_iter().map(|(_, sequence, log, publish, data)| (sequence, log, publish, data)).collect();
        assert_eq!(walked, others, "walked and read by the mcap crate");
    }
    if everything.is_ok() {
        assert_eq!((true, true, true), of_headers, "the file is sound");
        if let Ok(timed) = timed {
            walked.sort_by_key(|message| message.1);
            let times = |messages: &[(u32, u64, u64, Vec<u8>)]| messages.first().map(|m| m.1).zip(messages.last().map(|m| m.1));
            assert_eq!(times(&walked), times(&timed), "first and last time");
            walked.sort();
            let mut timed = timed;
            timed.sort();
            assert_eq!(walked, timed, "in the order of time");
        }
    }
});

type Timed = Vec<(u32, u64, u64, Vec<u8>)>;

/// The messages in the order of time, and from the middle on.
fn in_time(source: Source<'_>) -> Result<Timed, ContainerError> {
    let mut timeline = Timeline::open(source)?;
    let mut messages = Timed::new();
    while let Some(m) = timeline.next_message()? {
        assert!(
            messages.last().is_none_or(|last| last.1 <= m.log_time),
            "in order"
        );
        messages.push((m.sequence, m.log_time, m.publish_time, m.data.to_vec()));
    }
    if let Some((first, last)) = timeline.span() {
        let middle = first + (last - first) / 2;
        timeline.latest_before(middle)?;
        timeline.seek(middle);
        let mut later = 0;
        while timeline.next_message()?.is_some() {
            later += 1;
        }
        assert_eq!(
            later,
            messages.iter().filter(|m| m.1 >= middle).count(),
            "from {middle}"
        );
    }
    Ok(messages)
}
