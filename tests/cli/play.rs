//! `inhand play`: what a person or a script sees of it. What viewers get is tested in `inhand-live`.

use std::io::{BufRead, BufReader, Read};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::Value;
use tungstenite::{ClientRequestBuilder, Message, WebSocket};

use crate::support::{Bench, stderr};

/// A session with a short recording in it.
fn bench() -> Bench {
    let bench = Bench::empty();
    let sizes = [
        "--takes",
        "1",
        "--test-takes",
        "0",
        "--duration",
        "4",
        "--seed",
        "7",
    ];
    bench.ok(&[
        &["simulate", "-o", "session", "--format", "mcap"],
        &sizes[..],
    ]
    .concat());
    let takes = bench.files("session/train");
    let take = bench.bytes(&format!("session/train/{}", takes[0]));
    bench.write("take.mcap", take);
    bench
}

/// `inhand play` with any free port, and the address that it prints.
fn play(bench: &Bench, options: &[&str]) -> (Child, String) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_inhand"))
        .args(["play", "take.mcap", "--port", "0"])
        .args(options)
        .current_dir(bench.folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary under test runs");
    let mut address = String::new();
    let stdout = child.stdout.as_mut().expect("stdout is a pipe");
    BufReader::new(stdout)
        .read_line(&mut address)
        .expect("it prints text");
    let address = address.trim_end().to_owned();
    assert!(address.starts_with("ws://127.0.0.1:"), "{address:?}");
    (child, address)
}

/// Exit code and stderr.
fn end(mut child: Child) -> (Option<i32>, String) {
    let mut said = String::new();
    let stderr = child.stderr.as_mut().expect("stderr is a pipe");
    stderr.read_to_string(&mut said).expect("it prints text");
    (child.wait().expect("it ends").code(), said)
}

/// A viewer that shows everything.
fn watch(address: &str) -> WebSocket<TcpStream> {
    let request = ClientRequestBuilder::new(address.parse().expect("an address"));
    let stream = TcpStream::connect(&address["ws://".len()..]).expect("it listens");
    // A limit: nothing waits so long where all is well.
    let limit = Some(Duration::from_secs(60));
    stream.set_read_timeout(limit).expect("a limit can be set");
    let request = request.with_sub_protocol("foxglove.websocket.v1");
    let (mut socket, _) = tungstenite::client(request, stream).expect("it speaks WebSocket");
    loop {
        if let Message::Text(text) = socket.read().expect("it greets") {
            let said: Value = serde_json::from_str(text.as_str()).expect("texts are JSON");
            if said["op"] == "advertise" {
                let channels = said["channels"].as_array().expect("channels are a list");
                let wanted: Vec<Value> = (channels.iter())
                    .map(|channel| serde_json::json!({"id": channel["id"], "channelId": channel["id"]}))
                    .collect();
                let subscribe = serde_json::json!({"op": "subscribe", "subscriptions": wanted});
                let sent = socket.send(Message::text(subscribe.to_string()));
                sent.expect("it listens");
                return socket;
            }
        }
    }
}

/// Messages until it says goodbye.
fn count(mut socket: WebSocket<TcpStream>) -> u64 {
    let mut messages = 0;
    loop {
        match socket.read() {
            Ok(Message::Binary(bytes)) if bytes.first() == Some(&1) => messages += 1,
            Ok(Message::Close(_)) => {
                let _ = socket.flush();
                return messages;
            }
            Ok(_) => {}
            Err(error) => panic!("after {messages} messages: {error}"),
        }
    }
}

/// The number of messages as `info` prints it.
fn messages(bench: &Bench) -> u64 {
    let info = bench.ok(&["info", "take.mcap"]);
    let line = info.lines().find(|line| line.starts_with("messages"));
    let number = line.and_then(|line| line.split_whitespace().nth(1));
    number.expect("info counts them").parse().expect("a number")
}

#[test]
fn a_viewer_gets_every_message_and_then_it_ends() {
    let bench = bench();
    let (child, address) = play(&bench, &["--once", "--speed", "10"]);
    let seen = count(watch(&address));
    let (code, said) = end(child);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(seen, messages(&bench));
    let summary = format!("played   {seen} messages to 1 viewer\n");
    assert!(said.ends_with(&summary), "{said}");
    // No line that changes, and no word of keys, where nobody sees them.
    assert!(!said.contains('\x1b') && !said.contains("[space"), "{said}");
}

#[test]
fn without_viewers_it_ends_as_well() {
    let bench = bench();
    let (child, _) = play(
        &bench,
        &["--once", "--now", "--speed", "100", "--start", "3.5", "-q"],
    );
    assert_eq!(end(child), (Some(0), String::new()));
}

#[cfg(unix)]
#[test]
fn signals_end_it_with_a_goodbye() {
    let bench = bench();
    for signal in ["-INT", "-TERM"] {
        let (child, address) = play(&bench, &["--loop"]);
        let viewer = watch(&address);
        let killed = Command::new("kill")
            .args([signal, &child.id().to_string()])
            .status()
            .expect("the system can send signals");
        assert!(killed.success());
        // It panics where the connection ends without a goodbye.
        count(viewer);
        let (code, said) = end(child);
        assert_eq!(code, Some(0), "{signal} {said}");
    }
}

#[test]
fn a_port_in_use_is_an_error_that_says_what_to_do() {
    let bench = bench();
    let other = TcpListener::bind("127.0.0.1:0").expect("some port is free");
    let port = other.local_addr().expect("it listens").port().to_string();
    let output = bench.inhand(&["play", "take.mcap", "--port", &port]);
    assert_eq!(output.status.code(), Some(1));
    let said = stderr(&output);
    assert!(
        said.contains(&format!("127.0.0.1:{port}")) && said.contains("--port 0"),
        "{said}"
    );
    assert!(output.stdout.is_empty());
}

#[test]
fn what_cannot_be_played_is_refused() {
    let bench = bench();
    bench.write("notes.txt", "hello");
    let take = bench.bytes("take.mcap");
    bench.write("cut.mcap", &take[..take.len() / 2]);
    let nothing: [(&[&str], i32, &str); 6] = [
        (&["notes.txt"], 1, "not an MCAP file"),
        (&["missing.mcap"], 1, "missing.mcap"),
        (&["cut.mcap"], 1, "inhand recover"),
        (&["take.mcap", "--speed", "0"], 2, "0.01 to 100"),
        (&["take.mcap", "--start", "4000"], 2, "--start"),
        (&["take.mcap", "--loop", "--once"], 2, "--once"),
    ];
    for (args, code, word) in nothing {
        let output = bench.inhand(&[&["play", "--port", "0"], args].concat());
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?} {said}");
        assert!(said.contains(word), "{args:?} {said}");
    }
}
