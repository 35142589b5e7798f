//! Records that a file has and every output has: channels without messages, several channels of a topic,
//! ids that are used again; bookkeeping that contradicts the messages.

use std::collections::BTreeMap;
use std::io::Cursor;

use inhand_container::{
    Interval, Merge, Packing, Selection, Source, channels, merge, recover, select, span, verify,
};
use mcap::records::op;

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

fn channel(id: u8, topic: &str) -> Vec<u8> {
    let body = [&[id, 0, 0, 0], &text(topic)[..], &text("json"), &[0; 4]].concat();
    record(op::CHANNEL, &body)
}

fn message(channel: u8, time: u64) -> Vec<u8> {
    let times = [time.to_le_bytes(), time.to_le_bytes()].concat();
    record(
        op::MESSAGE,
        &[&[channel, 0, 0, 0, 0, 0][..], &times, b"{}"].concat(),
    )
}

/// A chunk that states these times, with a message index of the true ones.
fn chunk(records: &[u8], times: &[u64], stated: (u64, u64)) -> Vec<u8> {
    let body = [
        &stated.0.to_le_bytes()[..],
        &stated.1.to_le_bytes(),
        &(records.len() as u64).to_le_bytes(),
        &crc32fast::hash(records).to_le_bytes(),
        &text(""),
        &(records.len() as u64).to_le_bytes(),
        records,
    ];
    let entries: Vec<u8> = (times.iter())
        .flat_map(|time| [time.to_le_bytes(), [0; 8]].concat())
        .collect();
    let index = [&[1, 0][..], &(entries.len() as u32).to_le_bytes(), &entries].concat();
    [
        record(op::CHUNK, &body.concat()),
        record(op::MESSAGE_INDEX, &index),
    ]
    .concat()
}

/// A file of chunks, whose summary lists these channels and these times of the chunks.
fn file(chunks: &[Vec<u8>], listed: &[Vec<u8>], stated: (u64, u64), messages: u64) -> Vec<u8> {
    let mut bytes = [mcap::MAGIC, &record(op::HEADER, &[0; 8])].concat();
    let mut indexes = Vec::new();
    for chunk in chunks {
        let length = 9 + u64::from_le_bytes(chunk[1..9].try_into().unwrap());
        let start = bytes.len() as u64;
        let body = [
            &chunk[9..25],
            &start.to_le_bytes(),
            &length.to_le_bytes(),
            &10_u32.to_le_bytes(),
            &[1, 0],
            &(start + length).to_le_bytes(),
            &(chunk.len() as u64 - length).to_le_bytes(),
            &text(""),
            &[0; 16],
        ];
        indexes.extend(record(op::CHUNK_INDEX, &body.concat()));
        bytes.extend(chunk);
    }
    bytes.extend(record(op::DATA_END, &[0; 4]));
    let start = bytes.len() as u64;
    bytes.extend(listed.concat());
    let statistics = [
        &messages.to_le_bytes()[..],
        &[0, 0],
        &(listed.len() as u32).to_le_bytes(),
        &[0; 8],
        &(chunks.len() as u32).to_le_bytes(),
        &stated.0.to_le_bytes(),
        &stated.1.to_le_bytes(),
        &[0; 4],
    ];
    bytes.extend(record(op::STATISTICS, &statistics.concat()));
    bytes.extend(indexes);
    bytes.extend(record(
        op::FOOTER,
        &[&start.to_le_bytes()[..], &[0; 12]].concat(),
    ));
    bytes.extend(mcap::MAGIC);
    bytes
}

fn source(bytes: &[u8]) -> Source<'_> {
    Source::open("in.mcap", Cursor::new(bytes)).unwrap()
}

/// Topics by id, as the summary lists them.
fn topics(bytes: &[u8]) -> BTreeMap<u16, String> {
    let channels = channels(&mut source(bytes)).unwrap();
    channels
        .into_iter()
        .map(|channel| (channel.id, channel.topic))
        .collect()
}

fn selected(bytes: &[u8], selection: &Selection<'_>) -> Vec<u8> {
    let mut out = Vec::new();
    let selected = select(&mut source(bytes), &mut out, selection).unwrap();
    verify(&mut source(&out), &selected.written).unwrap();
    out
}

fn merged(bytes: &[u8]) -> Vec<u8> {
    let settings = Merge {
        library: "",
        keep_both: false,
        metadata: &|_, record| record,
        packing: Packing::Lz4,
    };
    let mut out = Vec::new();
    merge(vec![source(bytes)], &mut out, &settings).unwrap();
    out
}

fn recovered(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let recovered = recover("x", Cursor::new(bytes), &mut out, false, |_| None).unwrap();
    assert!(!recovered.is_lossy(), "{recovered:#?}");
    out
}

/// Topics and times of all messages, as the mcap crate reads them from front to back.
fn sent(bytes: &[u8]) -> Vec<(String, u64)> {
    (mcap::MessageStream::new(bytes).unwrap())
        .map(|message| message.unwrap())
        .map(|message| (message.channel.topic.clone(), message.log_time))
        .collect()
}

#[test]
fn channels_in_the_summary_alone_are_in_every_output() {
    let listed = [
        channel(1, "/a"),
        channel(2, "/silent"),
        channel(5, "/silent"),
    ];
    let records = [message(1, 3), message(1, 7)].concat();
    // Not even the channel with messages is defined in the data.
    for records in [records.clone(), [channel(1, "/a"), records].concat()] {
        let bytes = file(&[chunk(&records, &[3, 7], (3, 7))], &listed, (3, 7), 2);
        let part = Selection {
            keep: vec![Interval::new(0, Some(7))],
            ..Selection::default()
        };
        let outputs = [
            (selected(&bytes, &Selection::default()), 2),
            (selected(&bytes, &part), 1),
            (merged(&bytes), 2),
            (recovered(&bytes), 2),
        ];
        for (output, messages) in outputs {
            let expected = [(1, "/a"), (2, "/silent"), (5, "/silent")];
            let expected = expected.map(|(id, topic)| (id, topic.to_owned())).into();
            assert_eq!(topics(&output), expected);
            assert_eq!(sent(&output).len(), messages);
        }
    }
}

#[test]
fn a_channel_that_is_left_out_stays_out_of_the_summary() {
    let listed = [channel(1, "/a"), channel(2, "/silent")];
    let records = [channel(1, "/a"), message(1, 3)].concat();
    let bytes = file(&[chunk(&records, &[3], (3, 3))], &listed, (3, 3), 1);
    let output = selected(
        &bytes,
        &Selection {
            channels: Some(&|channel| channel.topic == "/a"),
            ..Selection::default()
        },
    );
    assert_eq!(topics(&output), BTreeMap::from([(1, "/a".to_owned())]));
}

#[test]
fn an_id_that_is_used_again_is_another_channel() {
    let first = [channel(1, "/a"), message(1, 1)].concat();
    let second = [channel(1, "/b"), message(1, 2)].concat();
    let third = [channel(1, "/a"), message(1, 3)].concat();
    let chunks = [first, second, third].map(|records| chunk(&records, &[2], (1, 3)));
    let bytes = file(&chunks, &[channel(1, "/b")], (1, 3), 3);
    let expected = [("/a", 1), ("/b", 2), ("/a", 3)].map(|(topic, time)| (topic.to_owned(), time));
    assert_eq!(sent(&recovered(&bytes)), expected);
    assert_eq!(sent(&merged(&bytes)), expected);
    let of_b = Selection {
        channels: Some(&|channel| channel.topic == "/b"),
        ..Selection::default()
    };
    assert_eq!(sent(&selected(&bytes, &of_b)), [("/b".to_owned(), 2)]);
}

#[test]
fn a_chunk_is_not_skipped_on_the_word_of_wrong_times() {
    let times: Vec<u64> = (0..40).map(|k| 1000 + k).collect();
    let chunks = |stated: fn(&[u64]) -> (u64, u64)| -> Vec<_> {
        (times.chunks(10))
            .map(|times| {
                let messages: Vec<u8> = times.iter().flat_map(|time| message(1, *time)).collect();
                chunk(&[channel(1, "/a"), messages].concat(), times, stated(times))
            })
            .collect()
    };
    let right = chunks(|times| (times[0], times[times.len() - 1]));
    let zero = chunks(|_| (0, 0));
    let other = chunks(|_| (5, 6));
    let listed = [channel(1, "/a")];
    for (chunks, stated) in [
        (&right, (1000, 1039)),
        (&right, (9, 9)),
        (&zero, (1000, 1039)),
        (&zero, (0, 0)),
        (&other, (1000, 1039)),
        (&other, (5, 6000)),
    ] {
        let bytes = file(chunks, &listed, stated, 40);
        assert_eq!(
            span(&mut source(&bytes)).unwrap(),
            Some((1000, 1039)),
            "{stated:?}"
        );
        let part = Selection {
            keep: vec![Interval::new(1015, Some(1025))],
            ..Selection::default()
        };
        let times: Vec<u64> = sent(&selected(&bytes, &part))
            .into_iter()
            .map(|sent| sent.1)
            .collect();
        assert_eq!(times, (1015..1025).collect::<Vec<_>>(), "{stated:?}");
    }
}

#[test]
fn two_joined_files_are_recovered_as_one() {
    let one = |topic: &str, time: u64| {
        let records = [channel(1, topic), message(1, time)].concat();
        file(
            &[chunk(&records, &[time], (time, time))],
            &[channel(1, topic)],
            (time, time),
            1,
        )
    };
    let bytes = [one("/a", 5), one("/b", 3), one("/a", 4)].concat();
    let expected = [("/a", 5), ("/b", 3), ("/a", 4)].map(|(topic, time)| (topic.to_owned(), time));
    let output = recovered(&bytes);
    assert_eq!(sent(&output), expected);
    assert_eq!(topics(&output).len(), 2);
}
