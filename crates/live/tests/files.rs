//! Small recordings.

use std::io::Cursor;
use std::net::SocketAddr;
use std::sync::mpsc::{self, Receiver};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use inhand_container::{Source, Timeline};
use inhand_live::{Control, Controls, Event, LiveError, Played, Server, Settings};
use mcap::records::MessageHeader;

/// Log time of the first message: of a day in 2024, as recordings have it.
pub(crate) const START: u64 = 1_715_000_000_000_000_000;

pub(crate) const MS: u64 = 1_000_000;

/// Topic, log time and data.
pub(crate) type Message = (String, u64, Vec<u8>);

/// 120 samples at 10 ms on `/a`, every fifth on `/b`, one message on `/tf_static`; `/a` has two channels
/// that differ in nothing but their number.
pub(crate) fn messages() -> Vec<Message> {
    let mut messages = vec![("/tf_static".to_owned(), START, b"static".to_vec())];
    for n in 0..120_u64 {
        let time = START + n * 10 * MS;
        messages.push(("/a".to_owned(), time, format!("a {n}").into_bytes()));
        if n % 5 == 0 {
            messages.push(("/b".to_owned(), time, format!("b {n}").into_bytes()));
        }
    }
    messages
}

pub(crate) fn mcap(messages: &[Message]) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().chunk_size(Some(500));
    let mut writer = options.create(&mut out).unwrap();
    let schema = writer
        .add_schema("Thing", "protobuf", &[0, 255, 7])
        .unwrap();
    for (id, topic) in [(1, "/tf_static"), (2, "/a"), (3, "/b"), (4, "/a")] {
        let metadata = Default::default();
        writer
            .add_channel_with_id(id, schema, topic, "protobuf", &metadata)
            .unwrap();
    }
    for (n, (topic, log_time, data)) in messages.iter().enumerate() {
        let channel_id = match &topic[..] {
            "/tf_static" => 1,
            "/a" => [2, 4][n % 2],
            _ => 3,
        };
        let header = MessageHeader {
            channel_id,
            sequence: n as u32,
            log_time: *log_time,
            publish_time: *log_time,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    out.into_inner()
}

pub(crate) fn timeline(bytes: Vec<u8>) -> Timeline<'static> {
    Timeline::open(Source::open("take.mcap", Cursor::new(bytes)).unwrap()).unwrap()
}

/// Any free port, as fast as it goes.
pub(crate) fn settings() -> Settings {
    Settings {
        port: 0,
        name: "take.mcap".to_owned(),
        speed: 20.0,
        ..Settings::default()
    }
}

/// A server that runs.
pub(crate) struct Running {
    pub(crate) address: SocketAddr,
    pub(crate) controls: Controls,
    pub(crate) events: Receiver<Event>,
    thread: JoinHandle<Result<Played, LiveError>>,
}

pub(crate) fn start(settings: &Settings) -> Running {
    run(timeline(mcap(&messages())), settings)
}

pub(crate) fn run(timeline: Timeline<'static>, settings: &Settings) -> Running {
    let server = Server::open(timeline, settings).unwrap();
    let (sender, events) = mpsc::channel();
    Running {
        address: server.address(),
        controls: server.controls(),
        events,
        thread: thread::spawn(move || server.run(move |event| drop(sender.send(event)))),
    }
}

impl Running {
    /// Waits for a event.
    pub(crate) fn wait_for(&self, wanted: impl Fn(&Event) -> bool) -> Event {
        loop {
            let event = self.events.recv_timeout(Duration::from_secs(60)).unwrap();
            if wanted(&event) {
                return event;
            }
        }
    }

    /// Waits until it ends by itself.
    pub(crate) fn end(self) -> Result<Played, LiveError> {
        self.thread.join().unwrap()
    }

    pub(crate) fn stop(self) -> Played {
        assert!(self.controls.send(Control::Stop));
        self.end().unwrap()
    }
}
