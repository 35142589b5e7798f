//! MCAP recordings of others as takes: ROS 2 bags of motion-capture drivers, and messages of package
//! `foxglove`.
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
//! * **Time** is capture time: the stamp in the message. Where stamps are zero or do not tell messages
//!   apart it is when messages were sent or, failing that, written; a finding says which.
//! * **Rate**: the slope of a line through the stamps of the most telling messages (of the topics
//!   that the user names; else motion-capture messages, poses, clouds, transforms). It becomes a whole
//!   number, or a rate of television, where the stamps single that one out: they lie within a
//!   fifth of a period of an even clock (root mean square), and no other such rate lies
//!   within the error.
//! * **Samples**: each message goes to the nearest instant of a phase that follows the stamps. An
//!   instant without a message is a missing sample; of two messages for one sample the first is taken.
//! * **Missing** is what is not in a message, not finite, or, as drivers without a notion of missing
//!   send it, exactly at the origin.
//! * **Frames**: transforms are chained up to the highest frame that moves. Frames of messages are
//!   otherwise taken for the world.
//! * **Units and axes** are stated nowhere: metres and z up, as ROS has it, unless the user says
//!   otherwise.

mod assemble;
mod cdr;
mod cloud;
mod format;
mod gather;
mod json;
mod pace;
mod place;
mod reading;
mod ros;
mod timing;
mod topics;
mod tree;
mod viewer;
mod world;

use std::collections::{BTreeMap, BTreeSet};

use inhand_model::{Finding, LengthUnit, Recording, RotationOrder, Source, UpAxis};
use mcap::records::Record;
use nalgebra::Isometry3;

use self::format::Format;
use self::gather::Gathered;
use self::timing::Timing;
pub use self::topics::{ForeignSettings, TopicUse, TopicUseError};
use crate::annotations::read_annotations;
use crate::error::ChannelError;
use crate::metadata::{ABOUT, ANNOTATIONS, Metadata, PROVENANCE, RECORDING};
use crate::read::{absent_part, read_metadata, read_take};
use crate::records::{Depth, walk};
use crate::take::ReadTake;
use crate::topic;

/// Start of the names of our own metadata records.
const OWN_METADATA: &str = "inhand.";
/// The step that adds views to a file.
const VIEW_STEP: &str = "view";

/// Reads a take from any MCAP file: one of our own as [`read_take`] does, one of others as
/// [`read_foreign`] does.
///
/// # Errors
///
/// As those.
pub fn read_any_take(
    bytes: &[u8],
    file_name: &str,
    settings: &ForeignSettings,
) -> Result<ReadTake, ChannelError> {
    let metadata = read_metadata(bytes, file_name)?;
    // Files of others may have been annotated, or have been given views.
    let added = |name: &str, facts: &BTreeMap<String, String>| {
        let step = facts.get("step").map_or("", String::as_str);
        [ANNOTATIONS, ABOUT].contains(&name)
            || name.starts_with(PROVENANCE) && ["annotate", VIEW_STEP].contains(&step)
    };
    let mut records = metadata.0.iter();
    if records.any(|(name, facts)| name.starts_with(OWN_METADATA) && !added(name, facts)) {
        return read_take(bytes, file_name);
    }
    Ok(ReadTake {
        cleaned: None,
        recording: read_foreign(bytes, file_name, settings)?,
        roles: None,
        motion: None,
        annotations: read_annotations(bytes, file_name)?,
        provenance: metadata.provenance(file_name)?,
    })
}

/// Reads the recording of others: every marker and body on topics that are understood, on an even
/// clock, in metres.
///
/// # Errors
///
/// [`ChannelError::NotMcap`], [`ChannelError::Truncated`] and [`ChannelError::Damaged`] for bytes
/// that are no sound MCAP file; [`ChannelError::Absent`], with a list of the topics, where none is
/// understood; [`ChannelError::Message`] where no message of them can be read;
/// [`ChannelError::Unclear`] where they leave open what they mean.
pub fn read_foreign(
    bytes: &[u8],
    file_name: &str,
    settings: &ForeignSettings,
) -> Result<Recording, ChannelError> {
    let (gathered, profile) = gather(bytes, file_name, settings)?;
    let used = world::used(&gathered);
    if used.is_empty() {
        return Err(nothing_to_read(&gathered, bytes, file_name));
    }
    let timing = Timing::of(&gathered, &used, settings)?;
    recording(&gathered, &used, &timing, profile, file_name, settings)
}

/// Everything that can be read, and the facts of the file's header.
fn gather<'a>(
    bytes: &[u8],
    file_name: &'a str,
    settings: &'a ForeignSettings,
) -> Result<(Gathered<'a>, BTreeMap<String, String>), ChannelError> {
    let viewed = was_given_views(&read_metadata(bytes, file_name)?);
    let mut gathered = Gathered::new(file_name, bytes.len(), settings);
    let mut profile = BTreeMap::new();
    let mut schemas: BTreeMap<u16, String> = BTreeMap::new();
    let mut channels: BTreeMap<u16, Option<usize>> = BTreeMap::new();
    walk(file_name, bytes, Depth::Everything, |record| {
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
                    if viewed && channel.topic.starts_with(topic::VIEW) {
                        return None;
                    }
                    let format = Format::of(schema, encoding)?;
                    gathered.topic(&channel.topic, schema, encoding, format)
                });
            }
            Record::Message { header, data } => {
                if let Some(&Some(topic)) = channels.get(&header.channel_id) {
                    gathered.message(topic, header.log_time, header.publish_time, &data)?;
                }
            }
            _ => {}
        }
        Ok(())
    })?;
    Ok((gathered, profile))
}

/// Whether the views in a file of others are ours.
pub(crate) fn was_given_views(metadata: &Metadata) -> bool {
    (metadata.0.iter()).any(|(name, facts)| {
        name.starts_with(PROVENANCE) && facts.get("step").is_some_and(|step| step == VIEW_STEP)
    })
}

/// Where the trees of frames stand that a recording of others lies in, by their roots: `world_from_root`.
/// Frames that coordinates stand in are all taken for the world by [`read_foreign`]; a root is there where
/// the first of its frames coincides with the world. Trees whose roots move against it have no place.
///
/// # Errors
///
/// As for [`read_foreign`], where the bytes are no sound MCAP file.
pub(crate) fn world_frames(
    bytes: &[u8],
    file_name: &str,
    settings: &ForeignSettings,
) -> Result<BTreeMap<String, Isometry3<f64>>, ChannelError> {
    let (gathered, _) = gather(bytes, file_name, settings)?;
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
    settings: &ForeignSettings,
) -> Result<Recording, ChannelError> {
    let mut findings = unread(gathered, settings);
    findings.extend(timing.findings.iter().cloned());
    let (placed, of_times) = place::place(gathered, used, timing);
    findings.extend(of_times);
    let mut entities = assemble::entities(gathered, used, &placed, timing.samples, settings);
    world::tell_apart(gathered, &mut entities);
    findings.append(&mut entities.findings);
    findings.extend(world::frames(gathered, used));
    findings.extend(world::units_and_axes(&entities, settings));
    let topics: BTreeSet<usize> = (used.iter())
        .map(|&series| gathered.series[series].topic)
        .collect();
    let schemas: BTreeSet<&str> = (topics.iter())
        .map(|&topic| gathered.topics[topic].schema.as_str())
        .collect();
    for &topic in &topics {
        let of = &gathered.topics[topic];
        let facts = format!("{}, {}, {} messages", of.schema, of.encoding, of.messages);
        header.insert(format!("topic {}", of.name), facts);
    }
    let source = Source {
        format: format!(
            "MCAP with {}",
            schemas.into_iter().collect::<Vec<_>>().join(", ")
        ),
        length_unit: settings.length_unit.unwrap_or(LengthUnit::Metres),
        up_axis: settings.up_axis.unwrap_or(UpAxis::Z),
        rotation: (!entities.bodies.is_empty()).then_some(RotationOrder::Quaternion),
        header,
    };
    let name = file_name
        .rsplit_once('.')
        .map_or(file_name, |(stem, _)| stem);
    let mut recording = Recording::new(
        name.to_owned(),
        timing.clock,
        source,
        timing.samples,
        entities
            .markers
            .into_iter()
            .map(|(_, marker)| marker)
            .collect(),
        entities.bodies.into_iter().map(|(_, body)| body).collect(),
    )
    .map_err(|error| ChannelError::mismatch(file_name, "tracks of one length", error))?;
    recording.findings = findings;
    Ok(recording)
}

/// What was passed over: messages that cannot be read, scans, things without a name, and settings
/// for topics that are not there.
fn unread(gathered: &Gathered<'_>, settings: &ForeignSettings) -> Vec<Finding> {
    let mut findings = Vec::new();
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

/// Why there is nothing to read.
fn nothing_to_read(gathered: &Gathered<'_>, bytes: &[u8], file_name: &str) -> ChannelError {
    let faulty = gathered.topics.iter().find_map(|topic| {
        let (number, fault) = topic.first_fault.clone()?;
        Some(ChannelError::Message {
            file: file_name.to_owned(),
            topic: topic.name.clone(),
            message: number,
            expected: fault.expected,
            found: fault.found,
        })
    });
    faulty.unwrap_or_else(|| {
        absent_part(
            bytes,
            file_name,
            format!(
                "take: neither a recording of inhand (metadata record \"{RECORDING}\") nor markers, \
                 poses or transforms on a topic that can be read"
            ),
            "readable are the ROS 2 messages PoseStamped, PointStamped, PoseArray, TransformStamped, \
             TFMessage, mocap4r2 Markers and RigidBodies in CDR, and foxglove.PoseInFrame, \
             PosesInFrame, FrameTransform(s) and PointCloud in protobuf or JSON; [topics] in the \
             settings says what their topics are",
        )
    })
}
