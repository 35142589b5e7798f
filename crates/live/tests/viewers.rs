//! Several viewers, and those that do not behave.

use std::io::{Read, Seek, Write};
use std::net::TcpStream;
use std::time::Duration;

use inhand_container::{ContainerError, Source, Timeline};
use inhand_live::{DisconnectReason, Event, LiveError, Repeat, Settings};
use serde_json::json;
use tungstenite::Message;

use crate::client::{Client, SDK, Said, WEBSOCKET, is_close, is_ended, messages};
use crate::files::{self, MS, START, mcap, run, settings, start, timeline};

#[test]
fn two_viewers_see_the_same() {
    let server = start(&Settings {
        paused: true,
        ..settings()
    });
    let mut first = Client::connect(server.address, SDK);
    let mut second = Client::connect(server.address, WEBSOCKET);
    assert_eq!(first.info["sessionId"], second.info["sessionId"]);
    first.subscribe_all();
    second.subscribe_all();
    // One asks, both get it: from a seek on they see the same.
    let sees = |client: &mut Client| client.until(|said| matches!(said, Said::Message(..)));
    sees(&mut first);
    sees(&mut second);
    first.playback(true, 20.0, Some(START + 100 * MS), "go");
    first.answer("go");
    second.until(|said| *said == Said::Time(START + 100 * MS));
    let seen = messages(&first.until(is_ended));
    let last = *files::messages()
        .iter()
        .map(|(_, time, _)| time)
        .max()
        .unwrap();
    let also =
        messages(&second.until(|said| matches!(said, Said::Message(_, time, _) if *time == last)));
    assert_eq!(also[..], seen[..also.len()]);
    assert_eq!(also.len(), seen.len());
    server.stop();
}

#[test]
fn one_that_vanishes_does_not_disturb_another() {
    let server = start(&Settings {
        repeat: Repeat::Finish,
        ..settings()
    });
    let mut stays = Client::connect(server.address, SDK);
    let mut goes = Client::connect(server.address, SDK);
    let address = goes.socket.get_ref().local_addr().unwrap();
    goes.subscribe_all();
    // With bytes that were not read this is a reset.
    drop(goes);
    stays.subscribe_all();
    assert_eq!(
        messages(&stays.until(is_close)).last(),
        files::messages().last()
    );
    let gone = server.wait_for(|event| matches!(event, Event::Left { .. }));
    let Event::Left { viewer, how } = gone else {
        unreachable!()
    };
    assert_eq!(viewer, address);
    assert!(matches!(how, DisconnectReason::Vanished(_)), "{how:?}");
    server.end().unwrap();
}

#[test]
fn one_that_says_goodbye_has_left() {
    let server = start(&settings());
    let mut client = Client::connect(server.address, SDK);
    client.socket.close(None).unwrap();
    client.until(is_close);
    let gone = server.wait_for(|event| matches!(event, Event::Left { .. }));
    assert!(
        matches!(
            gone,
            Event::Left {
                how: DisconnectReason::Closed,
                ..
            }
        ),
        "{gone:?}"
    );
    server.stop();
}

/// Messages of which a server holds back less than it has to send.
fn large() -> Vec<files::Message> {
    (0..1200)
        .map(|n: u64| {
            let mut data = vec![0; 64 << 10];
            data[..8].copy_from_slice(&n.to_le_bytes());
            ("/a".to_owned(), START + n * MS, data)
        })
        .collect()
}

#[test]
fn one_that_does_not_read_misses_messages_and_goes_on_later() {
    let server = run(
        timeline(mcap(&large())),
        &Settings {
            paused: true,
            ..settings()
        },
    );
    let mut sleeps = Client::connect(server.address, SDK);
    let address = sleeps.socket.get_ref().local_addr().unwrap();
    sleeps.subscribe(&["/a"]);
    sleeps.until(|said| matches!(said, Said::Message(..)));
    let mut reads = Client::connect(server.address, SDK);
    reads.subscribe(&["/a"]);
    reads.until(|said| matches!(said, Said::Message(..)));
    // No faster than the one that reads can: what it asks for one after the other.
    for hundred in 0..12_u64 {
        let id = format!("{hundred}");
        reads.playback(true, 2.0, None, &id);
        reads.answer(&id);
        let to = START + (hundred * 100 + 99) * MS;
        let seen = reads.until(|said| matches!(said, Said::Message(_, time, _) if *time == to));
        let times: Vec<_> = messages(&seen).iter().map(|(_, time, _)| *time).collect();
        assert!(
            times.windows(2).all(|pair| pair[1] == pair[0] + MS),
            "{times:?}"
        );
    }
    reads.until(is_ended);
    // Now it wakes up: what was kept for it, then word of what was not, then what holds.
    let warned = |said: &Said| matches!(said, Said::Json(value) if value["op"] == "status");
    let kept = messages(&sleeps.until(warned));
    assert!(kept.windows(2).all(|pair| pair[1].1 == pair[0].1 + MS));
    let missed = server.wait_for(|event| matches!(event, Event::Missed { .. }));
    let Event::Missed {
        viewer,
        messages: count,
    } = missed
    else {
        unreachable!()
    };
    assert_eq!(viewer, address);
    assert_eq!(kept.len() as u64 + count, 1199);
    let last = START + 1199 * MS;
    let holds = sleeps.until(|said| matches!(said, Said::Message(_, time, _) if *time == last));
    assert_eq!(messages(&holds).len(), 1);
    assert_eq!(server.stop().missed, count);
}

#[test]
fn nonsense_is_answered_and_the_viewer_stays() {
    let server = start(&Settings {
        paused: true,
        ..settings()
    });
    let mut client = Client::connect(server.address, SDK);
    let nonsense = [
        Message::text("no JSON"),
        Message::text(json!({"op": "getParameters"}).to_string()),
        Message::text(
            json!({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 99}]}).to_string(),
        ),
        Message::binary(Vec::new()),
        Message::binary(vec![3, 0, 0]),
        Message::binary(vec![77]),
    ];
    for message in nonsense {
        let what = format!("{message:?}");
        client.socket.send(message).unwrap();
        let said = client.until(|said| matches!(said, Said::Json(_)));
        let Some(Said::Json(value)) = said.last() else {
            unreachable!()
        };
        assert_eq!(
            (&value["op"], &value["level"]),
            (&json!("status"), &json!(1)),
            "{what}"
        );
    }
    client.subscribe(&["/a"]);
    client.subscribe(&["/b"]);
    let seen = client.until(|said| matches!(said, Said::Message(topic, ..) if topic == "/b"));
    assert_eq!(messages(&seen).len(), 2);
    server.stop();
}

#[test]
fn one_that_sends_too_much_is_disconnected() {
    let server = start(&settings());
    let mut client = Client::connect(server.address, SDK);
    // It may be cut off before all of it is sent.
    let _ = client.socket.send(Message::binary(vec![0; 2 << 20]));
    let gone = server.wait_for(|event| matches!(event, Event::Left { .. }));
    assert!(
        matches!(
            gone,
            Event::Left {
                how: DisconnectReason::Vanished(_),
                ..
            }
        ),
        "{gone:?}"
    );
    server.stop();
}

#[test]
fn a_ping_is_answered() {
    let server = start(&Settings {
        paused: true,
        ..settings()
    });
    let mut client = Client::connect(server.address, SDK);
    client
        .socket
        .send(Message::Ping(b"there?".to_vec().into()))
        .unwrap();
    loop {
        match client.socket.read().unwrap() {
            Message::Pong(data) => {
                assert_eq!(&data[..], b"there?");
                break;
            }
            Message::Binary(_) => {}
            other => panic!("{other:?}"),
        }
    }
    server.stop();
}

#[test]
fn a_browser_or_another_program_is_told_what_this_is() {
    let server = start(&settings());
    let mut stream = TcpStream::connect(server.address).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(60)))
        .unwrap();
    let asks = "GET / HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
                Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\
                Sec-WebSocket-Protocol: chat\r\n\r\n";
    stream.write_all(asks.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 400"), "{answer}");
    assert!(answer.contains("foxglove.websocket.v1"), "{answer}");
    server.wait_for(|event| matches!(event, Event::Strange { .. }));
    server.stop();
}

#[test]
fn a_file_that_is_damaged_meanwhile_ends_it_with_an_error_that_viewers_see() {
    let bytes = mcap(&files::messages());
    let mut file = tempfile::tempfile().unwrap();
    file.write_all(&bytes).unwrap();
    let other = file.try_clone().unwrap();
    let timeline = Timeline::open(Source::open("take.mcap", file).unwrap()).unwrap();
    let server = run(
        timeline,
        &Settings {
            paused: true,
            ..settings()
        },
    );
    let mut client = Client::connect(server.address, SDK);
    client.subscribe_all();
    client.until(|said| matches!(said, Said::Message(..)));
    let mut other = other;
    other.rewind().unwrap();
    other.set_len(bytes.len() as u64 / 2).unwrap();
    client.playback(true, 1.0, Some(START + 1100 * MS), "go");
    let said = client.until(is_close);
    let told = said.iter().any(
        |said| matches!(said, Said::Json(value) if value["op"] == "status" && value["level"] == 2),
    );
    assert!(told, "{said:?}");
    let error = server.end().unwrap_err();
    assert!(
        matches!(error, LiveError::File(ContainerError::Truncated { .. })),
        "{error:?}"
    );
}

#[test]
fn a_stop_reaches_every_viewer() {
    let server = start(&Settings {
        speed: 0.01,
        ..settings()
    });
    let mut watches = Client::connect(server.address, SDK);
    watches.subscribe_all();
    let mut idles = Client::connect(server.address, WEBSOCKET);
    // One that never says who it is does not hold it up.
    let silent = TcpStream::connect(server.address).unwrap();
    server.wait_for(|event| matches!(event, Event::Arrived { .. }));
    server.wait_for(|event| matches!(event, Event::Arrived { .. }));
    let address = server.address;
    server.stop();
    for client in [&mut watches, &mut idles] {
        let said = client.until(is_close);
        assert_eq!(said.last(), Some(&Said::Close(Some(1001))));
    }
    drop(silent);
    assert!(
        TcpStream::connect(address).is_err(),
        "nobody listens there any more"
    );
}
