//! Refused files, options and clients.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};

use inhand_live::{LiveError, Server, Settings};

use crate::files::{mcap, messages, settings, start, timeline};

fn refused(settings: &Settings) -> LiveError {
    Server::open(timeline(mcap(&messages())), settings)
        .map(|_| ())
        .unwrap_err()
}

#[test]
fn a_port_in_use_is_named_with_a_way_out() {
    let other = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = other.local_addr().unwrap().port();
    let error = refused(&Settings { port, ..settings() });
    let text = error.to_string();
    assert!(matches!(error, LiveError::PortInUse { .. }), "{text}");
    assert!(
        text.contains(&format!("127.0.0.1:{port}")) && text.contains("--port 0"),
        "{text}"
    );
}

#[test]
fn an_address_of_another_computer_is_refused() {
    // Reserved for documentation: no computer has it.
    let error = refused(&Settings {
        host: "192.0.2.1".to_owned(),
        ..settings()
    });
    assert!(matches!(error, LiveError::Bind { .. }), "{error}");
}

#[test]
fn a_file_without_messages_is_refused() {
    let error = Server::open(timeline(mcap(&[])), &settings())
        .map(|_| ())
        .unwrap_err();
    assert!(
        matches!(error, LiveError::Empty { channels: 4, .. }),
        "{error}"
    );
}

#[test]
fn speeds_and_starts_that_cannot_be_are_refused() {
    for speed in [0.0, -1.0, 0.009, 101.0, f64::NAN, f64::INFINITY] {
        let error = refused(&Settings {
            speed,
            ..settings()
        });
        assert!(matches!(error, LiveError::Speed { .. }), "{error}");
    }
    for start_s in [-0.1, 1.191, f64::NAN] {
        let error = refused(&Settings {
            start_s,
            ..settings()
        });
        assert!(matches!(error, LiveError::Start { .. }), "{error}");
    }
}

#[test]
fn a_browser_is_told_what_this_is() {
    let running = start(&settings());
    let mut browser = TcpStream::connect(running.address).unwrap();
    browser
        .write_all(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
        .unwrap();
    let mut answer = String::new();
    browser.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 400"), "{answer}");
    assert!(
        answer.contains("open a Foxglove WebSocket connection"),
        "{answer}"
    );
    running.stop();
}
