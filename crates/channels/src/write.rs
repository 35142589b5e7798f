//! A take's nouns as channels, sample by sample, so that messages are in the file in time order.

mod check;
mod methods;
mod tracks;
mod views;

pub use views::{ViewsFor, view_channels, write_views};

use std::io::Write;

use inhand_model::{Clock, Recording};

use crate::annotations::add_events;
use crate::error::ChannelError;
use crate::metadata::{CLEANED, HEADER, MOTION, Metadata, OBJECT, RECORDING};
use crate::outline::Outline;
use crate::output::PACKED;
use crate::streams::{Sampling, Streams};
use crate::take::{TakeFile, WriteSettings};
use crate::topic;
use crate::view::draw_take;

/// Writes everything about a take as one MCAP file; the same values give the same bytes.
///
/// `log_time` and `publish_time` of a message are the time of its sample. Coordinates are metres
/// in the frame that the channel's metadata key `frame` names. Writing takes memory for one
/// chunk (1 MiB) and the indexes, whatever the length of the take.
///
/// # Errors
///
/// [`ChannelError::Mismatch`] for parts that do not belong to one take (another clock or length, a
/// trajectory past the end, a method name that makes no topic), before anything is written;
/// [`ChannelError::Container`] when writing fails.
pub fn write_take(
    mut out: impl Write,
    file: &TakeFile,
    settings: &WriteSettings,
) -> Result<(), ChannelError> {
    let used = file.used();
    let outline = Outline::new(used).with_findings(file.recording.findings.clone());
    let mut writer = TakeWriter::begin(&mut out, file, &outline, settings)?;
    writer.append(used)?;
    writer.finish()
}

/// Writes a take whose samples come block by block: the same bytes as [`write_take`] with all of
/// them at once.
///
/// ```
/// # use inhand_channels::*;
/// # fn convert(recording: &inhand_model::Recording) -> Result<Vec<u8>, ChannelError> {
/// let blocks = || (0..recording.len()).step_by(1000).map(|k| recording.slice(k..k + 1000));
/// let mut outline = Outline::default();
/// for block in blocks() {
///     outline.add(&block);
/// }
/// let outline = outline.with_findings(recording.findings.clone());
///
/// let header = recording.slice(0..0);
/// let mut bytes = Vec::new();
/// let settings = WriteSettings::default();
/// let mut writer = TakeWriter::begin(&mut bytes, &TakeFile::new(&header), &outline, &settings)?;
/// for block in blocks() {
///     writer.append(&block)?;
/// }
/// writer.finish()?;
/// # Ok(bytes)
/// # }
/// ```
pub struct TakeWriter<'a> {
    streams: Streams<'a>,
    clock: Clock,
    expected: usize,
    written: usize,
}

impl<'a> TakeWriter<'a> {
    /// Writes the part before the first sample. Of `file.recording` only that is looked at
    /// which holds for the whole take: its name, clock, source, markers and bodies. Where the take was
    /// cleaned, both recordings are there whole, and the blocks are those of the cleaned one.
    ///
    /// # Errors
    ///
    /// As for [`write_take`].
    pub fn begin(
        out: &'a mut dyn Write,
        file: &TakeFile<'a>,
        outline: &Outline,
        settings: &WriteSettings,
    ) -> Result<Self, ChannelError> {
        check::parts(file, outline.samples)?;
        let mut streams = Streams::create(out, PACKED, &metadata(file, outline.samples))?;
        let (recording, clock) = (file.recording, file.used().clock);
        let samples = Sampling::all(clock, outline.samples);
        if let Some(annotations) = file.annotations
            && !annotations.events.is_empty()
        {
            add_events(annotations, &mut streams)?;
        }
        // The rest of a file with a cleaned recording follows the clock of that one.
        let (whole, measured) = match file.cleaned {
            None => (None, samples),
            Some(_) => (
                Some(recording),
                Sampling::all(recording.clock, recording.len()),
            ),
        };
        let topics = [topic::RECORDING_MARKERS, topic::RECORDING_BODIES];
        tracks::add_entities(recording, whole, topics, measured, &mut streams)?;
        if let Some(roles) = file.roles {
            tracks::add_recorded_tips(recording, whole, roles, measured, &mut streams)?;
        }
        let start = recording.clock.unix_nanos(0);
        tracks::write_findings(&outline.findings, start, &mut streams)?;
        if let Some(cleaned) = &file.cleaned {
            tracks::add_changes(cleaned, measured, &mut streams)?;
            let topics = [topic::CLEANED_MARKERS, topic::CLEANED_BODIES];
            tracks::add_entities(cleaned.recording, None, topics, samples, &mut streams)?;
        }
        if let Some(motion) = file.motion {
            tracks::add_motion(motion, samples, &mut streams)?;
        }
        methods::add_generated(file.generated, clock, &mut streams)?;
        methods::add_evaluated(file.evaluated, clock, &mut streams)?;
        if settings.view {
            let drawn = TakeFile {
                recording: file.used(),
                ..file.clone()
            };
            draw_take(&drawn, recording.clock, outline, &mut streams)?;
        }
        Ok(Self {
            streams,
            clock,
            expected: outline.samples,
            written: 0,
        })
    }

    /// Writes the samples that follow those so far.
    ///
    /// # Errors
    ///
    /// [`ChannelError::Container`].
    pub fn append(&mut self, block: &Recording) -> Result<(), ChannelError> {
        let first = self.written;
        self.written += block.len();
        match self.written.checked_sub(1).filter(|_| !block.is_empty()) {
            Some(last) => {
                (self.streams).write_until(self.clock.unix_nanos(last), Some((block, first)))
            }
            None => Ok(()),
        }
    }

    /// Writes the part behind the last sample.
    ///
    /// # Errors
    ///
    /// [`ChannelError::Mismatch`] for another number of samples than the outline has;
    /// [`ChannelError::Container`].
    pub fn finish(self) -> Result<(), ChannelError> {
        if self.written != self.expected {
            return Err(ChannelError::mismatch(
                "samples of the take",
                self.expected,
                self.written,
            ));
        }
        self.streams.finish()
    }
}

fn metadata(file: &TakeFile, samples: usize) -> Metadata {
    let mut metadata = Metadata::default();
    let measured = file.cleaned.map_or(samples, |_| file.recording.len());
    metadata.add_recording(RECORDING, file.recording, measured);
    let header = file.recording.source.header.clone();
    (metadata.0).insert(HEADER.to_owned(), header);
    if let Some(cleaned) = &file.cleaned {
        metadata.add_recording(CLEANED, cleaned.recording, cleaned.recording.len());
    }
    if let Some(roles) = file.roles {
        metadata.add_roles(roles);
    }
    if let Some(motion) = file.motion {
        metadata.add_fact(MOTION, "name", motion.name.clone());
    }
    if let Some(shape) = file.object_shape {
        metadata.add_fact(OBJECT, "shape", shape.to_string());
    }
    if let Some(annotations) = file.annotations {
        metadata.add_annotations(annotations);
    }
    metadata.add_provenance(file.provenance);
    metadata
}
