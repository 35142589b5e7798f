//! Clients that want to do harm, beside a viewer that does not.

use std::io::Write;
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use inhand_live::Settings;
use serde_json::json;
use tungstenite::http::StatusCode;
use tungstenite::{ClientRequestBuilder, Error};

use crate::client::{Client, SDK, Said, is_ended, messages};
use crate::files::{self, MS, START, mcap, run, settings, start, timeline};

/// More than there are places.
const CLIENTS: usize = 300;

/// A client that opens a connection and then does what no viewer does.
fn hostile(address: SocketAddr, kind: usize) -> Option<TcpStream> {
    let mut socket = TcpStream::connect(address).ok()?;
    let greeting = format!(
        "GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
         Sec-WebSocket-Protocol: {SDK}\r\n\r\n"
    );
    // A masked frame with a mask of zeros, so that what it says can be read here.
    let frame = |opcode: u8, bytes: &[u8]| {
        let length = (bytes.len() as u16).to_be_bytes();
        [
            &[0x80 | opcode, 0x80 | 126, length[0], length[1], 0, 0, 0, 0],
            bytes,
        ]
        .concat()
    };
    let all: Vec<_> = (0..64_u32)
        .map(|id| json!({"id": id, "channelId": id % 4 + 1}))
        .collect();
    let subscribe = json!({"op": "subscribe", "subscriptions": all}).to_string();
    let said: Vec<Vec<u8>> = match kind % 6 {
        // Never finishes its handshake.
        0 => vec![greeting.as_bytes()[..40].to_vec()],
        1 => vec![b"\x16\x03\x01\x02\x00".to_vec()],
        // Never asks for anything.
        2 => vec![greeting.into_bytes()],
        // Wants everything, many times, and reads nothing.
        3 => vec![greeting.into_bytes(), frame(1, subscribe.as_bytes())],
        // Begins a long message and does not end it.
        4 => vec![
            greeting.into_bytes(),
            vec![0x81, 0xff, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0],
        ],
        // Says what nobody understands, very often.
        _ => [
            vec![greeting.into_bytes()],
            vec![frame(1, b"{\"op\":\"?\"}"); 500],
        ]
        .concat(),
    };
    said.iter()
        .all(|bytes| socket.write_all(bytes).is_ok())
        .then_some(socket)
}

/// 12 MB in 2.4 s of recording.
fn recording() -> Vec<files::Message> {
    let data = |n: u64| vec![n as u8; 40_000];
    let times = (0..300).map(|n| (n, START + n * 8 * MS));
    times
        .map(|(n, time)| ("/b".to_owned(), time, data(n)))
        .collect()
}

/// `INHAND_HOSTILE_S=60` keeps it up for a minute.
#[test]
fn a_polite_viewer_gets_every_message_among_hostile_clients() {
    let seconds = std::env::var("INHAND_HOSTILE_S").ok();
    let seconds = seconds.map_or(0, |seconds| seconds.parse().unwrap());
    let until = Instant::now() + Duration::from_secs(seconds);
    let expected = recording();
    let server = run(
        timeline(mcap(&expected)),
        &Settings {
            speed: 1.0,
            paused: true,
            ..settings()
        },
    );
    let attack = || -> Vec<_> {
        (0..CLIENTS)
            .filter_map(|kind| hostile(server.address, kind))
            .collect()
    };
    let mut hostile = attack();
    // They get the time that they are given to behave.
    std::thread::sleep(Duration::from_millis(300));
    let mut polite = Client::connect(server.address, SDK);
    polite.subscribe_all();
    polite.until(|said| matches!(said, Said::State(_)));
    for pass in 0.. {
        let id = format!("pass {pass}");
        polite.playback(true, 1.0, Some(START), &id);
        polite.answer(&id);
        // At the start each is shown the latest messages; then all come.
        let seen = messages(&polite.until(is_ended));
        let seen = &seen[seen.len().saturating_sub(expected.len())..];
        let times = |messages: &[files::Message]| messages.iter().map(|m| m.1).collect::<Vec<_>>();
        assert_eq!(times(seen), times(&expected), "pass {pass}");
        assert!(
            seen.iter()
                .zip(&expected)
                .all(|(seen, expected)| seen.2 == expected.2)
        );
        if Instant::now() >= until {
            break;
        }
        hostile = attack();
    }
    drop(hostile);
    let played = server.stop();
    assert!(played.viewers > 20, "others got in as well: {played:?}");
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        let peak = status
            .lines()
            .find_map(|line| line.strip_prefix("VmHWM:"))
            .unwrap();
        let peak_kb: u64 = peak.trim().trim_end_matches("kB").trim().parse().unwrap();
        assert!(
            peak_kb < 200_000,
            "{peak_kb} kB, clients and their copies included"
        );
    }
}

/// Connects as a page of some origin does.
fn from_page(address: SocketAddr, origin: &str) -> Result<(), StatusCode> {
    let stream = TcpStream::connect(address).unwrap();
    let request = ClientRequestBuilder::new(format!("ws://{address}").parse().unwrap())
        .with_sub_protocol(SDK)
        .with_header("Origin", origin);
    match tungstenite::client(request, stream) {
        Ok(_) => Ok(()),
        Err(tungstenite::HandshakeError::Failure(Error::Http(response))) => Err(response.status()),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn pages_of_others_are_refused() {
    let server = start(&Settings {
        origins: vec!["https://viewer.example".to_owned()],
        ..settings()
    });
    let refused = Err(StatusCode::FORBIDDEN);
    assert_eq!(from_page(server.address, "https://evil.example"), refused);
    assert_eq!(from_page(server.address, "https://viewer.example"), Ok(()));
    assert_eq!(from_page(server.address, "http://localhost:8080"), Ok(()));
    server.stop();
}

#[test]
fn a_handshake_ends_however_little_at_a_time_is_said() {
    let server = start(&settings());
    let mut slow = TcpStream::connect(server.address).unwrap();
    let begun = Instant::now();
    // A byte every tenth of a second: no single one is late.
    while slow.write_all(b"G").is_ok() && begun.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(100));
    }
    assert!(begun.elapsed() < Duration::from_secs(15));
    server.stop();
}
