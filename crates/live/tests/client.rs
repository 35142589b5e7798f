//! A client as viewers are, that reads what comes one at a time.

use std::collections::BTreeMap;
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::protocol::CloseFrame;
use tungstenite::{ClientRequestBuilder, Message, WebSocket};

pub(crate) const SDK: &str = "foxglove.sdk.v1";
pub(crate) const WEBSOCKET: &str = "foxglove.websocket.v1";

/// What a server says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Said {
    Json(Value),
    Message(String, u64, Vec<u8>),
    Time(u64),
    State(State),
    Close(Option<u16>),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct State {
    pub(crate) status: u8,
    pub(crate) time: u64,
    pub(crate) speed: f32,
    pub(crate) did_seek: bool,
    pub(crate) request: String,
}

pub(crate) struct Client {
    pub(crate) socket: WebSocket<TcpStream>,
    pub(crate) info: Value,
    /// Number and entry of each topic.
    pub(crate) topics: BTreeMap<String, (u64, Value)>,
    subscriptions: BTreeMap<u32, String>,
}

impl Client {
    /// Connects; reads what is offered.
    pub(crate) fn connect(address: SocketAddr, protocol: &str) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        // A limit: nothing waits so long where all is well.
        let limit = Some(Duration::from_secs(60));
        stream.set_read_timeout(limit).unwrap();
        let request = ClientRequestBuilder::new(format!("ws://{address}").parse().unwrap());
        let request = request.with_sub_protocol(protocol);
        let (socket, response) = tungstenite::client(request, stream).unwrap();
        assert_eq!(response.headers()["sec-websocket-protocol"], protocol);
        let mut client = Self {
            socket,
            info: Value::Null,
            topics: BTreeMap::new(),
            subscriptions: BTreeMap::new(),
        };
        client.info = client.json("serverInfo");
        let offered = client.json("advertise");
        for entry in offered["channels"].as_array().unwrap() {
            let topic = entry["topic"].as_str().unwrap().to_owned();
            let entry = (entry["id"].as_u64().unwrap(), entry.clone());
            assert!(
                client.topics.insert(topic, entry).is_none(),
                "one channel a topic"
            );
        }
        client
    }

    fn json(&mut self, op: &str) -> Value {
        match self.next() {
            Said::Json(value) if value["op"] == op => value,
            other => panic!("expected {op}, found {other:?}"),
        }
    }

    pub(crate) fn send(&mut self, value: &Value) {
        self.socket.send(Message::text(value.to_string())).unwrap();
    }

    /// Subscribes to some topics; subscription numbers differ from channel numbers.
    pub(crate) fn subscribe(&mut self, topics: &[&str]) {
        let mut wanted = Vec::new();
        for topic in topics {
            let id = 100 + self.subscriptions.len() as u32;
            wanted.push(json!({"id": id, "channelId": self.topics[*topic].0}));
            self.subscriptions.insert(id, (*topic).to_owned());
        }
        self.send(&json!({"op": "subscribe", "subscriptions": wanted}));
    }

    pub(crate) fn subscribe_all(&mut self) {
        let topics: Vec<String> = self.topics.keys().cloned().collect();
        let topics: Vec<&str> = topics.iter().map(String::as_str).collect();
        self.subscribe(&topics);
    }

    /// Asks for play or pause, a speed, a seek.
    pub(crate) fn playback(&mut self, play: bool, speed: f32, seek: Option<u64>, id: &str) {
        let mut bytes = vec![3, u8::from(!play)];
        bytes.extend(speed.to_le_bytes());
        bytes.push(u8::from(seek.is_some()));
        bytes.extend(seek.unwrap_or_default().to_le_bytes());
        bytes.extend((id.len() as u32).to_le_bytes());
        bytes.extend(id.as_bytes());
        self.socket.send(Message::binary(bytes)).unwrap();
    }

    pub(crate) fn next(&mut self) -> Said {
        match self.socket.read().unwrap() {
            Message::Text(text) => Said::Json(serde_json::from_str(text.as_str()).unwrap()),
            Message::Binary(bytes) => self.parse(&bytes),
            Message::Close(frame) => {
                // Answers it.
                let _ = self.socket.flush();
                Said::Close(frame.map(|CloseFrame { code, .. }| u16::from(code)))
            }
            other => panic!("{other:?}"),
        }
    }

    fn parse(&self, bytes: &[u8]) -> Said {
        let long = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        let int = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        match bytes[0] {
            1 => {
                let topic = self.subscriptions[&int(1)].clone();
                Said::Message(topic, long(5), bytes[13..].to_vec())
            }
            2 => {
                assert_eq!(bytes.len(), 9);
                Said::Time(long(1))
            }
            5 => {
                assert_eq!(bytes.len(), 19 + int(15) as usize);
                Said::State(State {
                    status: bytes[1],
                    time: long(2),
                    speed: f32::from_bits(int(10)),
                    did_seek: bytes[14] != 0,
                    request: String::from_utf8(bytes[19..].to_vec()).unwrap(),
                })
            }
            other => panic!("opcode {other}"),
        }
    }

    /// All up to what is wanted, which comes last.
    pub(crate) fn until(&mut self, wanted: impl Fn(&Said) -> bool) -> Vec<Said> {
        let mut all = Vec::new();
        loop {
            let said = self.next();
            let found = wanted(&said);
            assert!(
                found || !matches!(said, Said::Close(_)),
                "closed after {all:?}"
            );
            all.push(said);
            if found {
                return all;
            }
        }
    }

    /// All up to the answer to a request, and that.
    pub(crate) fn answer(&mut self, id: &str) -> (Vec<Said>, State) {
        let mut all = self.until(|said| matches!(said, Said::State(state) if state.request == id));
        match all.pop() {
            Some(Said::State(state)) => (all, state),
            other => panic!("{other:?}"),
        }
    }
}

/// The messages among what was said.
pub(crate) fn messages(said: &[Said]) -> Vec<(String, u64, Vec<u8>)> {
    (said.iter())
        .filter_map(|said| match said {
            Said::Message(topic, time, data) => Some((topic.clone(), *time, data.clone())),
            _ => None,
        })
        .collect()
}

pub(crate) fn is_close(said: &Said) -> bool {
    matches!(said, Said::Close(_))
}

pub(crate) fn is_ended(said: &Said) -> bool {
    matches!(said, Said::State(state) if state.status == 3)
}
