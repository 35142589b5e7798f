//! A take's nouns from its file.

mod cleaned;
mod decode;
mod evaluated;
mod generated;

use std::collections::BTreeMap;

use inhand_model::{Annotations, Finding, Hand, Motion, Object, PerFinger, Recording, World};
use mcap::records::Record;

use crate::annotations::EventReader;
use crate::error::ChannelError;
use crate::info::info;
use crate::metadata::{Metadata, RECORDING, RecordingFacts};
use crate::records::{Depth, walk};
use crate::take::ReadTake;
use crate::topic;
pub use evaluated::read_evaluated;
pub use generated::{ReadMethod, read_generated};

use cleaned::{CleanedPart, CleanedParts};
use decode::{
    BodyTracks, Channel, Counter, FingertipTracks, MarkerTracks, PoseFromBodies, finding,
};

/// How far the time of a message may be from that of its sample. Both are rounded to nanoseconds, and a
/// cut counts them from another sample; samples are much farther apart.
pub(crate) const TIME_TOLERANCE_NANOS: u64 = 1000;

/// Reads a take that [`write_take`](crate::write_take) wrote.
///
/// Only channels that a recording or motion is made of are decoded; all chunks are unpacked and
/// their CRCs checked. `file_name` is what errors call the file.
///
/// # Errors
///
/// [`ChannelError::NotMcap`], [`ChannelError::Truncated`] and [`ChannelError::Damaged`] for bytes
/// that are no sound MCAP file, [`ChannelError::Absent`] for one without a recording,
/// [`ChannelError::Metadata`] and [`ChannelError::Message`] where one contradicts itself.
pub fn read_take(bytes: &[u8], file_name: &str) -> Result<ReadTake, ChannelError> {
    let metadata = read_metadata(bytes, file_name)?;
    let Some(facts) = metadata.recording(file_name)? else {
        return Err(no_recording(bytes, file_name));
    };
    let motion_name = metadata.motion_name(file_name)?;
    let cleaned = metadata.cleaned(file_name)?.map(CleanedParts::new);
    let mut parts = Parts::new(&facts, motion_name.is_some(), cleaned);
    let mut channels: BTreeMap<u16, Part> = BTreeMap::new();
    let mut events = EventReader::default();
    walk(file_name, bytes, Depth::Everything, |record| {
        events.record(&record, file_name)?;
        match record {
            Record::Channel(channel) => {
                if let Some(part) = Part::of(&channel.topic) {
                    parts.channel(part);
                    channels.insert(channel.id, part);
                }
                Ok(())
            }
            Record::Message { header, data } => match channels.get(&header.channel_id) {
                Some(&part) => {
                    let at = (header.log_time, header.sequence);
                    parts.message(part, at, &data, file_name, &facts)
                }
                None => Ok(()),
            },
            _ => Ok(()),
        }
    })?;
    parts.findings.extend(events.findings());
    let annotations = events.finish(&metadata, file_name)?;
    parts.into_take(facts, &metadata, motion_name, annotations, file_name)
}

/// The metadata records of any MCAP file.
///
/// # Errors
///
/// As for [`read_take`], where the bytes are no sound MCAP file outside its chunks.
pub fn read_metadata(bytes: &[u8], file_name: &str) -> Result<Metadata, ChannelError> {
    let mut metadata = Metadata::default();
    let outside = walk(file_name, bytes, Depth::Outside, |record| {
        if let Record::Metadata(facts) = record {
            metadata.0.insert(facts.name, facts.metadata);
        }
        Ok(())
    });
    match outside {
        Ok(()) => Ok(metadata),
        // A look into the chunks may say more exactly where the fault lies.
        Err(error) => Err(walk(file_name, bytes, Depth::Everything, |_| Ok(()))
            .err()
            .unwrap_or(error)),
    }
}

fn no_recording(bytes: &[u8], file_name: &str) -> ChannelError {
    absent(
        bytes,
        file_name,
        format!("recording (metadata record \"{RECORDING}\")"),
        "give a file that inhand convert or inhand run wrote, or convert the source again",
    )
}

/// The error for a sound file without `what` was looked for: lists the topics that it has.
pub fn absent(bytes: &[u8], file_name: &str, what: String, hint: &str) -> ChannelError {
    let topics = match info(bytes, file_name) {
        Ok(info) => info.channels.into_iter().map(|channel| channel.topic),
        Err(error) => return error,
    };
    let topics: Vec<String> = topics.take(20).collect();
    ChannelError::Absent {
        file: file_name.to_owned(),
        what,
        found: if topics.is_empty() {
            "no channel".to_owned()
        } else {
            format!("the topics {}", topics.join(", "))
        },
        hint: hint.to_owned(),
    }
}

/// What a channel is part of.
#[derive(Clone, Copy)]
enum Part {
    Markers,
    Bodies,
    Findings,
    Fingertips,
    Object,
    Hand,
    Cleaned(CleanedPart),
}

impl Part {
    fn of(topic: &str) -> Option<Self> {
        Some(match topic {
            topic::RECORDING_MARKERS => Part::Markers,
            topic::RECORDING_BODIES => Part::Bodies,
            topic::RECORDING_FINDINGS => Part::Findings,
            topic::PROCESSED_FINGERTIPS => Part::Fingertips,
            topic::PROCESSED_OBJECT => Part::Object,
            topic::PROCESSED_HAND => Part::Hand,
            topic::CLEANED_MARKERS => Part::Cleaned(CleanedPart::Markers),
            topic::CLEANED_BODIES => Part::Cleaned(CleanedPart::Bodies),
            topic::CLEANED_CHANGES => Part::Cleaned(CleanedPart::Changes),
            _ => return None,
        })
    }
}

/// Tracks as far as they have been read.
struct Parts {
    markers: MarkerTracks,
    bodies: BodyTracks,
    findings: Vec<Finding>,
    findings_read: Counter,
    fingertips: Option<FingertipTracks>,
    object: Option<PoseFromBodies<Hand, Object>>,
    hand: PoseFromBodies<World, Hand>,
    cleaned: Option<CleanedParts>,
}

impl Parts {
    fn new(facts: &RecordingFacts, motion: bool, cleaned: Option<CleanedParts>) -> Self {
        Self {
            markers: MarkerTracks::new(&facts.markers),
            bodies: BodyTracks::new(&facts.bodies),
            findings: Vec::new(),
            findings_read: Counter::default(),
            fingertips: motion.then(FingertipTracks::default),
            object: None,
            hand: PoseFromBodies::default(),
            cleaned,
        }
    }

    /// An object that was never tracked has no channel; one in an empty take has.
    fn channel(&mut self, part: Part) {
        if let Part::Object = part {
            self.object.get_or_insert_default();
        }
    }

    fn message(
        &mut self,
        part: Part,
        at: (u64, u32),
        data: &[u8],
        file: &str,
        facts: &RecordingFacts,
    ) -> Result<(), ChannelError> {
        // The motion is of the cleaned recording where there is one.
        let used = match part {
            Part::Fingertips | Part::Object | Part::Hand => self.used(facts),
            _ => facts,
        };
        let (clock, samples) = (used.clock, used.samples);
        let channel = |topic| Channel {
            file,
            topic,
            clock,
            samples,
            lossy: facts.lossy,
            log_time: at.0,
        };
        match part {
            Part::Markers => {
                (self.markers).message(&channel(topic::RECORDING_MARKERS), &facts.markers, data)
            }
            Part::Bodies => {
                (self.bodies).message(&channel(topic::RECORDING_BODIES), &facts.bodies, data)
            }
            Part::Findings => {
                let channel = channel(topic::RECORDING_FINDINGS);
                let finding = finding(&channel, &mut self.findings_read, data)?;
                self.findings.push(finding);
                Ok(())
            }
            Part::Fingertips => match &mut self.fingertips {
                Some(tracks) => tracks.message(&channel(topic::PROCESSED_FINGERTIPS), data),
                None => Ok(()),
            },
            Part::Object => (self.object.get_or_insert_default())
                .message(&channel(topic::PROCESSED_OBJECT), data),
            Part::Hand => self.hand.message(&channel(topic::PROCESSED_HAND), data),
            Part::Cleaned(part) => match &mut self.cleaned {
                Some(cleaned) => cleaned.message(part, at, data, file, facts.samples),
                None => Ok(()),
            },
        }
    }

    /// Ends a take, some of whose messages may be lost, with its last message.
    fn end_where_messages_do(&mut self, facts: &mut RecordingFacts) {
        let fingertips = self.fingertips.as_ref().map_or(0, |tips| tips.read.0);
        let object = self.object.as_ref().map_or(0, |object| object.read.0);
        let of_motion = fingertips.max(object).max(self.hand.read.0);
        let measured = self.markers.read.0.max(self.bodies.read.0);
        facts.samples = match &self.cleaned {
            None => measured.max(of_motion),
            Some(_) => measured,
        };
        let used = match &mut self.cleaned {
            None => facts.samples,
            Some(cleaned) => {
                let samples = cleaned.reached().max(of_motion);
                cleaned.end_at(samples);
                samples
            }
        };
        self.markers.miss(facts.samples - self.markers.read.0);
        self.bodies.miss(facts.samples - self.bodies.read.0);
        if let Some(fingertips) = &mut self.fingertips {
            fingertips.miss(used - fingertips.read.0);
            self.hand.miss(used - self.hand.read.0);
        }
        if let Some(object) = &mut self.object {
            object.miss(used - object.read.0);
        }
    }

    fn used<'a>(&'a self, facts: &'a RecordingFacts) -> &'a RecordingFacts {
        self.cleaned
            .as_ref()
            .map_or(facts, |cleaned| &cleaned.facts)
    }

    fn into_take(
        mut self,
        mut facts: RecordingFacts,
        metadata: &Metadata,
        motion_name: Option<String>,
        annotations: Annotations,
        file: &str,
    ) -> Result<ReadTake, ChannelError> {
        if facts.lossy {
            self.end_where_messages_do(&mut facts);
        }
        let (clock, of_motion) = (self.used(&facts).clock, self.used(&facts).samples);
        let samples = facts.samples;
        let complete = |topic: &str, samples: usize, found: usize| {
            if found == samples {
                return Ok(());
            }
            Err(ChannelError::Message {
                file: file.to_owned(),
                topic: topic.to_owned(),
                message: found,
                expected: format!("one message for each of the take's {samples} samples"),
                found: format!("{found} messages"),
            })
        };
        if !facts.markers.is_empty() {
            complete(topic::RECORDING_MARKERS, samples, self.markers.read.0)?;
        }
        if !facts.bodies.is_empty() {
            complete(topic::RECORDING_BODIES, samples, self.bodies.read.0)?;
        }
        let motion = match (motion_name, self.fingertips) {
            (Some(name), Some(fingertips)) => {
                complete(topic::PROCESSED_FINGERTIPS, of_motion, fingertips.read.0)?;
                complete(topic::PROCESSED_HAND, of_motion, self.hand.read.0)?;
                if let Some(object) = &self.object {
                    complete(topic::PROCESSED_OBJECT, of_motion, object.read.0)?;
                }
                Some(Motion {
                    name,
                    clock,
                    fingertips: PerFinger::new(fingertips.tracks),
                    object: self.object.map(|object| object.track),
                    hand: self.hand.track,
                    selected: None,
                })
            }
            _ => None,
        };
        let mut recording = Recording::new(
            facts.name,
            facts.clock,
            facts.source,
            samples,
            self.markers.into_markers(facts.markers),
            self.bodies.into_bodies(facts.bodies),
        )
        .map_err(|error| ChannelError::Metadata {
            file: file.to_owned(),
            record: RECORDING.to_owned(),
            key: "samples".to_owned(),
            expected: "the number of samples of every marker and body".to_owned(),
            found: error.to_string(),
        })?;
        recording.findings = self.findings;
        let cleaned = (self.cleaned)
            .map(|cleaned| cleaned.into_cleaned(&recording.findings, file))
            .transpose()?;
        Ok(ReadTake {
            recording,
            cleaned,
            roles: metadata.roles(file)?,
            motion,
            annotations,
            provenance: metadata.provenance(file)?,
        })
    }
}
