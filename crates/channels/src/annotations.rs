//! Events as viewers show them on their time line, `foxglove.Event`, and back from any file.

use std::collections::BTreeMap;
use std::io::{Cursor, Write};

use foxglove::messages::{Event as EventMessage, KeyValuePair};
use inhand_container::{Depth, Record, Source, Writer, metadata, profile, walk_source};
use inhand_model::{Annotations, Event, Finding};
use prost::Message;
use serde_json::{Value, json};

use crate::error::ChannelError;
use crate::metadata::{ABOUT, Metadata};
use crate::streams::{PACKED, Streams};
use crate::topic;
use crate::wire::viewer_time;

/// Name of the schema of events, of any writer.
const SCHEMA: &str = "foxglove.Event";

/// Profile of MCAP files that ROS 2 tools read: every channel is in CDR.
const ROS2_PROFILE: &str = "ros2";
/// Schema of events in a ROS 2 bag, which can hold no protobuf: each is JSON in a text.
const ROS2_SCHEMA: (&str, &str) = ("std_msgs/msg/String", "string data\n");
/// Plain CDR, little endian.
const CDR_HEADER: [u8; 4] = [0, 1, 0, 0];

/// Adds each event when it begins; its sequence number is its place among those given.
pub(crate) fn add_events<'a>(
    annotations: &'a Annotations,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let keys = annotations.all_keys();
    let message = move |(n, event): (usize, &Event)| {
        let message = EventMessage {
            start_time: Some(viewer_time(event.start_unix_nanos)),
            end_time: Some(viewer_time(event.end_unix_nanos)),
            metadata: (labels(event, &keys))
                .map(|(key, value)| KeyValuePair { key, value })
                .collect(),
        };
        (n, event.start_unix_nanos, message)
    };
    let channel = (streams.output).channel::<EventMessage>(topic::ANNOTATIONS, None)?;
    streams.listed(channel, by_time(annotations).into_iter().map(message));
    Ok(())
}

/// Events by the time at which they begin, with their places among those given.
fn by_time(annotations: &Annotations) -> Vec<(usize, &Event)> {
    let mut events: Vec<(usize, &Event)> = annotations.events.iter().enumerate().collect();
    events.sort_by_key(|(_, event)| event.start_unix_nanos);
    events
}

/// Labels of an event in the order of these keys.
fn labels(event: &Event, keys: &[&str]) -> impl Iterator<Item = (String, String)> {
    (keys.iter()).filter_map(|&key| Some((key.to_owned(), event.labels.get(key)?.clone())))
}

/// Events as JSON in the form of `foxglove.Event`, by the time at which they begin (nanoseconds since 1970).
pub fn events_json(annotations: &Annotations) -> Vec<(u64, String)> {
    let keys = annotations.all_keys();
    let time = |unix_nanos: u64| json!({ "sec": unix_nanos / 1_000_000_000, "nanosec": unix_nanos % 1_000_000_000 });
    let text = |event: &Event| {
        let pairs = labels(event, &keys).map(|(key, value)| json!({ "key": key, "value": value }));
        let message = json!({
            "start_time": time(event.start_unix_nanos),
            "end_time": time(event.end_unix_nanos),
            "metadata": pairs.collect::<Vec<_>>(),
        });
        (event.start_unix_nanos, message.to_string())
    };
    (by_time(annotations).into_iter())
        .map(|(_, event)| text(event))
        .collect()
}

/// Events and facts that any MCAP file holds: messages of the schema `foxglove.Event` (protobuf or
/// JSON) on any topic, of a ROS 2 bag texts with the same JSON on `/annotations`, in the order of their sequence numbers, and the metadata records
/// `inhand.annotations` and `inhand.about`.
///
/// # Errors
///
/// As [`read_take`](crate::read_take) for bytes that are no intact MCAP file;
/// [`ChannelError::Mismatch`] for an event that cannot be read or that ends before it starts.
pub fn read_annotations(bytes: &[u8], file_name: &str) -> Result<Annotations, ChannelError> {
    let mut source = Source::open(file_name, Cursor::new(bytes))?;
    let metadata = metadata(&mut source)?.into_iter().collect();
    let mut reader = EventReader::default();
    walk_source(&mut source, |record| {
        reader.record(&record, file_name)?;
        Ok::<_, ChannelError>(Depth::Everything)
    })?;
    reader.finish(&metadata, file_name)
}

/// The events of a file, with the facts that place them on its time line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileEvents {
    /// Those of the topic `/annotations`, which inhand may change.
    pub own: Annotations,
    /// Those of other topics.
    pub others: Vec<Event>,
    /// All metadata records.
    pub metadata: Metadata,
    /// Log time of the earliest message.
    pub first_unix_nanos: Option<u64>,
    /// Whether the file is a ROS 2 bag, whose events are JSON in `std_msgs/msg/String`.
    pub ros2: bool,
}

/// Reads the events of a file as [`read_annotations`] does, those that inhand may change apart.
///
/// # Errors
///
/// As [`read_annotations`].
pub fn read_file_events(source: &mut Source<'_>) -> Result<FileEvents, ChannelError> {
    let mut found = FileEvents {
        ros2: is_ros2(source)?,
        ..FileEvents::default()
    };
    let file_name = &*source.file().to_owned();
    let (mut own, mut all) = (EventReader::default(), EventReader::default());
    own.own_alone = true;
    walk_source(source, |record| {
        match &record {
            Record::Metadata(facts) => {
                (found.metadata.0).insert(facts.name.clone(), facts.metadata.clone());
            }
            Record::Message { header, .. } => {
                let first = found.first_unix_nanos.get_or_insert(header.log_time);
                *first = header.log_time.min(*first);
            }
            _ => {}
        }
        own.record(&record, file_name)?;
        all.record(&record, file_name)?;
        Ok::<_, ChannelError>(Depth::Everything)
    })?;
    found.own = own.finish(&found.metadata, file_name)?;
    found.others = all.finish(&found.metadata, file_name)?.events;
    // Each own event is among all of them once.
    for event in &found.own.events {
        if let Some(place) = found.others.iter().position(|other| other == event) {
            found.others.remove(place);
        }
    }
    Ok(found)
}

/// How a channel's messages state events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EventForm {
    Protobuf,
    Json,
    /// JSON in a text of ROS 2.
    Ros2,
}

impl EventForm {
    /// The form of a channel of this schema, encoding and topic; `None` where it has no events.
    fn new(schema: &str, encoding: &str, topic: &str) -> Option<Self> {
        match (schema, encoding) {
            (SCHEMA, "protobuf") => Some(Self::Protobuf),
            (SCHEMA, "json") => Some(Self::Json),
            (schema, "cdr") if schema == ROS2_SCHEMA.0 && topic == topic::ANNOTATIONS => {
                Some(Self::Ros2)
            }
            _ => None,
        }
    }
}

/// A channel of events.
#[derive(Debug)]
struct EventChannel {
    topic: String,
    form: EventForm,
    read: usize,
}

/// Collects events from the records of a file, given in their order.
#[derive(Debug, Default)]
pub struct EventReader {
    /// Whether events of other topics are ignored.
    own_alone: bool,
    /// Names of schemas.
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, EventChannel>,
    /// With the channel and the sequence number, which give the order.
    events: Vec<(u16, u32, Event)>,
    keys: Vec<String>,
    /// Third-party events that cannot be read; the first of each topic is reported.
    unread: Vec<Finding>,
}

impl EventReader {
    /// Findings about third-party events, one for each topic.
    pub(crate) fn findings(&mut self) -> Vec<Finding> {
        let mut unread = std::mem::take(&mut self.unread);
        unread.dedup_by(|later, first| later.place == first.place);
        unread
    }

    /// Looks at the next record; `file` is what errors call the file.
    ///
    /// # Errors
    ///
    /// [`ChannelError::Mismatch`] for an event of inhand that cannot be read.
    pub fn record(&mut self, record: &Record<'_>, file: &str) -> Result<(), ChannelError> {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name.clone());
            }
            Record::Channel(channel) => {
                let schema = self
                    .schemas
                    .get(&channel.schema_id)
                    .map_or("", String::as_str);
                let form = EventForm::new(schema, &channel.message_encoding, &channel.topic);
                let wanted = !self.own_alone || channel.topic == topic::ANNOTATIONS;
                if let Some(form) = form.filter(|_| wanted) {
                    self.channels
                        .entry(channel.id)
                        .or_insert_with(|| EventChannel {
                            topic: channel.topic.clone(),
                            form,
                            read: 0,
                        });
                }
            }
            Record::Message { header, data } => {
                if let Some(channel) = self.channels.get_mut(&header.channel_id) {
                    let (event, keys) = match channel.event(data, file) {
                        Ok(read) => read,
                        Err(error)
                            if channel.topic == topic::ANNOTATIONS
                                && (self.own_alone || channel.form != EventForm::Ros2) =>
                        {
                            return Err(error);
                        }
                        // A third-party event or text must not make the take unreadable.
                        Err(error) => {
                            self.unread.push(Finding::warning(
                                channel.topic.clone(),
                                format!("an event that cannot be read is left out: {error}"),
                            ));
                            return Ok(());
                        }
                    };
                    for key in keys {
                        if !self.keys.contains(&key) {
                            self.keys.push(key);
                        }
                    }
                    (self.events).push((header.channel_id, header.sequence, event));
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// The events of all records, and what the metadata of the file state about them.
    ///
    /// # Errors
    ///
    /// [`ChannelError::Mismatch`] for metadata that cannot be read.
    pub fn finish(mut self, metadata: &Metadata, file: &str) -> Result<Annotations, ChannelError> {
        // Stable: events of writers that do not count stay in the order of the file.
        self.events.sort_by_key(|(channel, n, _)| (*channel, *n));
        Ok(Annotations {
            events: self.events.into_iter().map(|(.., event)| event).collect(),
            keys: metadata.annotation_keys(file)?.unwrap_or(self.keys),
            about: metadata.0.get(ABOUT).cloned().unwrap_or_default(),
        })
    }
}

impl EventChannel {
    /// The event of a message, and the keys of its labels in their order.
    fn event(&mut self, data: &[u8], file: &str) -> Result<(Event, Vec<String>), ChannelError> {
        let number = self.read;
        self.read += 1;
        let error = |expected: &str, found: String| {
            ChannelError::message(file, &self.topic, number, expected, found)
        };
        let json = match self.form {
            EventForm::Protobuf => None,
            EventForm::Json => Some(data),
            EventForm::Ros2 => Some(ros2_text(data).unwrap_or_default()),
        };
        let parts = if let Some(json) = json {
            from_json(json).ok_or_else(|| {
                let expected = "JSON with start_time, end_time and metadata of foxglove.Event";
                error(expected, format!("{} bytes that are not", json.len()))
            })?
        } else {
            let message = EventMessage::decode(data).map_err(|source| {
                error(
                    &format!("{} bytes of protobuf", data.len()),
                    source.to_string(),
                )
            })?;
            let time = |time: Option<foxglove::messages::Timestamp>| {
                time.map_or(0, |t| {
                    u64::from(t.sec()) * 1_000_000_000 + u64::from(t.nsec())
                })
            };
            let pairs = message.metadata.into_iter().map(|p| (p.key, p.value));
            (
                time(message.start_time),
                // Without an end it is an instant.
                time(message.end_time.or(message.start_time)),
                pairs.collect(),
            )
        };
        let (start_unix_nanos, end_unix_nanos, pairs): (u64, u64, Vec<(String, String)>) = parts;
        if end_unix_nanos < start_unix_nanos {
            return Err(error(
                "an event that does not end before it starts",
                format!("from {start_unix_nanos} ns to {end_unix_nanos} ns"),
            ));
        }
        let pairs = || pairs.iter().filter(|(_, value)| !value.is_empty());
        let event = Event {
            start_unix_nanos,
            end_unix_nanos,
            labels: pairs().cloned().collect(),
        };
        Ok((event, pairs().map(|(key, _)| key.clone()).collect()))
    }
}

type JsonEvent = (u64, u64, Vec<(String, String)>);

fn from_json(data: &[u8]) -> Option<JsonEvent> {
    let value: Value = serde_json::from_slice(data).ok()?;
    let time = |key: &str| {
        let time = value.get(key)?;
        let sec = time.get("sec")?.as_u64()?;
        let nsec = time.get("nsec").or_else(|| time.get("nanosec"))?.as_u64()?;
        sec.checked_mul(1_000_000_000)?.checked_add(nsec)
    };
    let pair = |pair: &Value| {
        let text = |key| Some(pair.get(key)?.as_str()?.to_owned());
        Some((text("key")?, text("value")?))
    };
    let pairs = match value.get("metadata") {
        None => Vec::new(),
        Some(list) => list.as_array()?.iter().map(pair).collect::<Option<_>>()?,
    };
    // Without an end it is an instant.
    let end = match value.get("end_time") {
        None => time("start_time")?,
        Some(_) => time("end_time")?,
    };
    Some((time("start_time")?, end, pairs))
}

/// The text of a `std_msgs/String` in CDR of either order of bytes.
fn ros2_text(data: &[u8]) -> Option<&[u8]> {
    let (header, rest) = data.split_first_chunk::<4>()?;
    let (length, rest) = rest.split_first_chunk::<4>()?;
    let length = match header[1] {
        1 => u32::from_le_bytes(*length),
        _ => u32::from_be_bytes(*length),
    };
    let text = rest.get(..length as usize)?;
    Some(text.strip_suffix(&[0]).unwrap_or(text))
}

/// Writes a file that holds events alone, to be appended to another one: `ros2` says whether that is a ROS 2 bag.
///
/// # Errors
///
/// [`ChannelError::Container`] when writing fails.
pub fn write_annotations(
    out: &mut dyn Write,
    annotations: &Annotations,
    ros2: bool,
) -> Result<(), ChannelError> {
    if !ros2 {
        let mut streams = Streams::create(out, PACKED, &Metadata::default())?;
        add_events(annotations, &mut streams)?;
        return streams.finish();
    }
    let mut writer = Writer::new(out, ROS2_PROFILE, "", PACKED)?;
    let (name, definition) = ROS2_SCHEMA;
    let schema = writer.schema(name, "ros2msg", definition.as_bytes())?;
    let channel = writer.channel(schema, topic::ANNOTATIONS, "cdr", &BTreeMap::new())?;
    let places = by_time(annotations).into_iter().map(|(place, _)| place);
    for (place, (unix_nanos, json)) in places.zip(events_json(annotations)) {
        // The format has 32 bits for the place.
        writer.message(channel, place as u32, unix_nanos, |data| {
            data.extend(CDR_HEADER);
            data.extend((json.len() as u32 + 1).to_le_bytes());
            data.extend(json.as_bytes());
            data.push(0);
        })?;
    }
    writer.finish()?;
    Ok(())
}

/// Whether a file is a ROS 2 bag.
///
/// # Errors
///
/// [`ChannelError::Container`] where the file does not start with an intact record.
pub fn is_ros2(source: &mut Source<'_>) -> Result<bool, ChannelError> {
    Ok(profile(source)? == ROS2_PROFILE)
}

/// The metadata records that annotations need beside their events: name and pairs.
pub fn annotation_records(annotations: &Annotations) -> Metadata {
    let mut metadata = Metadata::default();
    metadata.add_annotations(annotations);
    metadata
}
