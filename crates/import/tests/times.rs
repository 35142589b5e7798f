//! Clocks: stamps, rates, gaps, and what stands in for stamps.

use inhand_import::ImportSettings;
use inhand_model::StartTime;

use super::bag::{self, Bag};
use super::{START, assert_found, at, findings, marker, read, read_with, refusal, stamp};

/// A recording of one marker whose x is the number of its sample in millimetres, from samples with their stamps
/// and the times at which they were logged and sent.
fn of(messages: impl IntoIterator<Item = (u64, u64, u64, u64)>) -> Vec<u8> {
    let mut bag = Bag::new();
    for (k, stamp, log, sent) in messages {
        let message = bag::markers(true, stamp, &[("Thumb", [k as f64 / 1e3, 1.0, 2.0])]);
        bag.add_by(0, "/markers", bag::MARKERS, [log, sent], &message);
    }
    bag.end()
}

/// Whole numbers from 0 up to `limit` that look like chance and are the same at every call.
fn noise(k: u64, limit: u64) -> u64 {
    ((k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 20) % limit
}

#[test]
fn capture_times_count_and_not_when_messages_were_logged() {
    let messages = (0..200).map(|k| {
        let log = stamp(k) + 2_000_000 + noise(k, 10_000_000);
        (k, stamp(k), log, log)
    });
    let recording = read(&of(messages));
    assert_eq!((recording.clock.rate_hz(), recording.len()), (100.0, 200));
    assert_eq!(recording.clock.start_unix_nanos(), START);
    assert_found(&recording, "times are capture times");
    assert_found(&recording, "jitter 0.00 ms");
    assert!(
        !findings(&recording).contains("warning"),
        "{}",
        findings(&recording)
    );
}

#[test]
fn jitter_drops_repetitions_and_back_steps_keep_samples_in_their_places() {
    // 120 Hz with up to 1 ms of jitter to either side.
    let stamp = |k: u64| START + k * 8_333_333 + noise(k, 2_000_000);
    let mut order: Vec<u64> = (0..600).filter(|k| !(100..103).contains(k)).collect();
    order.swap(50, 51);
    order.insert(200, order[199]);
    let bytes = of(order
        .iter()
        .map(|&k| (k, stamp(k), stamp(k) + 3_000_000, 0)));
    let recording = read(&bytes);
    assert_eq!((recording.clock.rate_hz(), recording.len()), (120.0, 600));
    let thumb = marker(&recording, "Thumb");
    for k in (0..600).filter(|k| !(100..103).contains(k)) {
        assert_eq!(at(thumb, k), Some([k as f64 / 1e3, 1.0, 2.0]), "sample {k}");
    }
    assert_eq!(thumb.track.gaps(), vec![100..103]);
    assert_found(&recording, "3 of 600 frames are in no message");
    assert_found(&recording, "1 messages come after a later one");
    assert_found(
        &recording,
        "1 values come twice for one sample and are equal",
    );
}

#[test]
fn without_stamps_sending_or_logging_stands_in() {
    let sent = |k: u64| stamp(k) + 1_000_000;
    let log = |k: u64| stamp(k) + 2_000_000 + noise(k, 3_000_000);
    for constant in [0, START] {
        let recording = read(&of((0..300).map(|k| (k, constant, log(k), sent(k)))));
        assert_eq!((recording.clock.rate_hz(), recording.len()), (100.0, 300));
        assert_eq!(recording.clock.start_unix_nanos(), sent(0));
        assert_found(&recording, "times are when they were sent");
    }
    let recording = read(&of((0..300).map(|k| (k, 0, log(k), log(k)))));
    assert_eq!((recording.clock.rate_hz(), recording.len()), (100.0, 300));
    assert_found(&recording, "times are when they were logged");
    assert_eq!(
        at(marker(&recording, "Thumb"), 299),
        Some([0.299, 1.0, 2.0])
    );
}

#[test]
fn stray_stamps_are_left_out_and_the_others_kept() {
    let stamp_of = |k: u64| match k {
        0 => 0,
        7 => 17_000_000_000, // A computer that has just been switched on.
        _ => stamp(k),
    };
    let recording = read(&of(
        (0..100).map(|k| (k, stamp_of(k), stamp(k) + 1_000_000, 0))
    ));
    assert_eq!(recording.len(), 99);
    assert_eq!(recording.clock.start_unix_nanos(), stamp(1));
    let thumb = marker(&recording, "Thumb");
    assert_eq!(
        (at(thumb, 0), at(thumb, 6)),
        (Some([0.001, 1.0, 2.0]), None)
    );
    assert_found(
        &recording,
        "2 messages have no stamp, or one far from those of the others",
    );
}

#[test]
fn simulated_time_starts_anywhere() {
    let recording = read(&of(
        (0..100).map(|k| (k, k * 10_000_000, START + k * 10_000_000, 0))
    ));
    assert_eq!(recording.len(), 100);
    assert_eq!(recording.clock.start_time(), StartTime::Unknown);
    assert_eq!(recording.clock.start_unix_nanos(), 0);
}

#[test]
fn rates_that_no_device_has_stay_as_measured() {
    let recording = read(&of((0..500).map(|k| (k, START + k * 10_070_000, START, 0))));
    assert!((recording.clock.rate_hz() - 1e9 / 10_070_000.0).abs() < 1e-9);
    assert_found(&recording, "it singles out no rate that devices have");
}

#[test]
fn uneven_stamps_are_refused_until_the_user_states_a_rate() {
    // Steps of 2 to 18 ms.
    let mut time = START;
    let messages: Vec<_> = (0..200)
        .map(|k| {
            time += 2_000_000 + noise(k, 16_000_000);
            (k, time, time, 0)
        })
        .collect();
    let bytes = of(messages);
    let error = refusal(&bytes, &ImportSettings::default());
    assert!(
        error.contains("/markers: expected stamps at an even rate"),
        "{error}"
    );
    assert!(error.contains("source.rate_hz"), "{error}");
    let settings = ImportSettings {
        rate_hz: Some(100.0),
        ..ImportSettings::default()
    };
    let recording = read_with(&bytes, &settings);
    assert_eq!(recording.clock.rate_hz(), 100.0);
    assert_found(&recording, "100 Hz as set");
}

#[test]
fn a_stream_of_another_rate_stands_at_the_nearest_samples() {
    let mut bag = Bag::new();
    for k in 0..100 {
        let message = bag::markers(true, stamp(k), &[("Thumb", [1.0, 2.0, 3.0])]);
        bag.add("/markers", bag::MARKERS, stamp(k), &message);
        if k % 4 == 0 {
            let message = bag::bodies(true, stamp(k), &[("Hand", super::turned(1.0, 1.0, 1.0))]);
            bag.add("/rigid_bodies", bag::BODIES, stamp(k), &message);
        }
    }
    let recording = read(&bag.end());
    assert_eq!((recording.clock.rate_hz(), recording.len()), (100.0, 100));
    let hand = &super::body(&recording, "Hand").track;
    assert_eq!(hand.counts().measured, 25);
    assert!(hand.get(96).is_some() && hand.get(97).is_none());
}

#[test]
fn a_stream_without_stamps_beside_others_goes_by_log_times_less_their_delay() {
    let mut bag = Bag::new();
    for k in 0..100 {
        let log = stamp(k) + 30_000_000;
        let message = bag::markers(true, stamp(k), &[("Thumb", [k as f64, 2.0, 3.0])]);
        bag.add("/markers", bag::MARKERS, log, &message);
        let message = bag::pose(0, "world", super::turned(k as f64, 0.0, 0.0));
        bag.add("/Hand/pose", bag::POSE, log, &message);
    }
    let recording = read(&bag.end());
    let hand = &super::body(&recording, "Hand").track;
    assert_eq!(hand.get(42).unwrap().origin().to_array(), [42.0, 0.0, 0.0]);
}
