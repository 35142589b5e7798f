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
fn stamps_count_where_the_clock_of_the_recorder_is_set() {
    // An hour back, then two forward; a stray stamp stays one.
    let hour = 3_600_000_000_000;
    let log = |k: u64| match k {
        0..50 => stamp(k),
        50..120 => stamp(k) - hour,
        _ => stamp(k) + hour,
    };
    let stamp_of = |k: u64| if k == 60 { 17_000_000_000 } else { stamp(k) };
    let recording = read(&of((0..200).map(|k| (k, stamp_of(k), log(k), 0))));
    assert_eq!((recording.clock.rate_hz(), recording.len()), (100.0, 200));
    let thumb = marker(&recording, "Thumb");
    let missing: Vec<usize> = (0..200).filter(|&k| at(thumb, k).is_none()).collect();
    assert_eq!(missing, [60]);
    assert_found(
        &recording,
        "2 times between messages at which log times jump",
    );
    assert_found(
        &recording,
        "1 messages have no stamp, or one far from those",
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

/// Markers of a frame, each in a message of its own, stamped so many nanoseconds after the one before.
fn a_message_for_each_marker(apart: u64, with: impl Fn(u64, usize) -> bool) -> Vec<u8> {
    const NAMES: [&str; 4] = ["Thumb", "Index", "Middle", "Ring"];
    let mut bag = Bag::new();
    for k in 0..300 {
        for (m, name) in NAMES.into_iter().enumerate().filter(|(m, _)| with(k, *m)) {
            let stamp = stamp(k) + m as u64 * apart;
            let message = bag::markers(true, stamp, &[(name, [k as f64 / 1e3, m as f64, 2.0])]);
            bag.add("/markers", bag::MARKERS, stamp + 2_000_000, &message);
        }
    }
    bag.end()
}

#[test]
fn a_message_for_each_marker_is_a_frame_all_the_same() {
    // Stamps alike, microseconds apart, and a third of a frame from the first to the last.
    for apart in [0, 20_000, 1_000_000] {
        let recording = read(&a_message_for_each_marker(apart, |_, _| true));
        assert_eq!((recording.clock.rate_hz(), recording.len()), (100.0, 300));
        assert_eq!(recording.clock.start_unix_nanos(), START, "{apart}");
        assert_eq!(recording.markers.len(), 4);
        for (m, marker) in recording.markers.iter().enumerate() {
            for k in 0..300 {
                assert_eq!(
                    at(marker, k),
                    Some([k as f64 / 1e3, m as f64, 2.0]),
                    "{apart} {k}"
                );
            }
        }
        assert!(
            !findings(&recording).contains("warning"),
            "{}",
            findings(&recording)
        );
        assert_found(&recording, "times are capture times");
    }
}

#[test]
fn a_marker_out_of_sight_has_no_message() {
    let seen = |k: u64, m: usize| match m {
        0 => !(10..20).contains(&k),
        1 => k >= 5,
        _ => !k.is_multiple_of(3),
    };
    let recording = read(&a_message_for_each_marker(20_000, seen));
    assert_eq!((recording.clock.rate_hz(), recording.len()), (100.0, 300));
    for (m, marker) in recording.markers.iter().enumerate() {
        // Series come in the order of their first messages: the thumb, then the index or those behind.
        let y = at(marker, 100).or(at(marker, 101)).unwrap()[1];
        for k in 0..300 {
            let expected = seen(k as u64, y as usize).then_some([k as f64 / 1e3, y, 2.0]);
            assert_eq!(at(marker, k), expected, "{m} {k}");
        }
    }
}

/// Samples of one marker that waits, sample by sample, for the next to be sent with it.
fn waiting(samples: u64, waits: impl Fn(u64) -> bool) -> Vec<u8> {
    let sent = |k: u64| {
        let last = (k..).find(|&k| !waits(k)).unwrap_or(k);
        stamp(last) + noise(last, 300_000) + 1_000 * (k + 100 - last)
    };
    of((1..samples).map(|k| (k, sent(k), sent(k) + 2_000_000, 0)))
}

#[test]
fn messages_that_wait_for_the_next_one_go_to_their_own_samples() {
    // One of three waits, also two and more in a row; single frames are dropped for good.
    let bytes = waiting(600, |k| noise(k, 3) == 0);
    let recording = read(&bytes);
    assert_eq!(recording.clock.rate_hz(), 100.0);
    let thumb = marker(&recording, "Thumb");
    let first = 600 - recording.len();
    for k in 0..recording.len() {
        let x = (first + k) as f64 / 1e3;
        assert_eq!(at(thumb, k), Some([x, 1.0, 2.0]), "sample {k}");
    }
    assert_found(&recording, "values come with that of another sample");
    assert!(!findings(&recording).contains("in no message"));
}

#[test]
fn of_several_messages_for_a_sample_the_nearest_in_time_counts() {
    // Two programs: each sample has a value 3 ms before and one at its instant.
    let mut bag = Bag::new();
    for k in 0..200 {
        for (off, y) in [(0, 1.0), (3_000_000, 2.0)] {
            let message = bag::markers(true, stamp(k) + off, &[("Thumb", [k as f64, y, 0.0])]);
            bag.add("/markers", bag::MARKERS, stamp(k) + off, &message);
        }
        let message = bag::markers(true, stamp(k), &[("A", [0.0; 3]), ("B", [1.0; 3])]);
        bag.add("/others", bag::MARKERS, stamp(k), &message);
    }
    let settings = ImportSettings {
        rate_hz: Some(100.0),
        ..ImportSettings::default()
    };
    let recording = read_with(&bag.end(), &settings);
    assert_eq!(recording.len(), 200);
    let ys: Vec<f64> = (0..200)
        .map(|k| at(marker(&recording, "Thumb"), k).unwrap()[1])
        .collect();
    assert!(ys.iter().all(|&y| y == ys[0]), "{ys:?}");
    assert_found(&recording, "200 values come again for a sample and differ");
    assert_found(&recording, "the nearest in time is taken");
    assert!(!findings(&recording).contains("come with that"));
}

#[test]
fn a_clock_at_which_most_samples_are_empty_is_refused_until_the_user_states_a_rate() {
    // Bursts of two and of five, a tenth of a millisecond apart.
    for burst in [2, 5] {
        let sent = |k: u64| {
            let last = k / burst * burst + burst - 1;
            stamp(last) + 100_000 * (k % burst)
        };
        let bytes = of((0..500).map(|k| (k, sent(k), sent(k), 0)));
        let error = refusal(&bytes, &ImportSettings::default());
        assert!(error.contains("/markers: expected a clock"), "{error}");
        assert!(error.contains("found 10000.00 Hz"), "{error}");
        assert!(error.contains("set source.rate_hz"), "{error}");
        let settings = ImportSettings {
            rate_hz: Some(100.0),
            ..ImportSettings::default()
        };
        let recording = read_with(&bytes, &settings);
        let before = 500 - recording.len();
        assert!(before < burst as usize, "{before}");
        for k in 0..recording.len() {
            let x = (before + k) as f64 / 1e3;
            assert_eq!(
                at(marker(&recording, "Thumb"), k),
                Some([x, 1.0, 2.0]),
                "{burst} {k}"
            );
        }
    }
}

#[test]
fn a_long_pause_is_no_reason_to_refuse_a_clock() {
    let seen = (0..3000).filter(|k| !(200..2800).contains(k));
    let recording = read(&of(seen.map(|k| (k, stamp(k), stamp(k), 0))));
    assert_eq!((recording.clock.rate_hz(), recording.len()), (100.0, 3000));
    assert_found(&recording, "2600 of 3000 frames are in no message");
}

#[test]
fn a_stamp_that_jitters_by_more_than_half_a_sample_takes_no_place_of_another() {
    // Rarely 6 ms early or late, with the sample beside it empty for that; frames are dropped here and there.
    let off = |k: u64| match k % 100 {
        20 => 6_000_000,
        60 => -6_000_000,
        _ => noise(k, 1_000_000) as i64,
    };
    let kept = (0..1000).filter(|k| !matches!(k % 100, 12 | 55));
    let bytes = of(kept.map(|k| (k, stamp(k).saturating_add_signed(off(k)), stamp(k), 0)));
    let recording = read(&bytes);
    assert_eq!((recording.clock.rate_hz(), recording.len()), (100.0, 1000));
    for k in 0..1000 {
        let expected = (!matches!(k % 100, 12 | 55)).then_some([k as f64 / 1e3, 1.0, 2.0]);
        assert_eq!(at(marker(&recording, "Thumb"), k), expected, "sample {k}");
    }
    assert_found(&recording, "20 values come with that of another sample");
}
