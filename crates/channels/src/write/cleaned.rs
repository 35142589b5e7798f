//! A cleaned recording beside the measured one, and what was changed.

use inhand_model::{Change, Clock, Recording};

use super::recorded::{Bodies, Markers};
use super::{Instant, Stream, Streams};
use crate::error::ChannelError;
use crate::messages;
use crate::output::{ChannelId, Output};
use crate::take::CleanedTake;
use crate::topic;
use crate::wire::Timestamp;

/// Adds the channels of the cleaned recording, whose clock the file's samples follow.
pub(super) fn add<'a>(
    cleaned: &CleanedTake<'a>,
    output: &mut Output,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    let recording = cleaned.recording;
    if !recording.markers.is_empty() {
        let topic = topic::CLEANED_MARKERS;
        streams.push(Box::new(Markers::new(recording, topic, output)?));
    }
    if !recording.bodies.is_empty() {
        let topic = topic::CLEANED_BODIES;
        streams.push(Box::new(Bodies::new(recording, topic, output)?));
    }
    Ok(())
}

/// Adds the changes, to streams that follow the clock `measured`, by which they count samples.
pub(super) fn add_changes<'a>(
    cleaned: &CleanedTake<'a>,
    measured: Clock,
    output: &mut Output,
    streams: &mut Streams<'a>,
) -> Result<(), ChannelError> {
    if !cleaned.changes.is_empty() {
        let mut changes: Vec<(usize, &Change)> = cleaned.changes.iter().enumerate().collect();
        // By time; `sequence` keeps the order of the steps.
        changes.sort_by_key(|(n, change)| (change.samples.start, *n));
        streams.push(Box::new(Changes {
            channel: output.channel::<messages::Change>(topic::CLEANED_CHANGES, None)?,
            clock: measured,
            changes,
            written: 0,
        }));
    }
    Ok(())
}

struct Changes<'a> {
    channel: ChannelId,
    clock: Clock,
    changes: Vec<(usize, &'a Change)>,
    written: usize,
}

impl Changes<'_> {
    fn write_until(&mut self, unix_nanos: u64, output: &mut Output) -> Result<(), ChannelError> {
        while let Some((n, change)) = self.changes.get(self.written) {
            let start = self.clock.unix_nanos(change.samples.start);
            if start > unix_nanos {
                break;
            }
            let last = change.samples.end.saturating_sub(1);
            let end = self.clock.unix_nanos(last.max(change.samples.start));
            let message = messages::Change {
                timestamp: Some(Timestamp::from_unix_nanos(start)),
                end: Some(Timestamp::from_unix_nanos(end)),
                kind: change.kind.name().to_owned(),
                entity: change.entity.clone(),
                first_sample: change.samples.start as u64,
                samples: change.samples.len() as u64,
                message: change.message.clone(),
            };
            output.message(self.channel, *n, start, &message)?;
            self.written += 1;
        }
        Ok(())
    }
}

impl Stream for Changes<'_> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        self.write_until(at.unix_nanos, output)
    }

    fn finish(&mut self, output: &mut Output) -> Result<(), ChannelError> {
        self.write_until(u64::MAX, output)
    }
}

/// Streams of a recording in a file whose samples follow another clock: each sample when its time has
/// come.
pub(super) struct AtOwnTimes<'a> {
    recording: &'a Recording,
    streams: Streams<'a>,
    written: usize,
}

impl<'a> AtOwnTimes<'a> {
    pub(super) fn new(recording: &'a Recording, streams: Streams<'a>) -> Self {
        Self {
            recording,
            streams,
            written: 0,
        }
    }

    fn write_until(&mut self, unix_nanos: u64, output: &mut Output) -> Result<(), ChannelError> {
        while self.written < self.recording.len() {
            let own = self.recording.clock.unix_nanos(self.written);
            if own > unix_nanos {
                break;
            }
            let at = Instant {
                k: self.written,
                unix_nanos: own,
                block: self.recording,
                row: self.written,
            };
            for stream in &mut self.streams {
                stream.sample(&at, output)?;
            }
            self.written += 1;
        }
        Ok(())
    }
}

impl Stream for AtOwnTimes<'_> {
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError> {
        self.write_until(at.unix_nanos, output)
    }

    fn finish(&mut self, output: &mut Output) -> Result<(), ChannelError> {
        self.write_until(u64::MAX, output)?;
        self.streams
            .iter_mut()
            .try_for_each(|stream| stream.finish(output))
    }
}
