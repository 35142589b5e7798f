//! Messages as they come in, sorted into series: one for each marker, body and transform.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::message_kinds::kinds_of;
use crate::reading::{Fault, Item, Kind, Label, MessageKind, Reading, Stored};
use crate::topics::{ImportSettings, TopicUse, name_of_topic};
use inhand_channels::ChannelError;

/// Markers, bodies and transforms of a file at most: names that never come twice are no names.
const MAX_SERIES: usize = 10_000;

/// Samples that are kept at most for each byte of the file, beside [`FREE_SAMPLES`]: more than any
/// packing of motion has, and a bound on memory for a file made to unpack without end.
const SAMPLES_PER_BYTE: u64 = 4;
const FREE_SAMPLES: u64 = 1 << 20;

/// Things of one name in a message at most, and bytes of a name.
const MAX_NAMESAKES: usize = 100;
const MAX_NAME_BYTES: usize = 1000;

/// A cloud with more points than this is a scan and no set of markers, unless the user says so.
const MAX_CLOUD_MARKERS: usize = 512;

/// The way out where a topic is no motion capture.
const IGNORE: &str = "set this topic to \"ignore\" under [topics]";

/// Times of the messages of a stream: taken, sent and logged, nanoseconds since 1970.
#[derive(Clone, Debug, Default)]
pub(crate) struct Times {
    pub(crate) stamp: Vec<u64>,
    pub(crate) publish: Vec<u64>,
    pub(crate) log: Vec<u64>,
    /// Messages of the series that comes most often: one for each frame, where a frame has several messages too.
    pub(crate) frames: Vec<u32>,
}

/// A topic that is read, and what was found on it.
#[derive(Debug)]
pub(crate) struct Topic {
    pub(crate) name: String,
    pub(crate) schema: String,
    pub(crate) encoding: &'static str,
    pub(crate) format: &'static MessageKind,
    pub(crate) setting: Option<TopicUse>,
    /// Whether the user named the topic, or one thing on it.
    pub(crate) named: bool,
    pub(crate) channels: usize,
    pub(crate) messages: usize,
    pub(crate) unreadable: usize,
    pub(crate) first_fault: Option<(usize, Fault)>,
    pub(crate) unnamed: usize,
    pub(crate) points_of_a_scan: Option<usize>,
    is_static: bool,
    /// By child frame where transforms come one by one.
    streams: BTreeMap<Option<String>, usize>,
    /// By name or number; things of one name in a message follow each other.
    series: BTreeMap<String, Vec<Option<usize>>>,
}

impl Topic {
    /// Priority of the topic, 0 highest: topics that users name, then by their messages.
    pub(crate) fn rank(&self) -> u8 {
        if self.named { 0 } else { self.format.rank + 1 }
    }
}

/// Use of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum As {
    /// As its kind, name and rotations suggest.
    Suggested,
    Body,
    Marker,
}

/// A marker, body or transform over the messages that hold it.
#[derive(Debug)]
pub(crate) struct Series {
    pub(crate) topic: usize,
    pub(crate) stream: usize,
    pub(crate) name: String,
    /// Its name in the source, where `name` may be what the user calls it.
    pub(crate) source_name: String,
    pub(crate) id: String,
    pub(crate) has_name: bool,
    pub(crate) kind: Kind,
    pub(crate) becomes: As,
    /// Frame of the first message.
    pub(crate) frame: String,
    pub(crate) other_frames: usize,
    /// Numbers of the messages in the stream.
    pub(crate) message: Vec<u32>,
    pub(crate) position: Vec<[f64; 3]>,
    pub(crate) rotation: Vec<[f64; 4]>,
}

/// A transform that holds all the time.
#[derive(Clone, Debug)]
pub(crate) struct Static {
    pub(crate) parent: String,
    pub(crate) position: [f64; 3],
    pub(crate) rotation: [f64; 4],
}

/// Everything that the messages of a file say.
pub(crate) struct Gathered<'a> {
    file: &'a str,
    settings: &'a ImportSettings,
    samples_left: u64,
    pub(crate) topics: Vec<Topic>,
    pub(crate) streams: Vec<Times>,
    pub(crate) series: Vec<Series>,
    pub(crate) statics: BTreeMap<String, Static>,
    /// Topics of messages that are read, but not in their encoding, and what they are.
    pub(crate) other_encodings: BTreeMap<String, String>,
}

impl Times {
    /// The times of the messages that make frames.
    pub(crate) fn of_frames<T: Copy>(&self, times: &[T]) -> Vec<T> {
        let of_frames = self
            .frames
            .iter()
            .filter_map(|&message| times.get(message as usize));
        of_frames.copied().collect()
    }
}

impl<'a> Gathered<'a> {
    pub(crate) fn new(file: &'a str, bytes: u64, settings: &'a ImportSettings) -> Self {
        Self {
            file,
            settings,
            samples_left: FREE_SAMPLES.saturating_add(bytes.saturating_mul(SAMPLES_PER_BYTE)),
            topics: Vec::new(),
            streams: Vec::new(),
            series: Vec::new(),
            statics: BTreeMap::new(),
            other_encodings: BTreeMap::new(),
        }
    }

    /// Notes a channel whose message is read, where it is so in other encodings alone.
    pub(crate) fn other_encoding(&mut self, topic: &str, schema: &str, encoding: &str) {
        let encodings: Vec<&str> =
            (kinds_of(schema).flat_map(|kind| kind.encodings.iter().copied())).collect();
        if !encodings.is_empty() && self.settings.topics.get(topic) != Some(&TopicUse::Ignore) {
            let encodings = encodings.join(", ");
            let what =
                format!("{schema} in encoding \"{encoding}\", which is read in {encodings} alone");
            self.other_encodings.insert(topic.to_owned(), what);
        }
    }

    /// The end of the file: finds the messages that make the frames of each stream.
    pub(crate) fn end(&mut self) {
        let mut fullest: BTreeMap<usize, usize> = BTreeMap::new();
        for (index, series) in self.series.iter().enumerate() {
            let best = fullest.entry(series.stream).or_insert(index);
            if self.series[*best].message.len() < series.message.len() {
                *best = index;
            }
        }
        for (stream, best) in fullest {
            self.streams[stream]
                .frames
                .clone_from(&self.series[best].message);
        }
    }

    /// The topic of a channel; `None` where it is ignored. Channels of one topic and type are one.
    pub(crate) fn topic(
        &mut self,
        name: &str,
        schema: &str,
        encoding: &str,
        format: &'static MessageKind,
    ) -> Option<usize> {
        let setting = self.settings.topics.get(name).cloned();
        let prefix = format!("{name}#");
        let parts = (self.settings.topics.iter()).filter(|(key, _)| key.starts_with(&prefix));
        let part_used = parts.clone().any(|(_, part)| *part != TopicUse::Ignore);
        if setting == Some(TopicUse::Ignore) && !part_used {
            return None;
        }
        let encoding = (format.encodings.iter().copied()).find(|known| *known == encoding)?;
        let same = |topic: &Topic| {
            topic.name == name && topic.encoding == encoding && std::ptr::eq(topic.format, format)
        };
        if let Some(known) = self.topics.iter().position(same) {
            self.topics[known].channels += 1;
            return Some(known);
        }
        self.topics.push(Topic {
            name: name.to_owned(),
            schema: schema.to_owned(),
            encoding,
            format,
            named: part_used || setting.is_some(),
            setting,
            channels: 1,
            messages: 0,
            unreadable: 0,
            first_fault: None,
            unnamed: 0,
            points_of_a_scan: None,
            is_static: name.ends_with("tf_static"),
            streams: BTreeMap::new(),
            series: BTreeMap::new(),
        });
        Some(self.topics.len() - 1)
    }

    /// Takes in a message of a topic, written at `log` and sent at `publish`.
    pub(crate) fn message(
        &mut self,
        topic: usize,
        log: u64,
        publish: u64,
        data: &[u8],
    ) -> Result<(), ChannelError> {
        let number = self.topics[topic].messages;
        self.topics[topic].messages += 1;
        let readings = match (self.topics[topic].format.read)(Stored {
            encoding: self.topics[topic].encoding,
            bytes: data,
        }) {
            Ok(readings) => readings,
            Err(fault) => {
                self.topics[topic].unreadable += 1;
                let first_fault = &mut self.topics[topic].first_fault;
                first_fault.get_or_insert((number, fault));
                return Ok(());
            }
        };
        for reading in readings {
            self.reading(topic, log, publish, reading)?;
        }
        Ok(())
    }

    fn reading(
        &mut self,
        topic: usize,
        log: u64,
        publish: u64,
        reading: Reading<'_>,
    ) -> Result<(), ChannelError> {
        let points = reading.items.len();
        let of = &mut self.topics[topic];
        if of.format.is_cloud() && of.setting.is_none() && points > MAX_CLOUD_MARKERS {
            of.points_of_a_scan = of.points_of_a_scan.max(Some(points));
            return Ok(());
        }
        self.samples_left = self
            .samples_left
            .checked_sub(points.max(1) as u64)
            .ok_or_else(|| {
                self.unclear(
                    topic,
                    "as many samples as fit the size of the file".to_owned(),
                    "more: the file unpacks to far more than motion capture does".to_owned(),
                    IGNORE,
                )
            })?;
        let stream = self.stream(topic, &reading);
        let times = &mut self.streams[stream];
        // A message number fits: there are fewer of them than bytes that a file of 4 GB unpacks to.
        let message = u32::try_from(times.stamp.len()).unwrap_or(u32::MAX);
        times.stamp.push(reading.stamp_nanos);
        times.publish.push(publish);
        times.log.push(log);
        for item in reading.items {
            if self.topics[topic].is_static {
                self.static_transform(&reading.frame, &item);
                continue;
            }
            let Some(series) = self.series(topic, stream, message, &reading.frame, &item)? else {
                continue;
            };
            let series = &mut self.series[series];
            if series.frame != reading.frame {
                series.other_frames += 1;
                if series.kind == Kind::Transform {
                    continue; // Its numbers mean something else in another frame.
                }
            }
            series.message.push(message);
            series.position.push(item.position);
            series.rotation.push(item.rotation);
        }
        Ok(())
    }

    /// Messages of a topic share their times; transforms come one by one and have their own.
    fn stream(&mut self, topic: usize, reading: &Reading<'_>) -> usize {
        let child = match &reading.items[..] {
            [
                Item {
                    kind: Kind::Transform,
                    label: Label::Name(child, _),
                    ..
                },
            ] => Some(child.as_ref().to_owned()),
            _ => None,
        };
        let next = self.streams.len();
        let stream = *self.topics[topic].streams.entry(child).or_insert(next);
        if stream == next {
            self.streams.push(Times::default());
        }
        stream
    }

    fn static_transform(&mut self, parent: &str, item: &Item<'_>) {
        if let Label::Name(child, _) = &item.label
            && self.statics.len() < MAX_SERIES
            && child.len() + parent.len() <= MAX_NAME_BYTES
        {
            let held = Static {
                parent: parent.to_owned(),
                position: item.position,
                rotation: item.rotation,
            };
            self.statics.insert(child.as_ref().to_owned(), held);
        }
    }

    /// The series that an item of a message belongs to; `None` where it is ignored.
    fn series(
        &mut self,
        topic: usize,
        stream: usize,
        message: u32,
        frame: &str,
        item: &Item<'_>,
    ) -> Result<Option<usize>, ChannelError> {
        let key = match &item.label {
            Label::Topic => Cow::Borrowed(""),
            Label::Name(name, _) => Cow::Borrowed(name.as_ref()),
            Label::Number(n) => Cow::Owned(n.to_string()),
            Label::Place(place) => Cow::Owned(place.to_string()),
        };
        let known = self.topics[topic].series.get(key.as_ref());
        let known = known.map_or(&[][..], Vec::as_slice);
        // One that this message has had already is another thing of the same name.
        let is_had = |&series: &usize| self.series[series].message.last() == Some(&message);
        if let Some(&free) = known
            .iter()
            .find(|series| !series.as_ref().is_some_and(is_had))
        {
            return Ok(free);
        }
        if known.len() >= MAX_NAMESAKES || key.len() > MAX_NAME_BYTES {
            return Err(self.unclear(
                topic,
                format!(
                    "names of at most {MAX_NAME_BYTES} bytes, each for at most {MAX_NAMESAKES} \
                     things in a message"
                ),
                format!("one of {} bytes for {} things", key.len(), known.len() + 1),
                IGNORE,
            ));
        }
        let made = self.new_series(topic, stream, &key, frame, item)?;
        let known = self.topics[topic].series.entry(key.into_owned());
        known.or_default().push(made);
        Ok(made)
    }

    fn new_series(
        &mut self,
        topic: usize,
        stream: usize,
        key: &str,
        frame: &str,
        item: &Item<'_>,
    ) -> Result<Option<usize>, ChannelError> {
        if self.series.len() >= MAX_SERIES {
            let more = "more: names that change from message to message name nothing";
            let expected = format!("at most {MAX_SERIES} markers and bodies");
            return Err(self.unclear(topic, expected, more.to_owned(), IGNORE));
        }
        let given = self.given(topic, key, item)?;
        let of = &self.topics[topic];
        let becomes = match given {
            Some((TopicUse::Ignore, _)) => return Ok(None),
            // There are names, and this is beyond the last one.
            Some((usage, None)) if !usage.names().is_empty() => {
                self.topics[topic].unnamed += 1;
                return Ok(None);
            }
            Some((TopicUse::Body(_), _)) => As::Body,
            Some((TopicUse::Marker(_), _)) => As::Marker,
            None => As::Suggested,
        };
        let given_name = given.and_then(|(_, name)| name);
        let own = match &item.label {
            Label::Topic => name_of_topic(&of.name),
            Label::Name(name, _) => name.as_ref().to_owned(),
            Label::Number(_) | Label::Place(_) => key.to_owned(),
        };
        let id = match &item.label {
            Label::Name(_, Some(number)) | Label::Number(number) => number.to_string(),
            _ => String::new(),
        };
        let has_name = given.is_some() || matches!(item.label, Label::Topic | Label::Name(..));
        self.series.push(Series {
            topic,
            stream,
            name: given_name.unwrap_or(&own).clone(),
            source_name: own,
            id,
            has_name,
            kind: item.kind,
            becomes,
            frame: frame.to_owned(),
            other_frames: 0,
            message: Vec::new(),
            position: Vec::new(),
            rotation: Vec::new(),
        });
        Ok(Some(self.series.len() - 1))
    }

    /// The use that the user gives a thing on a topic, and the name.
    fn given(
        &self,
        topic: usize,
        key: &str,
        item: &Item<'_>,
    ) -> Result<Option<(&TopicUse, Option<&String>)>, ChannelError> {
        let of = &self.topics[topic];
        if let Some(part) = self.settings.topics.get(&format!("{}#{key}", of.name)) {
            return Ok(Some((part, part.names().first())));
        }
        let Some(whole) = &of.setting else {
            return Ok(None);
        };
        let place = match item.label {
            Label::Topic => Some(0),
            Label::Place(place) => Some(place),
            Label::Number(number) => usize::try_from(number).ok(),
            Label::Name(..) => None,
        };
        match place {
            _ if whole.names().is_empty() => Ok(Some((whole, None))),
            Some(place) => Ok(Some((whole, whole.names().get(place)))),
            None => Err(self.unclear(
                topic,
                "one thing, or things without names, to give a name to".to_owned(),
                format!("things with names of their own, such as \"{key}\""),
                &format!("set \"{}#{key}\" instead", of.name),
            )),
        }
    }

    pub(crate) fn unclear(
        &self,
        topic: usize,
        expected: String,
        found: String,
        hint: &str,
    ) -> ChannelError {
        ChannelError::Mismatch {
            what: format!("{}: {}", self.file, self.topics[topic].name),
            expected,
            found: found + "; " + hint,
        }
    }
}
