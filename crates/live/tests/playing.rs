//! Messages that clients receive.

use inhand_live::{Repeat, Settings};
use serde_json::json;

use crate::client::{Client, SDK, Said, WEBSOCKET, is_close, is_ended, messages};
use crate::files::{self, MS, START, run, settings, start};

/// Ends when the file does.
fn once() -> Settings {
    Settings {
        repeat: Repeat::Finish,
        ..settings()
    }
}

#[test]
fn every_message_arrives_in_order_with_equal_bytes() {
    for protocol in [SDK, WEBSOCKET] {
        let server = start(&once());
        let mut client = Client::connect(server.address, protocol);
        client.subscribe_all();
        let said = client.until(is_close);
        assert_eq!(messages(&said), files::messages(), "{protocol}");
        assert_eq!(said.last(), Some(&Said::Close(Some(1001))));
        let played = server.end().unwrap();
        let count = files::messages().len() as u64;
        assert_eq!((played.viewers, played.sent, played.missed), (1, count, 0));
    }
}

#[test]
fn the_time_comes_before_the_messages_of_that_time() {
    let server = start(&once());
    let mut client = Client::connect(server.address, WEBSOCKET);
    client.subscribe_all();
    let mut now = None;
    for said in client.until(is_close) {
        match said {
            Said::Time(time) => {
                assert!(now <= Some(time), "it never goes back");
                now = Some(time);
            }
            Said::Message(topic, time, _) => assert_eq!(now, Some(time), "{topic}"),
            // This protocol has no playback states.
            Said::State(state) => panic!("{state:?}"),
            _ => {}
        }
    }
    assert_eq!(now, Some(START + 1190 * MS));
    server.end().unwrap();
}

#[test]
fn channels_are_offered_as_they_are_in_the_file() {
    let server = start(&settings());
    let client = Client::connect(server.address, SDK);
    assert_eq!(client.info["name"], "take.mcap");
    assert_eq!(
        client.info["capabilities"],
        json!(["time", "playbackControl"])
    );
    assert_eq!(
        client.info["dataStartTime"],
        json!({"sec": 1_715_000_000, "nsec": 0})
    );
    let end = json!({"sec": 1_715_000_001, "nsec": 190_000_000});
    assert_eq!(client.info["dataEndTime"], end);
    let topics: Vec<_> = client.topics.keys().collect();
    assert_eq!(topics, ["/a", "/b", "/tf_static"]);
    let entry = &client.topics["/a"].1;
    assert_eq!(
        (&entry["encoding"], &entry["schemaName"]),
        (&json!("protobuf"), &json!("Thing"))
    );
    assert_eq!(
        (&entry["schemaEncoding"], &entry["schema"]),
        (&json!("protobuf"), &json!("AP8H"))
    );
    server.stop();
}

#[test]
fn a_start_in_the_middle_shows_what_holds_there() {
    let server = start(&Settings {
        start_s: 0.605,
        ..once()
    });
    let mut client = Client::connect(server.address, SDK);
    client.subscribe_all();
    let found = messages(&client.until(is_close));
    let all = files::messages();
    let held = [
        ("/tf_static", 0, "static"),
        ("/a", 600, "a 60"),
        ("/b", 600, "b 60"),
    ];
    let held =
        held.map(|(topic, ms, data)| (topic.to_owned(), START + ms * MS, data.as_bytes().to_vec()));
    let mut first = found[..3].to_vec();
    first.sort_by_key(|(topic, time, _)| (*time, topic.clone()));
    let mut expected = held.to_vec();
    expected.sort_by_key(|(topic, time, _)| (*time, topic.clone()));
    assert_eq!(first, expected);
    let rest: Vec<_> = (all.into_iter())
        .filter(|(_, time, _)| *time >= START + 605 * MS)
        .collect();
    assert_eq!(found[3..], rest);
    server.end().unwrap();
}

#[test]
fn only_what_was_asked_for_comes() {
    let server = start(&once());
    let mut client = Client::connect(server.address, SDK);
    client.subscribe(&["/b", "/a"]);
    client.send(&json!({"op": "unsubscribe", "subscriptionIds": [101]}));
    let found = messages(&client.until(is_close));
    let all = files::messages();
    let expected: Vec<_> = all
        .into_iter()
        .filter(|(topic, ..)| topic == "/b")
        .collect();
    assert_eq!(found, expected);
    server.end().unwrap();
}

#[test]
fn a_recording_that_repeats_goes_back_to_the_start() {
    let server = start(&Settings {
        repeat: Repeat::Always,
        speed: 100.0,
        ..settings()
    });
    let mut client = Client::connect(server.address, SDK);
    client.subscribe_all();
    let sought = |said: &Said| matches!(said, Said::State(state) if state.did_seek);
    for round in 0..3 {
        let said = client.until(sought);
        assert_eq!(messages(&said), files::messages(), "round {round}");
    }
    server.stop();
}

#[test]
fn a_recording_of_one_instant_plays_once_and_stays() {
    let one = [("/b".to_owned(), 0, b"at zero".to_vec())];
    for repeat in [Repeat::Stay, Repeat::Always] {
        let server = run(
            files::timeline(files::mcap(&one)),
            &Settings {
                repeat,
                ..settings()
            },
        );
        let mut client = Client::connect(server.address, SDK);
        client.subscribe_all();
        assert_eq!(messages(&client.until(is_ended)), one);
        server.stop();
    }
}
