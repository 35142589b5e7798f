//! A take's nouns as channels, sample by sample, so that messages lie in the file in time order.

mod check;
mod evaluated;
mod generated;
mod processed;
mod recorded;

pub(crate) use generated::by_start;

use std::io::Write;

use inhand_model::{Finger, Provenance, Recording, Roles};

use crate::annotations::Events;
use crate::error::ChannelError;
use crate::messages;
use crate::metadata::{MOTION, Metadata};
use crate::output::{Output, PACKED};
use crate::take::{TakeFile, WriteSettings};
use crate::view;
use crate::wire::{Point, Timestamp};

/// Messages of one channel, or of a few that belong together.
pub(crate) trait Stream {
    /// Writes what there is to say at sample `k` of the take.
    fn sample(
        &mut self,
        k: usize,
        unix_nanos: u64,
        output: &mut Output,
    ) -> Result<(), ChannelError>;

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
    check::parts(file)?;
    let mut output = Output::create(&mut out, PACKED)?;
    for (name, facts) in &metadata(file).0 {
        output.metadata(name, facts)?;
    }

    let mut streams = Streams::new();
    if let Some(annotations) = file.annotations
        && !annotations.events.is_empty()
    {
        streams.push(Box::new(Events::new(annotations, &mut output)?));
    }
    recorded::add(file, &mut output, &mut streams)?;
    if let Some(motion) = file.motion {
        processed::add(motion, &mut output, &mut streams)?;
    }
    generated::add(file.generated, &mut output, &mut streams)?;
    evaluated::add(file.evaluated, &mut output, &mut streams)?;
    if settings.view {
        view::add_take(file, &mut output, &mut streams)?;
    }

    let recording = file.recording;
    for k in 0..recording.len() {
        let unix_nanos = recording.clock.unix_nanos(k);
        for stream in &mut streams {
            stream.sample(k, unix_nanos, &mut output)?;
        }
    }
    for stream in &mut streams {
        stream.finish(&mut output)?;
    }
    drop(streams);
    output.finish()
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

fn metadata(file: &TakeFile) -> Metadata {
    let mut metadata = Metadata::default();
    metadata.add_recording(file.recording);
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
