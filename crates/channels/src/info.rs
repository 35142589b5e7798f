//! Contents of an MCAP file of any writer.

use std::collections::BTreeMap;
use std::io::Cursor;

use foxglove::messages::{FrameTransform, FrameTransforms};
use inhand_container::{Depth, MetadataRecord, Record, Source, listed, walk_source, zstd_size};
use inhand_model::{PerFinger, Status, TrackCounts};
use prost::Message;
use serde::Serialize;

use crate::error::ChannelError;
use crate::messages;
use crate::metadata::Metadata;

/// Contents of an MCAP file.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct FileInfo {
    /// Name of the file as it was given.
    pub file: String,
    /// Size of the file.
    pub bytes: u64,
    /// Profile, such as `ros2`; mostly empty.
    pub profile: String,
    /// Program or library that wrote it.
    pub library: String,
    /// Channels by id.
    pub channels: Vec<ChannelInfo>,
    /// Messages in all channels.
    pub messages: u64,
    /// Messages of channels that the file does not define, counted in nothing else.
    pub messages_without_channel: u64,
    /// Chunks.
    pub chunks: ChunkInfo,
    /// Metadata records by name, the last of each.
    pub metadata: Metadata,
    /// All metadata records in the file's order.
    pub metadata_records: Vec<MetadataRecord>,
    /// Where counts and times of the summary or of chunks contradict the messages.
    pub warnings: Vec<String>,
    /// Attachments in the file's order.
    pub attachments: Vec<AttachmentInfo>,
    /// Edges of the tree of frames, as far as the file states it in Foxglove's messages.
    pub frames: Vec<FrameInfo>,
    /// Gaps per finger of each channel of `inhand.Fingertips`.
    pub fingertips: Vec<FingertipsInfo>,
    /// Whether the file ends with a summary, which viewers need.
    pub has_summary: bool,
    /// Fault that ended reading; the listing covers the part before it.
    pub problem: Option<ChannelError>,
}

impl FileInfo {
    /// Time of the earliest message, nanoseconds since 1970-01-01 UTC.
    pub fn first_unix_nanos(&self) -> Option<u64> {
        self.channels
            .iter()
            .filter_map(|c| c.first_unix_nanos)
            .min()
    }

    /// Time of the latest message, nanoseconds since 1970-01-01 UTC.
    pub fn last_unix_nanos(&self) -> Option<u64> {
        self.channels.iter().filter_map(|c| c.last_unix_nanos).max()
    }

    /// Time from the earliest to the latest message, seconds; 0 without messages.
    pub fn duration_s(&self) -> f64 {
        span_s(self.first_unix_nanos(), self.last_unix_nanos())
    }
}

/// One channel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelInfo {
    /// Identifier in the file.
    pub id: u16,
    /// Topic.
    pub topic: String,
    /// Name of the schema; `None` for a channel without one.
    pub schema: Option<String>,
    /// Encoding of the schema, such as `protobuf`; `None` for a channel without one.
    pub schema_encoding: Option<String>,
    /// Encoding of messages, such as `protobuf`, `json`, `cdr`.
    pub message_encoding: String,
    /// Metadata of the channel; those of inhand have `frame`.
    pub metadata: BTreeMap<String, String>,
    /// Messages.
    pub messages: u64,
    /// Bytes of all messages, uncompressed.
    pub bytes: u64,
    /// Their bytes in the file with those of their index: shares of packed chunks, divided by what each channel's
    /// messages alone pack to.
    pub packed_bytes: u64,
    /// Earliest log time, nanoseconds since 1970-01-01 UTC.
    pub first_unix_nanos: Option<u64>,
    /// Latest log time, nanoseconds since 1970-01-01 UTC.
    pub last_unix_nanos: Option<u64>,
}

impl ChannelInfo {
    /// Messages per second between the first and the last; `None` where they are of one instant.
    pub fn rate_hz(&self) -> Option<f64> {
        let span_s = span_s(self.first_unix_nanos, self.last_unix_nanos);
        (span_s > 0.0).then(|| (self.messages - 1) as f64 / span_s)
    }
}

fn span_s(first: Option<u64>, last: Option<u64>) -> f64 {
    match (first, last) {
        (Some(first), Some(last)) => (last - first) as f64 / 1e9,
        _ => 0.0,
    }
}

/// All chunks together.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ChunkInfo {
    /// Number of chunks; 0 for a file without chunks.
    pub count: u64,
    /// Their bytes in the file, compressed.
    pub packed_bytes: u64,
    /// Their bytes, uncompressed.
    pub unpacked_bytes: u64,
    /// Chunks by compression: `zstd`, `lz4`, `none`.
    pub compression: BTreeMap<String, u64>,
}

/// One attachment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AttachmentInfo {
    /// Name.
    pub name: String,
    /// Media type, such as `text/csv`.
    pub media_type: String,
    /// Bytes of its content.
    pub bytes: u64,
}

/// One edge of the tree of frames.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FrameInfo {
    /// The parent frame.
    pub parent: String,
    /// The child frame.
    pub child: String,
    /// Topic that places it.
    pub topic: String,
    /// Number of transforms.
    pub transforms: u64,
}

/// The fingertips of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct FingertipsInfo {
    /// Topic.
    pub topic: String,
    /// Each finger.
    pub fingers: PerFinger<FingerInfo>,
}

/// One fingertip over a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FingerInfo {
    /// Samples of each status.
    pub counts: TrackCounts,
    /// Runs of missing samples.
    pub gaps: usize,
    /// Samples of the longest run.
    pub longest_gap: usize,
    /// Length of the longest run at the channel's rate, seconds.
    pub longest_gap_s: f64,
}

/// Lists what is in an MCAP file of any origin: chunked or not, with or without summary and
/// schemas, in any encoding.
///
/// The whole file is read and every checksum compared. A file that is cut or damaged gives what
/// comes before the fault, and the fault as [`FileInfo::problem`].
///
/// # Errors
///
/// [`ChannelError::Container`] for bytes that are no MCAP file.
pub fn info(bytes: &[u8], file_name: &str) -> Result<FileInfo, ChannelError> {
    info_of_source(&mut Source::open(file_name, Cursor::new(bytes))?)
}

/// As [`info`] for a file of any size.
///
/// # Errors
///
/// [`ChannelError::Container`] for a file that cannot be read.
pub fn info_of_source(source: &mut Source<'_>) -> Result<FileInfo, ChannelError> {
    let mut listing = Listing::default();
    let listed = listed(source)?;
    let end = walk_source(source, |record| {
        listing.add(record);
        Ok::<_, ChannelError>(Depth::Everything)
    });
    listing.end_chunk();
    // Channels without messages may be in the summary alone.
    for channel in listed.channels {
        if !listing.channels.contains_key(&channel.id) {
            listing.listed_channel(channel);
        }
    }
    let mut info = FileInfo {
        file: source.file().to_owned(),
        bytes: source.bytes(),
        problem: end.err(),
        ..listing.into_info()
    };
    if let Some(counted) = listed.statistics.filter(|_| info.problem.is_none()) {
        let messages = info.messages + info.messages_without_channel;
        if counted.message_count != messages {
            let stated = counted.message_count;
            (info.warnings).push(format!(
                "the summary counts {stated} messages, not {messages}"
            ));
        }
        let stated = (counted.message_start_time, counted.message_end_time);
        if let (Some(first), Some(last)) = (info.first_unix_nanos(), info.last_unix_nanos())
            && (first, last) != stated
        {
            info.warnings.push(format!(
                "the summary states log times from {} to {} ns, those of the messages are from {first} to \
                 {last} ns",
                stated.0, stated.1
            ));
        }
    }
    Ok(info)
}

/// A file as far as it has been read; its channels, messages, frames and fingertips come at the end.
#[derive(Default)]
struct Listing {
    info: FileInfo,
    schemas: BTreeMap<u16, (String, String)>,
    channels: BTreeMap<u16, Listed>,
    frames: BTreeMap<(String, String, String), u64>,
    /// Packed bytes of the chunk that is being read, where it is packed, and its messages by channel.
    chunk: (Option<u64>, BTreeMap<u16, Vec<u8>>),
    /// Log times that the chunk that is being read states, and those of its messages.
    spans: Option<(Span, Option<Span>)>,
    /// Chunks whose messages have other log times than they state.
    wrong_chunks: u64,
}

/// The first and the last log time.
type Span = (u64, u64);

struct Listed {
    info: ChannelInfo,
    content: Content,
}

/// Messages that are looked into.
enum Content {
    Other,
    Transforms,
    Transform,
    Fingertips(Box<PerFinger<Gaps>>),
}

#[derive(Clone, Copy, Default)]
struct Gaps {
    info: FingerInfo,
    running: usize,
}

impl Gaps {
    fn add(&mut self, status: Status) {
        let FingerInfo {
            counts,
            gaps,
            longest_gap,
            ..
        } = &mut self.info;
        match status {
            Status::Measured => counts.measured += 1,
            Status::Filled => counts.filled += 1,
            Status::Missing => counts.missing += 1,
        }
        if status.is_present() {
            self.running = 0;
            return;
        }
        *gaps += usize::from(self.running == 0);
        self.running += 1;
        *longest_gap = self.running.max(*longest_gap);
    }
}

/// Bytes of a message in the index of its chunk.
const INDEX_ENTRY_BYTES: u64 = 16;

impl Listing {
    fn add(&mut self, record: Record) {
        match record {
            Record::Header(header) => {
                (self.info.profile, self.info.library) = (header.profile, header.library);
            }
            Record::Schema { header, .. } => {
                (self.schemas.entry(header.id)).or_insert((header.name, header.encoding));
            }
            Record::Channel(channel) => self.channel(channel),
            Record::Message { header, data } => {
                self.message(header.channel_id, header.log_time, &data);
            }
            Record::Chunk { header, data } => {
                self.end_chunk();
                self.spans = Some(((header.message_start_time, header.message_end_time), None));
                let is_packed = !header.compression.is_empty();
                self.chunk.0 = is_packed.then_some(data.len() as u64);
                let chunks = &mut self.info.chunks;
                chunks.count += 1;
                chunks.packed_bytes += data.len() as u64;
                // What a damaged chunk claims to hold can be anything.
                chunks.unpacked_bytes =
                    (chunks.unpacked_bytes).saturating_add(header.uncompressed_size);
                let compression = match header.compression.as_str() {
                    "" => "none",
                    name => name,
                };
                *(chunks.compression)
                    .entry(compression.to_owned())
                    .or_default() += 1;
            }
            Record::Metadata(record) => {
                let record = MetadataRecord::from(record);
                (self.info.metadata.0).insert(record.name.clone(), record.facts.clone());
                self.info.metadata_records.push(record);
            }
            Record::AttachmentIndex(attachment) => {
                self.end_chunk();
                self.info.attachments.push(AttachmentInfo {
                    name: attachment.name,
                    media_type: attachment.media_type,
                    bytes: attachment.data_size,
                });
            }
            Record::Footer(footer) => self.info.has_summary = footer.summary_start != 0,
            _ => {}
        }
    }

    /// Compares the log times of the chunk that was read, and divides its bytes.
    fn end_chunk(&mut self) {
        if let Some((stated, Some(found))) = self.spans.take() {
            self.wrong_chunks += u64::from(stated != found);
        }
        self.share_chunk();
    }

    /// Divides the bytes of a packed chunk among the channels of its messages.
    fn share_chunk(&mut self) {
        let (packed, messages) = std::mem::take(&mut self.chunk);
        let sizes = messages.iter().map(|(id, bytes)| (*id, zstd_size(bytes)));
        let sizes: Vec<(u16, u64)> = sizes.collect();
        let all: u64 = sizes.iter().map(|(_, size)| size).sum();
        for (id, size) in sizes {
            let (Some(channel), Some(packed)) = (self.channels.get_mut(&id), packed) else {
                continue;
            };
            channel.info.packed_bytes += packed * size / all.max(1);
        }
    }

    /// A channel that the summary lists.
    fn listed_channel(&mut self, channel: inhand_container::ChannelFacts) {
        let id = channel.id;
        let schema_id = match channel.schema {
            None => 0,
            Some(schema) => {
                let id = u16::MAX;
                self.schemas.insert(id, (schema.name, schema.encoding));
                id
            }
        };
        self.channel(mcap::records::Channel {
            id,
            schema_id,
            topic: channel.topic,
            message_encoding: channel.message_encoding,
            metadata: channel.metadata,
        });
    }

    fn channel(&mut self, channel: mcap::records::Channel) {
        let schema = self.schemas.get(&channel.schema_id);
        let name = schema.map(|(name, _)| name.as_str());
        let content = match (channel.message_encoding.as_str(), name) {
            ("protobuf", Some("foxglove.FrameTransforms")) => Content::Transforms,
            ("protobuf", Some("foxglove.FrameTransform")) => Content::Transform,
            ("protobuf", Some("inhand.Fingertips")) => Content::Fingertips(Box::default()),
            _ => Content::Other,
        };
        let info = ChannelInfo {
            id: channel.id,
            topic: channel.topic,
            schema: schema.map(|(name, _)| name.clone()),
            schema_encoding: schema.map(|(_, encoding)| encoding.clone()),
            message_encoding: channel.message_encoding,
            metadata: channel.metadata,
            messages: 0,
            bytes: 0,
            packed_bytes: 0,
            first_unix_nanos: None,
            last_unix_nanos: None,
        };
        (self.channels.entry(channel.id)).or_insert(Listed { info, content });
    }

    fn message(&mut self, channel: u16, log_time: u64, data: &[u8]) {
        if let Some((_, found)) = &mut self.spans {
            let (first, last) = found.unwrap_or((log_time, log_time));
            *found = Some((first.min(log_time), last.max(log_time)));
        }
        let Some(Listed { info, content }) = self.channels.get_mut(&channel) else {
            self.info.messages_without_channel += 1;
            return;
        };
        info.messages += 1;
        info.bytes += data.len() as u64;
        match self.chunk.0 {
            Some(_) => {
                info.packed_bytes += INDEX_ENTRY_BYTES;
                let of_chunk = self.chunk.1.entry(channel).or_default();
                of_chunk.extend_from_slice(data);
            }
            None => info.packed_bytes += data.len() as u64,
        }
        let first = info.first_unix_nanos.get_or_insert(log_time);
        *first = log_time.min(*first);
        let last = info.last_unix_nanos.get_or_insert(log_time);
        *last = log_time.max(*last);

        // A message that does not decode is no fault of the file: it is counted and left alone.
        let transforms = match content {
            Content::Other => return,
            Content::Fingertips(fingers) => {
                if let Ok(message) = messages::Fingertips::decode(data) {
                    for (finger, tip) in message.tips().iter() {
                        let status = tip.and_then(|tip| messages::Status::to_model(tip.status));
                        fingers[finger].add(status.unwrap_or(Status::Missing));
                    }
                }
                return;
            }
            Content::Transforms => FrameTransforms::decode(data).map(|message| message.transforms),
            Content::Transform => FrameTransform::decode(data).map(|message| vec![message]),
        };
        for transform in transforms.unwrap_or_default() {
            let edge = (
                transform.parent_frame_id,
                transform.child_frame_id,
                info.topic.clone(),
            );
            *self.frames.entry(edge).or_default() += 1;
        }
    }

    fn into_info(mut self) -> FileInfo {
        self.share_chunk();
        let mut file = self.info;
        if self.wrong_chunks > 0 {
            file.warnings.push(format!(
                "{} of {} chunks state other log times than their messages have",
                self.wrong_chunks, file.chunks.count
            ));
        }
        for Listed { info, content } in self.channels.into_values() {
            if let Content::Fingertips(fingers) = content {
                let rate_hz = info.rate_hz();
                let fingers = fingers.map(|gaps| FingerInfo {
                    longest_gap_s: rate_hz
                        .map_or(0.0, |rate_hz| gaps.info.longest_gap as f64 / rate_hz),
                    ..gaps.info
                });
                file.fingertips.push(FingertipsInfo {
                    topic: info.topic.clone(),
                    fingers,
                });
            }
            file.messages += info.messages;
            file.channels.push(info);
        }
        let frames = self.frames.into_iter();
        file.frames = frames
            .map(|((parent, child, topic), transforms)| FrameInfo {
                parent,
                child,
                topic,
                transforms,
            })
            .collect();
        file
    }
}
