//! Third-party MCAP recordings as takes: ROS 2 bags of motion-capture drivers, ROS 1 messages in MCAP, and messages
//! of package `foxglove`. Turns the bytes of a file into a [`Recording`].
//!
//! ```no_run
//! use inhand_import::{ImportSettings, read_recording};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let recording = read_recording(&std::fs::read("bag.mcap")?, "bag.mcap", &ImportSettings::default())?;
//! # Ok(())
//! # }
//! ```
//!
//! A bag that `ros2 bag record` wrote is a folder: [`bag_files`] lists its files, [`open`] reads them as one.
//! Files and messages that zstd packed are read. [`take_of_source`] reads files that are larger than memory.
//!
//! A message kind is a file in `ros` or `foxglove` and one line in the registry beside it.
//!
//! CDR stands for itself and for the encoding `ros1` of the same message in ROS 1.
//!
//! | message | encoding | read as |
//! | --- | --- | --- |
//! | `mocap4r2_msgs/msg/Markers` | CDR | markers, by name, else by number |
//! | `mocap4r2_msgs/msg/RigidBodies` | CDR | bodies and their markers |
//! | `geometry_msgs/msg/PoseStamped`, `foxglove.PoseInFrame` | CDR; protobuf, JSON | a body, called as the topic says |
//! | `geometry_msgs/msg/PointStamped` | CDR | a marker, called as the topic says |
//! | `geometry_msgs/msg/PoseArray`, `foxglove.PosesInFrame` | CDR; protobuf, JSON | bodies, by place |
//! | `foxglove.PointCloud` | protobuf, JSON | markers, by a number field, else by place |
//! | `tf2_msgs/msg/TFMessage`, `geometry_msgs/msg/TransformStamped`, `foxglove.FrameTransform(s)` | CDR; protobuf, JSON | bodies, one for each child frame |
//!
//! # Conventions
//!
//! * **Time** is capture time: the stamp in the message. Where stamps are zero or do not distinguish
//!   messages it is when messages were sent or, failing that, written; a finding says which.
//! * **Rate**: the slope of a line through the stamps of the messages of the highest priority (of the topics
//!   that the user names; else motion-capture messages, poses, clouds, transforms). It becomes a whole
//!   number, or a rate of television, where the stamps single that one out: they are within a
//!   fifth of a period of an even clock (root mean square), and no other such rate is
//!   within the error.
//!   Stamps are those of the marker or body that comes most often, so that a driver may send a message for each
//!   marker of a frame. A clock at which most samples are empty is refused unless the user sets the rate.
//! * **Samples**: each message goes to the nearest instant of a phase that follows the stamps. An
//!   instant without a message is a missing sample. A message that was stamped with the next one, as where it waited
//!   to be sent, goes to the empty sample before it; of several messages that remain for a sample the nearest in
//!   time is taken.
//! * **Missing** is what is not in a message, not finite, or, as drivers without a notion of missing
//!   send it, exactly at the origin.
//! * **Frames**: transforms are chained up to the highest frame that moves. Frames of messages are
//!   otherwise taken for the world.
//! * **Units and axes** are stated nowhere: metres and z up, as ROS has it, unless the user says
//!   otherwise.

mod assemble;
mod bag;
mod foxglove;
mod message_kinds;
mod open;
mod pace;
mod place;
mod reading;
mod ros;
mod series;
mod timing;
mod topics;
mod tree;
mod world;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;

use inhand_channels::{
    ChannelError, EventReader, Metadata, ReadTake, VIEW_TOPICS, ViewsFor, absent,
    metadata_of_source,
};
use inhand_container::{Depth, Record, Source as FileSource, is_zstd, unpack_zstd, walk_source};
use inhand_model::{Finding, LengthUnit, Recording, RotationOrder, Source, UpAxis};
use nalgebra::Isometry3;

pub use self::bag::{BAG_FACTS, bag_files, unpack_file, unpacked_name};
use self::message_kinds::find_kind;
pub use self::open::open;
use self::series::Gathered;
use self::timing::Timing;
pub use self::topics::{ImportSettings, TopicUse, TopicUseError};

/// Reads a take from any MCAP file: one that inhand wrote as [`inhand_channels::read_take`] does, a
/// third-party one as [`read_recording`] does.
///
/// # Errors
///
/// As those.
pub fn read_take(
    bytes: &[u8],
    file_name: &str,
    settings: &ImportSettings,
) -> Result<ReadTake, ChannelError> {
    take_of_source(
        &mut FileSource::open(file_name, Cursor::new(bytes))?,
        settings,
    )
}

/// As [`read_take`] for a file of any size: of a third-party one memory is taken for the numbers of its series.
///
/// # Errors
///
/// As for [`read_take`].
pub fn take_of_source(
    source: &mut FileSource<'_>,
    settings: &ImportSettings,
) -> Result<ReadTake, ChannelError> {
    let metadata = metadata_of_source(source)?;
    if metadata.is_written_by_inhand() {
        return inhand_channels::take_of_source(source);
    }
    let file_name = &*source.file().to_owned();
    let mut events = EventReader::default();
    let mut note_event = |record: &Record<'_>| events.record(record, file_name);
    let recording = recording_of(source, &metadata, settings, &mut note_event)?;
    Ok(ReadTake {
        cleaned: None,
        recording,
        roles: None,
        motion: None,
        annotations: events.finish(&metadata, file_name)?,
        provenance: metadata.provenance(file_name)?,
    })
}

/// The place for the views of a take in this file: beside those of inhand, or beside third-party frames.
///
/// # Errors
///
/// As for [`read_recording`], where the bytes are no intact MCAP file.
pub fn views_for(
    source: &mut FileSource<'_>,
    settings: &ImportSettings,
) -> Result<ViewsFor, ChannelError> {
    let metadata = metadata_of_source(source)?;
    if metadata.is_take() {
        return Ok(ViewsFor::Take);
    }
    let roots = world_frames(source, &metadata, settings)?;
    Ok(ViewsFor::ThirdParty { roots })
}

/// Reads a third-party recording: every marker and body on topics that are understood, on an even
/// clock, in metres.
///
/// # Errors
///
/// [`ChannelError::Container`] for bytes that are no intact MCAP file; [`ChannelError::Absent`], with a list of the topics, where none is
/// understood; [`ChannelError::Mismatch`] where no message of them can be read and where they leave open
/// what they mean.
pub fn read_recording(
    bytes: &[u8],
    file_name: &str,
    settings: &ImportSettings,
) -> Result<Recording, ChannelError> {
    let mut source = FileSource::open(file_name, Cursor::new(bytes))?;
    let metadata = metadata_of_source(&mut source)?;
    recording_of(&mut source, &metadata, settings, &mut |_| Ok(()))
}

/// Calls for each record of a file.
type Visit<'a> = dyn FnMut(&Record<'_>) -> Result<(), ChannelError> + 'a;

/// The recording of a file with this metadata, whose records are visited on the way.
fn recording_of(
    source: &mut FileSource<'_>,
    metadata: &Metadata,
    settings: &ImportSettings,
    visit: &mut Visit<'_>,
) -> Result<Recording, ChannelError> {
    let file_name = &*source.file().to_owned();
    let (gathered, profile) = gather(source, file_name, metadata, settings, visit)?;
    let used = world::used(&gathered);
    if used.is_empty() {
        return Err(nothing_to_read(&gathered, source));
    }
    let timing = Timing::new(&gathered, &used, settings)?;
    recording(&gathered, &used, &timing, profile, file_name, settings)
}

/// Everything that can be read, and the facts of the file's header.
fn gather<'a>(
    source: &mut FileSource<'_>,
    file_name: &'a str,
    metadata: &Metadata,
    settings: &'a ImportSettings,
    visit: &mut Visit<'_>,
) -> Result<(Gathered<'a>, BTreeMap<String, String>), ChannelError> {
    let viewed = metadata.has_added_views();
    let mut gathered = Gathered::new(file_name, source.bytes(), settings);
    let mut profile = BTreeMap::new();
    let mut schemas: BTreeMap<u16, String> = BTreeMap::new();
    let mut channels: BTreeMap<u16, Option<usize>> = BTreeMap::new();
    source.rewind()?;
    walk_source(source, |record| {
        visit(&record)?;
        match record {
            Record::Header(header) => {
                let facts = [("profile", header.profile), ("library", header.library)];
                let stated = facts.into_iter().filter(|(_, text)| !text.is_empty());
                profile.extend(stated.map(|(key, text)| (key.to_owned(), text)));
            }
            Record::Schema { header, .. } => {
                schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let schema = schemas.get(&channel.schema_id).map_or("", String::as_str);
                let encoding = &channel.message_encoding;
                // A channel may be repeated in every chunk.
                channels.entry(channel.id).or_insert_with(|| {
                    if viewed && channel.topic.starts_with(VIEW_TOPICS) {
                        return None;
                    }
                    let Some(format) = find_kind(schema, encoding) else {
                        gathered.other_encoding(&channel.topic, schema, encoding);
                        return None;
                    };
                    gathered.topic(&channel.topic, schema, encoding, format)
                });
            }
            Record::Message { header, data } => {
                if let Some(&Some(topic)) = channels.get(&header.channel_id) {
                    let data = unpacked_message(data, gathered.topics[topic].encoding);
                    gathered.message(topic, header.log_time, header.publish_time, &data)?;
                }
            }
            _ => {}
        }
        Ok::<_, ChannelError>(Depth::Everything)
    })?;
    gathered.end();
    Ok((gathered, profile))
}

/// The message that a recorder with compression per message stored; what cannot be unpacked stays, and is no message
/// that can be read. No CDR begins as zstd does.
fn unpacked_message<'a>(data: Cow<'a, [u8]>, encoding: &str) -> Cow<'a, [u8]> {
    if encoding != "cdr" || !is_zstd(&data) {
        return data;
    }
    unpack_zstd(&data).map_or(data, Cow::Owned)
}

/// Roots of the trees of frames that coordinates are given in: `world_from_root`. [`read_recording`] takes
/// all those frames for the world; a root is where the first of its frames coincides with the world.
/// Trees whose roots move against it have no place.
fn world_frames(
    source: &mut FileSource<'_>,
    metadata: &Metadata,
    settings: &ImportSettings,
) -> Result<BTreeMap<String, Isometry3<f64>>, ChannelError> {
    let file_name = &*source.file().to_owned();
    let (gathered, _) = gather(source, file_name, metadata, settings, &mut |_| Ok(()))?;
    let mut roots = BTreeMap::new();
    for frame in world::top_frames(&gathered, &world::used(&gathered)) {
        if let Some((root, frame_from_root)) = tree::root_of(&gathered, &frame) {
            roots.entry(root).or_insert(frame_from_root);
        }
    }
    Ok(roots)
}

fn recording(
    gathered: &Gathered<'_>,
    used: &[usize],
    timing: &Timing,
    mut header: BTreeMap<String, String>,
    file_name: &str,
    settings: &ImportSettings,
) -> Result<Recording, ChannelError> {
    let mut findings = unread(gathered, settings);
    findings.extend(timing.findings.iter().cloned());
    let (placed, of_times) = place::place(gathered, used, timing);
    findings.extend(of_times);
    let mut entities = assemble::entities(gathered, used, &placed, timing.samples, settings);
    world::distinguish(gathered, &mut entities);
    findings.append(&mut entities.findings);
    findings.extend(world::frames(gathered, used));
    findings.extend(world::units_and_axes(&entities, settings));
    let topics = used.iter().map(|&series| gathered.series[series].topic);
    let mut schemas = BTreeSet::new();
    for topic in topics.map(|topic| &gathered.topics[topic]) {
        schemas.insert(topic.schema.as_str());
        let facts = format!(
            "{}, {}, {} messages",
            topic.schema, topic.encoding, topic.messages
        );
        header.insert(format!("topic {}", topic.name), facts);
    }
    let schemas: Vec<&str> = schemas.into_iter().collect();
    let source = Source {
        format: format!("MCAP with {}", schemas.join(", ")),
        length_unit: settings.length_unit.unwrap_or(LengthUnit::Metres),
        up_axis: settings.up_axis.unwrap_or(UpAxis::Z),
        rotation: (!entities.bodies.is_empty()).then_some(RotationOrder::Quaternion),
        header,
    };
    let name = file_name
        .rsplit_once('.')
        .map_or(file_name, |(stem, _)| stem);
    let markers = entities.markers.into_iter().map(|(_, marker)| marker);
    let bodies = entities.bodies.into_iter().map(|(_, body)| body);
    let mut recording = Recording::new(
        name.to_owned(),
        timing.clock,
        source,
        timing.samples,
        markers.collect(),
        bodies.collect(),
    )
    .map_err(|error| ChannelError::Mismatch {
        what: file_name.to_owned(),
        expected: "tracks of one length".to_owned(),
        found: error.to_string(),
    })?;
    recording.findings = findings;
    Ok(recording)
}

/// Findings about what was passed over: messages that cannot be read, scans, things without a name, and settings
/// for topics that are not there.
fn unread(gathered: &Gathered<'_>, settings: &ImportSettings) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (topic, what) in &gathered.other_encodings {
        findings.push(Finding::warning(topic.clone(), format!("{what}: left out")));
    }
    for topic in &gathered.topics {
        let mut warn = |message| findings.push(Finding::warning(topic.name.clone(), message));
        if let Some((number, fault)) = &topic.first_fault {
            warn(format!(
                "{} of {} messages cannot be read and are left out; the first is message {number}: \
                 {fault}",
                topic.unreadable, topic.messages
            ));
        }
        if let Some(points) = topic.points_of_a_scan {
            warn(format!(
                "{points} points in a message are a scan and no set of markers: left out; \
                 \"marker\" under [topics] reads them"
            ));
        }
        if topic.unnamed > 0 {
            warn(format!(
                "{} things on the topic come after those that [topics] names: left out",
                topic.unnamed
            ));
        }
        if topic.channels > 1 {
            warn(format!(
                "{} channels have this topic, as of several programs that send on it or of files \
                 that were joined: read as one",
                topic.channels
            ));
        }
    }
    for (key, setting) in &settings.topics {
        let topic = key.split('#').next().unwrap_or(key);
        let known = |name: &str| gathered.topics.iter().any(|t| t.name == name);
        if *setting != TopicUse::Ignore && !known(key) && !known(topic) {
            findings.push(Finding::warning(
                key.clone(),
                "set under [topics], but the file has no such topic that can be read",
            ));
        }
    }
    findings
}

/// The error that there is nothing to read.
fn nothing_to_read(gathered: &Gathered<'_>, source: &mut FileSource<'_>) -> ChannelError {
    let file_name = source.file();
    let faulty = gathered.topics.iter().find_map(|topic| {
        let (number, fault) = topic.first_fault.clone()?;
        Some(ChannelError::Mismatch {
            what: format!("{file_name}: {}, message {number}", topic.name),
            expected: fault.expected,
            found: fault.found,
        })
    });
    let encodings = gathered.other_encodings.iter().next();
    let encodings = encodings.map_or_else(String::new, |(topic, what)| {
        format!("{topic} has {what}; record it in one of those encodings, or convert the file; ")
    });
    let hint = format!(
        "{encodings}readable are the ROS messages PoseStamped, PointStamped, PoseArray, \
         TransformStamped, TFMessage, mocap4r2 Markers and RigidBodies in CDR (ROS 2) or ros1, and \
         foxglove.PoseInFrame, PosesInFrame, FrameTransform(s) and PointCloud in protobuf or JSON; \
         [topics] in the settings says what their topics are"
    );
    faulty.unwrap_or_else(|| {
        absent(
            source,
            "take: neither a recording of inhand (metadata record \"inhand.recording\") nor markers, \
             poses or transforms on a topic that can be read",
            &hint,
        )
    })
}
