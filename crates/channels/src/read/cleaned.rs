//! A cleaned recording from its channels.

use inhand_model::{Change, ChangeKind, Finding, Recording};

use super::decode::{BodyTracks, Channel, Counter, MarkerTracks};
use crate::error::ChannelError;
use crate::messages;
use crate::metadata::{CLEANED, RecordingFacts};
use crate::take::ReadCleaned;
use crate::topic;

/// What a channel of the cleaned recording holds.
#[derive(Clone, Copy)]
pub(super) enum CleanedPart {
    Markers,
    Bodies,
    Changes,
}

/// Tracks as far as they have been read.
pub(super) struct CleanedParts {
    pub(super) facts: RecordingFacts,
    markers: MarkerTracks,
    bodies: BodyTracks,
    changes: Vec<(u32, Change)>,
    changes_read: Counter,
}

impl CleanedParts {
    pub(super) fn new(facts: RecordingFacts) -> Self {
        Self {
            markers: MarkerTracks::new(&facts.markers),
            bodies: BodyTracks::new(&facts.bodies),
            facts,
            changes: Vec::new(),
            changes_read: Counter::default(),
        }
    }

    /// `measured` are the samples of the recording as measured.
    pub(super) fn message(
        &mut self,
        part: CleanedPart,
        (log_time, sequence): (u64, u32),
        data: &[u8],
        file: &str,
        measured: usize,
    ) -> Result<(), ChannelError> {
        let channel = |topic| Channel {
            file,
            topic,
            clock: self.facts.clock,
            samples: self.facts.samples,
            lossy: self.facts.lossy,
            log_time,
        };
        match part {
            CleanedPart::Markers => {
                (self.markers).message(&channel(topic::CLEANED_MARKERS), &self.facts.markers, data)
            }
            CleanedPart::Bodies => {
                (self.bodies).message(&channel(topic::CLEANED_BODIES), &self.facts.bodies, data)
            }
            CleanedPart::Changes => {
                let channel = channel(topic::CLEANED_CHANGES);
                let read = self.changes_read;
                let message: messages::Change = channel.decode(read, data)?;
                let kind = ChangeKind::from_name(&message.kind).ok_or_else(|| {
                    let kinds = ChangeKind::ALL.map(ChangeKind::name).join(", ");
                    channel.error(
                        read,
                        format!("one of {kinds}"),
                        format!("\"{}\"", message.kind),
                    )
                })?;
                let end = message.first_sample.checked_add(message.samples);
                let samples = (end.filter(|end| *end <= measured as u64))
                    .map(|end| message.first_sample as usize..end as usize)
                    .ok_or_else(|| {
                        channel.error(
                            read,
                            format!("samples of the take, below {measured}"),
                            format!("{} from {}", message.samples, message.first_sample),
                        )
                    })?;
                self.changes_read.0 += 1;
                let change = Change {
                    kind,
                    entity: message.entity,
                    samples,
                    message: message.message,
                };
                self.changes.push((sequence, change));
                Ok(())
            }
        }
    }

    /// Samples up to the last one that has a message.
    pub(super) fn reached(&self) -> usize {
        self.markers.read.0.max(self.bodies.read.0)
    }

    /// Ends the recording, some of whose messages may be lost, after so many samples.
    pub(super) fn end_at(&mut self, samples: usize) {
        self.facts.samples = samples;
        self.markers.miss(samples - self.markers.read.0);
        self.bodies.miss(samples - self.bodies.read.0);
    }

    pub(super) fn into_cleaned(
        mut self,
        findings: &[Finding],
        file: &str,
    ) -> Result<ReadCleaned, ChannelError> {
        let samples = self.facts.samples;
        for (topic, wanted, found) in [
            (
                topic::CLEANED_MARKERS,
                !self.facts.markers.is_empty(),
                self.markers.read.0,
            ),
            (
                topic::CLEANED_BODIES,
                !self.facts.bodies.is_empty(),
                self.bodies.read.0,
            ),
        ] {
            if wanted && found != samples {
                return Err(ChannelError::Message {
                    file: file.to_owned(),
                    topic: topic.to_owned(),
                    message: found,
                    expected: format!("one message for each of the {samples} cleaned samples"),
                    found: format!("{found} messages"),
                });
            }
        }
        // In the order of the steps.
        self.changes.sort_by_key(|(sequence, _)| *sequence);
        let facts = self.facts;
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
            record: CLEANED.to_owned(),
            key: "samples".to_owned(),
            expected: "the number of samples of every marker and body".to_owned(),
            found: error.to_string(),
        })?;
        recording.findings = findings.to_vec();
        Ok(ReadCleaned {
            recording,
            changes: self.changes.into_iter().map(|(_, change)| change).collect(),
        })
    }
}
