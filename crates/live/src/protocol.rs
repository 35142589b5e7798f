//! The messages of the Foxglove WebSocket protocol that a player needs, as bytes and text.

use data_encoding::BASE64;
use inhand_container::ChannelFacts;
use serde::Deserialize;
use serde_json::{Value, json};

/// Subprotocols that viewers and server agree on when they connect. Both have the same messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subprotocol {
    /// The first one; Lichtblick asks for it.
    Websocket,
    /// That of Foxglove since 2024, with playback control.
    Sdk,
}

impl Subprotocol {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Subprotocol::Websocket => "foxglove.websocket.v1",
            Subprotocol::Sdk => "foxglove.sdk.v1",
        }
    }

    /// The first one known of those that a viewer offers, since it names what it prefers first.
    pub(crate) fn choose<'a>(offered: impl IntoIterator<Item = &'a str>) -> Option<Self> {
        (offered.into_iter()).find_map(|name| {
            [Subprotocol::Websocket, Subprotocol::Sdk]
                .into_iter()
                .find(|known| known.name() == name.trim())
        })
    }
}

/// Checks whether a channel can be advertised: text schemas have to be text. The error is in words.
pub(crate) fn check_schema(channel: &ChannelFacts) -> Result<(), &'static str> {
    match &channel.schema {
        Some(schema) if !is_binary(&schema.encoding) && str::from_utf8(&schema.data).is_err() => {
            Err("its schema is not text")
        }
        _ => Ok(()),
    }
}

fn is_binary(schema_encoding: &str) -> bool {
    matches!(schema_encoding, "protobuf" | "flatbuffer")
}

pub(crate) fn server_info(name: &str, session: &str, span: (u64, u64)) -> String {
    json!({
        "op": "serverInfo",
        "name": name,
        "capabilities": ["time", "playbackControl"],
        "supportedEncodings": [],
        "metadata": {},
        "sessionId": session,
        "dataStartTime": split(span.0),
        "dataEndTime": split(span.1),
    })
    .to_string()
}

/// Whole seconds and nanoseconds: JSON has no integers of 64 bits.
fn split(nanos: u64) -> Value {
    const SECOND: u64 = 1_000_000_000;
    json!({"sec": nanos / SECOND, "nsec": nanos % SECOND})
}

/// Advertises channels by the numbers that viewers know them by.
pub(crate) fn advertise<'a>(channels: impl IntoIterator<Item = (u64, &'a ChannelFacts)>) -> String {
    let channels: Vec<Value> = (channels.into_iter())
        .map(|(id, channel)| {
            let mut entry = json!({
                "id": id,
                "topic": channel.topic,
                "encoding": channel.message_encoding,
                "schemaName": "",
                "schema": "",
            });
            if let Some(schema) = &channel.schema {
                let text = match is_binary(&schema.encoding) {
                    true => BASE64.encode(&schema.data),
                    false => String::from_utf8_lossy(&schema.data).into_owned(),
                };
                entry["schemaName"] = json!(schema.name);
                entry["schemaEncoding"] = json!(schema.encoding);
                entry["schema"] = json!(text);
            }
            entry
        })
        .collect();
    json!({"op": "advertise", "channels": channels}).to_string()
}

/// Level of a status message.
#[derive(Clone, Copy)]
pub(crate) enum Level {
    Warning = 1,
    Error = 2,
}

pub(crate) fn status(level: Level, message: &str) -> String {
    json!({"op": "status", "level": level as u8, "message": message}).to_string()
}

/// In front of the data of a message: for which subscription, and its log time.
pub(crate) fn message_head(subscription: u32, log_time: u64) -> [u8; 13] {
    let mut head = [1; 13];
    head[1..5].copy_from_slice(&subscription.to_le_bytes());
    head[5..].copy_from_slice(&log_time.to_le_bytes());
    head
}

/// The message of the time.
pub(crate) fn time(log_time: u64) -> [u8; 9] {
    let mut bytes = [2; 9];
    bytes[1..].copy_from_slice(&log_time.to_le_bytes());
    bytes
}

/// Status of playback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Status {
    Playing = 0,
    Paused = 1,
    Ended = 3,
}

/// State of playback.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaybackState {
    pub(crate) status: Status,
    pub(crate) log_time: u64,
    pub(crate) speed: f64,
    pub(crate) did_seek: bool,
}

impl PlaybackState {
    /// As bytes; `request` is what it answers, or nothing.
    pub(crate) fn to_bytes(self, request: &str) -> Vec<u8> {
        let mut bytes = vec![5, self.status as u8];
        bytes.extend(self.log_time.to_le_bytes());
        bytes.extend((self.speed as f32).to_le_bytes());
        bytes.push(u8::from(self.did_seek));
        bytes.extend((request.len() as u32).to_le_bytes());
        bytes.extend(request.as_bytes());
        bytes
    }
}

/// A playback request of a viewer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlaybackRequest {
    pub(crate) play: bool,
    pub(crate) speed: f64,
    pub(crate) seek: Option<u64>,
    /// Identifier that the answer repeats.
    pub(crate) id: String,
}

/// A request of a viewer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Request {
    /// Subscriptions and the channels that they are for.
    Subscribe(Vec<(u32, u64)>),
    Unsubscribe(Vec<u32>),
    Playback(PlaybackRequest),
}

/// A text of a viewer.
#[derive(Deserialize)]
#[serde(tag = "op", rename_all = "camelCase", rename_all_fields = "camelCase")]
enum Operation {
    Subscribe { subscriptions: Vec<Subscription> },
    Unsubscribe { subscription_ids: Vec<u32> },
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Subscription {
    id: u32,
    channel_id: u64,
}

/// Parses a text of a viewer; an error is for the viewer.
pub(crate) fn parse_text(text: &str) -> Result<Request, String> {
    let operation = serde_json::from_str(text);
    Ok(
        match operation.map_err(|error| format!("not understood: {error}"))? {
            Operation::Subscribe { subscriptions } => {
                let wanted = subscriptions
                    .iter()
                    .map(|wanted| (wanted.id, wanted.channel_id));
                Request::Subscribe(wanted.collect())
            }
            Operation::Unsubscribe { subscription_ids } => Request::Unsubscribe(subscription_ids),
        },
    )
}

/// Parses bytes of a viewer; an error is for the viewer.
pub(crate) fn parse_bytes(bytes: &[u8]) -> Result<Request, String> {
    match bytes.split_first() {
        Some((3, body)) => playback(body)
            .map(Request::Playback)
            .ok_or_else(|| "a playback request that is cut off or no text".to_owned()),
        Some((opcode, _)) => Err(format!(
            "opcode {opcode} is nothing that a recording can do"
        )),
        None => Err("an empty message".to_owned()),
    }
}

fn playback(body: &[u8]) -> Option<PlaybackRequest> {
    let (&[command], rest) = body.split_first_chunk()?;
    let (speed, rest) = rest.split_first_chunk()?;
    let (&[sought], rest) = rest.split_first_chunk()?;
    let (time, rest) = rest.split_first_chunk()?;
    let (length, rest) = rest.split_first_chunk()?;
    let id = rest.get(..usize::try_from(u32::from_le_bytes(*length)).ok()?)?;
    let play = match command {
        0 => true,
        1 => false,
        _ => return None,
    };
    Some(PlaybackRequest {
        play,
        speed: f64::from(f32::from_le_bytes(*speed)),
        seek: (sought != 0).then_some(u64::from_le_bytes(*time)),
        id: str::from_utf8(id).ok()?.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_known_protocol_is_chosen() {
        let choose = |offered: &str| Subprotocol::choose(offered.split(','));
        assert_eq!(
            choose("foxglove.websocket.v1, foxglove.sdk.v1"),
            Some(Subprotocol::Websocket)
        );
        assert_eq!(
            choose("foxglove.sdk.v1.1,foxglove.sdk.v1"),
            Some(Subprotocol::Sdk)
        );
        assert_eq!(choose("foxglove.sdk.v2"), None);
        assert_eq!(choose(""), None);
    }

    #[test]
    fn messages_have_the_layout_of_the_specification() {
        assert_eq!(
            message_head(0x0102_0304, 0x1112_1314_1516_1718),
            [
                1, 4, 3, 2, 1, 0x18, 0x17, 0x16, 0x15, 0x14, 0x13, 0x12, 0x11
            ]
        );
        assert_eq!(time(1), [2, 1, 0, 0, 0, 0, 0, 0, 0]);
        let state = PlaybackState {
            status: Status::Ended,
            log_time: 258,
            speed: 1.0,
            did_seek: true,
        };
        assert_eq!(
            state.to_bytes("ab"),
            [
                5, 3, 2, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 0x3f, 1, 2, 0, 0, 0, b'a', b'b'
            ]
        );
    }

    #[test]
    fn a_playback_request_is_read_as_it_was_meant() {
        let mut bytes = vec![3, 1, 0, 0, 0, 0x40, 1];
        bytes.extend(7_u64.to_le_bytes());
        bytes.extend([2, 0, 0, 0, b'i', b'd']);
        let meant = PlaybackRequest {
            play: false,
            speed: 2.0,
            seek: Some(7),
            id: "id".to_owned(),
        };
        assert_eq!(parse_bytes(&bytes), Ok(Request::Playback(meant.clone())));
        for length in 0..bytes.len() {
            assert!(parse_bytes(&bytes[..length]).is_err(), "cut to {length}");
        }
        bytes[6] = 0;
        let without = PlaybackRequest {
            seek: None,
            ..meant
        };
        assert_eq!(parse_bytes(&bytes), Ok(Request::Playback(without)));
        bytes[1] = 2;
        assert!(parse_bytes(&bytes).is_err());
    }

    #[test]
    fn what_is_not_understood_is_said() {
        for text in [
            "",
            "{}",
            "[1]",
            r#"{"op": "subscribe"}"#,
            r#"{"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 1}]}"#,
            r#"{"op": "subscribe", "subscriptions": [{"id": 1}]}"#,
            r#"{"op": "unsubscribe", "subscriptionIds": ["1"]}"#,
            r#"{"op": "advertise", "channels": []}"#,
        ] {
            assert!(parse_text(text).is_err(), "{text}");
        }
        let text = r#"{"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 2}]}"#;
        assert_eq!(parse_text(text), Ok(Request::Subscribe(vec![(1, 2)])));
        let text = r#"{"op": "unsubscribe", "subscriptionIds": [1, 2]}"#;
        assert_eq!(parse_text(text), Ok(Request::Unsubscribe(vec![1, 2])));
    }
}
