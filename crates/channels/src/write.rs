//! A take's nouns as channels, sample by sample, so that messages are in the file in time order.

mod tracks;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;

use foxglove::messages::FrameTransforms;
use inhand_container::ChannelFacts;
use inhand_model::{Clock, Frame, Protocol, Track, World};
use nalgebra::Isometry3;

use crate::annotations::add_events;
use crate::error::{ChannelError, ensure};
use crate::made::Made;
use crate::metadata::{CLEANED, HEADER, MOTION, Metadata, OBJECT, RECORDING};
use crate::streams::{Block, PACKED, Sampling, Streams};
use crate::take::{GeneratedMethod, GeneratedSegment, Outline, TakeFile, Views};
use crate::topic;
use crate::view::{UPRIGHT, draw_take, transform};

/// Writes everything about a take as one MCAP file; the same values give the same bytes.
///
/// `views` tells which channels to add that viewers draw (`/tf`, `/tf_static`, `/view/...`).
/// `log_time` and `publish_time` of a message are the time of its sample. Coordinates are metres
/// in the frame that the channel's metadata key `frame` names. Writing takes memory for one
/// chunk (1 MiB) and the indexes, whatever the length of the take.
///
/// # Errors
///
/// [`ChannelError::Mismatch`] for parts that do not belong to one take (another clock or length, a
/// trajectory past the end, a method name that makes no topic), before anything is written;
/// [`ChannelError::Container`] when writing fails.
pub fn write_take(out: &mut dyn Write, file: &TakeFile, views: Views) -> Result<(), ChannelError> {
    let used = file.used();
    let outline = Outline::new(used).with_findings(file.recording.findings.clone());
    let mut writer = TakeWriter::begin(out, file, &outline, views)?;
    writer.append(file)?;
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
/// let mut writer = TakeWriter::begin(&mut bytes, &TakeFile::new(&header), &outline, Views::Default)?;
/// for block in blocks() {
///     writer.append(&TakeFile::new(&block))?;
/// }
/// writer.finish()?;
/// # Ok(bytes)
/// # }
/// ```
pub struct TakeWriter<'a> {
    streams: Streams<'a>,
    clock: Clock,
    /// Methods under each protocol.
    methods: [usize; 2],
    expected: usize,
    written: usize,
}

impl<'a> TakeWriter<'a> {
    /// Writes the part before the first sample. Of `file.recording` only that is looked at
    /// which holds for the whole take: its name, clock, source, markers and bodies. Where the take was
    /// cleaned, both recordings are there whole, and the blocks are those of the cleaned one. Of methods their names
    /// count, whether they have plans, and whether any sample of an evaluated one has an error or contacts.
    ///
    /// # Errors
    ///
    /// As for [`write_take`].
    pub fn begin(
        out: &'a mut dyn Write,
        file: &TakeFile<'a>,
        outline: &Outline,
        views: Views,
    ) -> Result<Self, ChannelError> {
        check(file, outline.samples)?;
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
        for (protocol, methods) in generated(file) {
            tracks::add_generated(protocol, methods, samples, &mut streams)?;
        }
        tracks::add_evaluated(file.evaluated, samples, &mut streams)?;
        if views != Views::None {
            let drawn = TakeFile {
                recording: file.used(),
                ..file.clone()
            };
            draw_take(&drawn, (recording.clock, outline), views, &mut streams)?;
        }
        Ok(Self {
            streams,
            clock,
            methods: generated(file).map(|(_, methods)| methods.len()),
            expected: outline.samples,
            written: 0,
        })
    }

    /// Writes the samples that follow those so far: the recording of `block`, and what methods made of its samples, the same
    /// methods in each block. A segment is in every block that it has samples in.
    ///
    /// # Errors
    ///
    /// [`ChannelError::Mismatch`] for segments that do not belong to the take; [`ChannelError::Container`].
    pub fn append(&mut self, block: &TakeFile<'_>) -> Result<(), ChannelError> {
        let methods = generated(block).map(|(_, methods)| methods.len());
        ensure(
            methods == self.methods,
            "methods of a block",
            format!("{:?}", self.methods),
            format!("{methods:?}"),
        )?;
        check_methods(block, self.expected, self.clock)?;
        let (recording, first) = (block.used(), self.written);
        self.written += recording.len();
        let Some(last) = self
            .written
            .checked_sub(1)
            .filter(|_| !recording.is_empty())
        else {
            return Ok(());
        };
        let made = &Made::new(block);
        let block = Block {
            recording,
            first,
            made,
        };
        (self.streams).write_until(self.clock.unix_nanos(last), Some(block))
    }

    /// Writes the part behind the last sample.
    ///
    /// # Errors
    ///
    /// [`ChannelError::Mismatch`] for another number of samples than the outline has;
    /// [`ChannelError::Container`].
    pub fn finish(self) -> Result<(), ChannelError> {
        ensure(
            self.written == self.expected,
            "samples of the take",
            self.expected,
            self.written,
        )?;
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

/// Owner of the file that the views of a take are for.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ViewsFor {
    /// A take that inhand wrote: the tree of frames is on `/tf` and `/tf_static`.
    #[default]
    Take,
    /// A third-party recording, which may have a tree of frames of its own: that of the views is on `/view/tf` and
    /// `/view/tf_static`, and the roots of their trees are placed in its `world`.
    ThirdParty {
        /// Poses of the roots: `world_from_root`, metres.
        roots: BTreeMap<String, Isometry3<f64>>,
    },
}

/// Selects the channels that inhand added for viewers: without them the file has the same data.
/// `dictionary` tells whether the file is one.
pub fn view_channels(
    metadata: &Metadata,
    dictionary: bool,
) -> impl Fn(&ChannelFacts) -> bool + use<> {
    let is_view = view_topics(metadata, dictionary);
    move |channel: &ChannelFacts| {
        let schema = channel.schema_name().unwrap_or_default();
        is_view(&channel.topic, &channel.message_encoding, schema)
    }
}

/// As [`view_channels`], by topic, encoding of the messages and name of the schema.
pub fn view_topics(
    metadata: &Metadata,
    dictionary: bool,
) -> impl Fn(&str, &str, &str) -> bool + use<> {
    let tree = dictionary || metadata.is_take();
    let ours = tree || metadata.has_added_views();
    move |topic, encoding, schema| {
        let shown = topic.starts_with(topic::VIEW)
            || tree && [topic::TF, topic::TF_STATIC].contains(&topic);
        let drawn = match encoding {
            "protobuf" => schema.starts_with("foxglove."),
            // In ROS 2 bags.
            "cdr" => schema == "visualization_msgs/msg/MarkerArray",
            _ => false,
        };
        ours && shown && drawn
    }
}

/// Writes the views of a take as an MCAP file of its own: the same messages that
/// [`write_take`](crate::write_take) adds to the rest.
///
/// # Errors
///
/// As for [`write_take`](crate::write_take).
pub fn write_views(
    out: &mut dyn Write,
    file: &TakeFile<'_>,
    views: Views,
    views_for: &ViewsFor,
) -> Result<(), ChannelError> {
    let used = file.used();
    let outline = Outline::new(used);
    check(file, outline.samples)?;
    let mut streams = Streams::create(out, PACKED, &Metadata::default())?;
    if let ViewsFor::ThirdParty { roots } = views_for {
        streams.output.rename = beside_others;
        place_roots(roots, used.clock.unix_nanos(0), &mut streams)?;
    }
    let drawn = TakeFile {
        recording: used,
        ..file.clone()
    };
    draw_take(
        &drawn,
        (file.recording.clock, &outline),
        views,
        &mut streams,
    )?;
    let block = Block {
        recording: used,
        first: 0,
        made: &Made::new(file),
    };
    streams.write_until(u64::MAX, Some(block))?;
    streams.finish()
}

fn beside_others(ours: &str) -> &str {
    match ours {
        topic::TF => topic::VIEW_TF,
        topic::TF_STATIC => topic::VIEW_TF_STATIC,
        other => other,
    }
}

/// Places third-party trees in the world: a viewer shows nothing that no tree connects.
fn place_roots(
    roots: &BTreeMap<String, Isometry3<f64>>,
    unix_nanos: u64,
    streams: &mut Streams<'_>,
) -> Result<(), ChannelError> {
    // A frame without a name is no frame, and those of inhand have their place already.
    let ours = [World::NAME, UPRIGHT];
    let named = |root: &str| !root.is_empty() && !ours.contains(&root);
    let transforms: Vec<_> = (roots.iter().filter(|(root, _)| named(root)))
        .map(|(root, &world_from_root)| transform(World::NAME, root, world_from_root, unix_nanos))
        .collect();
    if transforms.is_empty() {
        return Ok(());
    }
    let message = FrameTransforms { transforms };
    streams.once(topic::VIEW_FRAMES, None, unix_nanos, &message)
}

/// What methods generated, by protocol.
const fn generated<'a>(file: &TakeFile<'a>) -> [(Protocol, &'a [GeneratedMethod<'a>]); 2] {
    [
        (Protocol::Published, file.generated),
        (Protocol::HeldOut, file.held_out),
    ]
}

/// Checks that the parts of a take of so many samples belong together.
fn check(file: &TakeFile, samples: usize) -> Result<(), ChannelError> {
    let clock = file.used().clock;
    if let Some(motion) = file.motion {
        let lengths = [motion.hand.len()]
            .into_iter()
            .chain(motion.object.iter().map(Track::len))
            .chain(motion.fingertips.iter().map(|(_, track)| track.len()));
        for found in lengths {
            let what = "samples of a track of the motion";
            ensure(found == samples, what, samples, found)?;
        }
        let (found, expected) = (motion.clock, format!("that of the recording, {clock:?}"));
        let what = "clock of the motion";
        ensure(found == clock, what, expected, format!("{found:?}"))?;
    }
    check_methods(file, samples, clock)
}

/// Checks that what methods made belongs to a take of so many samples.
fn check_methods(file: &TakeFile, samples: usize, clock: Clock) -> Result<(), ChannelError> {
    for (_, methods) in generated(file) {
        let mut names = BTreeSet::new();
        for method in methods {
            check_method(&mut names, method.name)?;
            for segment in method.segments {
                check_segment(segment, method.name, samples, clock.rate_hz())?;
            }
        }
    }
    let mut names = BTreeSet::new();
    for method in file.evaluated {
        check_method(&mut names, &method.name)?;
        if let Some(last) = method.samples.iter().map(|judged| judged.sample).max() {
            let what = format!("judged sample of method \"{}\"", method.name);
            let expected = format!("below {samples}, the samples of the take");
            ensure(last < samples, what, expected, last)?;
        }
    }
    Ok(())
}

fn check_method<'a>(names: &mut BTreeSet<&'a str>, name: &'a str) -> Result<(), ChannelError> {
    topic::check_name("name of a method", name)?;
    let found = format!("\"{name}\" twice");
    let what = "names of the methods";
    ensure(names.insert(name), what, "each one once", found)
}

fn check_segment(
    segment: &GeneratedSegment,
    method: &str,
    samples: usize,
    rate_hz: f64,
) -> Result<(), ChannelError> {
    let start = segment.start_sample;
    let Some(trajectory) = segment.trajectory else {
        let what = format!("start of an unsolved plan of {method}");
        let expected = format!("below the {samples} samples of the take");
        return ensure(start < samples, what, expected, start);
    };
    let layout = trajectory.layout();
    let end = start.saturating_add(layout.samples);
    let what = format!("end of a trajectory of method \"{method}\"");
    let expected = format!("at most {samples}, the samples of the take");
    ensure(end <= samples, what, expected, end)?;
    let what = format!("rate of a trajectory of method \"{method}\" in Hz");
    ensure(layout.rate_hz == rate_hz, what, rate_hz, layout.rate_hz)
}
