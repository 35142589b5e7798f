//! A take's nouns as channels, sample by sample, so that messages lie in the file in time order.

mod check;
mod cleaned;
mod evaluated;
mod generated;
mod processed;
mod recorded;
mod views;

pub(crate) use generated::by_start;
pub(crate) use recorded::marker_indices;
pub use views::{ViewsFor, view_channels, write_views};

use std::io::Write;

use inhand_model::{Clock, Finger, Provenance, Recording, Roles};

use crate::annotations::Events;
use crate::error::ChannelError;
use crate::messages;
use crate::metadata::{MOTION, Metadata};
use crate::outline::Outline;
use crate::output::{Output, PACKED};
use crate::take::{TakeFile, WriteSettings};
use crate::view;
use crate::wire::{Point, Timestamp};

/// A sample of the take, and where in a block of the recording it stands.
pub(crate) struct Instant<'a> {
    /// Number of the sample in the take.
    pub(crate) k: usize,
    /// Its time.
    pub(crate) unix_nanos: u64,
    /// Consecutive samples of the take, this one among them.
    pub(crate) block: &'a Recording,
    /// Number of the sample in the block.
    pub(crate) row: usize,
}

/// Messages of one channel, or of a few that belong together.
pub(crate) trait Stream {
    /// Writes what there is to say at a sample of the take.
    fn sample(&mut self, at: &Instant<'_>, output: &mut Output) -> Result<(), ChannelError>;

    /// Writes what is left to say after the last sample.
    fn finish(&mut self, _output: &mut Output) -> Result<(), ChannelError> {
        Ok(())
    }
}

/// All streams of a file, in the order in which they speak at one instant.
pub(crate) type Streams<'a> = Vec<Box<dyn Stream + 'a>>;

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
/// [`ChannelError::Write`] when writing fails.
pub fn write_take(
    mut out: impl Write,
    file: &TakeFile,
    settings: &WriteSettings,
) -> Result<(), ChannelError> {
    let used = file.used();
    let outline = Outline::of(used).with_findings(file.recording.findings.clone());
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
    output: Output<'a>,
    streams: Streams<'a>,
    clock: Clock,
    expected: usize,
    written: usize,
}

impl<'a> TakeWriter<'a> {
    /// Writes what stands before the first sample. Of `file.recording` only that is looked at
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
        let mut output = Output::create(out, PACKED)?;
        for (name, facts) in &metadata(file, outline.samples).0 {
            output.metadata(name, facts)?;
        }

        let mut streams = Streams::new();
        if let Some(annotations) = file.annotations
            && !annotations.events.is_empty()
        {
            streams.push(Box::new(Events::new(annotations, &mut output)?));
        }
        match &file.cleaned {
            None => recorded::add(file, outline, &mut output, &mut streams)?,
            Some(cleaned) => {
                // The rest of the file follows the clock of the cleaned recording.
                let mut measured = Streams::new();
                recorded::add(file, outline, &mut output, &mut measured)?;
                cleaned::add_changes(cleaned, file.recording.clock, &mut output, &mut measured)?;
                streams.push(Box::new(cleaned::AtOwnTimes::new(file.recording, measured)));
                cleaned::add(cleaned, &mut output, &mut streams)?;
            }
        }
        if let Some(motion) = file.motion {
            processed::add(motion, &mut output, &mut streams)?;
        }
        generated::add(file.generated, &mut output, &mut streams)?;
        evaluated::add(file.evaluated, &mut output, &mut streams)?;
        if settings.view {
            let seen = TakeFile {
                recording: file.used(),
                ..file.clone()
            };
            view::add_take(
                &seen,
                file.recording.clock,
                outline,
                &mut output,
                &mut streams,
            )?;
        }
        Ok(Self {
            output,
            streams,
            clock: file.used().clock,
            expected: outline.samples,
            written: 0,
        })
    }

    /// Writes the samples that follow those so far.
    ///
    /// # Errors
    ///
    /// [`ChannelError::Write`].
    pub fn append(&mut self, block: &Recording) -> Result<(), ChannelError> {
        for row in 0..block.len() {
            let k = self.written + row;
            let at = Instant {
                k,
                unix_nanos: self.clock.unix_nanos(k),
                block,
                row,
            };
            for stream in &mut self.streams {
                stream.sample(&at, &mut self.output)?;
            }
        }
        self.written += block.len();
        Ok(())
    }

    /// Writes what stands behind the last sample.
    ///
    /// # Errors
    ///
    /// [`ChannelError::Mismatch`] for another number of samples than the outline has;
    /// [`ChannelError::Write`].
    pub fn finish(mut self) -> Result<(), ChannelError> {
        if self.written != self.expected {
            return Err(ChannelError::mismatch(
                "samples of the take",
                self.expected,
                self.written,
            ));
        }
        for stream in &mut self.streams {
            stream.finish(&mut self.output)?;
        }
        drop(self.streams);
        self.output.finish()
    }
}

/// Writes a recording alone, as `convert` does; see [`write_take`].
///
/// # Errors
///
/// [`ChannelError::Write`] when writing fails.
pub fn write_recording(
    out: impl Write,
    recording: &Recording,
    roles: Option<&Roles>,
    provenance: &[Provenance],
    settings: &WriteSettings,
) -> Result<(), ChannelError> {
    let file = TakeFile {
        roles,
        provenance,
        ..TakeFile::new(recording)
    };
    write_take(out, &file, settings)
}

fn metadata(file: &TakeFile, samples: usize) -> Metadata {
    let mut metadata = Metadata::default();
    let measured = file.cleaned.map_or(samples, |_| file.recording.len());
    metadata.add_recording(file.recording, measured);
    if let Some(cleaned) = &file.cleaned {
        metadata.add_cleaned(cleaned.recording);
    }
    if let Some(roles) = file.roles {
        metadata.add_roles(roles);
    }
    if let Some(motion) = file.motion {
        metadata.add_fact(MOTION, "name", motion.name.clone());
    }
    if let Some(shape) = file.object_shape {
        metadata.add_shape(shape);
    }
    if let Some(annotations) = file.annotations {
        metadata.add_annotations(annotations);
    }
    metadata.add_provenance(file.provenance);
    metadata
}

/// A fingertip message; `None` is missing.
pub(crate) fn fingertip(
    position_m: Option<[f64; 3]>,
    status: inhand_model::Status,
) -> messages::Fingertip {
    messages::Fingertip {
        position_m: position_m.map(Point::from),
        status: messages::Status::from(status).into(),
    }
}

/// A fingertips message from each finger's own.
pub(crate) fn fingertips(
    unix_nanos: u64,
    tip: impl Fn(Finger) -> messages::Fingertip,
) -> messages::Fingertips {
    messages::Fingertips {
        timestamp: Some(Timestamp::from_unix_nanos(unix_nanos)),
        thumb: Some(tip(Finger::Thumb)),
        index: Some(tip(Finger::Index)),
        middle: Some(tip(Finger::Middle)),
        ring: Some(tip(Finger::Ring)),
        little: Some(tip(Finger::Little)),
    }
}
