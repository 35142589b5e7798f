//! Messages by log time, compared with all messages of the file sorted.

use std::collections::BTreeMap;
use std::io::Cursor;

use inhand_container::{ContainerError, KeptMessage, Source, Timeline};
use proptest::prelude::*;

use crate::support::{PLAIN, Shape, file, messages, sent, shapes};

/// Topic, sequence, log time and data.
type Message = (String, u32, u64, Vec<u8>);

fn open(bytes: &[u8]) -> Result<Timeline<'_>, ContainerError> {
    Timeline::open(Source::open("in.mcap", Cursor::new(bytes))?)
}

fn topics(timeline: &Timeline<'_>) -> BTreeMap<u16, String> {
    (timeline.channels())
        .map(|channel| (channel.id, channel.topic.clone()))
        .collect()
}

/// All that follows.
fn rest(timeline: &mut Timeline<'_>) -> Vec<Message> {
    let topics = topics(timeline);
    let mut all = Vec::new();
    while let Some(due) = timeline.next_time().unwrap() {
        let message = timeline.next_message().unwrap().unwrap();
        assert_eq!(message.log_time, due);
        assert_eq!(message.publish_time, due / 2);
        let topic = topics[&message.channel].clone();
        all.push((topic, message.sequence, due, message.data.to_vec()));
    }
    assert!(timeline.next_message().unwrap().is_none());
    all
}

/// The messages of a file by time, those of equal time as they lie there.
fn sorted(bytes: &[u8]) -> Vec<Message> {
    let mut all = sent(bytes);
    all.sort_by_key(|(_, _, time, _)| *time);
    all
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(80) })]

    #[test]
    fn messages_come_as_if_all_were_sorted(
        shape in shapes(),
        messages in messages(),
        seeks in prop::collection::vec((0..1100_u64, 0..30_usize), 1..5),
    ) {
        let bytes = file(&shape, &messages);
        let all = sorted(&bytes);
        let mut timeline = open(&bytes).unwrap();
        let times = all.first().zip(all.last()).map(|(first, last)| (first.2, last.2));
        prop_assert_eq!(timeline.span(), times);
        prop_assert_eq!(rest(&mut timeline), all.clone());
        for (from, read) in seeks {
            timeline.seek(from);
            let expected: Vec<_> = all.iter().filter(|message| message.2 >= from).cloned().collect();
            // Left in the middle: the next seek starts anew all the same.
            for message in expected.iter().take(read) {
                prop_assert_eq!(timeline.next_message().unwrap().unwrap().data, &message.3[..]);
            }
            timeline.seek(from);
            prop_assert_eq!(rest(&mut timeline), expected);
        }
    }

    #[test]
    fn what_holds_is_what_a_look_at_all_messages_finds(
        shape in shapes(),
        messages in messages(),
        at in 0..1100_u64,
    ) {
        let bytes = file(&shape, &messages);
        let mut timeline = open(&bytes).unwrap();
        let found = timeline.latest_before(at).unwrap();
        // By place in `messages`, which the data tells.
        let mut numbered: Vec<_> = messages.iter().enumerate().collect();
        numbered.sort_by_key(|(_, (_, time))| *time);
        let data = crate::support::content;
        let mut last: BTreeMap<u16, KeptParts> = BTreeMap::new();
        let mut lasting: BTreeMap<Vec<u8>, u64> = BTreeMap::new();
        for (n, &(channel, time)) in numbered {
            if time < at {
                match channel {
                    0 => { lasting.entry(data(n)).or_insert(time); }
                    _ => { last.insert(channel, (channel, time, data(n))); }
                }
            }
        }
        let mut expected: Vec<KeptParts> = last.into_values().collect();
        expected.extend(lasting.into_iter().map(|(data, time)| (0, time, data)));
        expected.sort();
        prop_assert!(found.is_sorted_by_key(|message| message.log_time));
        let mut found: Vec<KeptParts> = found.into_iter().map(parts).collect();
        found.sort();
        prop_assert_eq!(found, expected);
        // Asking changes nothing of what comes next.
        prop_assert_eq!(rest(&mut timeline), sorted(&bytes));
    }
}

/// Channel, log time and data.
type KeptParts = (u16, u64, Vec<u8>);

fn parts(message: KeptMessage) -> KeptParts {
    (message.channel, message.log_time, message.data)
}

/// A hundred messages in several chunks.
fn hundred() -> Vec<(u16, u64)> {
    (0..100).map(|n| (1, n * 10)).collect()
}

#[test]
fn channels_carry_their_schemas() {
    for shape in [
        PLAIN,
        Shape {
            summary: false,
            ..PLAIN
        },
    ] {
        let bytes = file(&shape, &hundred());
        let timeline = open(&bytes).unwrap();
        let channels: Vec<_> = timeline.channels().collect();
        let topics: Vec<_> = channels.iter().map(|channel| &channel.topic[..]).collect();
        assert_eq!(topics, ["/tf_static", "/a", "/b", "/a"], "{shape:?}");
        let schema = channels[1].schema.as_ref().unwrap();
        assert_eq!(
            (&schema.name[..], &schema.encoding[..]),
            ("used", "jsonschema")
        );
        assert_eq!(schema.data, b"{}");
        assert_eq!(channels[2].schema, None);
    }
}

#[test]
fn a_file_without_messages_has_no_span() {
    let bytes = file(&PLAIN, &[]);
    let mut timeline = open(&bytes).unwrap();
    assert_eq!(timeline.span(), None);
    assert_eq!(timeline.next_time().unwrap(), None);
    assert_eq!(timeline.latest_before(u64::MAX).unwrap(), []);
}

/// A file that other programs may change while it is open.
fn changing(bytes: &[u8]) -> (tempfile::NamedTempFile, Timeline<'static>) {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    let source = Source::open("in.mcap", std::fs::File::open(file.path()).unwrap()).unwrap();
    let timeline = Timeline::open(source).unwrap();
    (file, timeline)
}

fn read_all(timeline: &mut Timeline<'_>) -> Result<usize, ContainerError> {
    let mut count = 0;
    while timeline.next_message()?.is_some() {
        count += 1;
    }
    Ok(count)
}

#[test]
fn a_file_that_shrinks_while_it_is_read_is_an_error() {
    let bytes = file(&PLAIN, &hundred());
    let (file, mut timeline) = changing(&bytes);
    assert_eq!(read_all(&mut timeline).unwrap(), 100);
    std::fs::write(file.path(), &bytes[..bytes.len() / 3]).unwrap();
    timeline.seek(0);
    let found = read_all(&mut timeline);
    assert!(
        matches!(found, Err(ContainerError::Truncated { .. })),
        "{found:?}"
    );
}

#[test]
fn a_file_that_is_overwritten_while_it_is_read_is_an_error() {
    let bytes = file(&PLAIN, &hundred());
    let (file, mut timeline) = changing(&bytes);
    let mut other = bytes.clone();
    for byte in &mut other[bytes.len() / 3..bytes.len() / 2] {
        *byte ^= 0x55;
    }
    std::fs::write(file.path(), &other).unwrap();
    let found = read_all(&mut timeline);
    assert!(
        matches!(found, Err(ContainerError::Damaged { .. })),
        "{found:?}"
    );
}

#[test]
fn a_file_that_is_cut_off_does_not_open() {
    let bytes = file(&PLAIN, &hundred());
    let found = open(&bytes[..bytes.len() / 2]).map(|_| ());
    assert!(
        matches!(found, Err(ContainerError::Truncated { .. })),
        "{found:?}"
    );
}
