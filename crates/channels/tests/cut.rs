//! A stretch of a take's file is a take.

use std::io::Cursor;

use inhand_channels::{ChannelError, cut_take, is_of_whole_take, latch, read_take};
use inhand_container::{ChannelFacts, Interval, Selection, Source, select};
use inhand_model::{Motion, Provenance};
use proptest::prelude::*;

use crate::common;
use crate::round_trip::{assert_same_recording, written};

fn made() -> Provenance {
    Provenance {
        step: "cut".to_owned(),
        ..common::provenance()[0].clone()
    }
}

/// The file cut to a stretch, and the samples that are in it.
fn cut(bytes: &[u8], keep: Interval) -> (Vec<u8>, std::ops::Range<usize>) {
    let metadata = inhand_channels::read_metadata(bytes, "take.mcap").unwrap();
    let cut = cut_take(&metadata, "take.mcap", &[keep], &made())
        .unwrap()
        .unwrap();
    let measured = |channel: &ChannelFacts| !is_of_whole_take(channel);
    let selection = Selection {
        keep: vec![cut.keep],
        channels: (!cut.whole).then_some(&measured),
        latch: &latch,
        replace: cut.replace,
        add: cut.add,
        ..Selection::default()
    };
    let mut out = Vec::new();
    let mut source = Source::open("take.mcap", Cursor::new(bytes)).unwrap();
    select(&mut source, &mut out, &selection).unwrap();
    (out, cut.samples)
}

fn seconds(start: u64, from_s: f64, to_s: f64) -> Interval {
    let nanos = |s: f64| start + (s * 1e9).round() as u64;
    Interval::new(nanos(from_s), Some(nanos(to_s)))
}

fn assert_same_motion(found: &Motion, whole: &Motion, samples: std::ops::Range<usize>) {
    assert_eq!(found.clock, whole.clock.starting_at(samples.start));
    for (finger, track) in found.fingertips.iter() {
        let expected = whole.fingertips[finger].slice(samples.clone());
        assert_eq!(track.statuses(), expected.statuses());
        assert!(track.iter().eq(expected.iter()));
    }
    assert_eq!(found.hand.statuses(), whole.hand.slice(samples).statuses());
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(16) })]

    #[test]
    fn a_stretch_reads_as_the_slice_of_the_take(
        // At most rates no sample but the first is taken at a whole nanosecond.
        rate_hz in prop_oneof![Just(100.0), Just(120.0), Just(240.0), Just(59.94)],
        from in 0.0..0.7_f64,
        length in 0.1..0.6_f64,
    ) {
        let take = common::take(300, rate_hz);
        let bytes = written(&common::take_file(&take, &[], &[]), true);
        let whole = read_take(&bytes, "take.mcap").unwrap();
        let duration_s = 300.0 / rate_hz;
        let start = whole.recording.clock.start_unix_nanos();
        let keep = seconds(start, from * duration_s, (from + length) * duration_s);
        let (stretch, samples) = cut(&bytes, keep);
        prop_assert!(!samples.is_empty());
        let read = read_take(&stretch, "cut.mcap").unwrap();
        assert_same_recording(&read.recording, &whole.recording.slice(samples.clone()));
        assert_same_motion(&read.motion.unwrap(), whole.motion.as_ref().unwrap(), samples.clone());
        prop_assert_eq!(&read.roles, &whole.roles);
        prop_assert_eq!(read.provenance.len(), whole.provenance.len() + usize::from(samples.len() < 300));

        // And a stretch of the stretch.
        let start = read.recording.clock.start_unix_nanos();
        let keep = seconds(start, 0.3 * length * duration_s, length * duration_s);
        let (again, inner) = cut(&stretch, keep);
        let read = read_take(&again, "again.mcap").unwrap();
        let expected = whole.recording.slice(samples).slice(inner);
        assert_same_recording(&read.recording, &expected);
    }
}

#[test]
fn all_of_a_take_stays_as_it_is() {
    let take = common::take(400, 100.0);
    let segments = common::segments(&take);
    let generated = common::generated(&["prior"], &segments);
    let bytes = written(&common::take_file(&take, &generated, &[]), true);
    let (copy, samples) = cut(&bytes, Interval::ALL);
    assert_eq!(samples, 0..400);
    let messages = |bytes: &[u8]| -> Vec<(String, u64, Vec<u8>)> {
        (mcap::MessageStream::new(bytes).unwrap())
            .map(|message| {
                let message = message.unwrap();
                (
                    message.channel.topic.clone(),
                    message.log_time,
                    message.data.to_vec(),
                )
            })
            .collect()
    };
    assert!(messages(&copy) == messages(&bytes));
    assert_eq!(
        inhand_channels::read_metadata(&copy, "x").unwrap(),
        inhand_channels::read_metadata(&bytes, "x").unwrap()
    );
    // Of a stretch, trajectories that count samples from the start of the take are left out.
    let (stretch, _) = cut(
        &bytes,
        seconds(take.recording.clock.start_unix_nanos(), 0.2, 0.5),
    );
    assert!(
        messages(&bytes)
            .iter()
            .any(|(topic, ..)| topic.starts_with("/generated/"))
    );
    assert!(
        !messages(&stretch)
            .iter()
            .any(|(topic, ..)| topic.starts_with("/generated/"))
    );
    assert!(
        messages(&stretch)
            .iter()
            .any(|(topic, ..)| topic == "/tf_static")
    );
}

#[test]
fn what_is_no_stretch_of_the_take_is_refused() {
    let take = common::take(100, 100.0);
    let bytes = written(&common::take_file(&take, &[], &[]), true);
    let metadata = inhand_channels::read_metadata(&bytes, "take.mcap").unwrap();
    let start = take.recording.clock.start_unix_nanos();
    let of = |stretches: &[Interval]| cut_take(&metadata, "take.mcap", stretches, &made());
    let after = of(&[seconds(start, 5.0, 6.0)]).unwrap_err();
    assert!(after.to_string().contains("none of them"), "{after}");
    let apart = [seconds(start, 0.1, 0.3), seconds(start, 0.5, 0.6)];
    let error = of(&apart).unwrap_err();
    assert!(
        matches!(error, ChannelError::Mismatch { .. }) && error.to_string().contains("2 ranges")
    );
    // Next to each other they are one.
    let next = [seconds(start, 0.3, 0.6), seconds(start, 0.1, 0.3)];
    assert_eq!(of(&next).unwrap().unwrap().samples, 10..60);
    let none = cut_take(&Default::default(), "x.mcap", &[Interval::ALL], &made()).unwrap();
    assert!(none.is_none());
}
